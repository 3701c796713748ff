//! What functions return.

use core::ffi::{CStr, c_char};
use firmware_core::actor::LoadError;

/// What a function returns: the `COVEY_` constants of the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
#[allow(missing_docs)] // The header says what each means.
pub enum Status {
    Ok = 0,
    Truncated = 1,
    Extended = 2,
    NotAnActor = 3,
    Version = 4,
    Checksum = 5,
    Malformed = 6,
    ObservationForm = 7,
    Dimension = 8,
    Length = 9,
    OutOfRange = 10,
    SelfTests = 11,
    ContentHash = 12,
    LoadFailed = 13,
    Null = 32,
    NotLoaded = 33,
    NotTested = 34,
    SelfTestFailed = 35,
    Argument = 36,
}

impl Status {
    /// Every status with its text.
    pub const ALL: [(Self, &'static CStr); 19] = [
        (Self::Ok, c"ok"),
        (Self::Truncated, c"the actor file is cut short"),
        (Self::Extended, c"bytes follow the actor file"),
        (Self::NotAnActor, c"this is no actor file"),
        (Self::Version, c"the actor file is of another format version: export it again"),
        (Self::Checksum, c"the actor file is damaged: copy it again"),
        (Self::Malformed, c"the actor file cannot be read: export it again"),
        (Self::ObservationForm, c"the actor wants another form of observation: train it again"),
        (Self::Dimension, c"the actor has widths that this library cannot fly"),
        (Self::Length, c"the actor's weights do not fit its widths"),
        (Self::OutOfRange, c"the actor has a number out of bounds"),
        (Self::SelfTests, c"the actor's self-test vectors cannot be read"),
        (Self::ContentHash, c"the actor's content hash does not fit its content"),
        (Self::LoadFailed, c"the actor file cannot be loaded"),
        (Self::Null, c"a pointer is NULL"),
        (Self::NotLoaded, c"no actor is loaded"),
        (Self::NotTested, c"the actor has not passed its self-test"),
        (Self::SelfTestFailed, c"the actor gives other logits than when it was exported: do not fly"),
        (Self::Argument, c"an argument is out of range"),
    ];
}

impl From<LoadError> for Status {
    fn from(e: LoadError) -> Self {
        match e {
            LoadError::Truncated { .. } => Self::Truncated,
            LoadError::Extended { .. } => Self::Extended,
            LoadError::NotAnActor => Self::NotAnActor,
            LoadError::Version { .. } => Self::Version,
            LoadError::Checksum { .. } => Self::Checksum,
            LoadError::Malformed => Self::Malformed,
            LoadError::Observation { .. } => Self::ObservationForm,
            LoadError::Dimension { .. } => Self::Dimension,
            LoadError::Length => Self::Length,
            LoadError::OutOfRange => Self::OutOfRange,
            LoadError::SelfTests => Self::SelfTests,
            LoadError::ContentHash => Self::ContentHash,
        }
    }
}

/// What a status means, in English.
#[unsafe(no_mangle)]
pub extern "C" fn covey_status_text(status: i32) -> *const c_char {
    let known = Status::ALL.iter().find(|(s, _)| *s as i32 == status);
    known.map_or(c"unknown status", |(_, text)| text).as_ptr()
}
