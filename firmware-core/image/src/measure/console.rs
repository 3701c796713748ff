//! Text to and from the computer that runs QEMU, by semihosting. Nothing here formats through `core::fmt`, whose
//! panic branches would stay in the program.

use cortex_m_semihosting::{debug, nr, syscall1};

/// Prints bytes.
pub fn print(text: &[u8]) {
    for byte in text {
        // SAFETY: WRITEC takes the address of a byte and only reads it.
        unsafe { syscall1(nr::WRITEC, (&raw const *byte).expose_provenance()) };
    }
}

/// Prints a line of a name and a decimal number.
pub fn result(name: &[u8], value: u32) {
    let mut digits = [b'0'; 10];
    let mut rest = value;
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    let zeros = digits.iter().take_while(|&&digit| digit == b'0').count();
    line(name, digits.get(zeros..).filter(|rest| !rest.is_empty()).unwrap_or(b"0"));
}

/// Prints a line of a name and a number of 16 hexadecimal digits.
pub fn result_hex(name: &[u8], value: u64) {
    let digit = |place: usize| match (value >> (60 - 4 * place)) as u8 & 15 {
        low @ 0..=9 => b'0' + low,
        high => b'a' + high - 10,
    };
    line(name, &core::array::from_fn::<u8, 16, _>(digit));
}

fn line(name: &[u8], value: &[u8]) {
    for part in [name, b" ", value, b"\n"] {
        print(part);
    }
}

/// The command line behind the program's name; empty when there is none or it does not fit.
pub fn command_line(buffer: &mut [u8; 64]) -> &[u8] {
    let mut block = [buffer.as_mut_ptr().expose_provenance(), buffer.len()];
    // SAFETY: GET_CMDLINE writes no more than the given length to the address, and the line's length to the block.
    let failed = unsafe { syscall1(nr::GET_CMDLINE, (&raw mut block).expose_provenance()) } != 0;
    let [_, length] = block;
    let line = buffer.get(..length).unwrap_or_default();
    let end = line.iter().position(|&byte| byte == b' ').map_or(length, |space| space + 1);
    if failed { &[] } else { line.get(end..).unwrap_or_default() }
}

/// Ends QEMU.
pub fn exit(success: bool) -> ! {
    debug::exit(if success { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}
