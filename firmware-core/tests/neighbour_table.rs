//! The neighbour table through its public interface: single rules, a plain model with
//! clocks that do not wrap, and what is promised about a dense swarm and a bad radio.

use firmware_core::actor::PolicyId;
use firmware_core::geometry::{State, TICKS_PER_U, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, MessageOutcome, Moment, NeighbourTable};
use firmware_core::observation::{MAX_NEIGHBOURS, Neighbour, Neighbours, Scene, observe};
use proptest::collection::vec;
use proptest::prelude::*;
use std::collections::HashMap;

const OWN: u16 = 0;
const STEP_MS: u32 = DEFAULT_STEP_MS as u32;
const POLICY: PolicyId = PolicyId { hash: 0xc0ff_ee00, width: 4 };
const HERE: Vec2 = Vec2 { x: 100 * TICKS_PER_U, y: 100 * TICKS_PER_U };

fn table() -> NeighbourTable {
    NeighbourTable::new(OWN, POLICY, DEFAULT_STEP_MS)
}

fn u(x: f32, y: f32) -> Vec2 {
    Vec2::from_u(x, y)
}

fn at(step: u32) -> Moment {
    Moment { step, time_ms: step.wrapping_mul(STEP_MS) }
}

fn at_ms(time_ms: u32) -> Moment {
    Moment { step: time_ms / STEP_MS, time_ms }
}

/// A beacon at `offset` from [`HERE`], measured at `time_ms`.
fn beacon(id: u16, sequence: u16, time_ms: u32, offset: Vec2, velocity: Vec2) -> Message {
    let state = State { position: HERE + offset, velocity };
    Message::Beacon(Beacon::new(Header { id, sequence, step: time_ms / STEP_MS }, time_ms, state, 5))
}

fn still(id: u16, sequence: u16, time_ms: u32, offset: Vec2) -> Message {
    beacon(id, sequence, time_ms, offset, Vec2::default())
}

fn feature(id: u16, sequence: u16, step: u32) -> Message {
    feature_of(id, sequence, step, POLICY.hash, &[sequence as i8; 4])
}

fn feature_of(id: u16, sequence: u16, step: u32, actor: u32, values: &[i8]) -> Message {
    Message::Feature(FeatureMessage::new(Header { id, sequence, step }, 3, actor, -7, values).unwrap())
}

fn view(table: &mut NeighbourTable, now: Moment) -> Vec<Neighbour> {
    let mut out = Neighbours::new();
    table.view(HERE, now, &mut out);
    out.as_slice().to_vec()
}

/// Ids and first values of the features in view at `now`.
fn features(table: &mut NeighbourTable, now: Moment) -> Vec<(u16, i8)> {
    let mut seen = Neighbours::new();
    table.view(HERE, now, &mut seen);
    table.features(&seen, now.step).map(|(id, f)| (id, f.values[0])).collect()
}

#[test]
fn a_small_table() {
    assert!(size_of::<NeighbourTable>() <= 2200, "{}", size_of::<NeighbourTable>());
}

#[test]
fn nobody_around_is_an_ordinary_case() {
    let mut t = table();
    assert!(view(&mut t, at(7)).is_empty());
    assert!(features(&mut t, at(7)).is_empty());
    assert!(t.is_empty());
}

#[test]
fn a_beacon_is_seen_and_extrapolated_until_it_is_two_steps_old() {
    let mut t = table();
    let velocity = u(2.0, -1.0);
    assert_eq!(t.hear(&beacon(3, 0, 10_000, u(4.0, 3.0), velocity), HERE, at_ms(10_020)), MessageOutcome::New);
    let offset_at = |t: &mut NeighbourTable, ms| view(t, at_ms(ms)).first().map(|n| n.offset);
    assert_eq!(offset_at(&mut t, 10_000), Some(u(4.0, 3.0)));
    assert_eq!(offset_at(&mut t, 11_000), Some(u(5.0, 2.5)));
    assert_eq!(offset_at(&mut t, 14_000), Some(u(8.0, 1.0)));
    assert_eq!(offset_at(&mut t, 14_001), None);
    assert!(t.is_empty());
}

