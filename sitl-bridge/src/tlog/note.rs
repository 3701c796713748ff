//! What stands in a recording beside the traffic: what was flown, by which settings, and what the operator commanded.
//!
//! A note is a text in STATUSTEXT frames of the node's system, component 155 (MAV_COMP_ID_LOG), which are written into
//! the tlog and never sent. Any reader of tlogs shows them. `docs/mavlink.md` tells their words.

use crate::frame::{Encoder, Frame};
use crate::messages::id;
use crate::node::OperatorCommand;
use std::collections::BTreeMap;
use std::fmt;

/// MAV_COMP_ID_LOG.
pub const NOTE_COMPONENT: u8 = 155;
/// MAV_SEVERITY_INFO.
const INFO: u8 = 6;
/// Characters in a frame.
const CHUNK: usize = 50;
/// STATUSTEXT's payload with its extensions.
const PAYLOAD: usize = 54;
/// Most chunks of a note.
const MAX_CHUNKS: u8 = 40;

/// A note in a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Note {
    /// A flight began with these settings.
    Flight(Flight),
    /// The operator, or the end of the program, commanded this.
    Command(OperatorCommand),
    /// From now on steps are counted from this Unix time, ms; with `None` there are none.
    Epoch(Option<i64>),
}

/// What was flown, and by which settings: names and values, as words without blanks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Flight(BTreeMap<String, String>);

impl Flight {
    /// Adds a setting.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl fmt::Display) -> Self {
        let value = value.to_string().split_whitespace().collect::<Vec<_>>().join("_");
        self.0.insert(name.to_owned(), value);
        self
    }

    /// A setting's value.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// A setting's value, read; `None` where it is missing or another kind of thing.
    #[must_use]
    pub fn number<T: std::str::FromStr>(&self, name: &str) -> Option<T> {
        self.get(name)?.parse().ok()
    }

    /// Names and values, in the order of names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flight(flight) => {
                write!(f, "covey flight 1")?;
                flight.iter().try_for_each(|(name, value)| write!(f, " {name}={value}"))
            }
            Self::Command(command) => write!(f, "covey command {}", command_name(*command)),
            Self::Epoch(Some(ms)) => write!(f, "covey epoch {ms}"),
            Self::Epoch(None) => write!(f, "covey epoch none"),
        }
    }
}

const fn command_name(command: OperatorCommand) -> &'static str {
    match command {
        OperatorCommand::Start => "start",
        OperatorCommand::Release => "release",
        OperatorCommand::Return => "return",
        OperatorCommand::Land => "land",
    }
}

impl Note {
    fn parse(text: &str) -> Option<Self> {
        let mut words = text.strip_prefix("covey ")?.split(' ');
        match words.next()? {
            "flight" if words.next() == Some("1") => {
                let pair = |word: &str| word.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
                Some(Self::Flight(Flight(words.filter_map(pair).collect())))
            }
            "command" => {
                let word = words.next()?;
                let all =
                    [OperatorCommand::Start, OperatorCommand::Release, OperatorCommand::Return, OperatorCommand::Land];
                all.into_iter().find(|&command| command_name(command) == word).map(Self::Command)
            }
            "epoch" => match words.next()? {
                "none" => Some(Self::Epoch(None)),
                ms => ms.parse().ok().map(|ms| Self::Epoch(Some(ms))),
            },
            _ => None,
        }
    }

    /// The frames of a note. `number` tells the notes of a recording apart and is not 0.
    pub(super) fn frames(&self, encoder: &mut Encoder, number: u16) -> Vec<Frame> {
        // Names and values are ASCII; a longer text is cut.
        let text: String =
            self.to_string().chars().filter(char::is_ascii).take(CHUNK * usize::from(MAX_CHUNKS)).collect();
        let mut frames = Vec::new();
        let mut chunks: Vec<&[u8]> = text.as_bytes().chunks(CHUNK).collect();
        if text.len().is_multiple_of(CHUNK) && text.len() < CHUNK * usize::from(MAX_CHUNKS) {
            // A text ends in a frame that is not full.
            chunks.push(&[]);
        }
        for (sequence, chunk) in (0..MAX_CHUNKS).zip(chunks) {
            let mut payload = [0; PAYLOAD];
            payload[0] = INFO;
            payload[1..1 + chunk.len()].copy_from_slice(chunk);
            payload[51..53].copy_from_slice(&number.to_le_bytes());
            payload[53] = sequence;
            // STATUSTEXT is a message of the common set.
            frames.extend(encoder.encode_payload(id::STATUSTEXT, &payload));
        }
        frames
    }

