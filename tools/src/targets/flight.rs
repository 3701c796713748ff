//! The flight program in QEMU, flown over its serial line beside the same server on this computer.

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
use super::elf;
use super::qemu::Machine;
use crate::error::{Error, Result};
use session::Session;

/// Steps to fly.
const STEPS: u32 = 40;
/// Bytes of noise that the line brings before some steps.
const NOISE: usize = 5000;
const STEP_MS: u16 = 2000;
/// UAVs around the one on the board: more than its table holds.
const SWARM: u16 = 20;
/// What a request may take on a busy computer.
pub const PATIENCE: Options = Options { timeout: Duration::from_secs(30), attempts: 2 };

/// Flies [`STEPS`] steps in a dense swarm with every kind of request and noise on the line, with each of the
/// actors, and returns the deepest stack, bytes.
///
/// # Errors
/// The board answers otherwise than this computer, or not at all.
pub fn fly(machine: Machine, image: &Image, actors: &[&Path]) -> Result<u64> {
    let mut deepest = 0;
    for actor in actors {
        let file = fs::read(actor).map_err(Error::file(actor))?;
        let here = mission(&mut Client::new(Loopback::new(&file), Loopback::OPTIONS), |_| Ok(()))?;
        let session = Session::start(machine, &image.flight, Some(&file))?;
        let there = mission(&mut session.client(PATIENCE)?, |noise| Ok(session.write(noise)?))?;
        if let Some(step) = (0..STEPS as usize).find(|&step| here.decisions[step] != there.decisions[step]) {
            return Err(Error::Setup(format!(
                "{}: step {step} with {}: the board decides {:?}, this computer {:?}",
                machine.target(),
                actor.display(),
                there.decisions[step],
                here.decisions[step]
            )));
        }
        if here.signature != there.signature {
            return Err(Error::Setup(format!("{}: the board's signature differs", machine.target())));
        }
        deepest = deepest.max(session.stack_used(&image.flight)?);
    }
    Ok(deepest)
}

/// Starts the flight program with a damaged actor file and with none: it must say so, and refuse to fly.
///
/// # Errors
/// It does not.
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
            return Err(Error::Setup(format!(
                "{}: expected the board to refuse ({fault}); it started with {said:?} and answered {answer:?}",
                machine.target()
            )));
        }
    }
    Ok(())
}

/// What came of a mission.
struct Log {
    decisions: Vec<Decided>,
    signature: u64,
}

fn setup() -> Setup {
    Setup { id: 3, seed: 10, argmax: false, step_ms: STEP_MS, half_side: 100 * TICKS_PER_U }
}

/// Flies the mission; `disturb` puts noise on the line.
fn mission<S: Read + Write>(board: &mut Client<S>, mut disturb: impl FnMut(&[u8]) -> Result<()>) -> Result<Log> {
    let mut random = Random(7);
    let info = board.hello(setup())?.actor.map_err(|fault| Error::Setup(fault.to_string()))?;
    let hash = (info.content_hash ^ (info.content_hash >> 32)) as u32;
    let mut decisions = Vec::new();
    for step in 0..STEPS {
        if step % 8 == 3 {
            let noise: Vec<u8> = (0..NOISE).map(|_| random.next() as u8).collect();
            // The zero ends what the noise began, so that only noise is lost.
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

/// splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// Both coordinates within this many map units of zero.
    fn around(&mut self, range_u: i32) -> Vec2 {
        let range = range_u * TICKS_PER_U;
        let mut axis = || (self.next() % (2 * range as u32 + 1)) as i32 - range;
        let (x, y) = (axis(), axis());
        Vec2::from_ticks(x, y)
    }
}

/// Bytes of paint that are gone, seen from the stack's far end: `ram` begins there.
fn deepest(ram: &[u8], paint: u32) -> u64 {
    let clean = ram.as_chunks::<4>().0.iter().take_while(|word| u32::from_le_bytes(**word) == paint).count();
    (ram.len() - 4 * clean) as u64
}

/// The stack's ends in an image: the far one and the one where it begins.
fn stack_of(image: &Path) -> Result<(u64, u64)> {
    Ok((elf::address_of(image, "_stack_end")?, elf::address_of(image, "_stack_start")?))
}

#[cfg(test)]
mod tests {
    use super::deepest;

    #[test]
    fn the_deepest_stack_ends_at_the_last_paint() {
        const PAINT: u32 = 0xcccc_cccc;
        let mut ram = vec![0xcc; 64];
        assert_eq!(deepest(&ram, PAINT), 0);
        ram[60..].fill(1);
        assert_eq!(deepest(&ram, PAINT), 4);
        // What looks like paint in the middle was used all the same.
        ram[20] = 0;
        assert_eq!(deepest(&ram, PAINT), 44);
        assert_eq!(deepest(&[0; 8], PAINT), 8);
    }
}