#[test]
fn a_beacon_measured_after_the_moment_is_taken_back_to_it() {
    let mut t = table();
    assert_eq!(t.hear(&beacon(3, 0, 10_500, u(5.0, 0.0), u(4.0, 0.0)), HERE, at(5)), MessageOutcome::New);
    assert_eq!(view(&mut t, at(5))[0].offset, u(4.0, 0.0));
}

#[test]
fn out_of_range_is_kept_but_not_seen() {
    let mut t = table();
    assert_eq!(t.hear(&beacon(3, 0, 10_000, u(20.0, 0.0), u(-4.0, 0.0)), HERE, at(5)), MessageOutcome::New);
    assert!(view(&mut t, at(5)).is_empty());
    assert_eq!(t.len(), 1);
    assert_eq!(view(&mut t, at(6))[0].offset, u(16.0, 0.0));
}

#[test]
fn an_unbelievable_velocity_is_cut() {
    let mut t = table();
    assert_eq!(t.hear(&beacon(3, 0, 10_000, u(1.0, 0.0), u(31.0, -31.0)), HERE, at(5)), MessageOutcome::New);
    assert_eq!(view(&mut t, at(6))[0].offset, u(7.0, -6.0));
}

#[test]
fn own_repeated_and_older_messages_are_dropped() {
    let mut t = table();
    assert_eq!(t.hear(&still(OWN, 1, 0, u(1.0, 0.0)), HERE, at(0)), MessageOutcome::OwnId);
    assert_eq!(t.hear(&still(3, 65_535, 0, u(1.0, 0.0)), HERE, at(0)), MessageOutcome::New);
    assert_eq!(t.hear(&still(3, 65_535, 0, u(2.0, 0.0)), HERE, at(0)), MessageOutcome::Repeated);
    assert_eq!(t.hear(&still(3, 65_534, 0, u(2.0, 0.0)), HERE, at(0)), MessageOutcome::Older);
    // The counter wraps around.
    assert_eq!(t.hear(&still(3, 0, 0, u(3.0, 0.0)), HERE, at(0)), MessageOutcome::Updated);
    assert_eq!(view(&mut t, at(0))[0].offset, u(3.0, 0.0));
}

#[test]
fn a_restarted_sender_is_heard_again_once_it_was_forgotten() {
    let mut t = table();
    assert_eq!(t.hear(&still(3, 900, 0, u(1.0, 0.0)), HERE, at_ms(0)), MessageOutcome::New);
    assert_eq!(t.hear(&still(3, 0, 4000, u(1.0, 0.0)), HERE, at_ms(4000)), MessageOutcome::Older);
    assert_eq!(t.hear(&still(3, 1, 4001, u(1.0, 0.0)), HERE, at_ms(4001)), MessageOutcome::New);
}

#[test]
fn late_and_future_beacons_are_dropped() {
    let mut t = table();
    let now = at_ms(20_000);
    assert_eq!(t.hear(&still(3, 0, 15_999, u(1.0, 0.0)), HERE, now), MessageOutcome::Late);
    assert_eq!(t.hear(&still(3, 0, 22_001, u(1.0, 0.0)), HERE, now), MessageOutcome::Ahead);
    assert_eq!(t.hear(&still(3, 0, 16_000, u(1.0, 0.0)), HERE, now), MessageOutcome::New);
    assert_eq!(t.hear(&still(4, 0, 22_000, u(1.0, 0.0)), HERE, now), MessageOutcome::New);
}

#[test]
fn the_clock_wraps_around() {
    let mut t = table();
    let before = u32::MAX - 999;
    assert_eq!(t.hear(&beacon(3, 0, before, u(1.0, 0.0), u(4.0, 0.0)), HERE, at_ms(before)), MessageOutcome::New);
    let after = Moment { step: 0, time_ms: 1000 };
    assert_eq!(view(&mut t, after)[0].offset, u(5.0, 0.0));
    assert!(view(&mut t, Moment { step: 0, time_ms: 3001 }).is_empty());
}

