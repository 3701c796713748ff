//! The deepest possible stack of a Cortex-M program, computed from its machine code.
//!
//! A function's frame is the sum of all that its instructions subtract from the stack pointer. Its depth is its frame
//! plus the depth of the deepest function that it calls or jumps to. A call through a register is taken to reach
//! every function that is never called directly and is no interrupt handler. Recursion is an error.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};

use super::elf::with_elf;
use crate::error::{Error, Result};

/// The function where the processor starts.
const ENTRY: &str = "Reset";

/// The stack use and the calls of a function.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Function {
    /// Bytes that it takes from the stack itself.
    frame: u64,
    /// Addresses of the functions that it calls or jumps to.
    calls: BTreeSet<u64>,
    /// Whether it calls through a register.
    calls_by_register: bool,
}

/// The deepest possible stack of a program, bytes.
///
/// # Errors
/// The file cannot be read, is no Cortex-M program, or has recursion.
pub fn of(path: &Path) -> Result<u64> {
    with_elf(path, |elf| {
        let text = elf.section_by_name(".text").ok_or_else(|| Error::content(path, "it has no .text".into()))?;
        let bytes = text.data().map_err(|error| Error::content(path, error.to_string()))?;
        let mut functions = BTreeMap::new();
        let (mut entry, mut handlers) = (None, BTreeSet::new());
        for symbol in elf.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
            // Bit 0 of a code address marks Thumb code.
            let address = symbol.address() & !1;
            let Some(at) = address.checked_sub(text.address()) else { continue };
            if let Some(code) = bytes.get(at as usize..(at + symbol.size()) as usize) {
                functions.insert(address, read(code, address));
            }
            if symbol.name() == Ok(ENTRY) {
                entry = Some(address);
            }
            if symbol.is_global() {
                handlers.insert(address);
            }
        }
        let entry = entry.ok_or_else(|| Error::content(path, format!("it has no {ENTRY}")))?;
        let called: BTreeSet<u64> = functions.values().flat_map(|function| &function.calls).copied().collect();
        let by_register =
            functions.keys().filter(|at| !called.contains(at) && !handlers.contains(at)).copied().collect();
        Walk { functions: &functions, by_register, known: BTreeMap::new() }
            .depth(entry, &mut Vec::new())
            .ok_or_else(|| Error::content(path, "a function calls itself".into()))
    })
}

/// A walk through the calls of a program.
struct Walk<'f> {
    /// All functions, by address.
    functions: &'f BTreeMap<u64, Function>,
    /// The functions that a call through a register may reach.
    by_register: BTreeSet<u64>,
    /// The depths computed so far, by address.
    known: BTreeMap<u64, u64>,
}

impl Walk<'_> {
    /// The depth of the function at an address; `above` are the functions that lead to it. `None` where there is
    /// recursion.
    fn depth(&mut self, at: u64, above: &mut Vec<u64>) -> Option<u64> {
        if let Some(&depth) = self.known.get(&at) {
            return Some(depth);
        }
        // An address where no function begins is a branch inside a function.
        let Some(function) = self.functions.get(&at) else { return Some(0) };
        if above.contains(&at) {
            return None;
        }
        above.push(at);
        let registers = if function.calls_by_register { self.by_register.clone() } else { BTreeSet::new() };
        let mut deepest = 0;
        for &next in function.calls.union(&registers) {
            if next != at {
                deepest = deepest.max(self.depth(next, above)?);
            }
        }
        above.pop();
        self.known.insert(at, function.frame + deepest);
        Some(function.frame + deepest)
    }
}

/// Reads a function's Thumb-2 code (Arm v7-M manual, chapter A5). Constants between the instructions are read as
/// instructions too, which can only increase the depth.
fn read(code: &[u8], address: u64) -> Function {
    let mut function = Function::default();
    let halves: Vec<u32> = code.as_chunks::<2>().0.iter().map(|half| u16::from_le_bytes(*half).into()).collect();
    let mut k = 0;
    while let Some(&first) = halves.get(k) {
        let at = address + 2 * k as u64;
        // 32-bit instructions begin with 0b111 and anything but 00.
        if first >> 11 < 0b11101 {
            narrow(first, at, &mut function);
            k += 1;
            continue;
        }
        wide(first, halves.get(k + 1).copied().unwrap_or(0), at, &mut function);
        k += 2;
    }
    function
}

/// Reads a 16-bit instruction.
fn narrow(code: u32, at: u64, function: &mut Function) {
    let mut jump = |bits: u32| {
        // The offset's sign is its highest bit.
        let offset = i64::from((code << (32 - bits)) as i32 >> (31 - bits));
        function.calls.insert(at.wrapping_add(4).wrapping_add_signed(offset));
    };
    if code & 0xfe00 == 0xb400 {
        // PUSH: eight registers and lr.
        function.frame += 4 * u64::from((code & 0x1ff).count_ones());
    } else if code & 0xff80 == 0xb080 {
        // SUB sp, #imm7·4
        function.frame += 4 * u64::from(code & 0x7f);
    } else if code & 0xff80 == 0x4780 || code & 0xff87 == 0x4700 && code & 0x78 != 0x70 {
        // BLX register, or BX register other than lr.
        function.calls_by_register = true;
    } else if code & 0xf800 == 0xe000 {
        // B: to another function it is its last call.
        jump(11);
    } else if code & 0xf000 == 0xd000 && code & 0x0e00 != 0x0e00 {
        // B<condition>
        jump(8);
    }
}

