//! The program that flies: tests its actor, reports, and answers the PIL protocol on the board's serial line.
//!
//! Without a sound actor file it says what is wrong with it and refuses every request that would fly.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use covey_image::actor_file::actor_file;
use covey_image::board::Board;
use firmware_core::pil::Server;

#[entry]
fn main() -> ! {
    static mut SERVER: Server<'static> = Server::new();

    let mut board = Board::take();
    board.write(SERVER.boot(actor_file()));
    loop {
        if let Some(answer) = SERVER.push(board.read()) {
            board.write(answer);
        }
    }
}
