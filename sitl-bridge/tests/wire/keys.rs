use super::frame;
use sitl_bridge::frame::Rejected;
use sitl_bridge::signing::{Key, LinkSigning, Session, StateFile, StateFileError, Timestamp, Unsigned};
use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::time::Duration;

const NOW: Timestamp = Timestamp::from_unix_us(1_790_000_000_000_000);

/// What a key signs a frame with: two keys that sign the same are the same.
fn code(key: Key) -> [u8; 6] {
    let link = LinkSigning::new(key, 1, Unsigned::Refuse);
    let sealed = Session::new().sign(&link, frame(1), NOW).expect("a signed frame");
    sealed.signature().expect("a signature").code
}

fn key_file(folder: &Path, text: &[u8], mode: u32) -> PathBuf {
    let path = folder.join("swarm.key");
    fs::write(&path, text).unwrap();
    fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
    path
}

#[test]
fn a_key_is_64_hexadecimal_digits_or_a_passphrase() {
    let folder = tempfile::tempdir().unwrap();
    let digits = "000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F";
    let bytes: [u8; 32] = std::array::from_fn(|i| i as u8);
    for text in [digits.to_owned(), format!("{digits}\n"), format!("  {digits}\r\n"), digits.to_lowercase()] {
        let read = Key::from_file(&key_file(folder.path(), text.as_bytes(), 0o600)).unwrap();
        assert_eq!(code(read), code(Key::new(bytes)));
    }
    // SHA-256 of "abc" is in the standard (FIPS 180-4).
    let read = Key::from_file(&key_file(folder.path(), b"abc\n", 0o400)).unwrap();
    let sha = [
        0xba, 0x78, 0x16, 0xbf, 0x8f, 0x01, 0xcf, 0xea, 0x41, 0x41, 0x40, 0xde, 0x5d, 0xae, 0x22, 0x23, 0xb0, 0x03,
        0x61, 0xa3, 0x96, 0x17, 0x7a, 0x9c, 0xb4, 0x10, 0xff, 0x61, 0xf2, 0x00, 0x15, 0xad,
    ];
    assert_eq!(code(read), code(Key::new(sha)));
}

#[test]
fn a_key_that_others_may_read_is_refused_with_the_cure() {
    let folder = tempfile::tempdir().unwrap();
    for mode in [0o640, 0o604, 0o660, 0o644, 0o601, 0o777] {
        let path = key_file(folder.path(), b"a passphrase", mode);
        let error = Key::from_file(&path).expect_err("others may read it").to_string();
        assert!(error.contains(&format!("chmod 600 {}", path.display())), "{error}");
    }
    // A link does not hide the mode of the file.
    let open = key_file(folder.path(), b"a passphrase", 0o644);
    let link = folder.path().join("link");
    symlink(&open, &link).unwrap();
    assert!(Key::from_file(&link).is_err());
}

#[test]
fn what_is_no_key_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &[u8]| Key::from_file(&key_file(folder.path(), text, 0o600)).expect_err("no key").to_string();
    assert!(refused(b" \n").contains("empty"));
    assert!(refused(&[0xFF; 32]).contains("no text"));
    // Digits lost when copying are not taken for a passphrase.
    assert!(refused(&[b'a'; 63]).contains("63 hexadecimal digits"));
    assert!(refused(&[b'1'; 65]).contains("65 hexadecimal digits"));
    assert!(Key::from_file(folder.path()).expect_err("a folder").to_string().contains("not a regular file"));
    let missing = folder.path().join("missing.key");
    assert!(Key::from_file(&missing).expect_err("nothing").to_string().contains("missing.key"));
}

#[test]
fn what_looks_like_a_key_in_another_notation_is_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let read = |text: &str| Key::from_file(&key_file(folder.path(), text.as_bytes(), 0o600));
    let texts = [
        ("0x000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F", "without `0x`"),
        ("AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8=", "base64 -d"),
        ("AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8", "base64 -d"),
        ("\u{feff}a passphrase", "UTF-8"),
    ];
    for (text, how) in texts {
        let error = read(text).expect_err("likely no passphrase").to_string();
        assert!(error.contains(how) && error.contains("`passphrase:`") && !error.contains(text), "{error}");
        let insisted = read(&format!("passphrase:{text}\n")).unwrap();
        assert_eq!(code(insisted), code(Key::from_passphrase(text)));
    }
    for text in ["four words of a passphrase, not so short", "0xcafe", "thequickbrownfoxjumpsoverthelazydogandsleeps"] {
        assert_eq!(code(read(text).unwrap()), code(Key::from_passphrase(text)));
    }
}

