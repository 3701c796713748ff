//! The part of QEMU's machine protocol (QMP) that reads the memory of an emulated board. Its messages are JSON
//! objects, one a line.

use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::error::{Error, Result};

/// A connection to the monitor of a running QEMU.
pub struct Qmp {
    stream: BufReader<UnixStream>,
    path: PathBuf,
}

impl Qmp {
    /// Connects to the socket at `path` and enters QMP's command mode.
    ///
    /// # Errors
    /// Nothing listens there, or it is not QEMU.
    pub fn connect(path: &Path) -> Result<Self> {
        let stream = UnixStream::connect(path).map_err(Error::file(path))?;
        let mut monitor = Self { stream: BufReader::new(stream), path: path.into() };
        monitor.read()?;
        monitor.ask(&json!({"execute": "qmp_capabilities"}))?;
        Ok(monitor)
    }

    /// Stops the emulated board and writes `size` bytes of its memory from `address` to a file.
    ///
    /// # Errors
    /// QEMU refuses, or the connection is lost.
    pub fn save_memory(&mut self, address: u64, size: u64, file: &Path) -> Result<()> {
        self.ask(&json!({"execute": "stop"}))?;
        let arguments = json!({"val": address, "size": size, "filename": file});
        self.ask(&json!({"execute": "pmemsave", "arguments": arguments}))
    }

    /// Sends a command and waits for its result.
    fn ask(&mut self, command: &Value) -> Result<()> {
        let line = format!("{command}\n");
        self.stream.get_mut().write_all(line.as_bytes()).map_err(Error::file(&self.path))?;
        loop {
            let answer = self.read()?;
            if answer.get("return").is_some() {
                return Ok(());
            }
            if let Some(error) = answer.get("error") {
                return Err(Error::Board(format!("QEMU refuses {command}: {error}")));
            }
            // Every other message is an event and of no interest here.
        }
    }

    /// Reads the next message.
    fn read(&mut self) -> Result<Value> {
        let mut line = String::new();
        self.stream.read_line(&mut line).map_err(Error::file(&self.path))?;
        serde_json::from_str(&line).map_err(|error| Error::Board(format!("QEMU's monitor said {line:?}: {error}")))
    }
}
