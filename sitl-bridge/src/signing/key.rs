//! The secret key: reading it, and keeping it out of logs and freed memory.

use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Read as _};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::{env, fmt};
use subtle::ConstantTimeEq as _;
use thiserror::Error;
use zeroize::{Zeroize as _, Zeroizing};

/// The longest text a key is read from, bytes.
const MAX_TEXT: u64 = 4096;

/// What stands before a passphrase that looks like something else.
const INSISTS: &str = "passphrase:";

/// A key of 32 bytes, wiped from memory when dropped. It is never printed.
#[derive(Clone)]
pub struct Key([u8; 32]);

/// Why a key cannot be read.
#[derive(Debug, Error)]
pub enum KeyError {
    /// The file cannot be read.
    #[error("cannot read the signing key {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// It is a directory, a device or a pipe.
    #[error("the signing key {} is not a regular file", .0.display())]
    NotAFile(PathBuf),
    /// Other users may read or change it.
    #[error(
        "the signing key {} may be read or changed by others (mode {mode:03o}): run `chmod 600 {}`",
        path.display(), path.display()
    )]
    Permissions {
        /// The file.
        path: PathBuf,
        /// Its permission bits.
        mode: u32,
    },
    /// It belongs to another user than the one who runs this, and not to root.
    #[error("the signing key {} belongs to user {owner}, not to you: run `chown $USER {}`", path.display(), path.display())]
    Owner {
        /// The file.
        path: PathBuf,
        /// Its owner's number.
        owner: u32,
    },
    /// The environment variable is not set.
    #[error("the environment variable {0} with the signing key is not set")]
    NotSet(String),
    /// It is empty.
    #[error("the signing key in {0} is empty: `openssl rand -hex 32` makes one")]
    Empty(String),
    /// It is neither text nor hexadecimal digits.
    #[error("the signing key in {0} is no text: it must be 64 hexadecimal digits or a passphrase")]
    NotText(String),
    /// It looks like a key in another notation than hexadecimal digits.
    #[error(
        "the signing key in {place} looks like {notation}: give its 32 bytes as 64 hexadecimal digits and nothing else \
         ({how}), or write `passphrase:` before it if it really is a passphrase"
    )]
    Notation {
        /// Where it was read.
        place: String,
        /// What it looks like.
        notation: &'static str,
        /// How to convert it.
        how: &'static str,
    },
    /// It looks like hexadecimal digits, but not 64 of them.
    #[error(
        "the signing key in {place} has {digits} hexadecimal digits, a key has 64; a passphrase needs another character"
    )]
    Digits {
        /// Where it was read.
        place: String,
        /// How many there are.
        digits: usize,
    },
}