#[test]
fn a_key_comes_from_the_environment_too() {
    // Set by cargo for every test.
    let text = std::env::var("CARGO_PKG_NAME").unwrap();
    assert_eq!(code(Key::from_environment("CARGO_PKG_NAME").unwrap()), code(Key::from_passphrase(&text)));
    let error = Key::from_environment("COVEY_NO_SUCH_VARIABLE").expect_err("not set").to_string();
    assert!(error.contains("COVEY_NO_SUCH_VARIABLE"), "{error}");
}

#[test]
fn nothing_prints_a_key() {
    let key = Key::new([0xA7; 32]);
    let link = LinkSigning::new(key.clone(), 1, Unsigned::Refuse);
    let mut session = Session::new();
    let sealed = session.sign(&link, frame(1), NOW).unwrap();
    for printed in [format!("{key:?}"), format!("{link:#?}"), format!("{session:#?}"), format!("{sealed:?}")] {
        let printed = printed.to_lowercase();
        assert!(!printed.contains("a7") && !printed.contains("167"), "{printed}");
    }
}

/// A session with this file, `seconds` after [`NOW`].
fn open(path: &Path, seconds: u64) -> Result<Session, StateFileError> {
    Session::with_state(StateFile::open(path)?, NOW.after(Duration::from_secs(seconds)))
}

/// The timestamp that a session signs with, `seconds` after [`NOW`].
fn issue(session: &mut Session, seconds: u64) -> Timestamp {
    let link = LinkSigning::new(Key::new([1; 32]), 1, Unsigned::Refuse);
    let sealed = session.sign(&link, frame(1), NOW.after(Duration::from_secs(seconds))).expect("a signed frame");
    sealed.signature().expect("a signature").timestamp
}

#[test]
fn a_restart_repeats_no_timestamp_even_when_the_clock_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state");
    let mut last = Timestamp::default();
    // The clock: right, 1000 s behind, unset, right again.
    for (start, seconds) in [(0, 0), (1, 1), (2, 2), (3, 3)] {
        let now = match start {
            1 => NOW.before(Duration::from_secs(1000)),
            2 => Timestamp::from_unix_us(0),
            _ => NOW.after(Duration::from_secs(seconds)),
        };
        let mut session = Session::with_state(StateFile::open(&path).unwrap(), now).unwrap();
        let link = LinkSigning::new(Key::new([1; 32]), 1, Unsigned::Refuse);
        for _ in 0..3 {
            let issued = session.sign(&link, frame(1), now).unwrap().signature().unwrap().timestamp;
            assert!(issued > last, "start {start}");
            last = issued;
        }
        // A lost clock costs nothing: the time goes on from the last one.
        assert!(last < NOW.after(Duration::from_secs(10)), "start {start}");
    }
}

#[test]
fn a_crash_repeats_no_timestamp() {
    let folder = tempfile::tempdir().unwrap();
    let (path, after_crash) = (folder.path().join("state"), folder.path().join("after-crash"));
    let mut session = open(&path, 0).unwrap();
    // Clock standing still: the timestamps go on by themselves.
    let last = (0..1000).map(|_| issue(&mut session, 0)).max().unwrap();
    // What a power cut leaves: the file as it is while the session lives.
    fs::copy(&path, &after_crash).unwrap();
    let first = issue(&mut open(&after_crash, 0).unwrap(), 0);
    assert!(first > last);
}

/// Sixty restarts in a minute do not carry the time away: others would follow it.
#[test]
fn restarts_in_order_leave_no_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state");
    for second in 0..60 {
        let issued = issue(&mut open(&path, second).unwrap(), second);
        assert!(issued <= NOW.after(Duration::from_secs(second)).next(), "start {second}");
    }
}