/// Reads a 32-bit instruction.
fn wide(first: u32, second: u32, at: u64, function: &mut Function) {
    if first == 0xe92d {
        // STMDB sp!, {registers}
        function.frame += 4 * u64::from(second.count_ones());
    } else if first == 0xf84d && second & 0x0fff == 0x0d04 {
        // STR register, [sp, #-4]!
        function.frame += 4;
    } else if first == 0xed2d && second & 0x0e00 == 0x0a00 {
        // VPUSH
        function.frame += 4 * u64::from(second & 0xff);
    } else if first & 0xfbff == 0xf1ad && second & 0x8f00 == 0x0d00 {
        // SUB sp, sp, #modified constant
        function.frame += u64::from(expand(first, second));
    } else if first & 0xfbff == 0xf2ad && second & 0x8f00 == 0x0d00 {
        // SUBW sp, sp, #imm12
        function.frame += u64::from((first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff);
    } else if first & 0xf800 == 0xf000 && second & 0x9000 == 0x9000 {
        // BL, B.W
        let sign = first >> 10 & 1;
        let high = |bit: u32| (!(second >> bit) ^ sign) & 1;
        let offset = sign << 24 | high(13) << 23 | high(11) << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
        let offset = i64::from((offset << 7) as i32 >> 7);
        function.calls.insert(at.wrapping_add(4).wrapping_add_signed(offset));
    } else if first & 0xf800 == 0xf000 && second & 0xd000 == 0x8000 && first & 0x0380 != 0x0380 {
        // B<condition>.W
        let (sign, high) = (first >> 10 & 1, |bit: u32| second >> bit & 1);
        let offset = sign << 20 | high(11) << 19 | high(13) << 18 | (first & 0x3f) << 12 | (second & 0x7ff) << 1;
        let offset = i64::from((offset << 11) as i32 >> 11);
        function.calls.insert(at.wrapping_add(4).wrapping_add_signed(offset));
    }
}

/// The constant of an instruction (function ThumbExpandImm of the manual).
fn expand(first: u32, second: u32) -> u32 {
    let imm12 = (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff;
    let byte = imm12 & 0xff;
    match imm12 >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | imm12 & 0x7f).rotate_right(imm12 >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(halves: &[u16]) -> Vec<u8> {
        halves.iter().flat_map(|half| half.to_le_bytes()).collect()
    }

    #[test]
    fn frames_add_up() {
        let cases: [(&[u16], u64); 8] = [
            (&[0xb5f0], 20),                 // push {r4-r7, lr}
            (&[0xe92d, 0x4ff0], 36),         // push {r4-r11, lr}
            (&[0xb090], 64),                 // sub sp, #64
            (&[0xf5ad, 0x7d1a], 616),        // sub.w sp, sp, #616
            (&[0xf2ad, 0x4d4c], 1100),       // subw sp, sp, #1100
            (&[0xf84d, 0x8d04], 4),          // str r8, [sp, #-4]!
            (&[0xed2d, 0x8b04], 16),         // vpush {d8, d9}
            (&[0xb580, 0xb082, 0x4770], 16), // push {r7, lr}; sub sp, #8; bx lr
        ];
        for (halves, frame) in cases {
            assert_eq!(read(&code(halves), 0), Function { frame, ..Function::default() }, "{halves:x?}");
        }
    }

    #[test]
    fn calls_are_found() {
        // At 0x100: bl 0x200; bl 0x80; b.w 0x100; blx r3; b.n 0xf0; bne.n 0x130; beq.w 0x1000; bne.w 0x0
        let halves =
            [0xf000, 0xf87e, 0xf7ff, 0xffbc, 0xf7ff, 0xbffa, 0x4798, 0xe7ef, 0xd10e, 0xf000, 0x8775, 0xf47f, 0xaf73];
        let function = read(&code(&halves), 0x100);
        assert_eq!(function.calls, BTreeSet::from([0x0, 0x80, 0xf0, 0x100, 0x130, 0x200, 0x1000]));
        assert!(function.calls_by_register);
    }

    #[test]
    fn the_deepest_path_counts() {
        let function =
            |frame, calls: &[u64]| Function { frame, calls: calls.iter().copied().collect(), calls_by_register: false };
        let functions = BTreeMap::from([
            (0, function(8, &[1, 2])),
            (1, function(100, &[3])),
            (2, Function { calls_by_register: true, ..function(16, &[]) }),
            (3, function(4, &[99])),
            (4, function(200, &[])),
        ]);
        let mut walk = Walk { functions: &functions, by_register: BTreeSet::from([4]), known: BTreeMap::new() };
        assert_eq!(walk.depth(0, &mut Vec::new()), Some(224));
        let circle = BTreeMap::from([(0, function(8, &[1])), (1, function(8, &[0]))]);
        let mut walk = Walk { functions: &circle, by_register: BTreeSet::new(), known: BTreeMap::new() };
        assert_eq!(walk.depth(0, &mut Vec::new()), None);
    }
}