#[test]
fn a_clock_that_jumps_back_leaves_no_ghosts() {
    let mut t = table();
    assert_eq!(t.hear(&still(3, 0, 500_000, u(1.0, 0.0)), HERE, at_ms(500_000)), MessageOutcome::New);
    assert_eq!(t.hear(&still(4, 0, 500_000, u(2.0, 0.0)), HERE, at_ms(500_000)), MessageOutcome::New);
    // A small correction keeps them, for as long as a fresh beacon and one step more.
    assert_eq!(view(&mut t, at_ms(498_500)).len(), 2);
    assert!(view(&mut t, at_ms(100_000)).is_empty());
    assert!(t.is_empty());
    assert_eq!(t.hear(&still(3, 1, 100_000, u(1.0, 0.0)), HERE, at_ms(100_000)), MessageOutcome::New);
}

#[test]
fn a_jump_waits_for_a_second_beacon() {
    let mut t = table();
    let now = at_ms(2000);
    assert_eq!(t.hear(&still(3, 0, 0, u(0.0, 0.0)), HERE, at_ms(0)), MessageOutcome::New);
    // 6 u/step and 2 u of noise are believed, no more.
    assert_eq!(t.hear(&still(3, 1, 2000, u(8.1, 0.0)), HERE, now), MessageOutcome::Suspicious);
    assert_eq!(view(&mut t, now)[0].offset, Vec2::default());
    // Not by itself ...
    assert_eq!(t.hear(&still(3, 1, 2000, u(8.1, 0.0)), HERE, now), MessageOutcome::Repeated);
    // ... nor by yet another jump, but by a beacon that agrees.
    assert_eq!(t.hear(&still(3, 2, 2100, u(0.0, 12.0)), HERE, at_ms(2100)), MessageOutcome::Suspicious);
    assert_eq!(t.hear(&still(3, 4, 2200, u(0.0, 11.0)), HERE, at_ms(2200)), MessageOutcome::Confirmed);
    assert_eq!(view(&mut t, at_ms(2200))[0].offset, u(0.0, 11.0));
    assert_eq!(t.hear(&still(3, 3, 2150, u(0.0, 11.0)), HERE, at_ms(2200)), MessageOutcome::Older);
}

#[test]
fn one_wild_beacon_changes_nothing() {
    let mut t = table();
    assert_eq!(t.hear(&still(3, 0, 0, u(1.0, 0.0)), HERE, at_ms(0)), MessageOutcome::New);
    assert_eq!(t.hear(&still(3, 30_000, 100, u(17.0, 0.0)), HERE, at_ms(100)), MessageOutcome::Suspicious);
    assert_eq!(t.hear(&still(3, 1, 200, u(1.1, 0.0)), HERE, at_ms(200)), MessageOutcome::Updated);
    assert_eq!(t.hear(&still(3, 2, 300, u(1.2, 0.0)), HERE, at_ms(300)), MessageOutcome::Updated);
    assert_eq!(view(&mut t, at_ms(300))[0].offset, u(1.2, 0.0));
}

#[test]
fn features_need_a_beacon_the_same_policy_and_its_width() {
    let mut t = table();
    assert_eq!(t.hear(&feature(3, 0, 5), HERE, at(5)), MessageOutcome::UnknownSender);
    assert_eq!(t.hear(&still(3, 0, 10_000, u(1.0, 0.0)), HERE, at(5)), MessageOutcome::New);
    assert!(features(&mut t, at(5)).is_empty());
    let foreign = feature_of(3, 0, 5, POLICY.hash + 1, &[1; 4]);
    assert_eq!(t.hear(&foreign, HERE, at(5)), MessageOutcome::ForeignActor);
    let narrow = feature_of(3, 0, 5, POLICY.hash, &[1; 3]);
    assert_eq!(t.hear(&narrow, HERE, at(5)), MessageOutcome::WrongWidth);
    assert_eq!(t.hear(&feature(OWN, 0, 5), HERE, at(5)), MessageOutcome::OwnId);
    assert_eq!(t.hear(&feature(3, 0, 5), HERE, at(5)), MessageOutcome::Updated);
    let mut seen = Neighbours::new();
    t.view(HERE, at(5), &mut seen);
    let all: Vec<_> = t.features(&seen, 5).collect();
    assert_eq!(all.len(), 1);
    let (id, f) = all[0];
    assert_eq!((id, f.degree, f.attention_source, f.values), (3, 3, -7, &[0i8; 4][..]));
}

