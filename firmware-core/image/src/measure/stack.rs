//! How much stack a call takes.

use core::ptr;

const PAINT: u32 = 0x5aa5_c33c;
/// Words painted below the caller's frame: more than anything here may use.
const WORDS: usize = 4096;
/// Words right below the stack pointer that are left alone.
const MARGIN: usize = 16;

/// Bytes of stack that `action` takes, its own frame included; 0 where it takes no more than 64.
#[inline(never)]
pub fn used(action: impl FnOnce()) -> u32 {
    let top = cortex_m::register::msp::read() as usize - 4 * MARGIN;
    let word = |k: usize| ptr::with_exposed_provenance_mut::<u32>(top - 4 * (k + 1));
    for k in 0..WORDS {
        // SAFETY: below the stack pointer nothing is kept, and no interrupt is enabled; the stack is far larger.
        unsafe { word(k).write_volatile(PAINT) };
    }
    action();
    let clean = |k: &usize| unsafe { word(*k).read_volatile() } == PAINT;
    let deepest = WORDS - (0..WORDS).rev().take_while(clean).count();
    if deepest == 0 { 0 } else { 4 * (MARGIN + deepest) as u32 }
}
