//! QEMU's mps2-an500 (Cortex-M7) and mps2-an386 (Cortex-M4F): the first CMSDK UART, which QEMU gives a socket.

use super::{Register, wait_for};

/// The board's name.
pub const NAME: &str = "mps2";

const UART: usize = 0x4000_4000;
/// Interrupt number of its receiver.
const RECEIVED: u16 = 0;

// State
const TX_FULL: u32 = 1;
const RX_FULL: u32 = 1 << 1;
// Control
const TX_ENABLE: u32 = 1;
const RX_ENABLE: u32 = 1 << 1;
const RX_INTERRUPT: u32 = 1 << 3;
/// Smallest divider; QEMU keeps no time on the line.
const FASTEST: u32 = 16;

/// The board.
pub struct Board {
    data: Register,
    state: Register,
    interrupts: Register,
}

impl Board {
    /// Sets up the line.
    #[must_use]
    pub fn take() -> Self {
        // SAFETY: the registers of the UART.
        let register = |offset| unsafe { Register::at(UART + offset) };
        register(0x10).write(FASTEST);
        register(0x08).write(TX_ENABLE | RX_ENABLE | RX_INTERRUPT);
        Self { data: register(0), state: register(0x04), interrupts: register(0x0c) }
    }

    /// The next byte from the line; sleeps until there is one.
    pub fn read(&mut self) -> u8 {
        while self.state.read() & RX_FULL == 0 {
            wait_for(RECEIVED);
        }
        self.interrupts.write(RX_FULL);
        self.data.read() as u8
    }

    /// Sends bytes.
    pub fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            while self.state.read() & TX_FULL != 0 {}
            self.data.write(byte.into());
        }
    }
}
