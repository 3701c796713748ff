//! Exact instruction counts.
//!
//! With `-icount shift=10` QEMU's clock advances 1024 ns an instruction. Timer 0 counts at 25 MHz, one tick every
//! 40 ns: 25.6 ticks an instruction.

const TIMER: *mut u32 = 0x4000_0000 as *mut u32;
/// The timer's registers, in words.
const VALUE: usize = 1;
const RELOAD: usize = 2;

/// Starts the timer from the top.
fn start() {
    // SAFETY: registers of the timer, which nothing else uses.
    unsafe {
        TIMER.add(RELOAD).write_volatile(u32::MAX);
        TIMER.add(VALUE).write_volatile(u32::MAX);
        TIMER.write_volatile(1);
    }
}

/// The timer's value; it counts down.
fn ticks() -> u32 {
    // SAFETY: a register of the timer.
    unsafe { TIMER.add(VALUE).read_volatile() }
}

/// Instructions that `action` takes, up to 160 million, without those of calling and counting it.
pub fn count(action: impl FnOnce()) -> u32 {
    fn between(action: impl FnOnce()) -> u32 {
        start();
        let before = ticks();
        action();
        // Rounded: 10/256 instructions a tick.
        ((u64::from(before.wrapping_sub(ticks())) * 10 + 128) / 256) as u32
    }
    between(action).saturating_sub(between(|| ()))
}
