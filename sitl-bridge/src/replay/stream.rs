//! Files that are no tlog, told by what they are.

use crate::frame;
use std::io::{self, Read};

/// What a file is instead of a tlog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// MAVLink frames without times, as they were on the wire.
    Stream,
    /// Another kind of recording.
    Other(&'static str),
}

/// So much of a file is looked at, bytes.
const LOOK: u64 = 1 << 20;
/// Length of a record's time.
const TIME: usize = 8;

/// Other files that are taken for tlogs, by their first bytes.
const KINDS: [(&[u8], &str); 9] = [
    (b"\xA3\x95", "a flight log of ArduPilot's own (.bin)"),
    (b"ULog", "a flight log of PX4's own (.ulg)"),
    (b"\x1f\x8b", "compressed by gzip: unpack it with `gunzip`"),
    (b"PK\x03\x04", "a ZIP archive: unpack it"),
    (b"(\xB5/\xFD", "compressed by zstd: unpack it with `unzstd`"),
    (b"\xD4\xC3\xB2\xA1", "a capture of network packets (pcap)"),
    (b"\xA1\xB2\xC3\xD4", "a capture of network packets (pcap)"),
    (b"\x0A\x0D\x0D\x0A", "a capture of network packets (pcapng)"),
    (b"timestamp,", "a table of QGroundControl's (.csv)"),
];

/// Looks at the beginning of a file; `None` when it may be a tlog.
///
/// # Errors
/// It cannot be read.
pub fn foreign(input: impl Read) -> io::Result<Option<Foreign>> {
    let mut bytes = Vec::new();
    input.take(LOOK).read_to_end(&mut bytes)?;
    Ok(of_bytes(&bytes))
}

fn of_bytes(bytes: &[u8]) -> Option<Foreign> {
    if let Some((_, kind)) = KINDS.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(Foreign::Other(kind));
    }
    // In a tlog eight bytes of time stand before each frame; on the wire frames follow one another.
    let (mut at, mut end) = (0, None);
    let (mut close, mut apart) = (0_usize, 0_usize);
    while at < bytes.len() {
        match frame::parse(&bytes[at..]) {
            Ok(frame) if frame.is_checked() => {
                match end.map(|end| at - end) {
                    Some(0) => close += 1,
                    Some(TIME) => apart += 1,
                    None if at == TIME => apart += 1,
                    _ => {}
                }
                at += frame.bytes().len();
                end = Some(at);
            }
            _ => at += 1,
        }
    }
    (close > 0 && close > apart).then_some(Foreign::Stream)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Encoder;

    #[test]
    fn frames_without_times_are_told_from_a_tlog() {
        let mut encoder = Encoder::new(1, 1);
        let mut frame = || encoder.encode_payload(0, &[4, 0, 0, 0, 2, 3, 81, 4, 3]).unwrap().bytes().to_vec();
        let raw: Vec<u8> = (0..20).flat_map(|_| frame()).collect();
        let time = 1_790_000_000_000_000u64.to_be_bytes();
        let tlog: Vec<u8> = (0..20).flat_map(|_| [&time[..], &frame()].concat()).collect();
        assert_eq!(of_bytes(&raw), Some(Foreign::Stream));
        // Cut anywhere at its beginning, and with noise in it.
        assert_eq!(of_bytes(&raw[7..]), Some(Foreign::Stream));
        assert_eq!(of_bytes(&[&raw[..100], &[0x55; 30], &raw[100..]].concat()), Some(Foreign::Stream));
        assert_eq!(of_bytes(&tlog), None);
        assert_eq!(of_bytes(&tlog[..40]), None);
        assert_eq!(of_bytes(&[&[0; 5][..], &tlog[3..]].concat()), None);
        assert_eq!(of_bytes(b""), None);
        assert!(matches!(of_bytes(b"\xA3\x95\x80\x80"), Some(Foreign::Other(kind)) if kind.contains("ArduPilot")));
    }
}
