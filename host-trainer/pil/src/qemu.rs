//! The flight program on QEMU's Cortex-M boards, with its serial line on a Unix socket.

use crate::client::Client;
use crate::exchange::Options;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Name of the emulator's program.
pub const PROGRAM: &str = "qemu-system-arm";
/// Where the image for QEMU looks for its actor file; see its memory map.
const ACTOR_ADDRESS: &str = "0x00200000";
/// How long QEMU may take to open its sockets.
const START_LIMIT: Duration = Duration::from_secs(30);
/// How long one read of the line blocks.
const READ_LIMIT: Duration = Duration::from_millis(10);
/// How long a read lets bytes gather first. QEMU sends every byte by itself, and to wake for each takes
/// processor time from the board: a third of its speed on two cores.
const GATHER: Duration = Duration::from_micros(300);

/// One of QEMU's boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// mps2-an500.
    CortexM7,
    /// mps2-an386.
    CortexM4f,
}

impl Machine {
    /// QEMU's name of the board.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CortexM7 => "mps2-an500",
            Self::CortexM4f => "mps2-an386",
        }
    }

    /// QEMU's arguments to run `image` with the actor file in its flash.
    #[must_use]
    pub fn arguments(self, image: &Path, actor: Option<&Path>) -> Vec<OsString> {
        let mut arguments: Vec<OsString> =
            ["-machine", self.name(), "-nographic", "-monitor", "none", "-kernel"].map(Into::into).into();
        arguments.push(image.into());
        if let Some(file) = actor {
            // In an option's value QEMU takes two commas for one.
            let file = file.display().to_string().replace(',', ",,");
            arguments.push("-device".into());
            arguments.push(format!("loader,file={file},addr={ACTOR_ADDRESS},force-raw=on").into());
        }
        arguments
    }
}

/// Why QEMU does not run.
#[derive(Debug, thiserror::Error)]
pub enum QemuError {
    /// The program is missing or may not be run.
    #[error("cannot start {PROGRAM}: {0}; `cargo xtask setup` installs it")]
    Start(io::Error),
    /// It ended at once with this output.
    #[error("{PROGRAM} ended at once: {0}")]
    Ended(String),
    /// A file for it could not be written.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system reported.
        cause: io::Error,
    },
}

impl QemuError {
    fn file(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |cause| Self::File { path, cause }
    }
}

/// A running QEMU; dropping it ends the process.
#[derive(Debug)]
pub struct Qemu {
    process: Child,
    folder: Folder,
    line: UnixStream,
}

impl Qemu {
    /// Starts the program `image` with the bytes of an actor file in its flash. It begins to run once its serial line
    /// is connected, so that nothing it sends is lost.
    ///
    /// # Errors
    /// [`QemuError`] when QEMU does not start.
    pub fn start(machine: Machine, image: &Path, actor: Option<&[u8]>) -> Result<Self, QemuError> {
        let folder = Folder::new()?;
        let actor = actor.map(|bytes| folder.write("actor", bytes)).transpose()?;
        let output = folder.0.join("output");
        let log = File::create(&output).map_err(QemuError::file(&output))?;
        let socket = |name, wait| format!("unix:{},server=on,wait={wait}", folder.0.join(name).display());
        let mut process = Command::new(PROGRAM)
            .args(machine.arguments(image, actor.as_deref()))
            .args(["-serial", &socket("line", "on"), "-qmp", &socket("monitor", "off")])
            .stdin(Stdio::null())
            .stdout(log.try_clone().map_err(QemuError::file(&output))?)
            .stderr(log)
            .spawn()
            .map_err(QemuError::Start)?;
        match connect(&folder.0.join("line"), &mut process) {
            Ok(Some(line)) => Ok(Self { process, folder, line }),
            Ok(None) => Err(QemuError::Ended(fs::read_to_string(&output).unwrap_or_default().trim().to_owned())),
            Err(error) => {
                end(&mut process);
                Err(error)
            }
        }
    }

    /// A client for the board's serial line.
    ///
    /// # Errors
    /// The system has no more sockets.
    pub fn client(&self, options: Options) -> Result<Client<Line>, QemuError> {
        Ok(Client::new(Line(self.line.try_clone().map_err(QemuError::file(&self.folder.0))?), options))
    }

    /// Writes bytes to the serial line.
    ///
    /// # Errors
    /// QEMU has ended.
    pub fn write(&self, bytes: &[u8]) -> Result<(), QemuError> {
        (&self.line).write_all(bytes).map_err(QemuError::file(&self.folder.0))
    }

    /// The socket of QEMU's monitor (QMP).
    #[must_use]
    pub fn monitor(&self) -> PathBuf {
        self.folder.0.join("monitor")
    }

    /// A temporary folder that is removed when this value is dropped.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder.0
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        end(&mut self.process);
    }
}

/// A board's serial line.
#[derive(Debug)]
pub struct Line(UnixStream);

impl Read for Line {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        thread::sleep(GATHER);
        self.0.read(buffer)
    }
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Ends the process; it may have ended by itself.
fn end(process: &mut Child) {
    let _ = process.kill();
    let _ = process.wait();
}

/// A temporary folder with a short name, since the path of a socket must be short; removed on drop.
#[derive(Debug)]
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, QemuError> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("covey-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir(&path).map_err(QemuError::file(&path))?;
        Ok(Self(path))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, QemuError> {
        let path = self.0.join(name);
        fs::write(&path, bytes).map_err(QemuError::file(&path))?;
        Ok(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that stays behind does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Connects once the socket is there; none if QEMU has ended.
fn connect(path: &Path, qemu: &mut Child) -> Result<Option<UnixStream>, QemuError> {
    let start = Instant::now();
    let line = loop {
        match UnixStream::connect(path) {
            Ok(stream) => break stream,
            Err(_) if matches!(qemu.try_wait(), Ok(Some(_))) => return Ok(None),
            Err(error) if start.elapsed() > START_LIMIT => return Err(QemuError::file(path)(error)),
            Err(_) => thread::sleep(Duration::from_millis(5)),
        }
    };
    line.set_read_timeout(Some(READ_LIMIT)).map_err(QemuError::file(path))?;
    Ok(Some(line))
}
