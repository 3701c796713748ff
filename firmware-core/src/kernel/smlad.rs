//! Layers on Cortex-M4 and M7 (ARMv7E-M with DSP): the only unsafe code on board.
//!
//! Four rows (two pairs) at a time, so that each word of the input is loaded once for all of them. Where input and
//! weights are word-aligned, 32 columns take 116 instructions for 128 multiplications, plus two for the loop. What is
//! left over, and data that is not aligned, goes a word at a time, at 11 instructions for 8 multiplications.
#![expect(unsafe_code, reason = "the assembly below")]

use core::arch::{asm, naked_asm};
use core::mem::offset_of;

use super::dense::Dense;
use super::finish::Finish;
use super::portable;

/// Words of two columns in a block of the assembly.
const BLOCK_WORDS: usize = 16;

/// See [`Dense::apply`].
pub(super) fn apply(layer: &Dense<'_>, x: &[i16], out: &mut [i16], finish: Finish) {
    if x.is_empty() || !x.len().is_multiple_of(2) {
        // Not whole words; rows are not where the assembly would look for them.
        return other(layer, x, out, finish);
    }
    let stride = 2 * x.len();
    let rows = out.len().min(layer.biases.len()).min(layer.multipliers.len()).min(layer.weights.len() / stride * 2);
    let words = x.len() / 2;
    let aligned = (x.as_ptr().addr() | layer.weights.as_ptr().addr()).is_multiple_of(4);
    let blocks = if aligned { words / BLOCK_WORDS } else { 0 };
    let mut job = Job {
        x: x.as_ptr(),
        blocks,
        start: sum(x).wrapping_mul(-128),
        stride,
        words: words - blocks * BLOCK_WORDS,
        biases: layer.biases.as_ptr().cast(),
        multipliers: layer.multipliers.as_ptr().cast(),
        out: out.as_mut_ptr(),
        tiles: rows / 4,
    };
    let tiles: Tiles = match finish {
        Finish::Rectified => tiles_rectified,
        Finish::Wide => tiles_wide,
    };
    let mut weights = layer.weights.as_ptr();
    if job.tiles > 0 {
        // SAFETY: `x` is `words` words and `weights` at least `rows / 2` pairs of so many; `biases`, `multipliers` and
        // `out` have at least `rows` places. Blocks are asked for only if both pointers are word-aligned, and as the
        // stride is a multiple of four, so is every pair.
        weights = unsafe { tiles(&mut job, weights) };
    }
    if !rows.is_multiple_of(4) {
        // SAFETY: as above; one or two pairs are left at `weights`.
        unsafe { last_rows(job, weights, tiles, layer, out, rows) };
    }
}

/// The last one to three of the rows: a tile of their own, with room for four. Of one pair, the tile has it twice.
///
/// # Safety
/// At `weights` are the one or two pairs of these rows, for the input that `job` has.
#[inline(never)]
unsafe fn last_rows(mut job: Job, weights: *const u8, tiles: Tiles, layer: &Dense<'_>, out: &mut [i16], rows: usize) {
    let done = rows & !3;
    let (mut biases, mut multipliers, mut last) = ([[0; 4]; 4], [[0; 4]; 4], [0; 4]);
    for (to, from) in biases.iter_mut().zip(layer.biases.iter().skip(done)) {
        *to = *from;
    }
    for (to, from) in multipliers.iter_mut().zip(layer.multipliers.iter().skip(done)) {
        *to = *from;
    }
    if rows - done < 3 {
        job.stride = 0;
    }
    job.biases = biases.as_ptr().cast();
    job.multipliers = multipliers.as_ptr().cast();
    job.out = last.as_mut_ptr();
    job.tiles = 1;
    // SAFETY: the caller's promise, and the arrays have four places.
    unsafe { tiles(&mut job, weights) };
    for (to, from) in out.iter_mut().take(rows).skip(done).zip(last) {
        *to = from;
    }
}

/// Off the common path, so that its variables take no stack there.
#[cold]
#[inline(never)]
fn other(layer: &Dense<'_>, x: &[i16], out: &mut [i16], finish: Finish) {
    portable::apply(layer, x, out, finish);
}

/// A function made by [`tiles`].
type Tiles = unsafe extern "C" fn(job: *mut Job, weights: *const u8) -> *const u8;

/// What the assembly works on; it knows this layout. The last four fields advance with each tile.
#[repr(C)]
struct Job {
    /// The input.
    x: *const i16,
    /// Blocks of [`BLOCK_WORDS`] words in a row; only if `x` and the weights are word-aligned.
    blocks: usize,
    /// Where the accumulators begin: −128·Σx, see [`super`]. It cancels in acc1 − acc2.
    start: i32,
    /// Bytes from the first pair of a tile to the second.
    stride: usize,
    /// Words in a row beyond the blocks.
    words: usize,
    /// Biases, four a tile, at any alignment.
    biases: *const i32,
    /// Multipliers, four a tile, at any alignment.
    multipliers: *const i32,
    /// Outputs, four a tile.
    out: *mut i16,
    /// Tiles to do, at least one.
    tiles: usize,
}

