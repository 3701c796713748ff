//! The notes of one node in a recording.

use crate::frame::Frame;
use crate::tlog::{Flight, Note, NoteReader};

/// What the notes of one node say.
#[derive(Debug, Default)]
pub(super) struct Notes {
    reader: NoteReader,
    /// How many flights began.
    pub flights: u64,
    /// The settings of the last of them.
    pub flight: Option<Flight>,
    /// From which Unix time (ms) steps were counted in the end.
    pub epoch_ms: Option<i64>,
}

impl Notes {
    /// Takes in the next frame of a note.
    pub(super) fn take(&mut self, frame: &Frame) {
        match self.reader.take(frame) {
            Some(Note::Flight(flight)) => {
                self.flights += 1;
                self.flight = Some(flight);
            }
            Some(Note::Epoch(epoch_ms)) => self.epoch_ms = epoch_ms,
            Some(Note::Command(_)) | None => {}
        }
    }
}
