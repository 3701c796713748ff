//! Client and server in one process, over good and bad lines: the board decides what
//! the same code decides at home.

#[path = "../../../firmware-core/tests/common/mod.rs"]
mod common;
mod pipe;

use common::sample_actor;
use covey_pil::{Client, Options, PilError, UavStep};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::actor::{Actor, Aggregation, Logits, Mode, fingerprint};
use firmware_core::geometry::{State, TICKS_PER_U, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, Message};
use firmware_core::neighbour_table::{MessageOutcome, Moment, NeighbourTable};
use firmware_core::observation::{Neighbours, Scene, observe};
use firmware_core::pil::{ActorError, RequestError, Setup};
use pipe::{Line, Pipe};
use proptest::prelude::*;
use std::time::Duration;

/// The pipe answers at once or never.
const AT_ONCE: Options = Options { timeout: Duration::ZERO, attempts: 1 };
const STUBBORN: Options = Options { timeout: Duration::ZERO, attempts: 200 };
const SETUP: Setup = Setup { id: 0, seed: 10, argmax: false, step_ms: 2000, half_side: 100 * TICKS_PER_U };

fn client(file: &[u8], line: Line, options: Options) -> Client<Pipe<'_>> {
    Client::new(Pipe::new(file, line), options)
}

/// A UAV as it flies at home: table, observation and actor without a line between.
struct Home<'a> {
    actor: Actor<'a>,
    setup: Setup,
    table: NeighbourTable,
}

impl<'a> Home<'a> {
    fn new(actor: Actor<'a>, setup: Setup) -> Self {
        Self { actor, setup, table: NeighbourTable::new(setup.id, actor.policy_id(), setup.step_ms) }
    }

    /// Feature message, logits, action, and number of features.
    fn step(
        &mut self,
        now: Moment,
        own: State,
        pois: &[Vec2],
        beacons: &[Message],
        features: &[Message],
    ) -> (Option<Message>, Logits, Action, usize) {
        for m in beacons {
            let _ = self.table.hear(m, own.position, now);
        }
        let mut view = Neighbours::new();
        self.table.view(own.position, now, &mut view);
        let Setup { id, seed, half_side, .. } = self.setup;
        let tie = self.actor.tie_breaker(seed, id, now.step);
        let scene = Scene { id, own, tie, half_side, neighbours: &view };
        let h = self.actor.encode(&observe(&scene, pois.iter().copied()));
        let degree = view.as_slice().len() as u8 + 1;
        let header = Header { id, sequence: now.step as u16, step: now.step };
        let message = FeatureMessage::from_actor(header, degree, &self.actor, &h).map(Message::Feature);
        for m in features {
            let _ = self.table.hear(m, own.position, now);
        }
        let used = self.table.features(&view, now.step).map(|(_, f)| f);
        let logits = self.actor.logits(&h, degree, used.clone());
        (message, logits, self.actor.choose(&logits, Mode::Sample, seed, id, now.step), used.count())
    }
}

/// Neighbours' messages of a step, from random numbers.
fn messages(step: u32, draws: &[(i32, i32, i8)], actor: &Actor<'_>) -> (Vec<Message>, Vec<Message>) {
    let time_ms = step * 2000;
    let width = usize::from(actor.policy_id().width.max(1));
    let both = draws.iter().zip(1..).map(|(&(x, y, r), id)| {
        let header = Header { id, sequence: step as u16, step };
        let state = State { position: Vec2 { x: 100_000 + x, y: 100_000 + y }, velocity: Vec2 { x: y / 8, y: x / 8 } };
        let values = vec![r & 127; width];
        let feature =
            FeatureMessage::new(header, 1 + (id % 17) as u8, actor.message_hash(), i16::from(r), &values).unwrap();
        (Message::Beacon(Beacon::new(header, time_ms, state, r)), Message::Feature(feature))
    });
    both.unzip()
}

fn kind() -> impl Strategy<Value = Aggregation> {
    prop::sample::select(&Aggregation::ALL)
}

fn draws() -> impl Strategy<Value = Vec<(i32, i32, i8)>> {
    prop::collection::vec((-20_000..20_000i32, -20_000..20_000i32, any::<i8>()), 0..24)
}

fn pois() -> impl Strategy<Value = Vec<Vec2>> {
    let near = (-16_000..16_000i32, -16_000..16_000i32);
    prop::collection::vec(near.prop_map(|(x, y)| Vec2 { x: 100_000 + x, y: 100_000 + y }), 0..60)
}

