//! The board layer: a serial line, and nothing more.
//!
//! To port Covey to another board write a module like these, a memory map, and a feature that chooses them. A board
//! offers `NAME`, and a type `Board` with `take()` (sets up clocks and the line), `read()` (waits for a byte) and
//! `write(bytes)`.

#[cfg(feature = "mps2")]
mod mps2;
#[cfg(feature = "mps2")]
pub use mps2::{Board, NAME};

#[cfg(feature = "stm32h743")]
mod stm32h743;
#[cfg(feature = "stm32h743")]
pub use stm32h743::{Board, NAME};

/// A 32-bit register.
#[derive(Clone, Copy)]
struct Register(*mut u32);

impl Register {
    /// # Safety
    /// `address` must be that of a register of this board, which may be read and written at any time.
    const unsafe fn at(address: usize) -> Self {
        Self(address as *mut u32)
    }

    fn read(self) -> u32 {
        // SAFETY: see `at`.
        unsafe { self.0.read_volatile() }
    }

    fn write(self, value: u32) {
        // SAFETY: see `at`.
        unsafe { self.0.write_volatile(value) }
    }

    #[cfg(feature = "stm32h743")]
    fn modify(self, clear: u32, set: u32) {
        self.write(self.read() & !clear | set);
    }

    #[cfg(feature = "stm32h743")]
    fn has(self, bits: u32) -> bool {
        self.read() & bits != 0
    }
}

/// Sleeps until `interrupt` (its number) is pending, and clears it. No handler runs.
fn wait_for(interrupt: u16) {
    const ENABLE: usize = 0xe000_e100;
    const CLEAR_PENDING: usize = 0xe000_e280;
    let (word, bit) = (4 * usize::from(interrupt / 32), 1 << (interrupt % 32));
    // Masked, an interrupt wakes the processor all the same.
    cortex_m::interrupt::disable();
    // SAFETY: registers of the interrupt controller, which every Cortex-M has, for the interrupts a board has.
    let (enable, clear) = unsafe { (Register::at(ENABLE + word), Register::at(CLEAR_PENDING + word)) };
    enable.write(bit);
    cortex_m::asm::wfi();
    clear.write(bit);
}