    /// Whether a frame is a piece of a note of this system.
    #[must_use]
    pub fn is_piece(frame: &Frame, system: u8) -> bool {
        frame.message_id() == id::STATUSTEXT && frame.system() == system && frame.component() == NOTE_COMPONENT
    }
}

/// Puts notes together from their frames.
#[derive(Clone, Debug, Default)]
pub struct NoteReader {
    number: u16,
    next: u8,
    text: Vec<u8>,
}

impl NoteReader {
    /// Takes in the next frame; the note, when it is whole.
    pub fn take(&mut self, frame: &Frame) -> Option<Note> {
        let mut payload = [0; PAYLOAD];
        let len = frame.payload().len().min(PAYLOAD);
        payload[..len].copy_from_slice(&frame.payload()[..len]);
        let number = u16::from_le_bytes([payload[51], payload[52]]);
        let sequence = payload[53];
        if sequence == 0 {
            *self = Self { number, ..Self::default() };
        }
        if number != self.number || sequence != self.next || sequence >= MAX_CHUNKS {
            // A piece is missing.
            *self = Self { next: u8::MAX, ..Self::default() };
            return None;
        }
        self.next += 1;
        let chunk = &payload[1..=CHUNK];
        let used = chunk.iter().position(|&b| b == 0).unwrap_or(CHUNK);
        self.text.extend_from_slice(&chunk[..used]);
        if used == CHUNK && self.next < MAX_CHUNKS {
            return None;
        }
        let text = std::mem::take(&mut self.text);
        Note::parse(std::str::from_utf8(&text).ok()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(frames: &[Frame]) -> Vec<Note> {
        let mut reader = NoteReader::default();
        frames.iter().filter_map(|frame| reader.take(frame)).collect()
    }

    #[test]
    fn commands_and_epochs_come_back() {
        let mut encoder = Encoder::new(4, NOTE_COMPONENT);
        let notes = [
            Note::Command(OperatorCommand::Return),
            Note::Epoch(Some(-5)),
            Note::Epoch(None),
            Note::Command(OperatorCommand::Land),
            Note::Command(OperatorCommand::Start),
            Note::Command(OperatorCommand::Release),
        ];
        let frames: Vec<_> =
            notes.iter().zip(1..).flat_map(|(note, number)| note.frames(&mut encoder, number)).collect();
        assert!(frames.iter().all(|frame| Note::is_piece(frame, 4) && !Note::is_piece(frame, 5)));
        assert_eq!(read(&frames), notes);
    }

    proptest! {
        #[test]
        fn settings_come_back_whatever_their_length(
            settings in prop::collection::btree_map("[a-z_]{1,12}", "[!-<>-~]{1,40}", 0..20), lost in any::<prop::sample::Index>(),
        ) {
            let flight = settings.iter().fold(Flight::default(), |flight, (name, value)| flight.with(name, value));
            let note = Note::Flight(flight);
            let mut encoder = Encoder::new(1, NOTE_COMPONENT);
            let mut frames = note.frames(&mut encoder, 7);
            let command = Note::Command(OperatorCommand::Start);
            frames.extend(command.frames(&mut encoder, 8));
            prop_assert_eq!(read(&frames), [note, command.clone()]);
            // A note that lacks a piece is none; the next is.
            if frames.len() > 2 {
                frames.remove(lost.index(frames.len() - 2));
                prop_assert_eq!(read(&frames), [command]);
            }
        }
    }
}