fn fly(file: &[u8], line: Line, options: Options, steps: &[Vec<(i32, i32, i8)>], pois: &[Vec2]) {
    let actor = Actor::load(file).unwrap();
    let mut home = Home::new(actor, SETUP);
    let mut board = client(file, line, options);
    let hash = board.hello(SETUP).unwrap().actor.map(|a| a.content_hash);
    assert_eq!(hash, Ok(actor.content_hash()));
    let own = State { position: Vec2 { x: 100_000, y: 100_000 }, velocity: Vec2 { x: 300, y: -700 } };
    for (step, draws) in (5..).zip(steps) {
        let now = Moment { step, time_ms: step * 2000 };
        let (beacons, features) = messages(step, draws, &actor);
        let (message, logits, action, used) = home.step(now, own, pois, &beacons, &features);
        for m in &beacons {
            board.hear(now, own.position, m).unwrap();
        }
        let observed = board.observe(now, own, pois.iter().copied()).unwrap();
        assert_eq!(Message::decode(&observed.message).ok(), message);
        for m in &features {
            board.hear(now, own.position, m).unwrap();
        }
        let decided = board.decide(step).unwrap();
        assert_eq!((decided.logits, decided.action), (logits, action.index()));
        assert_eq!(usize::from(decided.features), used);
        assert!(usize::from(decided.action) < ACTIONS);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_board_decides_what_is_decided_at_home(
        kind in kind(), steps in prop::collection::vec(draws(), 1..4), pois in pois(),
    ) {
        fly(&sample_actor(kind, 5), Line::perfect(), AT_ONCE, &steps, &pois);
    }

    #[test]
    fn a_bad_line_changes_nothing(
        kind in kind(), steps in prop::collection::vec(draws(), 1..3), pois in pois(),
        seed: u64, each in 0..150u16,
    ) {
        fly(&sample_actor(kind, 5), Line::bad(seed, each), STUBBORN, &steps, &pois);
    }

    #[test]
    fn one_board_takes_the_place_of_a_swarm(
        kind in kind(), steps in prop::collection::vec((0..9u16, draws()), 1..4), pois in pois(),
        seed: u64, each in 0..60u16,
    ) {
        let file = sample_actor(kind, 5);
        let actor = Actor::load(&file).unwrap();
        let mut board = client(&file, Line::bad(seed, each), STUBBORN);
        let own = State { position: Vec2 { x: 100_000, y: 100_000 }, velocity: Vec2 { x: 300, y: -700 } };
        for (step, (id, draws)) in (5..).zip(steps) {
            // Nothing of the UAV before is left.
            let setup = Setup { id, ..SETUP };
            let now = Moment { step, time_ms: step * 2000 };
            let (beacons, features) = messages(step, &draws, &actor);
            let (message, logits, action, used) =
                Home::new(actor, setup).step(now, own, &pois, &beacons, &features);
            let step = UavStep { setup, now, own, beacons: &beacons, pois: &pois, features: &features };
            let (observed, decided) = board.fly_step(&step).unwrap();
            prop_assert_eq!(Message::decode(&observed.message).ok(), message);
            prop_assert_eq!((decided.logits, decided.action), (logits, action.index()));
            prop_assert_eq!(usize::from(decided.features), used);
        }
    }

    #[test]
    fn noise_between_answers_changes_nothing(noise in prop::collection::vec(any::<u8>(), 0..400), chunk in 1..50usize) {
        let file = sample_actor(Aggregation::Gcn, 1);
        let mut pipe = Pipe::new(&file, Line::perfect());
        pipe.say(&noise);
        pipe.chunk = chunk;
        prop_assert!(Client::new(pipe, AT_ONCE).hello(SETUP).is_ok());
    }
}

#[test]
fn fingerprints_agree_in_any_chunks() {
    let file = sample_actor(Aggregation::Gat, 2);
    let expected = fingerprint(&Actor::load(&file).unwrap(), 60);
    for chunk in [1, 7, 60, 1000] {
        let mut counted = 0;
        let mut board = client(&file, Line::perfect(), AT_ONCE);
        assert_eq!(board.fingerprint(60, chunk, |done| counted = done).unwrap(), expected);
        assert_eq!(counted, 60);
    }
    let mut far = client(&file, Line::bad(4, 300), STUBBORN);
    assert_eq!(far.fingerprint(60, 5, |_| ()).unwrap(), expected);
    assert!(far.dropped() > 0);
}

#[test]
fn a_board_without_a_sound_actor_is_refused() {
    let mut file = sample_actor(Aggregation::Gcn, 2);
    file[200] ^= 4;
    let mut board = client(&file, Line::perfect(), AT_ONCE);
    let refused = board.hello(SETUP);
    assert!(matches!(refused, Err(PilError::Refused(RequestError::Actor(ActorError::Checksum)))), "{refused:?}");
    assert!(board.self_test().is_err());
}

#[test]
fn a_dead_board_is_silent() {
    struct Dead;
    impl std::io::Write for Dead {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    impl std::io::Read for Dead {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::TimedOut.into())
        }
    }
    let error = Client::new(Dead, Options { attempts: 3, ..AT_ONCE }).status().unwrap_err();
    assert!(matches!(error, PilError::Silent { request: "status", attempts: 3 }), "{error}");
    let closed = Client::new(std::io::Cursor::new(Vec::new()), AT_ONCE).status();
    assert!(matches!(closed, Err(PilError::Closed)));
}