#[test]
fn a_feature_is_used_until_it_is_two_steps_old() {
    let mut t = table();
    for step in 5..8 {
        let sequence = step as u16;
        assert!(t.hear(&still(3, sequence, step * STEP_MS, u(1.0, 0.0)), HERE, at(step)).is_taken());
    }
    assert_eq!(t.hear(&feature(3, 1, 4), HERE, at(7)), MessageOutcome::Late);
    assert_eq!(t.hear(&feature(3, 1, 9), HERE, at(7)), MessageOutcome::Ahead);
    assert_eq!(t.hear(&feature(3, 1, 5), HERE, at(7)), MessageOutcome::Updated);
    assert_eq!(t.hear(&feature(3, 1, 6), HERE, at(7)), MessageOutcome::Repeated);
    assert_eq!(t.hear(&feature(3, 0, 6), HERE, at(7)), MessageOutcome::Older);
    assert_eq!(features(&mut t, at(7)), [(3, 1)]);
    // The neighbour stays, its feature is gone; then a new one counts, whatever its number.
    assert_eq!(features(&mut t, at(8)), []);
    assert_eq!(view(&mut t, at(8)).len(), 1);
    assert_eq!(t.hear(&feature(3, 0, 8), HERE, at(8)), MessageOutcome::Updated);
    assert_eq!(features(&mut t, at(8)), [(3, 0)]);
}

#[test]
fn a_full_table_keeps_the_nearest() {
    let mut t = table();
    for id in 1..=16 {
        assert_eq!(t.hear(&still(id, 0, 0, u(f32::from(id), 0.0)), HERE, at(0)), MessageOutcome::New);
    }
    assert_eq!(t.hear(&still(17, 0, 0, u(17.0, 0.0)), HERE, at(0)), MessageOutcome::TooFar);
    assert_eq!(t.hear(&still(18, 0, 0, u(15.5, 0.0)), HERE, at(0)), MessageOutcome::Replaced(16));
    assert_eq!(t.hear(&feature(16, 0, 0), HERE, at(0)), MessageOutcome::UnknownSender);
    assert_eq!(view(&mut t, at(0)).last().map(|n| n.id), Some(18));
}

/// The rules again, on clocks and counters that do not wrap, without a capacity.
#[derive(Default)]
struct Model(HashMap<u16, Known>);

struct Known {
    /// Position (ticks), velocity (ticks/step), time (ms), sequence.
    fix: (Vec2, Vec2, i64, i64),
    doubt: Option<(Vec2, i64, i64)>,
    /// Step, sequence.
    feature: Option<(i64, i64)>,
}

fn flyable(a: Vec2, b: Vec2, ms: i64) -> bool {
    let (dx, dy) = (f64::from(a.x - b.x), f64::from(a.y - b.y));
    let reach = (6144 * ms.abs() / i64::from(STEP_MS) + 2048) as f64;
    dx * dx + dy * dy <= reach * reach
}

impl Model {
    fn expire(&mut self, step: i64, ms: i64) {
        self.0.retain(|_, k| (-2000..=4000).contains(&(ms - k.fix.2)));
        for k in self.0.values_mut() {
            k.doubt = k.doubt.filter(|d| (-2000..=4000).contains(&(ms - d.1)));
            k.feature = k.feature.filter(|f| (-1..=2).contains(&(step - f.0)));
        }
    }

    fn hear_beacon(&mut self, id: u16, fix: (Vec2, Vec2, i64, i64), now: i64) -> MessageOutcome {
        match now - fix.2 {
            _ if id == OWN => return MessageOutcome::OwnId,
            ..-2000 => return MessageOutcome::Ahead,
            4001.. => return MessageOutcome::Late,
            _ => {}
        }
        let Some(k) = self.0.get_mut(&id) else {
            self.0.insert(id, Known { fix, doubt: None, feature: None });
            return MessageOutcome::New;
        };
        if fix.3 == k.fix.3 || fix.3 > k.fix.3 && k.doubt.is_some_and(|d| d.2 == fix.3) {
            return MessageOutcome::Repeated;
        } else if fix.3 < k.fix.3 {
            return MessageOutcome::Older;
        }
        let overtaken = k.doubt.is_some_and(|d| fix.3 < d.2);
        if flyable(k.fix.0, fix.0, k.fix.2 - fix.2) {
            (k.fix, k.doubt) = (fix, None);
            MessageOutcome::Updated
        } else if !overtaken && k.doubt.is_some_and(|d| flyable(d.0, fix.0, d.1 - fix.2)) {
            (k.fix, k.doubt) = (fix, None);
            MessageOutcome::Confirmed
        } else {
            k.doubt = if overtaken { k.doubt } else { Some((fix.0, fix.2, fix.3)) };
            MessageOutcome::Suspicious
        }
    }

