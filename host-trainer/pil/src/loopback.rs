//! A simulated board.

use crate::exchange::Options;
use firmware_core::pil::Server;
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::time::Duration;

/// A board in this process, as a stream that never blocks: for tests, and as the reference for a real board.
pub struct Loopback<'a> {
    board: Server<'a>,
    answers: VecDeque<u8>,
}

impl<'a> Loopback<'a> {
    /// Options for its client: it answers at once or never.
    pub const OPTIONS: Options = Options { timeout: Duration::ZERO, attempts: 1 };

    /// Starts the board with the bytes of an actor file.
    #[must_use]
    pub fn new(file: &'a [u8]) -> Self {
        let mut board = Server::new();
        let answers = board.boot(file).iter().copied().collect();
        Self { board, answers }
    }
}

impl Write for Loopback<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        for &byte in bytes {
            self.answers.extend(self.board.push(byte).unwrap_or_default());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Read for Loopback<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match self.answers.read(buffer) {
            Ok(0) => Err(Error::from(ErrorKind::WouldBlock)),
            read => read,
        }
    }
}
