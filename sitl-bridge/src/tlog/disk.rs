//! A recording on the disk: made once, never written over, and safe from power cuts as it grows.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Folders of flights in one folder.
const FLIGHTS: u32 = 100_000;

/// A file whose flush waits for the disk.
#[derive(Debug)]
pub(super) struct RecordingFile(File);

impl RecordingFile {
    /// Makes the file; an error when one is there.
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let made = OpenOptions::new().write(true).create_new(true).open(path);
        match made {
            Ok(file) => {
                // The name too must outlive a power cut. Where a folder cannot be synchronised, it need not be.
                let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
                let _ = File::open(folder).and_then(|folder| folder.sync_all());
                Ok(Self(file))
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                // A pipe to another program keeps nothing that could be lost.
                match path.metadata() {
                    Ok(data) if !data.is_file() && !data.is_dir() => {
                        Ok(Self(OpenOptions::new().write(true).open(path)?))
                    }
                    _ => Err(error),
                }
            }
            Err(error) => Err(error),
        }
    }
}

impl Write for RecordingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.0.sync_data() {
            // Pipes and devices.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            result => result,
        }
    }
}

/// The folder for a flight's recordings: `folder` itself where no recording is in it, else a new folder
/// `flight-2`, `flight-3` and so on inside, so that flights are never mixed. Folders that are missing are made.
///
/// # Errors
/// A folder cannot be read or made.
pub fn flight_folder(folder: &Path) -> io::Result<PathBuf> {
    std::fs::create_dir_all(folder)?;
    let mut taken = false;
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name();
        let name = Path::new(&name);
        let is_world = || name.to_string_lossy().starts_with("world-") && name.extension().is_some_and(|e| e == "toml");
        taken |= name.extension().is_some_and(|e| e == "tlog") || is_world();
    }
    if !taken {
        return Ok(folder.to_owned());
    }
    for number in 2..FLIGHTS {
        let flight = folder.join(format!("flight-{number}"));
        match std::fs::create_dir(&flight) {
            Ok(()) => return Ok(flight),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("it has too many flights"))
}

/// Something written to that may be full at times.
#[derive(Debug)]
pub(super) struct Output<W> {
    output: W,
    /// The end of a batch that was written in part. It goes first, or the rest would be garbage.
    rest: Vec<u8>,
}

impl<W: Write> Output<W> {
    pub(super) const fn new(output: W) -> Self {
        Self { output, rest: Vec::new() }
    }

    /// Writes a batch, or nothing of it; or takes the part of it that is not written along.
    pub(super) fn write(&mut self, batch: &[u8]) -> io::Result<()> {
        let rest = std::mem::take(&mut self.rest);
        let (written, result) = write_some(&mut self.output, &rest);
        if result.is_err() {
            self.rest = rest[written..].to_vec();
            return result;
        }
        let (written, result) = write_some(&mut self.output, batch);
        if result.is_err() && written > 0 {
            self.rest = batch[written..].to_vec();
            return Ok(());
        }
        result
    }

    /// Writes what is left over and waits for the disk.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.write(&[])?;
        self.output.flush()
    }
}

/// Like `write_all`, but says how much was written.
fn write_some(output: &mut impl Write, bytes: &[u8]) -> (usize, io::Result<()>) {
    let mut written = 0;
    while written < bytes.len() {
        match output.write(&bytes[written..]) {
            Ok(0) => return (written, Err(io::ErrorKind::WriteZero.into())),
            Ok(len) => written += len,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return (written, Err(error)),
        }
    }
    (written, Ok(()))
}
