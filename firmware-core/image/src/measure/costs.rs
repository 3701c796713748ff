//! What the parts of a decision cost.

use core::hint::black_box;

use firmware_core::action::ACTIONS;
use firmware_core::actor::{Actor, MAX_FEATURE, Mode, NeighbourFeature};
use firmware_core::kernel::{Dense, Finish};
use firmware_core::observation::{LEN, MAX_NEIGHBOURS, Observation};

use super::console::result;
use super::instructions::count;
use super::stack::used;

/// Prints the costs of this actor, and of the layers that other kernels are compared by.
pub fn print(actor: &Actor<'_>) {
    result(b"dense_128_64_64_17", layers());
    let observation: Observation = black_box([37; LEN]);
    let own = actor.encode(&observation);
    let values = [[29i8; MAX_FEATURE]; MAX_NEIGHBOURS];
    let width = usize::from(actor.dimensions().feature);
    let neighbours = |n: usize| {
        values.iter().zip(0i16..).take(n).map(move |(values, k)| NeighbourFeature {
            values: values.get(..width).unwrap_or_default(),
            degree: 1 + k as u8,
            attention_source: 100 * k,
        })
    };
    let decide = |n: usize| {
        let logits = actor.logits(black_box(&own), n as u8 + 1, black_box(neighbours(n)));
        black_box(actor.choose(&logits, Mode::Sample, 10, 3, 7));
    };
    let step = || {
        let own = actor.encode(black_box(&observation));
        let logits = actor.logits(&own, MAX_NEIGHBOURS as u8 + 1, black_box(neighbours(MAX_NEIGHBOURS)));
        black_box(actor.choose(&logits, Mode::Sample, 10, 3, 7));
    };
    let encode = || {
        black_box(actor.encode(black_box(&observation)));
    };
    let alone = count(|| decide(0));
    let crowded = count(|| decide(MAX_NEIGHBOURS));
    result(b"encode", count(encode));
    result(b"per_neighbour", crowded.saturating_sub(alone) / MAX_NEIGHBOURS as u32);
    result(b"decide", alone);
    result(b"step16", count(step));
    result(b"encode_stack", used(encode));
    result(b"decide_stack", used(|| decide(MAX_NEIGHBOURS)));
}

/// Aligned, as in an actor file.
#[repr(align(4))]
struct Aligned<T>(T);

static WEIGHTS: Aligned<[u8; 128 * 64]> = Aligned([0xa7; 128 * 64]);
static TABLE: [[u8; 4]; 64] = [[0x11, 0x22, 0x33, 0x01]; 64];

/// Instructions of int8 layers 128 → 64 → 64 → 17 with biases and requantisation.
fn layers() -> u32 {
    let layer = |rows: usize, columns: usize| Dense {
        weights: WEIGHTS.0.get(..rows.next_multiple_of(2) * columns).unwrap_or_default(),
        biases: TABLE.get(..rows).unwrap_or_default(),
        multipliers: TABLE.get(..rows).unwrap_or_default(),
    };
    let layers = black_box([layer(64, 128), layer(64, 64), layer(ACTIONS, 64)]);
    let x = black_box(Aligned([5i16; 128]));
    count(|| {
        let [first, second, last] = &layers;
        let mut a = Aligned([0i16; 64]);
        first.apply(&x.0, &mut a.0, Finish::Rectified);
        let mut b = Aligned([0i16; 64]);
        second.apply(&a.0, &mut b.0, Finish::Rectified);
        let mut out = [0i16; ACTIONS];
        last.apply(&b.0, &mut out, Finish::Wide);
        black_box(out);
    })
}
