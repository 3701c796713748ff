use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, MAX_LEN, Message};
use proptest::prelude::*;
use sitl_bridge::frame::{Encoder, Frame, Rejected};
use sitl_bridge::signing::{Key, LinkSigning, Session, Timestamp, Unsigned};
use sitl_bridge::swarm_link::{SwarmError, SwarmLink, SwarmSocket, system_of};
use std::time::Duration;

const NOW: Timestamp = Timestamp::from_unix_us(1_790_000_000_000_000);

fn header(id: u16) -> Header {
    Header { id, sequence: 3, step: 42 }
}

fn beacon(id: u16) -> Message {
    let state = State { position: Vec2 { x: 1000, y: -2000 }, velocity: Vec2 { x: 3, y: 4 } };
    Message::Beacon(Beacon::new(header(id), 84_000, state, 5))
}

/// One UAV's link with its session.
struct End {
    link: SwarmLink,
    session: Session,
}

impl End {
    fn new(id: u16, signing: LinkSigning) -> Self {
        Self { link: SwarmLink::new(id, signing).unwrap(), session: Session::new() }
    }

    fn open(id: u16) -> Self {
        Self::new(id, LinkSigning::off())
    }

    fn keyed(id: u16, key: u8) -> Self {
        Self::new(id, LinkSigning::new(Key::new([key; 32]), 1, Unsigned::Refuse))
    }

    fn wrap(&mut self, message: &Message) -> Frame {
        self.link.wrap(message, &mut self.session, NOW).unwrap()
    }

    fn hear(&mut self, datagram: &[u8]) -> Vec<Message> {
        self.link.push(datagram);
        std::iter::from_fn(|| self.link.next_message(&mut self.session, NOW)).map(|n| n.message).collect()
    }

    /// Hears nothing, for this reason alone.
    fn refuse(&mut self, datagram: &[u8], reason: Rejected) {
        let before = self.link.counts();
        assert!(self.hear(datagram).is_empty());
        let after = self.link.counts();
        assert_eq!((after.get(reason), after.total()), (before.get(reason) + 1, before.total() + 1), "{reason:?}");
    }
}

/// V2_EXTENSION with these fields, from the UAV with this id.
fn extension(id: u16, message_type: u16, network: u8, system: u8, body: &[u8]) -> Frame {
    let payload = [&message_type.to_le_bytes()[..], &[network, system, 0], body].concat();
    Encoder::new(system_of(id).unwrap(), 191).encode_payload(248, &payload).unwrap()
}

fn bytes_of(message: &Message) -> Vec<u8> {
    message.encode(&mut [0; MAX_LEN]).to_vec()
}

/// Docs/messages.md's beacon, as it is on the air.
#[test]
fn the_frame_is_as_described() {
    let frame = End::open(7).wrap(&beacon(7));
    assert_eq!((frame.system(), frame.component(), frame.message_id()), (8, 191, 248));
    assert_eq!(frame.payload()[..5], [0x56, 0xC0, 0, 0, 0]);
    assert_eq!(frame.payload()[5..], bytes_of(&beacon(7)));
}

#[test]
fn ids_up_to_254_can_fly() {
    assert_eq!([0, 7, 254, 255, 65_535].map(system_of), [Some(1), Some(8), Some(255), None, None]);
    assert!(matches!(SwarmLink::new(255, LinkSigning::off()), Err(SwarmError::Id(255))));
}

#[test]
fn messages_that_end_in_zeros_come_back_whole() {
    let zeros = Message::Feature(FeatureMessage::new(header(7), 1, 0, 0, &[0; 64]).unwrap());
    let still = Message::Beacon(Beacon::new(Header { id: 7, sequence: 0, step: 0 }, 0, State::default(), 0));
    let mut receiver = End::open(9);
    for message in [zeros, still] {
        let frame = End::open(7).wrap(&message);
        assert!(frame.payload().len() < bytes_of(&message).len());
        assert_eq!(receiver.hear(frame.bytes()), std::slice::from_ref(&message));
        // A sender that leaves the zeros in, up to V2_EXTENSION's full length, is understood too.
        let mut body = bytes_of(&message);
        body.resize(249, 0);
        let frame = extension(7, 0xC056, 0, 0, &body);
        assert_eq!(receiver.hear(frame.bytes()), [message]);
    }
}

