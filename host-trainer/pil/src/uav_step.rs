//! One board in the place of a whole swarm, UAV after UAV.

use crate::answers::Observed;
use crate::client::Client;
use crate::convert::{board, decided, heard, in_view, observe_request, observed, read};
use crate::error::PilError;
use crate::exchange::name;
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::Moment;
use firmware_core::pil::{Decided, Hear, Request, Setup};
use std::io::{Read, Write};

/// One step of one UAV, for which all messages are known beforehand; see [`Client::fly_step`].
#[derive(Clone, Copy, Debug)]
pub struct UavStep<'a> {
    /// The UAV and its swarm.
    pub setup: Setup,
    /// The step and its time.
    pub now: Moment,
    /// The UAV's own state.
    pub own: State,
    /// Beacons received before it observes.
    pub beacons: &'a [Message],
    /// PoIs (positions in ticks; those out of view are left out).
    pub pois: &'a [Vec2],
    /// Features received before it decides.
    pub features: &'a [Message],
}

impl<S: Read + Write> Client<S> {
    /// Sets the board up as one UAV, with an empty neighbour table, and lets it fly a step: so one board can take the
    /// place of a whole swarm. All requests are sent at once, so use it only over lines with flow control: sockets have
    /// it, bare serial lines do not.
    ///
    /// # Errors
    /// As [`Self::hello`], [`Self::observe`] and [`Self::decide`].
    pub fn fly_step(&mut self, step: &UavStep<'_>) -> Result<(Observed, Decided), PilError> {
        let UavStep { setup, now, own, .. } = *step;
        let encode = |m: &Message| m.encode(&mut [0; MAX_LEN]).to_vec();
        let messages: Vec<Vec<u8>> = step.beacons.iter().chain(step.features).map(encode).collect();
        let (beacons, features) = messages.split_at(step.beacons.len());
        let position = [own.position.x, own.position.y];
        let hear = |message| Request::Hear(Hear { now, position, message });
        let pois = in_view(own.position, step.pois.iter().copied())?;

        let mut requests = vec![Request::Hello(setup)];
        requests.extend(beacons.iter().map(|m| hear(m)));
        let observe = requests.len();
        requests.push(observe_request(now, own, &pois));
        requests.extend(features.iter().map(|m| hear(m)));
        requests.push(Request::Decide { step: now.step });

        let answers = self.exchange.ask_all(&requests)?;
        let (mut observation, mut decision) = (None, None);
        for (k, (request, answer)) in requests.iter().zip(&answers).enumerate() {
            let name = name(request);
            match request {
                Request::Hello(_) => drop(read(answer, name, board)?),
                Request::Hear(_) => drop(read(answer, name, heard)?),
                _ if k == observe => observation = Some(read(answer, name, |reply| observed(now.step, reply))?),
                _ => decision = Some(read(answer, name, |reply| decided(now.step, reply))?),
            }
        }
        observation.zip(decision).ok_or(PilError::Unexpected { request: "decide" })
    }
}
