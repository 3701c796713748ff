//! The assembly kernel against its portable twin, on the processor it is for.

use firmware_core::kernel::{Dense, Finish, MAX_COLUMNS, portable};
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::console::result;

const MAX_ROWS: usize = 21;
const COLUMNS: usize = MAX_COLUMNS.next_multiple_of(2);

/// Room for the largest layer at any alignment.
struct Room {
    weights: [u8; MAX_ROWS.next_multiple_of(2) * COLUMNS + 4],
    biases: [[u8; 4]; MAX_ROWS],
    multipliers: [[u8; 4]; MAX_ROWS],
    x: [i16; COLUMNS + 2],
}

/// Compares this many pseudo-random layers, each with both finishes: all shapes up to 21 rows and the longest columns,
/// every alignment, values at random and at the ends of their ranges.
///
/// # Errors
/// The first layer whose outputs differ.
pub fn check(cases: u32) -> Result<(), &'static str> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(1);
    let mut room = Room {
        weights: [0; MAX_ROWS.next_multiple_of(2) * COLUMNS + 4],
        biases: [[0; 4]; MAX_ROWS],
        multipliers: [[0; 4]; MAX_ROWS],
        x: [0; COLUMNS + 2],
    };
    for case in 0..cases {
        if !room.same(case, &mut random) {
            result(b"differs", case);
            return Err("the assembly kernel differs from the portable one");
        }
    }
    result(b"cases", cases);
    Ok(())
}

impl Room {
    fn same(&mut self, case: u32, random: &mut Xoshiro128PlusPlus) -> bool {
        let mut below = |n: usize| random.next_u32() as usize % n;
        let rows = 1 + below(MAX_ROWS);
        // The longest rows in every fourth case.
        let pairs_of_columns = if case.is_multiple_of(4) { COLUMNS / 2 } else { 1 + below(COLUMNS / 2) };
        let (weights_at, x_at, extreme) = (below(4), below(2), case.is_multiple_of(3));
        let mut byte = || match random.next_u32() {
            // One end of the range in a row's every column, or near enough.
            r if extreme => [0x80, 0x81, 0x7f, 0xff, 0][(case / 3 + u32::from(r > 0xf000_0000)) as usize % 5],
            r => (r >> 24) as u8,
        };
        self.x.fill_with(|| i16::from(byte() as i8));
        // A packed byte is a weight too, offset or not, so any byte will do.
        self.weights.fill_with(&mut byte);
        self.biases.fill_with(|| (random.next_u32() as i32 >> 7).to_le_bytes());
        self.multipliers.fill_with(|| (random.next_u32() >> 1).to_le_bytes());
        let layer = Dense {
            weights: self.weights.get(weights_at..).unwrap_or_default(),
            biases: self.biases.get(..rows).unwrap_or_default(),
            multipliers: self.multipliers.get(..rows).unwrap_or_default(),
        };
        let x = self.x.get(x_at..x_at + 2 * pairs_of_columns).unwrap_or_default();
        [Finish::Rectified, Finish::Wide].into_iter().all(|finish| {
            let (mut assembly, mut plain) = ([-1; MAX_ROWS], [-1; MAX_ROWS]);
            layer.apply(x, &mut assembly, finish);
            portable::apply(&layer, x, &mut plain, finish);
            assembly == plain
        })
    }
}
