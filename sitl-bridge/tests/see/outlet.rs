//! Outputs that nobody reads hold nobody up.

use sitl_bridge::outlet::Outlet;
use std::io::{self, Write};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Nothing here takes so long: a test that would is cut by whoever runs it.
const FOR_EVER: Duration = Duration::from_secs(1 << 30);

/// A pipe: a write tells that it began, and waits until the test lets it through, or until the test has let all
/// through.
struct Pipe {
    began: Sender<()>,
    open: Receiver<()>,
    written: Arc<Mutex<Vec<u8>>>,
}

/// The test's end of a pipe.
struct Reader {
    began: Receiver<()>,
    open: Sender<()>,
    written: Arc<Mutex<Vec<u8>>>,
}

fn pipe() -> (Pipe, Reader) {
    let ((began, has_begun), (open, opened)) = (channel(), channel());
    let written = Arc::default();
    (Pipe { began, open: opened, written: Arc::clone(&written) }, Reader { began: has_begun, open, written })
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = self.began.send(());
        let _ = self.open.recv();
        self.written.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn lost(lines: u64) -> String {
    format!("{lines} lost\n")
}

#[test]
fn a_full_queue_drops_counts_and_tells() {
    let (pipe, reader) = pipe();
    let outlet = Outlet::new(Box::new(pipe), lost);
    assert!(outlet.write("first\n"));
    reader.began.recv().unwrap();
    // From here on the pipe is blocked, and every call returns all the same.
    assert!(!outlet.offer("a table that another replaces\n"));
    let kept = (0..1_000_000).take_while(|n| outlet.write(format!("line {n}\n"))).count();
    assert!((1000..1_000_000).contains(&kept), "{kept}");
    assert!((0..99).all(|_| !outlet.write("too late\n")));
    assert_eq!(outlet.lost(), 100);
    // Somebody reads again.
    drop(reader.open);
    assert!(outlet.drain(FOR_EVER));
    assert!(outlet.write("last\n") && outlet.drain(FOR_EVER));
    assert_eq!(outlet.lost(), 0);
    let text = String::from_utf8(reader.written.lock().unwrap().clone()).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("first"));
    assert!((0..kept).all(|n| lines.next() == Some(&format!("line {n}"))));
    assert_eq!(lines.collect::<Vec<_>>(), ["100 lost", "last"]);
}

#[test]
fn losses_are_told_before_what_comes_after_them() {
    let (pipe, reader) = pipe();
    let outlet = Outlet::new(Box::new(pipe), lost);
    outlet.write("x".repeat(1 << 19) + "\n");
    reader.began.recv().unwrap();
    // One line may be longer than the queue; the next finds no room behind another.
    assert!(outlet.write("y".repeat(1 << 19) + "\n"));
    assert!(!outlet.write("lost\n"));
    reader.open.send(()).unwrap();
    reader.began.recv().unwrap();
    assert!(outlet.write("after\n"));
    drop(reader.open);
    assert!(outlet.drain(FOR_EVER));
    let text = String::from_utf8(reader.written.lock().unwrap().clone()).unwrap();
    assert!(text.ends_with("y\n1 lost\nafter\n"), "{}", &text[text.len() - 40..]);
}

/// An output that is closed.
struct Closed(Sender<()>);

impl Write for Closed {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        let _ = self.0.send(());
        Err(io::ErrorKind::BrokenPipe.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_closed_output_is_waited_for_by_nobody() {
    let (tried, trials) = channel();
    let outlet = Outlet::new(Box::new(Closed(tried)), lost);
    assert!(outlet.write("line\n"));
    trials.recv().unwrap();
    assert!(outlet.drain(FOR_EVER));
    assert!(outlet.write("another\n") && outlet.drain(FOR_EVER));
    assert!(trials.try_recv().is_err(), "it was tried again");
}
