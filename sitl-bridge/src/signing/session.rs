//! Signing frames to send, and authenticating received ones.

use super::key::Key;
use super::state_file::{StateFile, StateFileError, Streams};
use super::timestamp::Timestamp;
use crate::frame::{Frame, Rejected};
use crate::messages::id;
use std::time::Duration;
use thiserror::Error;

/// How much older than our clock the first frame of a stream may be (MAVLink's rule).
const FIRST_SEEN: Duration = Duration::from_secs(60);
/// A sender this much ahead of our clock is believed, but its time is not taken over: one wrong clock
/// would otherwise move everybody's timestamps out of reach for good.
const FAR_AHEAD: Duration = Duration::from_secs(24 * 3600);
/// Before 2020 our own clock was never set, and the time of others is all there is.
const CLOCK_UNSET: Timestamp = Timestamp::from_unix_us(1_577_836_800_000_000);

/// How unsigned frames are treated on a link that has a key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unsigned {
    /// They are rejected, except RADIO_STATUS.
    #[default]
    Refuse,
    /// They are accepted like signed ones. Wrong signatures are still rejected.
    Accept,
}

/// The signing settings of one link.
#[derive(Clone, Debug)]
pub struct LinkSigning {
    key: Option<Key>,
    link_id: u8,
    unsigned: Unsigned,
}

/// Why a frame was not signed.
#[derive(Debug, Error)]
pub enum SigningError {
    /// MAVLink 1 has no signatures.
    #[error("this link has a signing key, and MAVLink 1 has no signatures: send MAVLink 2")]
    NeedsVersion2,
    /// The frame is signed already.
    #[error("the frame is signed already")]
    AlreadySigned,
}

impl LinkSigning {
    /// A link without a key: nothing is signed, all frames are accepted.
    #[must_use]
    pub const fn off() -> Self {
        Self { key: None, link_id: 0, unsigned: Unsigned::Accept }
    }

    /// A link with a key. `link_id` distinguishes the node's links and is part of each signature.
    #[must_use]
    pub const fn new(key: Key, link_id: u8, unsigned: Unsigned) -> Self {
        Self { key: Some(key), link_id, unsigned }
    }

    /// Whether frames are signed.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.key.is_some()
    }
}

/// The clock of a node's signatures and the newest timestamps of all senders. All links of the node share
/// it.
///
/// The timestamps it issues never repeat and never go back, whatever the system's clock does,
/// and with a [`StateFile`] not over a restart either.
#[derive(Debug, Default)]
pub struct Session {
    /// The newest timestamp of each (system, component, link id), authenticated or our own.
    streams: Streams,
    /// The time given in the last call.
    given: Timestamp,
    /// The session's time is the given time plus this: jumps back of the clock, and the lead of other
    /// senders.
    ahead: Duration,
    /// The newest timestamp that was issued; no older one is issued any more.
    issued: Timestamp,
    /// A sender was far ahead of our clock; and it was told.
    far_ahead: bool,
    far_ahead_told: bool,
    state: Option<StateFile>,
}

