//! Frames from and to the autopilot: parsing, authentication, encoding, signing.

use super::host_time::HostTime;
use crate::autopilot::Notice;
use crate::frame::{Counts, Encoder, Frame, Reader, Source};
use crate::messages::Payload;
use crate::signing::{LinkSigning, Session};
use crate::swarm_link::COMPONENT;

/// A node's end of the autopilot's link, without the socket.
#[derive(Debug)]
pub(super) struct AutopilotLink {
    reader: Reader,
    encoder: Encoder,
    signing: LinkSigning,
    rejected: Counts,
    /// A signed frame came although this link has no key; and it was told.
    signed: bool,
    signed_told: bool,
}

impl AutopilotLink {
    /// The end of the node with MAVLink system id `system`.
    pub fn new(system: u8, source: Source, signing: LinkSigning) -> Self {
        Self {
            reader: Reader::new(source),
            encoder: Encoder::new(system, COMPONENT),
            signing,
            rejected: Counts::new(),
            signed: false,
            signed_told: false,
        }
    }

    /// Drops a frame whose end was lost, when a stream was cut off and is connected again.
    pub fn reset(&mut self) {
        self.reader.reset();
    }

    /// Adds received bytes; then take their frames with [`Self::next_frame`].
    pub fn push(&mut self, bytes: &[u8]) {
        self.reader.push(bytes);
    }

    /// The next authentic frame. Others are counted and skipped.
    pub fn next_frame(&mut self, session: &mut Session, now: HostTime) -> Option<Frame> {
        while let Some(frame) = self.reader.next_frame() {
            self.signed |= frame.is_signed() && !self.signing.is_on();
            match session.verify(&self.signing, &frame, now.timestamp()) {
                Ok(()) => return Some(frame),
                Err(reason) => self.rejected.count(reason),
            }
        }
        None
    }

    /// The frame that carries a payload, signed where the link is.
    ///
    /// # Errors
    /// What went wrong, in words.
    pub fn encode(&mut self, payload: &Payload, session: &mut Session, now: HostTime) -> Result<Frame, String> {
        let frame = self.encoder.encode_payload(payload.id, payload.bytes()).map_err(|e| e.to_string())?;
        session.sign(&self.signing, frame, now.timestamp()).map_err(|e| e.to_string())
    }

    /// That the autopilot signs and the node has no key; once.
    pub fn keyless_notice(&mut self) -> Option<Notice> {
        let is_new = self.signed && !std::mem::replace(&mut self.signed_told, self.signed);
        let text = "the autopilot signs and this node has no key, so it may refuse all that is sent to it: \
                    --signing-key-file names the key";
        is_new.then(|| Notice::warning(text))
    }

    /// Frames and bytes that were not used, by reason.
    pub fn rejected(&self) -> Counts {
        let mut counts = self.rejected;
        counts += self.reader.counts();
        counts
    }
}
