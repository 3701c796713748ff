//! STM32H743 and STM32H753: USART3, which NUCLEO-H743ZI2 wires to its USB connector (PD8 sends, PD9 receives).
//!
//! The core runs from the internal 64 MHz oscillator it starts with: with caches that decides in about a millisecond.
//! Register addresses and bits: reference manual RM0433.

use super::{Register, wait_for};

/// The board's name.
pub const NAME: &str = "stm32h743";

/// Speed of the line, bit/s: 8 bits, no parity, 1 stop bit.
const BAUD: u32 = 921_600;
/// The oscillator, Hz: clocks core and USART.
const HSI_HZ: u32 = 64_000_000;

const RCC: usize = 0x5802_4400;
const GPIOD: usize = 0x5802_0c00;
const USART3: usize = 0x4000_4800;
/// Interrupt number of USART3.
const USART3_INTERRUPT: u16 = 39;

// USART: CR1
const ENABLE: u32 = 1;
const RX_ENABLE: u32 = 1 << 2;
const TX_ENABLE: u32 = 1 << 3;
const RX_INTERRUPT: u32 = 1 << 5;
const FIFO_ENABLE: u32 = 1 << 29;
// USART: ISR and ICR
const OVERRUN: u32 = 1 << 3;
const RX_READY: u32 = 1 << 5;
const TX_READY: u32 = 1 << 7;

/// The board.
pub struct Board {
    status: Register,
    clear: Register,
    received: Register,
    send: Register,
}

impl Board {
    /// Switches the caches on and sets up the line.
    #[must_use]
    pub fn take() -> Self {
        if let Some(mut core) = cortex_m::Peripherals::take() {
            core.SCB.enable_icache();
            core.SCB.enable_dcache(&mut core.CPUID);
        }
        // SAFETY: registers of these peripherals.
        let register = |base: usize, offset| unsafe { Register::at(base + offset) };
        // Clocks of port D (AHB4ENR) and USART3 (APB1LENR); the latter's from HSI (D2CCIP2R).
        register(RCC, 0xe0).modify(0, 1 << 3);
        register(RCC, 0xe8).modify(0, 1 << 18);
        register(RCC, 0x54).modify(0b111, 0b011);
        // Read back: a peripheral answers only two cycles after its clock is on.
        register(RCC, 0xe8).read();
        // PD8 and PD9: alternate function (MODER) 7 (AFRH), USART3.
        register(GPIOD, 0x24).modify(0xff, 0x77);
        register(GPIOD, 0x00).modify(0b1111 << 16, 0b1010 << 16);
        // Baud rate register, rounded.
        register(USART3, 0x0c).write((HSI_HZ + BAUD / 2) / BAUD);
        register(USART3, 0x00).write(FIFO_ENABLE | RX_INTERRUPT | TX_ENABLE | RX_ENABLE | ENABLE);
        Self {
            status: register(USART3, 0x1c),
            clear: register(USART3, 0x20),
            received: register(USART3, 0x24),
            send: register(USART3, 0x28),
        }
    }

    /// The next byte from the line; sleeps until there is one.
    pub fn read(&mut self) -> u8 {
        while !self.status.has(RX_READY) {
            // A flood that overran the FIFO would otherwise keep waking us.
            self.clear.write(OVERRUN);
            wait_for(USART3_INTERRUPT);
        }
        self.received.read() as u8
    }

    /// Sends bytes.
    pub fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            while !self.status.has(TX_READY) {}
            self.send.write(byte.into());
        }
    }
}
