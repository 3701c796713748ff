//! A board in the same process at the other end of a bad line.

use firmware_core::pil::Server;
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Read, Result, Write};

/// Damages bytes as they pass, from a seed.
#[derive(Clone, Debug)]
pub struct Line {
    state: u64,
    /// Of 65,536 bytes, how many are lost, changed, or follow an invented one.
    pub lost: u16,
    pub changed: u16,
    pub invented: u16,
}

impl Line {
    pub const fn perfect() -> Self {
        Self { state: 0, lost: 0, changed: 0, invented: 0 }
    }

    pub const fn bad(seed: u64, each: u16) -> Self {
        Self { state: seed, lost: each, changed: each, invented: each }
    }

    fn draw(&mut self) -> u64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.state >> 32
    }

    fn hits(&mut self, of_65536: u16) -> bool {
        of_65536 > 0 && self.draw() % 65_536 < u64::from(of_65536)
    }

    fn pass(&mut self, byte: u8, mut to: impl FnMut(u8)) {
        if self.hits(self.invented) {
            to(self.draw() as u8);
        }
        if self.hits(self.lost) {
            return;
        }
        to(if self.hits(self.changed) { self.draw() as u8 } else { byte });
    }
}

/// A board, as a stream that never blocks.
pub struct Pipe<'a> {
    pub board: Server<'a>,
    pub line: Line,
    to_host: VecDeque<u8>,
    /// Bytes a read returns at most.
    pub chunk: usize,
}

impl<'a> Pipe<'a> {
    pub fn new(file: &'a [u8], line: Line) -> Self {
        let mut pipe = Self { board: Server::new(), line, to_host: VecDeque::new(), chunk: usize::MAX };
        pipe.restart(file);
        pipe
    }

    /// Powers the board up again.
    pub fn restart(&mut self, file: &'a [u8]) {
        self.board = Server::new();
        let Self { board, line, to_host, .. } = self;
        board.boot(file).iter().for_each(|&b| line.pass(b, |b| to_host.push_back(b)));
    }

    /// Something else speaks on the line.
    pub fn say(&mut self, bytes: &[u8]) {
        self.to_host.extend(bytes);
    }
}

impl Write for Pipe<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let Self { board, line, to_host, .. } = self;
        for &byte in bytes {
            let mut arriving = Vec::new();
            line.pass(byte, |b| arriving.push(b));
            for b in arriving {
                if let Some(answer) = board.push(b) {
                    answer.iter().for_each(|&b| line.pass(b, |b| to_host.push_back(b)));
                }
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Read for Pipe<'_> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        let n = out.len().min(self.chunk).min(self.to_host.len());
        if n == 0 {
            return Err(Error::from(ErrorKind::WouldBlock));
        }
        self.to_host.drain(..n).zip(out).for_each(|(b, place)| *place = b);
        Ok(n)
    }
}
