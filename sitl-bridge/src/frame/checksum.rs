//! MAVLink's checksum: CRC-16/MCRF4XX over the frame from its length byte on, then CRC_EXTRA, a byte
//! that depends on the message's fields, so that two dialects never mix.

use crc::{CRC_16_MCRF4XX, Crc, Table};
use mavlink::Message as _;
use mavlink::dialects::common::MavMessage;

static CRC: Crc<u16, Table<16>> = Crc::<u16, Table<16>>::new(&CRC_16_MCRF4XX);

/// (message id, CRC_EXTRA) of ardupilotmega.xml and what it includes beyond the common set.
/// ArduPilot sends many of them without a request; with CRC_EXTRA they can be skipped safely.
#[rustfmt::skip]
const ARDUPILOT: [(u32, u8); 91] = [
    (150, 134), (151, 219), (152, 208), (153, 188), (154, 84), (155, 22), (156, 19), (157, 21), (158, 134), (160, 78),
    (161, 68), (163, 127), (164, 154), (165, 21), (166, 21), (167, 144), (168, 1), (169, 234), (170, 73), (171, 181),
    (172, 22), (173, 83), (174, 167), (175, 138), (176, 234), (177, 240), (178, 47), (179, 189), (180, 52), (181, 174),
    (182, 229), (183, 85), (184, 159), (185, 186), (186, 72), (191, 92), (193, 71), (194, 98), (195, 120), (200, 134),
    (201, 205), (214, 69), (215, 101), (216, 50), (217, 202), (218, 17), (219, 162), (226, 207), (10001, 209),
    (10002, 186), (10003, 4), (10004, 133), (10005, 103), (10006, 193), (10007, 71), (10008, 240), (10151, 195),
    (11000, 134), (11001, 15), (11002, 234), (11003, 64), (11004, 11), (11005, 93), (11010, 46), (11011, 106),
    (11020, 205), (11030, 144), (11031, 133), (11032, 85), (11033, 195), (11034, 79), (11035, 128), (11036, 177),
    (11037, 130), (11038, 47), (11039, 142), (11040, 132), (11041, 208), (11042, 201), (11043, 193), (11044, 189),
    (11060, 162), (42000, 227), (42001, 239), (50001, 246), (50002, 181), (50003, 62), (50004, 240), (50005, 152),
    (52000, 13), (52001, 239),
];

/// CRC_EXTRA of a message; `None` for a message in neither the common set nor ArduPilot's.
#[must_use]
pub fn crc_extra(message_id: u32) -> Option<u8> {
    match MavMessage::extra_crc(message_id) {
        // Unknown to the common set, or one whose CRC_EXTRA is 0 (COMPONENT_INFORMATION).
        0 if MavMessage::default_message_from_id(message_id).is_some() => Some(0),
        0 => ARDUPILOT.binary_search_by_key(&message_id, |&(id, _)| id).ok().map(|at| ARDUPILOT[at].1),
        extra => Some(extra),
    }
}

/// The checksum of these bytes of a frame (without the magic byte) for a message.
pub(super) fn checksum(bytes: &[u8], extra: u8) -> u16 {
    let mut digest = CRC.digest();
    digest.update(bytes);
    digest.update(&[extra]);
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_can_be_searched_and_adds_to_the_common_set() {
        assert!(ARDUPILOT.is_sorted_by_key(|&(id, _)| id));
        let common = |id| MavMessage::default_message_from_id(id).is_some();
        assert!(ARDUPILOT.iter().all(|&(id, extra)| !common(id) && crc_extra(id) == Some(extra)));
        assert_eq!([0, 33, 248, 193].map(crc_extra), [Some(50), Some(104), Some(8), Some(71)]);
        assert_eq!([395, 3, 60_000, u32::MAX].map(crc_extra), [Some(0), None, None, None]);
    }

    /// The check value of this CRC in every catalogue.
    #[test]
    fn it_is_the_crc_of_mavlink() {
        assert_eq!(CRC.checksum(b"123456789"), 0x6F91);
    }
}
