//! Tests and measures the on-board code on QEMU; the command comes from QEMU's command line.
//!
//! | command | prints |
//! |---|---|
//! | `signature CASES` | `signature` of the actor file, after its self-test |
//! | `costs` | exact instruction counts and stack use of the actor's parts, with `-icount shift=10` |
//! | `gate TICKS` | `signature` of the safety gate |
//! | `kernel CASES` | `cases` of the assembly kernel found equal to its portable twin |
//!
//! Each result is a line of a name and a number. Anything wrong is a line `error …` and a bad exit code.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use covey_image::actor_file::actor_file;
use covey_image::measure::{console, costs, kernel};
use firmware_core::actor::{Actor, fingerprint};
use firmware_core::gate;

#[entry]
fn main() -> ! {
    let mut line = [0; 64];
    let line = console::command_line(&mut line);
    let mut words = line.split(|&byte| byte == b' ');
    let done = match words.next() {
        Some(b"signature") => sign(number(words.next())),
        Some(b"costs") => sound_actor().map(|actor| costs::print(&actor)),
        Some(b"gate") => {
            console::result_hex(b"signature", gate::fingerprint(number(words.next())));
            Ok(())
        }
        Some(b"kernel") => kernel::check(number(words.next())),
        _ => Err("unknown command"),
    };
    if let Err(error) = done {
        console::print(b"error ");
        console::print(error.as_bytes());
        console::print(b"\n");
    }
    console::exit(done.is_ok())
}

/// The actor of the board's file, tested.
fn sound_actor() -> Result<Actor<'static>, &'static str> {
    let actor = Actor::load(actor_file()).map_err(|_| "there is no sound actor file at the actor's address")?;
    actor.self_test().map_err(|_| "the actor fails its self-test")?;
    Ok(actor)
}

fn sign(cases: u32) -> Result<(), &'static str> {
    let actor = sound_actor()?;
    console::result_hex(b"signature", fingerprint(&actor, cases));
    Ok(())
}

/// A decimal number; what is none counts as zero.
fn number(word: Option<&[u8]>) -> u32 {
    let digits = word.unwrap_or_default().iter().map(|byte| u32::from(byte.wrapping_sub(b'0')));
    digits.fold(0, |number, digit| number.wrapping_mul(10).wrapping_add(digit))
}