#[test]
fn each_way_to_be_no_neighbour_is_counted() {
    let mut end = End::open(9);
    let body = bytes_of(&beacon(7));
    end.refuse(super::frame(1).bytes(), Rejected::NotNeighbour);
    end.refuse(extension(7, 0xC057, 0, 0, &body).bytes(), Rejected::NotNeighbour);
    end.refuse(extension(7, 0xC056, 1, 0, &body).bytes(), Rejected::Addressed);
    end.refuse(extension(7, 0xC056, 0, 11, &body).bytes(), Rejected::Addressed);
    end.refuse(extension(8, 0xC056, 0, 0, &body).bytes(), Rejected::SpoofedId);
    end.refuse(extension(7, 0xC056, 0, 0, &bytes_of(&beacon(7 + 256))).bytes(), Rejected::SpoofedId);
    end.refuse(extension(7, 0xC056, 0, 0, &[&body[..], &[1]].concat()).bytes(), Rejected::Malformed);
    end.refuse(extension(7, 0xC056, 0, 0, &[2, 1, 7]).bytes(), Rejected::OtherVersion);
    end.refuse(extension(7, 0xC056, 0, 0, &[1, 9, 7]).bytes(), Rejected::Malformed);
    end.refuse(extension(7, 0xC056, 0, 0, &[]).bytes(), Rejected::OtherVersion);
    // A feature of 65 values.
    let mut wide = bytes_of(&Message::Feature(FeatureMessage::new(header(7), 1, 0, 0, &[1; 64]).unwrap()));
    wide[17] = 65;
    wide.push(1);
    end.refuse(extension(7, 0xC056, 0, 0, &wide).bytes(), Rejected::Malformed);
    // Addressed to us alone, and to all.
    assert_eq!(end.hear(extension(7, 0xC056, 0, 10, &body).bytes()), [beacon(7)]);
    assert_eq!(end.hear(extension(7, 0xC056, 0, 0, &body).bytes()), [beacon(7)]);
}

#[test]
fn damage_in_a_datagram_does_not_cost_the_next_message() {
    let mut sender = End::open(7);
    let (first, second) = (sender.wrap(&beacon(7)), sender.wrap(&beacon(7)));
    let mut end = End::open(9);
    for bit in 0..first.bytes().len() * 8 {
        let mut bytes = [first.bytes(), second.bytes()].concat();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(end.hear(&bytes), [beacon(7)], "bit {bit}");
    }
    for len in 0..first.bytes().len() {
        assert!(end.hear(&first.bytes()[..len]).is_empty());
        assert_eq!(end.hear(&[&first.bytes()[..len], second.bytes()].concat()), [beacon(7)], "cut at {len}");
    }
    assert_eq!(end.hear(&[first.bytes(), second.bytes()].concat()).len(), 2);
}

#[test]
fn own_messages_that_come_back_are_no_collision() {
    for mut end in [End::open(7), End::keyed(7, 1)] {
        let frames: Vec<_> = (0..50).map(|_| end.wrap(&beacon(7))).collect();
        for frame in frames {
            end.refuse(frame.bytes(), Rejected::OwnEcho);
        }
    }
}

#[test]
fn another_uav_with_our_id_is_noticed() {
    let (mut end, mut twin) = (End::open(7), End::open(7));
    // The twin counts its frames as we do; what it says is different.
    let other = Message::Beacon(Beacon::new(header(7), 90_000, State::default(), 5));
    end.wrap(&beacon(7));
    end.refuse(twin.wrap(&other).bytes(), Rejected::IdCollision);
    // With a key, only those who have it can collide.
    let (mut end, mut twin, mut forger) = (End::keyed(7, 1), End::keyed(7, 1), End::keyed(7, 2));
    end.refuse(twin.wrap(&other).bytes(), Rejected::IdCollision);
    end.refuse(forger.wrap(&other).bytes(), Rejected::WrongKey);
    end.refuse(End::open(7).wrap(&other).bytes(), Rejected::Unsigned);
}

/// Played back long after it was sent, an own message must not look like a twin.
#[test]
fn a_recording_of_ourselves_is_a_replay() {
    let mut end = End::keyed(7, 1);
    let recorded = end.wrap(&beacon(7));
    for _ in 0..1000 {
        end.wrap(&beacon(7));
    }
    end.refuse(recorded.bytes(), Rejected::Replayed);
}

#[test]
fn signed_messages_are_heard_once() {
    let (mut sender, mut end) = (End::keyed(7, 1), End::keyed(9, 1));
    let frame = sender.wrap(&beacon(7));
    assert_eq!(end.hear(frame.bytes()), [beacon(7)]);
    end.refuse(frame.bytes(), Rejected::Replayed);
    end.refuse(End::keyed(8, 2).wrap(&beacon(8)).bytes(), Rejected::WrongKey);
    end.refuse(End::open(8).wrap(&beacon(8)).bytes(), Rejected::Unsigned);
    // An end without a key hears signed messages.
    assert_eq!(End::open(9).hear(frame.bytes()), [beacon(7)]);
}