#[test]
fn a_babbling_board_does_not_outlast_the_deadline() {
    struct Babble;
    impl std::io::Write for Babble {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    impl std::io::Read for Babble {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            out.fill(0x55);
            Ok(out.len())
        }
    }
    let options = Options { timeout: Duration::from_nanos(1), attempts: 2 };
    assert!(matches!(Client::new(Babble, options).status(), Err(PilError::Silent { .. })));
}

#[test]
fn a_restart_on_the_way_is_noticed() {
    let file = sample_actor(Aggregation::None, 2);
    let mut pipe = Pipe::new(&file, Line::perfect());
    pipe.restart(&file);
    let mut board = Client::new(pipe, AT_ONCE);
    let refused = board.decide(3);
    assert!(matches!(refused, Err(PilError::Refused(RequestError::NotStarted))), "{refused:?}");
    let report = board.restarted().unwrap();
    assert_eq!(board.hello(SETUP).unwrap(), report);
    assert_eq!(board.restarted(), None);
    assert!(board.status().unwrap().started);
}

#[test]
fn a_policy_without_neighbours_broadcasts_nothing() {
    let file = sample_actor(Aggregation::None, 2);
    let mut board = client(&file, Line::perfect(), AT_ONCE);
    assert_eq!(board.hello(SETUP).unwrap().actor.unwrap().width, 0);
    let now = Moment { step: 1, time_ms: 2000 };
    assert!(board.observe(now, State::default(), []).unwrap().message.is_empty());
    assert_eq!(board.decide(1).unwrap().features, 0);
}

#[test]
fn a_crowd_of_pois_is_an_error_and_far_ones_are_none() {
    let file = sample_actor(Aggregation::Gcn, 2);
    let mut board = client(&file, Line::perfect(), AT_ONCE);
    board.hello(SETUP).unwrap();
    let now = Moment { step: 1, time_ms: 2000 };
    let near = |n| std::iter::repeat_n(Vec2 { x: 5, y: 5 }, n);
    assert!(board.observe(now, State::default(), near(240)).is_ok());
    let crowd = board.observe(now, State::default(), near(241));
    assert!(matches!(crowd, Err(PilError::TooManyPois(241))), "{crowd:?}");
    let far = std::iter::repeat_n(Vec2 { x: 14 * TICKS_PER_U, y: 0 }, 1000);
    assert!(board.observe(now, State::default(), far).is_ok());
}

#[test]
fn bytes_that_are_no_message_are_refused() {
    let file = sample_actor(Aggregation::Gcn, 2);
    let mut board = client(&file, Line::perfect(), AT_ONCE);
    board.hello(SETUP).unwrap();
    for bytes in [&[1, 1, 1][..], &[0; 500]] {
        let refused = board.hear_bytes(Moment::default(), Vec2::default(), bytes);
        assert!(matches!(refused, Err(PilError::Refused(RequestError::Message))), "{refused:?}");
    }
    let own = Message::Beacon(Beacon::new(Header::default(), 0, State::default(), 0));
    let outcome = board.hear(Moment::default(), Vec2::default(), &own).unwrap();
    assert_eq!((outcome.outcome, outcome.kept), (MessageOutcome::OwnId, 0));
}

#[test]
fn it_works_over_a_socket() {
    let file = sample_actor(Aggregation::Gcn, 2);
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let board_file = file.clone();
    let board = std::thread::spawn(move || {
        use std::io::{Read, Write};
        let (mut stream, _) = listener.accept().unwrap();
        let mut server = firmware_core::pil::Server::new();
        stream.write_all(server.boot(&board_file)).unwrap();
        let mut chunk = [0; 64];
        while let Ok(n @ 1..) = stream.read(&mut chunk) {
            for &byte in &chunk[..n] {
                if let Some(answer) = server.push(byte) {
                    stream.write_all(answer).unwrap();
                }
            }
        }
    });
    let patient = Options { timeout: Duration::from_secs(60), attempts: 1 };
    let mut client = Client::tcp(address, patient).unwrap();
    client.hello(SETUP).unwrap();
    assert!(client.status().unwrap().started);
    assert!(client.restarted().is_some());
    drop(client);
    board.join().unwrap();
}
