//! What a memory promises, whatever is sent to it.

extern crate std;
use super::*;
use proptest::prelude::*;
use std::vec::Vec;

const HALF_SIDE: i32 = 100 * TICKS_PER_U;

fn u(x: i32, y: i32) -> Vec2 {
    Vec2::from_ticks(x * TICKS_PER_U, y * TICKS_PER_U)
}

fn told(memory: &mut Memory, budget: usize) -> Knowledge {
    let mut out = Knowledge::new();
    memory.tell(budget, &mut out);
    out
}

fn places(memory: &Memory) -> Vec<GridPoint> {
    memory.pois().iter().map(|p| p.at).collect()
}

/// A memory whose UAV stood at `own` in step `step` and saw these PoIs.
fn saw(id: u16, step: u32, own: Vec2, pois: &[Vec2]) -> Memory {
    let mut memory = Memory::new(id, HALF_SIDE);
    memory.begin(step, own, pois.iter().copied());
    memory
}

#[test]
fn what_one_has_seen_the_other_knows_a_step_older() {
    let (at, poi) = (u(50, 50), u(56, 53));
    let mut first = saw(1, 10, at, &[poi]);
    let mut second = saw(2, 10, u(66, 50), &[]);
    second.hear(1, at, &told(&mut first, 200));
    assert_eq!(second.pois().iter().map(|p| (p.at, p.age)).collect::<Vec<_>>(), [(GridPoint::of(poi), 1)]);
    // And the area: it has never been near there itself.
    assert!(!saw(2, 10, u(66, 50), &[]).is_explored(u(45, 45)) && second.is_explored(u(45, 45)));
}

#[test]
fn a_poi_that_is_not_there_when_looked_at_is_forgotten() {
    let (here, there, poi) = (u(50, 50), u(90, 50), u(55, 50));
    let mut memory = saw(1, 0, here, &[poi]);
    memory.begin(1, there, []);
    assert_eq!(memory.pois().len(), 1);
    memory.begin(2, here, []);
    assert_eq!(memory.pois().len(), 0);
    // Nor does hearsay of it outlast the look.
    let mut liar = saw(2, 2, here, &[poi]);
    memory.hear(2, here, &told(&mut liar, 200));
    memory.settle();
    assert_eq!(memory.pois().len(), 0);
}

#[test]
fn a_full_memory_keeps_the_nearest() {
    let along = |k: i32| u(20 + 14 * k, 60);
    let pois: Vec<_> = (0..12).flat_map(|k| (-4..=4).map(move |d| along(k) + u(d, d.abs() + 2))).collect();
    let mut memory = Memory::new(1, HALF_SIDE);
    (0..12).for_each(|step| memory.begin(step as u32, along(step), pois.iter().copied()));
    memory.begin(12, u(100, 100), [u(101, 101), u(99, 104)]);
    assert_eq!(memory.pois().len(), POI_CAPACITY);
    assert!(places(&memory).contains(&GridPoint::of(u(101, 101))));
}

#[test]
fn intentions_are_forgotten_when_their_owner_should_be_here() {
    let own = u(50, 50);
    let mut memory = saw(1, 0, own, &[]);
    memory.hear_target(7, u(60, 50), 2);
    memory.hear_target(8, u(150, 50), 31);
    for step in 1..=2 {
        memory.begin(step, own, []);
        memory.settle();
        assert_eq!(memory.reports().len(), 2, "step {step}");
    }
    memory.begin(3, own, []);
    memory.settle();
    assert_eq!(memory.reports().iter().map(|r| r.id).collect::<Vec<_>>(), [8]);
    // Its last word counts, and nobody else's younger one.
    memory.hear_target(8, u(20, 20), 9);
    assert_eq!(memory.reports()[0].target, GridPoint::of(u(20, 20)));
}

#[test]
fn steps_wrap_around_and_a_jump_leaves_nothing() {
    let poi = u(55, 50);
    let mut memory = saw(1, u32::MAX, u(50, 50), &[poi]);
    memory.begin(1, u(90, 90), []);
    assert_eq!(memory.pois()[0].age, 2);
    // Back, or too far ahead: a clock was set, or the UAV was off.
    for step in [0, 1 + MAX_GAP + 1] {
        let mut memory = memory.clone();
        memory.begin(step, u(90, 90), []);
        assert!(memory.pois().is_empty() && !memory.is_explored(u(50, 50)), "{step}");
    }
}

#[test]
fn everything_gets_its_turn() {
    let own = u(60, 60);
    let pois: Vec<_> = (0..60).map(|k| own + Vec2 { x: (k % 10 - 5) * 1024, y: (k / 10 - 3) * 1024 }).collect();
    let mut memory = Memory::new(1, HALF_SIDE);
    let mut all = std::collections::BTreeSet::new();
    for step in 0..3 {
        memory.begin(step, own, pois.iter().copied());
        let knowledge = told(&mut memory, 200);
        assert!(knowledge.as_bytes().len() <= 200);
        all.extend(knowledge.pois(memory.frame(GridPoint::of(own))).map(|(at, _)| at));
    }
    assert_eq!(all.len(), 60);
}

#[test]
fn the_area_is_told_once_and_again_to_who_comes() {
    let mut memory = saw(1, 0, u(60, 60), &[]);
    let blocks = |memory: &mut Memory| told(memory, 3).counts()[2];
    assert_eq!(blocks(&mut memory), 1);
    let mut other = saw(9, 0, u(70, 60), &[]);
    // Nothing else is needed, so what is known is told again in the next step.
    memory.begin(1, u(60, 60), []);
    memory.hear(9, u(70, 60), &told(&mut other, 200));
    assert_eq!(blocks(&mut memory), 1);
}

