//! One run of the flight program in QEMU.

use std::fs;
use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use covey_link::{Client, Options};

use super::super::qemu::Machine;
use super::qmp::Qmp;
use super::{deepest, stack_of};
use crate::error::{Error, Result};

/// What the program's start-up code fills its stack with (cortex-m-rt).
const PAINT: u32 = 0xcccc_cccc;
/// How long QEMU may take to open its sockets.
const START_LIMIT: Duration = Duration::from_secs(30);
/// How long one read of the line blocks.
const READ_LIMIT: Duration = Duration::from_millis(10);

/// A running QEMU; it ends with this value.
pub struct Session {
    qemu: Child,
    folder: PathBuf,
    line: UnixStream,
}

impl Session {
    /// Starts the program with this actor file in its flash. It begins to run when its line is connected, so that
    /// nothing it says is lost.
    ///
    /// # Errors
    /// QEMU does not start.
    pub fn start(machine: Machine, program: &Path, actor: Option<&Path>) -> Result<Self> {
        let folder = private_folder()?;
        let (line, monitor) = (folder.join("line"), folder.join("monitor"));
        let command = machine
            .run(program, actor)
            .arg("-serial")
            .arg(format!("unix:{},server=on,wait=on", line.display()))
            .arg("-qmp")
            .arg(format!("unix:{},server=on,wait=off", monitor.display()));
        let output = folder.join("output");
        let mut qemu = command.spawn_into(&output)?;
        let line = connect(&line, &mut qemu)?.ok_or_else(|| Error::Failed {
            command: command.to_string(),
            status: "it ended at once".into(),
            output: format!("\n{}", fs::read_to_string(&output).unwrap_or_default().trim()),
        })?;
        line.set_read_timeout(Some(READ_LIMIT)).map_err(Error::file(&folder))?;
        Ok(Self { qemu, folder, line })
    }

    /// The host's end of the link.
    ///
    /// # Errors
    /// The system has no more sockets.
    pub fn client(&self, options: Options) -> Result<Client<UnixStream>> {
        Ok(Client::new(self.line.try_clone().map_err(Error::file(&self.folder))?, options))
    }

    /// Puts bytes on the line.
    ///
    /// # Errors
    /// QEMU has ended.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        (&self.line).write_all(bytes).map_err(Error::file(&self.folder))
    }

    /// The deepest stack so far, bytes; stops the program.
    ///
    /// # Errors
    /// QEMU's monitor does not answer.
    pub fn stack_used(&mut self, program: &Path) -> Result<u64> {
        let (end, start) = stack_of(program)?;
        let dump = self.folder.join("stack");
        let mut monitor = Qmp::connect(&self.folder.join("monitor"))?;
        monitor.save_memory(end, start - end, &dump)?;
        let ram = fs::read(&dump).map_err(Error::file(&dump))?;
        Ok(deepest(&ram, PAINT))
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // It may have ended by itself, and a folder left behind does no harm.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// A folder with a short name, as a socket's path must be short.
fn private_folder() -> Result<PathBuf> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = format!("covey-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(name);
    fs::create_dir(&folder).map_err(Error::file(&folder))?;
    Ok(folder)
}

/// Connects once the socket is there; none if QEMU has ended.
fn connect(path: &Path, qemu: &mut Child) -> Result<Option<UnixStream>> {
    let start = Instant::now();
    loop {
        match UnixStream::connect(path) {
            Ok(stream) => return Ok(Some(stream)),
            Err(_) if matches!(qemu.try_wait(), Ok(Some(_))) => return Ok(None),
            Err(error) if start.elapsed() > START_LIMIT => return Err(Error::file(path)(error)),
            Err(_) => thread::sleep(Duration::from_millis(5)),
        }
    }
}