/// Σ x over whole words, at least one.
fn sum(x: &[i16]) -> i32 {
    let words = x.len() / 2;
    let eights = if x.as_ptr().addr().is_multiple_of(4) { words / 8 } else { 0 };
    let mut sum = 0;
    // SAFETY: reads eight times `eights` and then the other words of the slice, which are `words` together; LDM only
    // at multiples of four, while LDR takes any alignment.
    unsafe {
        asm!(
            "cbz r0, 3f",
            "2:",
            "ldm {x}!, {{r8-r11}}",
            "smlad {sum}, r8, {ones}, {sum}",
            "smlad {sum}, r9, {ones}, {sum}",
            "smlad {sum}, r10, {ones}, {sum}",
            "smlad {sum}, r11, {ones}, {sum}",
            "ldm {x}!, {{r8-r11}}",
            "smlad {sum}, r8, {ones}, {sum}",
            "smlad {sum}, r9, {ones}, {sum}",
            "smlad {sum}, r10, {ones}, {sum}",
            "smlad {sum}, r11, {ones}, {sum}",
            "subs r0, r0, #1",
            "bne 2b",
            "3:",
            "cbz r1, 5f",
            "4:",
            "ldr r8, [{x}], #4",
            "smlad {sum}, r8, {ones}, {sum}",
            "subs r1, r1, #1",
            "bne 4b",
            "5:",
            inout("r0") eights => _,
            inout("r1") words - 8 * eights => _,
            x = inout(reg) x.as_ptr() => _,
            ones = in(reg) 0x0001_0001,
            sum = inout(reg) sum,
            out("r8") _,
            out("r9") _,
            out("r10") _,
            out("r11") _,
            options(pure, readonly, nostack),
        );
    }
    sum
}

/// Two words (r12, lr) of the pair at `$pair` against the input words `$x0` and `$x1`.
macro_rules! two_words {
    ($pair:literal, $acc1:literal, $acc2:literal, $x0:literal, $x1:literal) => {
        concat!(
            "ldrd r12, lr, [",
            $pair,
            "], #8\n",
            "smlad ",
            $acc1,
            ", r12, ",
            $x0,
            ", ",
            $acc1,
            "\n",
            "uxtb16 r12, r12\n",
            "smlad ",
            $acc1,
            ", lr, ",
            $x1,
            ", ",
            $acc1,
            "\n",
            "uxtb16 lr, lr\n",
            "smlad ",
            $acc2,
            ", r12, ",
            $x0,
            ", ",
            $acc2,
            "\n",
            "smlad ",
            $acc2,
            ", lr, ",
            $x1,
            ", ",
            $acc2,
            "\n",
        )
    };
}

/// Four words of the input against both pairs.
macro_rules! four_words {
    () => {
        concat!(
            "ldm r0!, {{r8-r11}}\n",
            two_words!("r1", "r4", "r5", "r8", "r9"),
            two_words!("r1", "r4", "r5", "r10", "r11"),
            two_words!("r2", "r6", "r7", "r8", "r9"),
            two_words!("r2", "r6", "r7", "r10", "r11"),
        )
    };
}

/// Bias, multiplier and output of one row whose sum is `$sum`.
macro_rules! finish_row {
    ($sum:literal, $finish:literal) => {
        concat!(
            "ldr r3, [r8], #4\n",
            "ldr lr, [r9], #4\n",
            "add r3, r3, ", $sum, "\n",
            $finish,
            "strh r3, [r10], #2\n",
        )
    };
}

/// A function that computes `job.tiles` tiles of four rows, and returns where the weights behind them begin.
///
/// r0 x, r1 and r2 the pairs, r3 count, r4 to r7 acc1 and acc2 of both, r8 to r11 words of x, r12 and lr words of w.
macro_rules! tiles {
    ($(#[$doc:meta])* $name:ident, $finish:literal) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// All pointers must be good for so many tiles, and word-aligned (x, weights) if there are blocks. At least
        /// one tile.
        #[unsafe(naked)]
        unsafe extern "C" fn $name(job: *mut Job, weights: *const u8) -> *const u8 {
            naked_asm!(
                "push {{r0, r4-r11, lr}}",
                "mov r12, r0",
                "mov r2, r1",
                "1:",
                "ldm r12, {{r0, r3, r4, r5}}",
                "mov r1, r2",
                "add r2, r2, r5",
                "mov r5, r4",
                "mov r6, r4",
                "mov r7, r4",
                "cmp r3, #0",
                "beq 3f",
                "2:",
                four_words!(),
                four_words!(),
                four_words!(),
                four_words!(),
                "subs r3, r3, #1",
                "bne 2b",
                "3:",
                "ldr r12, [sp]",
                "ldr r3, [r12, #{words}]",
                "cbz r3, 5f",
                "4:",
                "ldr r8, [r0], #4",
                "ldr r9, [r1], #4",
                "ldr r10, [r2], #4",
                "smlad r4, r9, r8, r4",
                "uxtb16 r9, r9",
                "smlad r6, r10, r8, r6",
                "uxtb16 r10, r10",
                "smlad r5, r9, r8, r5",
                "smlad r7, r10, r8, r7",
                "subs r3, r3, #1",
                "bne 4b",
                "5:",
                "sub r4, r4, r5",
                "sub r6, r6, r7",
                "add r0, r12, #{advancing}",
                "ldm r0, {{r8-r11}}",
                finish_row!("r4, asr #8", $finish),
                finish_row!("r5", $finish),
                finish_row!("r6, asr #8", $finish),
                finish_row!("r7", $finish),
                "subs r11, r11, #1",
                "stm r0, {{r8-r11}}",
                "bne 1b",
                "mov r0, r2",
                "pop {{r1, r4-r11, pc}}",
                words = const offset_of!(Job, words),
                advancing = const offset_of!(Job, biases),
            )
        }
    };
}

tiles! {
    /// Tiles that end as [`Finish::Rectified`].
    tiles_rectified, "smmulr r3, r3, lr\n usat r3, #7, r3\n"
}

tiles! {
    /// Tiles that end as [`Finish::Wide`].
    tiles_wide, "lsl r3, r3, #4\n smmulr r3, r3, lr\n ssat r3, #16, r3\n"
}
