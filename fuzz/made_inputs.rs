//! Runs a fuzz target's check on the stable compiler, for the tests of the crates: over its corpus, so that what it once
//! found stays fixed, and over inputs made of the corpus as a fuzzer makes them.

use std::fs;
use std::path::PathBuf;

/// Inputs made of a target's corpus in a run of the tests; COVEY_FUZZ_INPUTS asks for another number.
const MADE: u32 = 20_000;
/// Inputs that are kept to be changed further.
const KEPT: usize = 4096;
/// Bytes that readers treat in their own way: zero, one, a digit, a sign, and both sides of the sign bit.
const SPECIAL: [u8; 7] = [0, 1, b'9', b'-', 0x7f, 0x80, 0xff];

/// The folder of a target's corpus, seen from the crate whose tests include this file.
pub fn corpus(target: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target)
}

/// Marsaglia's xorshift: the same inputs every time.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % n.max(1)
    }
}

/// Checks the corpus of a target, then the inputs made of it.
pub fn run(target: &str, check: fn(&[u8])) {
    let mut paths: Vec<_> = fs::read_dir(corpus(target)).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let mut inputs: Vec<_> = paths.iter().map(|path| fs::read(path).unwrap()).collect();
    assert!(!inputs.is_empty());
    inputs.iter().for_each(|input| check(input));
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let asked = std::env::var("COVEY_FUZZ_INPUTS").ok().and_then(|text| text.parse().ok());
    for made in 0..asked.unwrap_or(MADE) {
        let input = changed(&inputs, &mut random);
        check(&input);
        // Some are changed further; of many runs the memory is bounded.
        if made.is_multiple_of(16) && inputs.len() < KEPT {
            inputs.push(input);
        } else if made.is_multiple_of(16) {
            let at = random.below(KEPT);
            inputs[at] = input;
        }
    }
}

/// One of the inputs with one to four changes.
fn changed(inputs: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut input = inputs[random.below(inputs.len())].clone();
    for _ in 0..=random.below(4) {
        let (at, other) = (random.below(input.len()), &inputs[random.below(inputs.len())]);
        let piece = &other[random.below(other.len())..];
        let piece = &piece[..random.below(piece.len() + 1).min(64)];
        let end = (at + random.below(16)).min(input.len());
        match random.below(6) {
            0 => input.truncate(at),
            1 => drop(input.drain(at..end)),
            2 => drop(input.splice(at..at, piece.iter().copied())),
            3 => drop(input.splice(at..end, piece.iter().copied())),
            4 => input.iter_mut().skip(at).take(1).for_each(|byte| *byte = SPECIAL[random.below(SPECIAL.len())]),
            _ => input.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << random.below(8)),
        }
    }
    input
}