impl Session {
    /// A session without a state file. After a restart others reject its frames until the system's clock
    /// is later than before.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A session that continues where the last one with this state file ended.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn with_state(mut state: StateFile, now: Timestamp) -> Result<Self, StateFileError> {
        let mut session = Self::new();
        (session.issued, session.streams) = (state.reserved(), state.streams());
        session.learn(state.time(), now);
        let time = session.time(now);
        state.reserve(time, time.max(session.issued.next()), &session.streams)?;
        session.state = Some(state);
        Ok(session)
    }

    /// Signs a frame for this link; on a link without a key the frame is returned as it is.
    ///
    /// # Errors
    /// See [`SigningError`].
    pub fn sign(&mut self, link: &LinkSigning, frame: Frame, now: Timestamp) -> Result<Frame, SigningError> {
        let Some(key) = &link.key else { return Ok(frame) };
        if frame.is_signed() {
            return Err(SigningError::AlreadySigned);
        }
        let timestamp = self.issue(now);
        // Our own frames, sent back to us, are replays too.
        self.streams.insert((frame.system(), frame.component(), link.link_id), timestamp);
        let sign = |signed: &[u8]| {
            let mut signature = [0; crate::frame::SIGNATURE];
            signature[0] = link.link_id;
            signature[1..7].copy_from_slice(&timestamp.ticks().to_le_bytes()[..6]);
            let code = key.code(signed, &signature[..7]);
            signature[7..].copy_from_slice(&code);
            signature
        };
        frame.signed_with(sign).ok_or(SigningError::NeedsVersion2)
    }

    /// Authenticates a frame that was received on this link.
    ///
    /// # Errors
    /// [`Rejected::Unsigned`], [`Rejected::WrongKey`], [`Rejected::Replayed`] or
    /// [`Rejected::OldTimestamp`]; [`Rejected::UnknownMessage`] when neither a checksum nor a
    /// signature authenticates it.
    pub fn verify(&mut self, link: &LinkSigning, frame: &Frame, now: Timestamp) -> Result<(), Rejected> {
        let sound = if frame.is_checked() { Ok(()) } else { Err(Rejected::UnknownMessage) };
        let Some(key) = &link.key else { return sound };
        let Some(signature) = frame.signature() else {
            // Telemetry radios have no key and put RADIO_STATUS between the frames of others.
            let exempt = link.unsigned == Unsigned::Accept || frame.message_id() == id::RADIO_STATUS;
            return if exempt { sound } else { Err(Rejected::Unsigned) };
        };
        // The signature is checked before the table is touched, so that a forger cannot fill it.
        let link_and_time = frame.signature_bytes().map_or(&[][..], |bytes| &bytes[..7]);
        if !key.is_code(signature.code, frame.signed_part(), link_and_time) {
            return Err(Rejected::WrongKey);
        }
        let stream = (frame.system(), frame.component(), signature.link_id);
        let oldest = self.time(now).before(FIRST_SEEN);
        match self.streams.get(&stream) {
            Some(&newest) if signature.timestamp <= newest => return Err(Rejected::Replayed),
            None if signature.timestamp < oldest => return Err(Rejected::OldTimestamp),
            _ => {}
        }
        self.streams.insert(stream, signature.timestamp);
        if now >= CLOCK_UNSET && signature.timestamp.since(self.time(now)) > FAR_AHEAD {
            self.far_ahead = true;
        } else {
            self.learn(signature.timestamp, now);
        }
        Ok(())
    }

    /// Whether a sender with the key was more than a day ahead of our clock; true once.
    pub(crate) fn takes_far_future(&mut self) -> bool {
        self.far_ahead && !std::mem::replace(&mut self.far_ahead_told, self.far_ahead)
    }

    /// The error of the last write of the state file, if it failed: after a restart others may then reject
    /// our frames for a while.
    #[must_use]
    pub fn state_error(&self) -> Option<String> {
        self.state.as_ref().and_then(StateFile::error)
    }

    /// A timestamp later than all issued before.
    fn issue(&mut self, now: Timestamp) -> Timestamp {
        let time = self.time(now);
        self.issued = time.max(self.issued.next());
        if let Some(state) = &mut self.state {
            state.keep_ahead_of(time, self.issued, &self.streams);
        }
        self.issued
    }

    /// The session's time: it advances with the given time and never goes back.
    fn time(&mut self, now: Timestamp) -> Timestamp {
        self.ahead += self.given.since(now);
        self.given = now;
        now.after(self.ahead)
    }

    /// Advances to the time of another sender with the key; otherwise it would reject our frames as old.
    fn learn(&mut self, theirs: Timestamp, now: Timestamp) {
        let ours = self.time(now);
        self.ahead += theirs.since(ours);
    }
}

/// Gives back the reserved timestamps that were not used, so that a session that ends normally leaves no
/// gap.
impl Drop for Session {
    fn drop(&mut self) {
        if let Some(state) = &mut self.state {
            state.close(self.given.after(self.ahead), self.issued, std::mem::take(&mut self.streams));
        }
    }
}