    fn hear_feature(&mut self, id: u16, step: i64, sequence: i64, now: i64) -> MessageOutcome {
        match now - step {
            _ if id == OWN => return MessageOutcome::OwnId,
            ..-1 => return MessageOutcome::Ahead,
            3.. => return MessageOutcome::Late,
            _ => {}
        }
        let Some(k) = self.0.get_mut(&id) else { return MessageOutcome::UnknownSender };
        match k.feature {
            Some(f) if f.1 == sequence => MessageOutcome::Repeated,
            Some(f) if f.1 > sequence => MessageOutcome::Older,
            _ => {
                k.feature = Some((step, sequence));
                MessageOutcome::Updated
            }
        }
    }

    /// Offsets by id.
    fn view(&self, ms: i64) -> Vec<(u16, Vec2)> {
        let mut all: Vec<_> = self
            .0
            .iter()
            .map(|(&id, k)| {
                let (p, v, then, _) = k.fix;
                let moved = |v: i32| (f64::from(v.clamp(-6144, 6144)) * (ms - then) as f64 / 2000.0).round() as i32;
                (id, Vec2 { x: p.x + moved(v.x) - HERE.x, y: p.y + moved(v.y) - HERE.y })
            })
            .filter(|(_, o)| o.within(18 * TICKS_PER_U).is_some())
            .collect();
        all.sort_by_key(|(id, o)| (o.within(18 * TICKS_PER_U), *id));
        all
    }
}

#[derive(Clone, Debug)]
struct Event {
    /// ms since the event before.
    passed: i64,
    id: u16,
    sequence: i64,
    /// Age of the message: ms, and steps.
    age: (i64, i64),
    /// Offset and velocity of a beacon, or a feature.
    what: Option<(Vec2, Vec2)>,
}

fn event() -> impl Strategy<Value = Event> {
    let passed = prop_oneof![20 => 0..700i64, 1 => -9000..9000i64];
    let vec2 = |r: i32| (-r..r, -r..r).prop_map(|(x, y)| Vec2 { x, y });
    let what = prop::option::weighted(0.7, (vec2(14 * TICKS_PER_U), vec2(8000)));
    (passed, 0..=16u16, 0..40i64, (-2500..5000i64, -2..4i64), what)
        .prop_map(|(passed, id, sequence, age, what)| Event { passed, id, sequence, age, what })
}

