//! Test flights of the flight program in QEMU, over its serial line. The same requests go to a server on this
//! computer, and the answers must be equal.

mod qmp;
pub mod session;

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::time::Duration;

use covey_pil::{Client, Loopback, Options, PilError};
use firmware_core::geometry::{State, TICKS_PER_U, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, MAX_LEN, Message};
use firmware_core::neighbour_table::Moment;
use firmware_core::pil::{ActorError, Decided, MAX_POIS, Setup};

use super::artefacts::{Actors, Image};
use super::qemu::Machine;
use crate::error::{Error, Result};
use session::Session;

/// Steps of a flight.
const STEPS: u32 = 40;
/// Bytes of noise on the serial line before some of the steps.
const NOISE: usize = 5000;
/// Length of a step, ms.
const STEP_MS: u16 = 2000;
/// UAVs around the one on the board; more than its neighbour table holds.
const SWARM: u16 = 20;
/// Time limit and attempts of a request, enough for a busy computer.
pub const PATIENCE: Options = Options { timeout: Duration::from_secs(30), attempts: 2 };

/// Flies [`STEPS`] steps with each of the actor files, in a dense swarm, with every kind of request and with noise on
/// the line. Returns the deepest stack of the flight program, bytes.
///
/// # Errors
/// The board answers something else than this computer, or does not answer.
pub fn fly(machine: Machine, image: &Image, actors: &[&Path]) -> Result<u64> {
    let mut deepest = 0;
    for actor in actors {
        let file = fs::read(actor).map_err(Error::file(actor))?;
        let here = mission(&mut Client::new(Loopback::new(&file), Loopback::OPTIONS), |_| Ok(()))?;
        let session = Session::start(machine, &image.flight, Some(&file))?;
        let there = mission(&mut session.client(PATIENCE)?, |noise| Ok(session.write(noise)?))?;
        if let Some(step) = (0..STEPS as usize).find(|&step| here.decisions[step] != there.decisions[step]) {
            return Err(Error::Board(format!(
                "{}: step {step} with {}: the board decides {:?}, this computer {:?}",
                machine.target(),
                actor.display(),
                there.decisions[step],
                here.decisions[step]
            )));
        }
        if here.signature != there.signature {
            return Err(Error::Board(format!("{}: the board's signature differs", machine.target())));
        }
        deepest = deepest.max(session.stack_used(&image.flight)?);
    }
    Ok(deepest)
}

/// Starts the flight program with a damaged actor file and without one, and checks that it reports this and refuses
/// to decide.
///
/// # Errors
/// It does not report the fault, or decides all the same.
pub fn refuses_bad_files(machine: Machine, image: &Image, actors: &Actors) -> Result<()> {
    let mut bytes = fs::read(&actors.gcn).map_err(Error::file(&actors.gcn))?;
    bytes[1000] ^= 1;
    for (file, fault) in [(Some(&*bytes), ActorError::Checksum), (None, ActorError::NotAnActor)] {
        let session = Session::start(machine, &image.flight, file)?;
        let mut board = session.client(PATIENCE)?;
        let answer = board.hello(setup());
        let said = board.restarted().map(|report| report.actor);
        let refused = board.decide(0).is_err();
        let expected = matches!(&answer, Err(PilError::Refused(refusal)) if refusal.to_string() == fault.to_string());
        if !expected || said != Some(Err(fault)) || !refused {
            return Err(Error::Board(format!(
                "{}: expected the board to refuse ({fault}); it started with {said:?} and answered {answer:?}",
                machine.target()
            )));
        }
    }
    Ok(())
}

/// The answers during a mission.
struct Log {
    /// The decision of each step.
    decisions: Vec<Decided>,
    /// The actor's signature.
    signature: u64,
}

/// The set-up of the UAV on the board.
fn setup() -> Setup {
    Setup { id: 3, seed: 10, argmax: false, step_ms: STEP_MS, half_side: 100 * TICKS_PER_U }
}

/// Flies the mission with the server at the other end of the line; `disturb` puts noise on the line.
fn mission<S: Read + Write>(board: &mut Client<S>, mut disturb: impl FnMut(&[u8]) -> Result<()>) -> Result<Log> {
    let mut random = Random(7);
    let info = board.hello(setup())?.actor.map_err(|fault| Error::Board(fault.to_string()))?;
    let hash = (info.content_hash ^ (info.content_hash >> 32)) as u32;
    let mut decisions = Vec::new();
    for step in 0..STEPS {
        if step % 8 == 3 {
            let noise: Vec<u8> = (0..NOISE).map(|_| random.next() as u8).collect();
            // The zero byte ends the frame that the noise may have begun, so no request is lost with it.
            disturb(&[&noise[..], &[0]].concat())?;
        }
        let now = Moment { step, time_ms: step * u32::from(STEP_MS) };
        let own = State { position: random.around(100), velocity: random.around(4) };
        let near = |random: &mut Random| own.position + random.around(14);
        let header = |id| Header { id, sequence: step as u16, step };
        for id in 10..10 + SWARM {
            let state = State { position: near(&mut random), velocity: random.around(4) };
            let beacon = Beacon::new(header(id), now.time_ms, state, random.next() as i8);
            board.hear(now, own.position, &Message::Beacon(beacon))?;
        }
        board.observe(now, own, (0..MAX_POIS).map(|_| near(&mut random)).collect::<Vec<_>>())?;
        for id in 10..10 + SWARM {
            let values: Vec<i8> = (0..info.width).map(|_| (random.next() & 127) as i8).collect();
            let attention_source = (random.next() as i16) / 16;
            if let Ok(feature) = FeatureMessage::new(header(id), 1 + (id % 17) as u8, hash, attention_source, &values) {
                board.hear_bytes(now, own.position, Message::Feature(feature).encode(&mut [0; MAX_LEN]))?;
            }
        }
        decisions.push(board.decide(step)?);
    }
    board.self_test()?;
    board.status()?;
    let signature = board.fingerprint(200, 100, |_| ())?;
    Ok(Log { decisions, signature })
}

/// The random number generator splitmix64.
struct Random(u64);

impl Random {
    /// The next 32 random bits.
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// A random position or velocity whose coordinates are at most `range_u` map units from zero.
    fn around(&mut self, range_u: i32) -> Vec2 {
        let range = range_u * TICKS_PER_U;
        let mut axis = || (self.next() % (2 * range as u32 + 1)) as i32 - range;
        let (x, y) = (axis(), axis());
        Vec2::from_ticks(x, y)
    }
}
