use super::{frame, position};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use sitl_bridge::connection::{Connection, RECEIVE_LEN, Received, Sent, wait};
use sitl_bridge::frame::{Encoder, Frame, Reader, Source};
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::time::Duration;

fn open(text: &str) -> Connection {
    Connection::open(&text.parse().expect("a connection string")).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// The next thing that happens on it, whenever that is.
fn next(connection: &mut Connection, buffer: &mut [u8]) -> Received {
    loop {
        match connection.recv(buffer).expect("a sound socket") {
            Received::Nothing => {
                // A link that is being connected again has nothing to watch.
                let watched: Vec<_> = connection.watch().into_iter().collect();
                wait(&watched, Duration::from_millis(50)).unwrap();
            }
            happened => return happened,
        }
    }
}

/// The next bytes.
fn receive(connection: &mut Connection) -> Vec<u8> {
    let mut buffer = [0; RECEIVE_LEN];
    loop {
        match next(connection, &mut buffer) {
            Received::Bytes { len, .. } => return buffer[..len].to_vec(),
            Received::Connected => {}
            other => panic!("bytes were expected, not {other:?}"),
        }
    }
}

fn reads(connection: &mut Connection, expected: &Frame) {
    let mut reader = Reader::new(connection.source());
    loop {
        reader.push(&receive(connection));
        if let Some(found) = reader.next_frame() {
            return assert_eq!(&found, expected);
        }
    }
}

#[test]
fn a_listener_answers_the_last_peer_that_was_confirmed() {
    let mut ours = open("udpin:127.0.0.1:0");
    let here = ours.listens_on().expect("a port");
    assert_ne!(here.port(), 0);
    assert_eq!(ours.describe(), format!("listening on udp {here}"));
    assert!(ours.advice().contains(&here.port().to_string()));
    assert_eq!(ours.source(), Source::Datagrams);

    let [autopilot, stranger] = [(), ()].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    assert_eq!(ours.send(frame(1).bytes()).unwrap(), Sent::NoPeer);

    // The autopilot's frame is believed; then a stranger sends what is not.
    let mut buffer = [0; RECEIVE_LEN];
    autopilot.send_to(frame(2).bytes(), here).unwrap();
    let Received::Bytes { len, peer } = next(&mut ours, &mut buffer) else { panic!("a datagram") };
    assert_eq!(&buffer[..len], frame(2).bytes());
    ours.confirm(peer);
    stranger.send_to(b"garbage", here).unwrap();
    assert!(matches!(next(&mut ours, &mut buffer), Received::Bytes { len: 7, .. }));
    assert_eq!(ours.send(frame(3).bytes()).unwrap(), Sent::Yes);
    let (len, from) = autopilot.recv_from(&mut buffer).unwrap();
    assert_eq!((&buffer[..len], from), (frame(3).bytes(), here));
    assert!(ours.describe().contains(&autopilot.local_addr().unwrap().to_string()));

    // The autopilot is restarted and sends from another port.
    stranger.send_to(frame(4).bytes(), here).unwrap();
    let Received::Bytes { peer, .. } = next(&mut ours, &mut buffer) else { panic!("a datagram") };
    ours.confirm(peer);
    ours.send(frame(5).bytes()).unwrap();
    assert_eq!(stranger.recv_from(&mut buffer).unwrap().1, here);
    assert!(matches!(ours.recv(&mut buffer).unwrap(), Received::Nothing));
}

#[test]
fn a_talker_talks_to_one_address_and_hears_only_that() {
    let there = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut ours = open(&format!("udpout:{}", there.local_addr().unwrap()));
    assert_eq!(ours.listens_on(), None);
    assert_eq!(ours.send(frame(1).bytes()).unwrap(), Sent::Yes);
    let mut buffer = [0; RECEIVE_LEN];
    let (len, from) = there.recv_from(&mut buffer).unwrap();
    assert_eq!(&buffer[..len], frame(1).bytes());
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    stranger.send_to(frame(2).bytes(), from).unwrap();
    there.send_to(frame(3).bytes(), from).unwrap();
    reads(&mut ours, &frame(3));
    // While nobody listens there (a simulator that is restarted) nothing is an error.
    drop(there);
    for _ in 0..3 {
        assert!(matches!(ours.send(frame(4).bytes()), Ok(Sent::Yes | Sent::NoPeer)));
        assert!(matches!(ours.recv(&mut buffer), Ok(Received::Nothing)));
    }
}

#[test]
fn addresses_are_ipv4_ipv6_or_names() {
    for text in ["udp:localhost:0", "udpin://127.0.0.1:0", "udp::0", "udpin:0.0.0.0:0"] {
        assert_ne!(open(text).listens_on().expect("a port").port(), 0, "{text}");
    }
    // Not every computer has IPv6.
    if UdpSocket::bind("[::1]:0").is_ok() {
        assert!(open("udpin:[::1]:0").describe().contains("[::1]:"));
    }
}

#[test]
fn what_cannot_be_opened_says_why() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let own = taken.local_addr().unwrap();
    for (text, part) in [
        (format!("udpin:{own}"), "another program listens there"),
        ("udpin:192.0.2.1:14550".into(), "no such address"),
        ("tcp:no-such-host.invalid:5760".into(), "`no-such-host.invalid`"),
        ("serial:/dev/no-such-line:57600".into(), "no such device"),
        ("serial:/dev/null:57600".into(), "no serial line"),
    ] {
        let error = Connection::open(&text.parse().unwrap()).expect_err(&text).to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
}

/// What happens on a stream next, bytes aside.
fn connected(connection: &mut Connection) {
    match next(connection, &mut [0; RECEIVE_LEN]) {
        Received::Connected => {}
        other => panic!("a connection was expected, not {other:?}"),
    }
}

fn lost(connection: &mut Connection) {
    loop {
        match next(connection, &mut [0; RECEIVE_LEN]) {
            Received::Lost(_) => return,
            Received::Bytes { .. } => {}
            other => panic!("a loss was expected, not {other:?}"),
        }
    }
}

#[test]
fn a_tcp_client_waits_for_its_server_and_comes_back_to_it() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let there = listener.local_addr().unwrap();
    drop(listener);
    // Nobody serves yet.
    let mut ours = open(&format!("tcp:{there}"));
    let mut buffer = [0; RECEIVE_LEN];
    for _ in 0..100 {
        assert!(matches!(ours.recv(&mut buffer), Ok(Received::Nothing)));
    }
    assert_eq!(ours.send(frame(1).bytes()).unwrap(), Sent::NoPeer);
    assert_eq!(ours.describe(), format!("waiting for tcp {there}"));

    let listener = TcpListener::bind(there).unwrap();
    for time in [2, 3] {
        connected(&mut ours);
        assert_eq!(ours.describe(), format!("connected to tcp {there}"));
        let (mut server, _) = listener.accept().unwrap();
        server.write_all(frame(time).bytes()).unwrap();
        reads(&mut ours, &frame(time));
        assert_eq!(ours.send(frame(9).bytes()).unwrap(), Sent::Yes);
        let mut got = vec![0; frame(9).bytes().len()];
        server.read_exact(&mut got).unwrap();
        assert_eq!(got, frame(9).bytes());
        drop(server);
        lost(&mut ours);
        assert_eq!(ours.send(frame(1).bytes()).unwrap(), Sent::NoPeer);
    }
}