proptest! {
    #[test]
    fn the_table_does_as_the_model(events in vec(event(), 0..300), base in any::<[u32; 2]>(), first in any::<u16>()) {
        let (mut t, mut m, mut ms) = (table(), Model::default(), 0i64);
        for e in events {
            ms += e.passed;
            let step = ms.div_euclid(i64::from(STEP_MS));
            // What the real thing sees wraps around somewhere.
            let clock = |ms: i64| base[0].wrapping_add(ms as u32);
            let now = Moment { step: base[1].wrapping_add(step as u32), time_ms: clock(ms) };
            let sequence = first.wrapping_add(e.sequence as u16);
            m.expire(step, ms);
            let (answer, expected) = match e.what {
                Some((offset, velocity)) => {
                    let then = ms - e.age.0;
                    let message = beacon(e.id, sequence, clock(then), offset, velocity);
                    let fix = (HERE + offset, velocity, then, e.sequence);
                    (t.hear(&message, HERE, now), m.hear_beacon(e.id, fix, ms))
                }
                None => {
                    let message = feature(e.id, sequence, now.step.wrapping_sub(e.age.1 as u32));
                    (t.hear(&message, HERE, now), m.hear_feature(e.id, step - e.age.1, e.sequence, step))
                }
            };
            prop_assert_eq!(answer, expected);
            prop_assert_eq!(t.len(), m.0.len());
            let seen: Vec<_> = view(&mut t, now).iter().map(|n| (n.id, n.offset)).collect();
            prop_assert_eq!(&seen, &m.view(ms));
            let with_feature: Vec<_> = features(&mut t, now).iter().map(|f| f.0).collect();
            let expected: Vec<_> = seen.iter().map(|s| s.0).filter(|id| m.0[id].feature.is_some()).collect();
            prop_assert_eq!(with_feature, expected);
        }
    }

    #[test]
    fn of_one_moment_the_nearest_are_kept_in_any_order(
        offsets in vec((-20_000..20_000i32, -20_000..20_000i32), 0..60),
        order in any::<u64>(),
    ) {
        let mut all: Vec<Neighbour> = offsets.iter().zip(1..).map(|(&(x, y), id)| Neighbour {
            id, offset: Vec2 { x, y }, velocity: Vec2::default(), tie: 5,
        }).collect();
        let mut direct = Neighbours::new();
        all.iter().for_each(|&n| direct.insert(n));
        all.sort_by_key(|n| u64::from(n.id).wrapping_mul(order | 1));
        let mut t = table();
        for n in &all {
            let _ = t.hear(&still(n.id, 0, 10_000, n.offset), HERE, at(5));
            prop_assert!(t.len() <= MAX_NEIGHBOURS);
        }
        prop_assert_eq!(view(&mut t, at(5)), direct.as_slice());
    }

    /// A swarm flies for some steps and loses half of its beacons, the rest in any order. Then comes
    /// one step with every beacon: all is as if positions were known.
    #[test]
    fn with_every_beacon_the_table_is_what_the_world_is(
        starts in vec((80.0..120.0f32, 80.0..120.0f32), 1..50),
        turns in vec((0..17u8, any::<bool>()), 0..400),
        order in any::<u64>(),
        pois in vec((80.0..120.0f32, 80.0..120.0f32), 0..60),
    ) {
        let mut states: Vec<State> =
            starts.iter().map(|&(x, y)| State { position: u(x, y), velocity: Vec2::default() }).collect();
        let mut t = table();
        let mut turns = turns.iter();
        let mut step = 0;
        loop {
            let draws: Vec<_> = states.iter().map(|_| turns.next().copied()).collect();
            let last = draws.iter().all(Option::is_none);
            let mut ids: Vec<usize> = (1..states.len()).collect();
            ids.sort_by_key(|&i| (i as u64).wrapping_mul(order.wrapping_add(u64::from(step)) | 1));
            for i in ids {
                if last || draws[i].is_some_and(|d| d.1) {
                    let header = Header { id: i as u16, sequence: step as u16, step };
                    let tie = firmware_core::random::tie_breaker(1, header.id, step, 1);
                    let message = Message::Beacon(Beacon::new(header, step * STEP_MS, states[i], tie));
                    let answer = t.hear(&message, states[0].position, at(step));
                    prop_assert!(answer.is_taken() || answer == MessageOutcome::TooFar, "{:?}", answer);
                }
            }
            if last {
                break;
            }
            for (s, d) in states.iter_mut().zip(&draws) {
                let action = firmware_core::action::Action::new(d.map_or(16, |d| d.0)).unwrap();
                let (vx, vy) = action.next_velocity(s.velocity.to_u());
                s.velocity = u(vx, vy);
                s.position = s.position + s.velocity;
            }
            step += 1;
        }
        let tie = |id: usize| firmware_core::random::tie_breaker(1, id as u16, step, 1);
        let mut direct = Neighbours::new();
        for (i, s) in states.iter().enumerate().skip(1) {
            let offset = s.position - states[0].position;
            direct.insert(Neighbour { id: i as u16, offset, velocity: s.velocity, tie: tie(i) });
        }
        let mut heard = Neighbours::new();
        t.view(states[0].position, at(step), &mut heard);
        prop_assert_eq!(heard.as_slice(), direct.as_slice());
        let scene = |neighbours| Scene { id: OWN, own: states[0], tie: tie(0), half_side: 100 * TICKS_PER_U, neighbours };
        let pois = || pois.iter().map(|&(x, y)| u(x, y));
        prop_assert_eq!(observe(&scene(&heard), pois()), observe(&scene(&direct), pois()));
    }
}