impl Key {
    /// A key made of these bytes.
    #[must_use]
    pub const fn new(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// The key of a passphrase, as MAVProxy and Mission Planner make it: its SHA-256.
    #[must_use]
    pub fn from_passphrase(passphrase: &str) -> Self {
        Self(Sha256::digest(passphrase.as_bytes()).into())
    }

    /// Reads a key from a file that only its owner may read: 64 hexadecimal digits, or a
    /// passphrase. White space around it does not count. What follows `passphrase:` is one, whatever it
    /// looks like.
    ///
    /// # Errors
    /// See [`KeyError`].
    pub fn from_file(path: &Path) -> Result<Self, KeyError> {
        let read = |source| KeyError::Read { path: path.into(), source };
        // What is checked is what was opened, whoever renames files meanwhile. A pipe without a
        // writer must not hang here.
        let nonblocking = rustix::fs::OFlags::NONBLOCK.bits();
        let file = {
            use std::os::unix::fs::OpenOptionsExt as _;
            File::options().read(true).custom_flags(nonblocking as i32).open(path).map_err(read)?
        };
        let metadata = file.metadata().map_err(read)?;
        if !metadata.is_file() {
            return Err(KeyError::NotAFile(path.into()));
        }
        let mode = metadata.permissions().mode() & 0o777;
        if mode & 0o077 != 0 {
            return Err(KeyError::Permissions { path: path.into(), mode });
        }
        let owner = metadata.uid();
        if owner != 0 && owner != rustix::process::geteuid().as_raw() {
            return Err(KeyError::Owner { path: path.into(), owner });
        }
        // As much at once as is ever read, so that no half-filled copy is left behind by growing.
        let mut text = Zeroizing::new(Vec::with_capacity(MAX_TEXT as usize + 1));
        file.take(MAX_TEXT).read_to_end(&mut text).map_err(read)?;
        Self::from_text(&text, &path.display().to_string())
    }

    /// Reads a key from an environment variable: 64 hexadecimal digits, or a passphrase.
    ///
    /// # Errors
    /// See [`KeyError`].
    pub fn from_environment(variable: &str) -> Result<Self, KeyError> {
        let value = env::var_os(variable).ok_or_else(|| KeyError::NotSet(variable.into()))?;
        let text = Zeroizing::new(value.into_encoded_bytes());
        Self::from_text(&text, variable)
    }

    /// Reads 64 hexadecimal digits, or a passphrase; `place` is for the message.
    fn from_text(text: &[u8], place: &str) -> Result<Self, KeyError> {
        let text = str::from_utf8(text).map_err(|_| KeyError::NotText(place.into()))?.trim();
        if text.is_empty() {
            return Err(KeyError::Empty(place.into()));
        }
        if let Some(passphrase) = text.strip_prefix(INSISTS) {
            return Ok(Self::from_passphrase(passphrase));
        }
        if let Some((notation, how)) = other_notation(text) {
            return Err(KeyError::Notation { place: place.into(), notation, how });
        }
        let digits = text.len();
        if !text.bytes().all(|b| b.is_ascii_hexdigit()) || digits < 32 {
            return Ok(Self::from_passphrase(text));
        }
        // So long a row of hexadecimal digits is a key with some missing, not a passphrase.
        if digits != 64 {
            return Err(KeyError::Digits { place: place.into(), digits });
        }
        let mut key = Self([0; 32]);
        for (byte, pair) in key.0.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
            *byte = pair.iter().fold(0, |value, &digit| value << 4 | (digit as char).to_digit(16).unwrap_or(0) as u8);
        }
        Ok(key)
    }

    /// The code of a frame: the first 48 bits of SHA-256 over key, frame, link id and timestamp.
    pub(super) fn code(&self, frame: &[u8], link_and_time: &[u8]) -> [u8; 6] {
        let mut hash = Sha256::new();
        hash.update(self.0);
        hash.update(frame);
        hash.update(link_and_time);
        let hash = hash.finalize();
        [hash[0], hash[1], hash[2], hash[3], hash[4], hash[5]]
    }

    /// Whether this is the code of the frame, compared in constant time.
    pub(super) fn is_code(&self, code: [u8; 6], frame: &[u8], link_and_time: &[u8]) -> bool {
        self.code(frame, link_and_time).ct_eq(&code).into()
    }
}

/// The notation of a text that is likely a key and no passphrase, and how to convert it.
fn other_notation(text: &str) -> Option<(&'static str, &'static str)> {
    if text.starts_with('\u{feff}') {
        return Some(("text with a byte order mark", "save it as UTF-8 without one"));
    }
    let hex = |text: &str| text.len() >= 32 && text.bytes().all(|b| b.is_ascii_hexdigit());
    if text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")).is_some_and(hex) {
        return Some(("hexadecimal digits with a prefix", "without `0x`"));
    }
    // 32 bytes are 43 characters and a pad. Words are not written with capitals, small letters and digits mixed.
    let characters = text.strip_suffix('=').unwrap_or(text);
    let alphabet = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'/' | b'-' | b'_');
    let has = |kind: fn(&u8) -> bool| characters.bytes().any(|b| kind(&b));
    let mixed = has(u8::is_ascii_uppercase) && has(u8::is_ascii_lowercase) && has(u8::is_ascii_digit);
    if characters.len() == 43 && characters.bytes().all(alphabet) && (mixed || text.len() == 44) {
        return Some(("base64 of 32 bytes", "`base64 -d | xxd -p -c 32` converts it"));
    }
    None
}

impl Drop for Key {
    fn drop(&mut self) {
        self.0.zeroize();
    }
}

/// Prints that there is a key, but not its bytes.
impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(secret)")
    }
}