#[test]
fn a_tcp_server_serves_one_client_after_the_other() {
    let mut ours = open("tcpin:127.0.0.1:0");
    let here = ours.listens_on().expect("a port");
    assert_eq!(ours.describe(), format!("listening on tcp {here}"));
    for time in [1, 2] {
        let mut client = TcpStream::connect(here).unwrap();
        connected(&mut ours);
        client.write_all(frame(time).bytes()).unwrap();
        reads(&mut ours, &frame(time));
        drop(client);
        lost(&mut ours);
    }
}

/// Whoever reads slowly gets whole frames, and not all of them.
#[test]
fn a_full_line_drops_whole_frames() {
    let mut ours = open("tcpin:127.0.0.1:0");
    let mut client = TcpStream::connect(ours.listens_on().expect("a port")).unwrap();
    connected(&mut ours);
    let mut encoder = Encoder::new(1, 1);
    let mut sent = Vec::new();
    // The system's buffers hold a few megabytes; the line is full well before this ends.
    let mut full = 0;
    for time in 0..2_000_000 {
        let frame = encoder.encode(&position(time)).unwrap();
        match ours.send(frame.bytes()).unwrap() {
            Sent::Yes => sent.push(frame),
            Sent::Full => full += 1,
            Sent::NoPeer => panic!("the client is there"),
        }
        if full == 100 {
            break;
        }
    }
    assert_eq!(full, 100);
    // The client reads on; meanwhile one more frame pushes out the rest of the last one.
    let mut reader = Reader::new(Source::Stream);
    let mut found = Vec::new();
    let mut buffer = vec![0; 1 << 16];
    let last = encoder.encode(&position(7)).unwrap();
    let mut last_sent = false;
    while !last_sent || found.len() <= sent.len() {
        if !last_sent {
            last_sent = ours.send(last.bytes()).unwrap() == Sent::Yes;
        }
        let len = client.read(&mut buffer).unwrap();
        reader.push(&buffer[..len]);
        found.extend(std::iter::from_fn(|| reader.next_frame()));
    }
    sent.push(last);
    assert_eq!(reader.counts().total(), 0);
    assert!(found == sent);
}

/// A pseudo-terminal stands in for the autopilot's serial port.
#[test]
fn a_serial_line_carries_bytes_as_they_are() {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let mut autopilot = File::from(master);
    let mut ours = open(&format!("serial:{path}:115200"));
    assert_eq!((ours.source(), ours.describe()), (Source::Stream, format!("serial line {path} at 115200 bit/s")));
    // All bytes there are, among them those that terminals like to translate.
    let all: Vec<u8> = (0..=255).collect();
    autopilot.write_all(&all).unwrap();
    let mut got = Vec::new();
    while got.len() < all.len() {
        got.extend(receive(&mut ours));
    }
    assert_eq!(got, all);
    assert_eq!(ours.send(&all).unwrap(), Sent::Yes);
    let mut back = vec![0; all.len()];
    autopilot.read_exact(&mut back).unwrap();
    assert_eq!(back, all);
    // The adapter is pulled out.
    drop(autopilot);
    lost(&mut ours);
    assert_eq!(ours.describe(), format!("waiting for serial line {path} at 115200 bit/s"));
    assert_eq!(ours.send(&all).unwrap(), Sent::NoPeer);
}
