//! Asking a board over the PIL protocol what it runs.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use covey_pil::{Client, Options};

use super::{ActorFile, FlashError, say};
use crate::command::Cmd;
use crate::error::{Error, Result};

/// The board's speed, bit/s.
const BAUD: &str = "921600";
/// Neighbourhoods that a board signs: enough to tell, quick on a slow clock.
const CASES: u32 = 1000;
const CHUNK: u16 = 100;
const OPTIONS: Options = Options { timeout: Duration::from_secs(5), attempts: 3 };

/// Checks over a serial port that the board runs this actor and computes what this computer does.
///
/// # Errors
/// The port cannot be used, or the board does not.
pub fn check(actor: &ActorFile, port: &Path, dry_run: bool) -> Result<()> {
    // Raw bytes; a read returns after a tenth of a second without any.
    let stty = Cmd::new("stty").arg("-F").arg(port).args([BAUD, "raw", "-echo", "min", "0", "time", "1"]);
    if dry_run {
        println!("  {stty}");
        return Ok(());
    }
    stty.read()?;
    let file = OpenOptions::new().read(true).write(true).open(port).map_err(Error::file(port))?;
    verify(&mut Client::new(Port(file), OPTIONS), &port.display().to_string(), actor)
}

/// Checks that the board at the other end runs this actor and computes what this computer does.
///
/// # Errors
/// It does not, or does not answer.
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

/// A serial port, of which a read without bytes is no end.
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
