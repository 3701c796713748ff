//! Whole files: old or new, never half.

use std::cell::Cell;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use covey_report::atomic::{self, Disk, RealDisk, Stage, write, write_on};

/// A disk on which one operation fails, and which takes only so many bytes.
struct FaultyDisk {
    fails_at: Option<(&'static str, io::ErrorKind)>,
    room: Cell<usize>,
}

struct FaultyFile<'a> {
    inner: File,
    room: &'a Cell<usize>,
}

impl Write for FaultyFile<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.room.get().min(bytes.len());
        if n == 0 && !bytes.is_empty() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.room.set(self.room.get() - n);
        self.inner.write(&bytes[..n])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl FaultyDisk {
    fn failing(operation: &'static str, kind: io::ErrorKind) -> Self {
        Self { fails_at: Some((operation, kind)), room: Cell::new(usize::MAX) }
    }

    fn check(&self, operation: &str) -> io::Result<()> {
        match self.fails_at {
            Some((at, kind)) if at == operation => Err(kind.into()),
            _ => Ok(()),
        }
    }
}

/// Borrowed, so that files can share the room that is left.
struct On<'a>(&'a FaultyDisk);

impl<'a> Disk for On<'a> {
    type File = FaultyFile<'a>;

    fn create_new(&self, path: &Path) -> io::Result<Self::File> {
        self.0.check("create")?;
        Ok(FaultyFile { inner: RealDisk.create_new(path)?, room: &self.0.room })
    }
    fn sync(&self, file: &Self::File) -> io::Result<()> {
        self.0.check("sync")?;
        RealDisk.sync(&file.inner)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.0.check("rename")?;
        RealDisk.rename(from, to)
    }
    fn sync_folder(&self, folder: &Path) -> io::Result<()> {
        self.0.check("sync_folder")?;
        RealDisk.sync_folder(folder)
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        RealDisk.remove(path)
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn writes_a_new_file_and_replaces_an_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy");
    for content in [&b"first, and longer"[..], b"second", b""] {
        write(&path, content).unwrap();
        assert_eq!(fs::read(&path).unwrap(), content);
    }
    assert_eq!(names(folder.path()), ["policy"]);
}

#[test]
fn whatever_fails_before_the_rename_leaves_the_old_file_and_no_other() {
    let faults = [
        ("create", io::ErrorKind::PermissionDenied, Stage::Create, "Allow writing in"),
        ("sync", io::ErrorKind::QuotaExceeded, Stage::Write, "quota"),
        ("rename", io::ErrorKind::ReadOnlyFilesystem, Stage::Rename, "read-only"),
    ];
    for (operation, kind, stage, advice) in faults {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy");
        fs::write(&path, "old").unwrap();
        let error = write_on(&On(&FaultyDisk::failing(operation, kind)), &path, b"new").unwrap_err();
        assert_eq!((error.stage, error.source.kind()), (stage, kind));
        let message = error.to_string();
        assert!(message.contains(advice) && message.contains("policy held before is untouched"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old", "{operation}");
        assert_eq!(names(folder.path()), ["policy"], "{operation}");
    }
}

#[test]
fn a_disk_that_fills_up_leaves_the_old_file_at_every_length() {
    for room in 0..8 {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy");
        fs::write(&path, "old").unwrap();
        let disk = FaultyDisk { fails_at: None, room: Cell::new(room) };
        let error = write_on(&On(&disk), &path, b"12345678").unwrap_err();
        assert_eq!(error.stage, Stage::Write);
        assert!(error.to_string().contains("Free space on the disk"), "{error}");
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"old".to_vec(), vec!["policy".into()]));
    }
}

#[test]
fn a_folder_that_cannot_be_synced_is_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy");
    let error = write_on(&On(&FaultyDisk::failing("sync_folder", io::ErrorKind::Other)), &path, b"new").unwrap_err();
    assert_eq!(error.stage, Stage::SyncFolder);
    assert!(error.to_string().contains("The new file is in place"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

/// As shares do it, of which EINVAL and ENOTSUP are known.
#[test]
fn a_file_system_that_refuses_to_sync_is_lived_with() {
    for operation in ["sync", "sync_folder"] {
        for kind in [io::ErrorKind::InvalidInput, io::ErrorKind::Unsupported] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("policy");
            write_on(&On(&FaultyDisk::failing(operation, kind)), &path, b"new").unwrap();
            assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"new".to_vec(), vec!["policy".into()]));
        }
    }
}

#[test]
fn a_missing_folder_says_how_to_make_it() {
    let folder = tempfile::tempdir().unwrap();
    let error = write(folder.path().join("runs/a/policy"), b"new").unwrap_err();
    assert!(error.to_string().contains("mkdir -p") && error.to_string().contains("runs/a"), "{error}");
}

#[test]
fn a_folder_of_that_name_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy");
    fs::create_dir(&path).unwrap();
    let error = write(&path, b"new").unwrap_err();
    assert_eq!(error.stage, Stage::Rename);
    assert_eq!(names(folder.path()), ["policy"]);
    assert!(write("/", b"new").is_err());
}

/// The operating system's own refusal. The super-user may write everywhere, so
/// there the folder of a kernel file system stands in.
#[cfg(target_os = "linux")]
#[test]
fn the_operating_system_refuses_an_unwritable_folder() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
    let path = folder.path().join("policy");
    let refused = if File::create(folder.path().join("probe")).is_err() { path } else { "/proc/covey-policy".into() };
    let error = write(refused, b"new").unwrap_err();
    assert_eq!(error.stage, Stage::Create);
}

#[test]
fn leftovers_of_a_killed_process_are_removed_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path().join("policy"), b"new").unwrap();
    fs::write(folder.path().join(".policy.77-0.covey-tmp"), "half").unwrap();
    assert_eq!(atomic::remove_leftovers(folder.path()).unwrap(), 1);
    assert_eq!(names(folder.path()), ["policy"]);
}
