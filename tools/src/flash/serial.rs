//! Checking over the PIL protocol what a board runs.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use covey_pil::{Client, Options};

use super::actor_file::ActorFile;
use super::error::FlashError;
use super::progress::say;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::output::print;

/// Speed of the board's serial port, bit/s.
const BAUD: &str = "921600";
/// Neighbourhoods in the signature: enough to find a difference, and few enough for a slow board.
const CASES: u32 = 1000;
/// Neighbourhoods that the board computes for one request.
const CHUNK: u16 = 100;
/// Time limit and attempts of a request over a serial port.
const OPTIONS: Options = Options { timeout: Duration::from_secs(5), attempts: 3 };

/// Checks over a serial port that the board runs this actor and computes what this computer computes. With `dry_run`
/// it only prints how the port would be set up.
///
/// # Errors
/// The port cannot be opened, the board does not answer, runs another actor, or computes another signature.
pub fn check(actor: &ActorFile, port: &Path, dry_run: bool) -> Result<()> {
    // The port carries raw bytes, and a read returns after a tenth of a second in which nothing came.
    let stty = Cmd::new("stty").arg("-F").arg(port).args([BAUD, "raw", "-echo", "min", "0", "time", "1"]);
    if dry_run {
        print(&format!("  {stty}\n"))?;
        return Ok(());
    }
    stty.read()?;
    let file = OpenOptions::new().read(true).write(true).open(port).map_err(Error::file(port))?;
    verify(&mut Client::new(Port(file), OPTIONS), &port.display().to_string(), actor)
}

/// Checks that the board at the other end of the line runs this actor and computes what this computer computes.
/// `place` is its name in messages.
///
/// # Errors
/// The board does not answer, runs another actor, or computes another signature.
pub fn verify<S: Read + Write>(board: &mut Client<S>, place: &str, actor: &ActorFile) -> Result<()> {
    let report = board.self_test()?;
    let expected = actor.content_hash;
    match report.actor {
        Ok(info) if info.content_hash == expected => {}
        Ok(info) => {
            return Err(FlashError::OtherActor { place: place.into(), found: info.content_hash, expected }.into());
        }
        Err(fault) => return Err(FlashError::wrong_file(&actor.path, &fault).into()),
    }
    say(&format!("{place} runs covey {} with actor {expected:016x}, self-test passed", report.software));
    let (there, here) = (board.fingerprint(CASES, CHUNK, |_| ())?, actor.signature(CASES)?);
    if there != here {
        let found = format!("{there:016x}");
        return Err(FlashError::Signature { place: place.into(), found, expected: here }.into());
    }
    say(&format!("signature over {CASES} neighbourhoods: {here:016x} there and here"));
    Ok(())
}

/// A serial port. A read without any bytes means that nothing came in time, not that the port has ended.
struct Port(File);

impl Read for Port {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.read(buffer) {
            Ok(0) if !buffer.is_empty() => Err(ErrorKind::WouldBlock.into()),
            read => read,
        }
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