#[test]
fn on_a_large_map_the_window_moves_and_coordinates_stay_true() {
    let half_side = 5_000 * TICKS_PER_U;
    let mut memory = Memory::new(1, half_side);
    for (step, x) in (0..400).map(|k| (k, 3_000 + 4 * k as i32)) {
        let own = u(x, 7_777);
        memory.begin(step, own, [own + u(3, 2)]);
        assert!(memory.is_explored(own) && !memory.is_explored(own - u(300, 0)));
        let mut other = Memory::new(2, half_side);
        other.begin(step, own + u(17, 0), []);
        other.hear(1, own, &told(&mut memory, 200));
        for p in other.pois() {
            assert!(places(&memory).contains(&p.at), "{p:?}");
        }
        assert!(other.is_explored(own));
    }
    assert!(!memory.is_explored(u(3_000, 7_777)));
}

fn knowledge() -> impl Strategy<Value = Knowledge> {
    ((0u8..20, 0u8..16, 0u8..20), prop::collection::vec(any::<u8>(), MAX_KNOWLEDGE)).prop_map(|((p, r, b), bytes)| {
        let len = usize::from(p) * POI_LEN + usize::from(r) * REPORT_LEN + usize::from(b) * BLOCK_LEN;
        Knowledge::from_bytes([p, r, b], &bytes[..len]).unwrap_or_default()
    })
}

fn on_map() -> impl Strategy<Value = Vec2> {
    (0..2 * HALF_SIDE, 0..2 * HALF_SIDE).prop_map(|(x, y)| Vec2 { x, y })
}

proptest! {
    #[test]
    fn whatever_is_heard_lies_on_the_map_and_in_the_past(
        half_side in prop_oneof![Just(HALF_SIDE), 1..=HALF_SIDE_LIMIT],
        messages in prop::collection::vec((any::<u16>(), -1000..1000i32, -1000..1000i32, knowledge()), 0..12),
        steps in prop::collection::vec(0u32..200, 1..12),
    ) {
        let mut memory = Memory::new(3, half_side);
        let mut step = u32::MAX - 50;
        let side = (2 * half_side).unsigned_abs().div_ceil(512);
        for passed in steps {
            step = step.wrapping_add(passed);
            memory.begin(step, u(30, 40), [u(31, 41)]);
            for (id, x, y, knowledge) in &messages {
                memory.hear(*id, u(*x, *y), knowledge);
                memory.hear_target(*id, u(*y, *x), 200);
            }
            memory.settle();
            prop_assert!(memory.pois().len() <= POI_CAPACITY && memory.reports().len() <= REPORT_CAPACITY);
            prop_assert!(memory.pois().is_sorted_by(|a, b| a.at < b.at));
            prop_assert!(memory.pois().iter().all(|p| p.at.is_on_map(side) && p.age <= POI_MAX_AGE));
            let seen = |p: &KnownPoi| p.age > 0 || p.at == GridPoint::of(u(31, 41));
            prop_assert!(memory.pois().iter().all(seen));
            let right = |r: &Report| r.id != 3 && r.target.is_on_map(side) && r.age <= REPORT_MAX_AGE;
            prop_assert!(memory.reports().iter().all(right));
            prop_assert!(told(&mut memory, 117).as_bytes().len() <= 117);
        }
    }

    #[test]
    fn doubled_and_reordered_messages_change_nothing(
        seed in prop::collection::vec((on_map(), prop::collection::vec(on_map(), 0..8)), 2..6),
        order in prop::collection::vec(0usize..100, 12),
    ) {
        // Few enough facts that nothing is displaced.
        let mut sent = Vec::new();
        for (id, (at, pois)) in (10u16..).zip(&seed) {
            let near: Vec<_> = pois.iter().map(|p| *at + Vec2 { x: p.x % 8000, y: p.y % 8000 }).collect();
            sent.push((id, *at, told(&mut saw(id, 5, *at, &near), 200)));
        }
        let run = |messages: &mut dyn Iterator<Item = &(u16, Vec2, Knowledge)>| {
            let mut memory = saw(1, 5, u(100, 100), &[]);
            for (id, at, knowledge) in messages {
                memory.hear(*id, *at, knowledge);
            }
            memory.settle();
            let explored: Vec<bool> = (0..400).map(|k| memory.is_explored(u(5 + 10 * (k % 20), 5 + 10 * (k / 20)))).collect();
            (places(&memory), memory.pois().iter().map(|p| p.age).collect::<Vec<_>>(), explored)
        };
        let plain = run(&mut sent.iter());
        let shuffled = order.iter().map(|k| &sent[k % sent.len()]).chain(&sent);
        let mut shuffled: Vec<_> = shuffled.collect();
        shuffled.reverse();
        prop_assert_eq!(plain, run(&mut shuffled.into_iter()));
    }

    #[test]
    fn knowledge_of_a_wrong_length_is_refused(p in 0u8..30, r in 0u8..30, b in 0u8..30, len in 0usize..260) {
        let right = usize::from(p) * POI_LEN + usize::from(r) * REPORT_LEN + usize::from(b) * BLOCK_LEN;
        let got = Knowledge::from_bytes([p, r, b], &[0; 260][..len]);
        prop_assert_eq!(got.is_some(), len == right && len <= MAX_KNOWLEDGE);
    }
}
