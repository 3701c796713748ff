//! Recordings of MAVLink traffic that QGroundControl, MAVProxy and pymavlink read.
//!
//! A tlog is a row of records, each the time of arrival or sending (microseconds since 1970,
//! eight bytes, the highest first) and one frame as it was on the wire. There is no head and no
//! index. SETUP_SIGNING is never recorded: it holds a key. What was flown and what the operator
//! commanded stand between the frames as [notes](Note).

mod disk;
mod layout;
mod note;
mod reader;
mod writer;

pub use disk::flight_folder;
pub use note::{Flight, NOTE_COMPONENT, Note, NoteReader};
pub use reader::{Record, TlogReader};
pub use writer::TlogWriter;
