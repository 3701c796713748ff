//! One board that plays a whole swarm, UAV after UAV.

use crate::PilError;
use crate::client::{Client, Observed};
use crate::exchange::name;
use crate::records::{board, decided, heard, in_view, observe_request, observed, read};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::Moment;
use firmware_core::pil::{Decided, Hear, Request, Setup};
use std::io::{Read, Write};

/// A UAV's whole step, when all that it hears is known beforehand; see [`Client::take_turn`].
#[derive(Clone, Copy, Debug)]
pub struct Turn<'a> {
    /// Who it is.
    pub setup: Setup,
    /// The step and its time.
    pub now: Moment,
    /// Its own state.
    pub own: State,
    /// Beacons heard before it observes.
    pub beacons: &'a [Message],
    /// PoIs (positions, ticks); those out of view are left out.
    pub pois: &'a [Vec2],
    /// Features heard before it decides.
    pub features: &'a [Message],
}

impl<S: Read + Write> Client<S> {
    /// Makes the board a UAV, with an empty neighbour table, and lets it fly that UAV's step: so
    /// one board plays a whole swarm. All requests are sent in one go, only for lines that hold
    /// back what the board has not read: sockets do, bare serial lines do not.
    ///
    /// # Errors
    /// As [`Self::hello`], [`Self::observe`] and [`Self::decide`].
    pub fn take_turn(&mut self, turn: &Turn<'_>) -> Result<(Observed, Decided), PilError> {
        let Turn { setup, now, own, .. } = *turn;
        let encode = |m: &Message| m.encode(&mut [0; MAX_LEN]).to_vec();
        let messages: Vec<Vec<u8>> = turn.beacons.iter().chain(turn.features).map(encode).collect();
        let (beacons, features) = messages.split_at(turn.beacons.len());
        let position = [own.position.x, own.position.y];
        let hear = |message| Request::Hear(Hear { now, position, message });
        let pois = in_view(own.position, turn.pois.iter().copied())?;

        let mut requests = vec![Request::Hello(setup)];
        requests.extend(beacons.iter().map(|m| hear(m)));
        let observe = requests.len();
        requests.push(observe_request(now, own, &pois));
        requests.extend(features.iter().map(|m| hear(m)));
        requests.push(Request::Decide { step: now.step });

        let answers = self.exchange.ask_all(&requests)?;
        let (mut seen, mut choice) = (None, None);
        for (k, (request, answer)) in requests.iter().zip(&answers).enumerate() {
            let name = name(request);
            match request {
                Request::Hello(_) => drop(read(answer, name, board)?),
                Request::Hear(_) => drop(read(answer, name, heard)?),
                _ if k == observe => seen = Some(read(answer, name, |reply| observed(now.step, reply))?),
                _ => choice = Some(read(answer, name, |reply| decided(now.step, reply))?),
            }
        }
        seen.zip(choice).ok_or(PilError::Unexpected { request: "decide" })
    }
}