#[test]
fn a_state_that_cannot_be_kept_is_refused_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let nowhere = folder.path().join("no-such-folder/state");
    let error = open(&nowhere, 0).map(|_| ()).expect_err("no folder").to_string();
    assert!(error.contains("no-such-folder") && error.contains("may write"), "{error}");

    let path = folder.path().join("state");
    let sound = "covey signing state 1\ntime 1\nreserved 2\nheard 1 1 0 2\nheard 2 191 1 3\nend\n";
    fs::write(&path, sound).unwrap();
    assert!(open(&path, 0).is_ok());
    let cut = (0..sound.len()).map(|len| sound[..len].to_owned());
    let changed = [
        ("1\nt", "2\nt"),
        ("time 1", "time -1"),
        ("d 2\n", "d 999999999999999999\n"),
        ("191", "256"),
        ("3\n", "3 4\n"),
    ];
    for damage in cut.chain(changed.map(|(from, to)| sound.replacen(from, to, 1))).chain([sound.to_owned() + "\n"]) {
        fs::write(&path, &damage).unwrap();
        assert!(matches!(open(&path, 0), Err(StateFileError::Damaged(_))), "{damage:?}");
    }
    fs::write(&path, b"\xff\xff").unwrap();
    assert!(matches!(open(&path, 0), Err(StateFileError::Damaged(_))));
    fs::remove_file(&path).unwrap();

    let first = open(&path, 0).unwrap();
    assert!(matches!(open(&path, 0), Err(StateFileError::InUse(_))));
    drop(first);
    assert!(open(&path, 0).is_ok());
}

/// What was heard before is a replay after.
#[test]
fn a_restart_does_not_forget_what_was_heard() {
    let folder = tempfile::tempdir().unwrap();
    let (path, after_crash) = (folder.path().join("state"), folder.path().join("after-crash"));
    let link = LinkSigning::new(Key::new([1; 32]), 1, Unsigned::Refuse);
    let theirs = LinkSigning::new(Key::new([1; 32]), 2, Unsigned::Refuse);
    let mut sender = Session::new();
    let heard = sender.sign(&theirs, frame(1), NOW).unwrap();
    let mut session = open(&path, 0).unwrap();
    assert_eq!(session.verify(&link, &heard, NOW), Ok(()));
    // The next block is written with it.
    issue(&mut session, 55);
    while !fs::read_to_string(&path).unwrap().contains("heard 1 1 2 ") {
        std::thread::yield_now();
    }
    fs::copy(&path, &after_crash).unwrap();
    drop(session);
    let next = sender.sign(&theirs, frame(2), NOW).unwrap();
    for path in [path, after_crash] {
        let mut session = open(&path, 0).unwrap();
        assert_eq!(session.verify(&link, &heard, NOW), Err(Rejected::Replayed));
        assert_eq!(session.verify(&link, &next, NOW), Ok(()));
    }
}

/// A disk that fails in flight is said, and does not stop the flight.
#[test]
fn a_state_lost_in_flight_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state");
    let mut session = open(&path, 0).unwrap();
    issue(&mut session, 1);
    assert_eq!(session.state_error(), None);
    folder.close().unwrap();
    let mut seconds = 40;
    // The block is written in the background: go on flying until its failure is there.
    while session.state_error().is_none() {
        issue(&mut session, seconds);
        seconds += 1;
        std::thread::yield_now();
    }
    assert!(session.state_error().unwrap().contains("state"));
    assert!(issue(&mut session, seconds) > NOW.after(Duration::from_secs(40)));
}

#[test]
fn the_next_block_is_reserved_in_flight() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state");
    let reserved = |path: &Path| {
        let text = fs::read_to_string(path).unwrap();
        let ticks = text.lines().find_map(|l| l.strip_prefix("reserved ")).unwrap().parse().unwrap();
        Timestamp::from_ticks(ticks)
    };
    let mut session = open(&path, 0).unwrap();
    let first = reserved(&path);
    assert_eq!(first, NOW.after(Duration::from_secs(60)));
    issue(&mut session, 29);
    assert_eq!(reserved(&path), first);
    let last = issue(&mut session, 55);
    // In the background.
    while reserved(&path) == first {
        std::thread::yield_now();
    }
    assert!(reserved(&path) > last.after(Duration::from_secs(30)));
    // When it ends in order, only what was used is kept.
    drop(session);
    assert_eq!(reserved(&path), last);
}
