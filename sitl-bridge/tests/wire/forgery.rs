//! A million forged frames, and not one is believed.

use super::{frame, position, read};
use sitl_bridge::frame::{Counts, Encoder, Rejected};
use sitl_bridge::signing::{Key, LinkSigning, Session, Timestamp, Unsigned};

const NOW: Timestamp = Timestamp::from_unix_us(1_790_000_000_000_000);
/// Without optimisation a tenth must do.
const FORGED: u64 = if cfg!(debug_assertions) { 100_000 } else { 1_000_000 };

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

/// The forger has heard a genuine frame and knows all but the key. Frames have right checksums;
/// link ids, timestamps and codes are guessed, kept, or made with another key.
#[test]
fn of_a_million_forged_frames_none_is_believed() {
    let ours = LinkSigning::new(Key::from_passphrase("the swarm's own"), 0, Unsigned::Refuse);
    let theirs = LinkSigning::new(Key::from_passphrase("a guess"), 0, Unsigned::Refuse);
    let (mut sender, mut session, mut forger) = (Session::new(), Session::new(), Session::new());
    let genuine = sender.sign(&ours, frame(1), NOW).unwrap();
    assert_eq!(session.verify(&ours, &genuine, NOW), Ok(()));

    let mut random = Random(1);
    let mut encoder = Encoder::new(1, 1);
    let mut counts = Counts::new();
    for n in 0..FORGED {
        let forged = match n % 4 {
            // Another key.
            0 => forger.sign(&theirs, encoder.encode(&position(n as u32)).unwrap(), NOW).unwrap(),
            // Another message under the genuine signature; the forger's is cut off.
            kind => {
                let made = forger.sign(&theirs, encoder.encode(&position(n as u32)).unwrap(), NOW).unwrap();
                let (body, _) = made.bytes().split_last_chunk::<13>().unwrap();
                let mut signature = *genuine.bytes().last_chunk::<13>().unwrap();
                let guess = random.next().to_le_bytes();
                match kind {
                    1 => signature[7..].copy_from_slice(&guess[..6]),
                    2 => signature[1..3].copy_from_slice(&guess[..2]),
                    _ => signature[0] = guess[0],
                }
                read(&[body, &signature].concat()).0[0]
            }
        };
        match session.verify(&ours, &forged, NOW) {
            Ok(()) => panic!("believed {forged:?}, number {n}"),
            Err(reason) => counts.count(reason),
        }
    }
    assert_eq!((counts.total(), counts.get(Rejected::WrongKey)), (FORGED, FORGED));
    // And the genuine sender is heard as before.
    let next = sender.sign(&ours, frame(2), NOW).unwrap();
    assert_eq!(session.verify(&ours, &next, NOW), Ok(()));
}