/// Whoever waits so long waits for ever: no test does unless something is broken.
const A_DAY: Duration = Duration::from_secs(86_400);

/// Sends from each socket to all and expects every other one to hear it.
fn all_hear_all(sockets: &mut [SwarmSocket]) {
    let mut ends: Vec<_> = (0..sockets.len()).map(|id| End::open(id as u16)).collect();
    for from in 0..sockets.len() {
        let frame = ends[from].wrap(&beacon(from as u16));
        sockets[from].send(frame.bytes()).unwrap();
        for to in (0..sockets.len()).filter(|&to| to != from) {
            let mut buffer = [0; 4096];
            let heard = loop {
                // A signal may end a wait early.
                sitl_bridge::connection::wait(&[sockets[to].watch()], A_DAY).unwrap();
                let Some(len) = sockets[to].recv(&mut buffer).unwrap() else { continue };
                // Own echoes of before may come first.
                let heard = ends[to].hear(&buffer[..len]);
                if !heard.is_empty() {
                    break heard;
                }
            };
            assert_eq!(heard, [beacon(from as u16)]);
        }
    }
}

#[test]
fn a_swarm_of_peers_hears_each_other() {
    let address = "peers:127.0.0.1:0".parse().unwrap();
    let mut sockets: Vec<_> = (0..3).map(|_| SwarmSocket::open(&address).unwrap()).collect();
    let ports: Vec<_> = sockets.iter().map(SwarmSocket::listens_on).collect();
    for (n, socket) in sockets.iter_mut().enumerate() {
        let others: Vec<_> = ports.iter().enumerate().filter(|&(m, _)| m != n).map(|(_, &port)| port).collect();
        socket.set_peers(&others);
        assert!(socket.describe().contains(&ports[n].to_string()) && socket.describe().ends_with("2 peers"));
    }
    all_hear_all(&mut sockets);
    assert!(sockets[0].recv(&mut [0; 4096]).unwrap().is_none());
}

#[test]
fn a_multicast_group_on_one_computer_hears_each_other() {
    let port = free_port();
    let address = format!("multicast:239.86.67.9:{port}@127.0.0.1").parse().unwrap();
    let mut sockets: Vec<_> = (0..3).map(|_| SwarmSocket::open(&address).unwrap()).collect();
    all_hear_all(&mut sockets);
}

#[test]
fn a_broadcast_on_one_computer_is_heard_by_all() {
    let port = free_port();
    let address = format!("broadcast:127.255.255.255:{port}").parse().unwrap();
    let mut sockets: Vec<_> = (0..3).map(|_| SwarmSocket::open(&address).unwrap()).collect();
    all_hear_all(&mut sockets);
}

/// A port that nobody has just now.
fn free_port() -> u16 {
    SwarmSocket::open(&"peers:0.0.0.0:0".parse().unwrap()).unwrap().listens_on().port()
}

#[test]
fn an_address_of_another_computer_is_an_error_that_says_so() {
    let address = "peers:192.0.2.1:14600".parse().unwrap();
    let error = SwarmSocket::open(&address).expect_err("not ours").to_string();
    assert!(error.contains("192.0.2.1:14600") && error.contains("no such address"), "{error}");
}

fn any_message() -> impl Strategy<Value = Message> {
    let header =
        (0u16..=254, any::<u16>(), any::<u32>()).prop_map(|(id, sequence, step)| Header { id, sequence, step });
    let beacon =
        (header.clone(), any::<u32>(), any::<[i32; 4]>(), any::<i8>()).prop_map(|(header, time, [x, y, u, v], tie)| {
            let state = State { position: Vec2 { x, y }, velocity: Vec2 { x: u, y: v } };
            Message::Beacon(Beacon::new(header, time, state, tie))
        });
    let value = prop_oneof![Just(0i8), any::<i8>()];
    let feature = (header, 1u8..=17, any::<u32>(), any::<i16>(), prop::collection::vec(value, 1..=64)).prop_map(
        |(header, degree, actor, attention_source, values)| {
            Message::Feature(FeatureMessage::new(header, degree, actor, attention_source, &values).unwrap())
        },
    );
    prop_oneof![beacon, feature]
}

proptest! {
    #[test]
    fn every_message_comes_back(message in any_message(), keyed in any::<bool>()) {
        let id = message.header().id;
        let end = if keyed { |id| End::keyed(id, 1) } else { End::open };
        let frame = end(id).wrap(&message);
        prop_assert_eq!(end((id + 1) % 255).hear(frame.bytes()), [message]);
    }
}
