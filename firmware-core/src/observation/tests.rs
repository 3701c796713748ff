//! The observation beside its table, computed plainly.

extern crate std;
use super::exploration::UNIT_VECTORS;
use super::neighbours::COMMUNICATION_RANGE;
use super::{LEN, MAX_NEIGHBOURS, Neighbour, Neighbours, Scene, observe};
use crate::geometry::{MAP_SIDE_U, State, TICKS_PER_U, Vec2};
use proptest::prelude::*;
use std::vec::Vec as List;

const SIDE: i32 = MAP_SIDE_U as i32 * TICKS_PER_U;

/// The module's table, word for word, in wide and floating numbers.
fn naive(scene: &Scene<'_>, pois: &[Vec2]) -> List<i8> {
    let scaled = |v: i64, scale: i64| {
        let r = (v.abs() * 127 + scale / 2) / scale * v.signum();
        r.clamp(-127, 127) as i8
    };
    let d2 = |v: Vec2| i64::from(v.x).pow(2) + i64::from(v.y).pow(2);
    let u = |n: i32| i64::from(n) * i64::from(TICKS_PER_U);
    let neighbours = scene.neighbours.as_slice();
    let first = |n: &Neighbour| scene.tie > n.tie || scene.tie == n.tie && scene.id > n.id;
    let claim = |o: Vec2| {
        let covers = |n: &&Neighbour| d2(o - n.offset) <= u(10).pow(2);
        neighbours.iter().filter(covers).map(|n| if first(n) { 1 } else { 2 }).max().unwrap_or(0)
    };
    let mut seen: List<(i64, Vec2, u8)> = pois
        .iter()
        .map(|&p| p - scene.own.position)
        .filter(|&o| d2(o) <= u(13).pow(2))
        .map(|o| (d2(o), o, claim(o)))
        .collect();
    seen.sort();
    let free: List<Vec2> = seen.iter().filter(|p| p.2 < 2).map(|p| p.1).collect();
    let half = i64::from(scene.half_side);
    let (own, v) = (scene.own.position, scene.own.velocity);
    let mut out = List::from([
        scaled(i64::from(own.x) - half, half),
        scaled(i64::from(own.y) - half, half),
        scaled(v.x.into(), u(4)),
        scaled(v.y.into(), u(4)),
        scene.tie.max(-127),
        scaled(neighbours.len() as i64, 16),
        scaled(free.len() as i64, 48),
    ]);
    let mean = |axis: fn(&Vec2) -> i32| match free.len() as i64 {
        0 => 0,
        n => {
            let sum: i64 = free.iter().map(|o| i64::from(axis(o))).sum();
            scaled((sum.abs() + n / 2) / n * sum.signum(), u(13))
        }
    };
    out.extend([mean(|o| o.x), mean(|o| o.y)]);
    let push = |axis: fn(&Vec2) -> i32| {
        let part = |n: &Neighbour| {
            let share = ((u(18).pow(2) - d2(n.offset)) >> 20).clamp(0, 324);
            i64::from(axis(&n.offset)) * share
        };
        let sum: i64 = -neighbours.iter().map(part).sum::<i64>();
        scaled((sum.abs() + 162) / 324 * sum.signum(), u(18))
    };
    out.extend([push(|o| o.x), push(|o| o.y)]);
    let yields = |n: &Neighbour| first(n);
    let named: List<(Vec2, u8)> = seen.iter().take(22).map(|&(_, o, claim)| (o, claim)).collect();
    let chosen = naive_best(scene, &named, yields);
    out.extend(chosen.rings.map(|w| scaled(w, 512 * 24)));
    out.push(scaled(chosen.worth, 512 * 24));
    for at in [chosen.coarse, chosen.fine] {
        out.extend([scaled(at.0, u(18)), scaled(at.1, u(18))]);
    }
    out.extend([scaled(chosen.acceleration.0, u(8)), scaled(chosen.acceleration.1, u(8)), scaled(chosen.count, 440)]);
    for n in neighbours.iter().take(6) {
        let (o, v) = (n.offset, n.velocity);
        out.extend([127, scaled(o.x.into(), u(18)), scaled(o.y.into(), u(18))]);
        out.extend([scaled(v.x.into(), u(4)), scaled(v.y.into(), u(4)), if first(n) { 127 } else { -127 }]);
    }
    out.resize(72, 0);
    for &(_, o, claim) in seen.iter().take(22) {
        out.extend([127, scaled(o.x.into(), u(13)), scaled(o.y.into(), u(13)), [0, 64, 127][usize::from(claim)]]);
    }
    out.resize(LEN, 0);
    out
}

/// What the numbers about places are made of.
struct Chosen {
    rings: [i64; 17],
    worth: i64,
    coarse: (i64, i64),
    fine: (i64, i64),
    acceleration: (i64, i64),
    count: i64,
}

/// Sixteenths of a square unit, rounded down axis by axis, as the document says.
fn sixteenths(a: (i64, i64), b: (i64, i64)) -> i64 {
    ((a.0 - b.0).pow(2) >> 16) + ((a.1 - b.1).pow(2) >> 16)
}

fn limit(ticks: i64) -> i64 {
    ticks.pow(2) >> 16
}

fn naive_best(scene: &Scene<'_>, pois: &[(Vec2, u8)], yields: impl Fn(&Neighbour) -> bool) -> Chosen {
    let wide = |v: Vec2| (i64::from(v.x), i64::from(v.y));
    let isqrt = |v: i64| v.unsigned_abs().isqrt() as i64;
    let cap = |v: i64| v.clamp(-8192, 8192);
    let v = (cap(scene.own.velocity.x.into()), cap(scene.own.velocity.y.into()));
    let moving = v.0.pow(2) + v.1.pow(2) > 1024 * 1024 / 4;
    let ahead = |unit: (i64, i64)| if moving { ((unit.0 * v.0 + unit.1 * v.1) * 5) >> 11 } else { 0 };
    // The coarse grid, rows from south to north.
    let mut worth = std::collections::BTreeMap::new();
    for (row, column) in (-3i64..=3).flat_map(|row| (-3i64..=3).map(move |column| (row, column))) {
        let at = (column * 4096, row * 4096);
        let far = isqrt((row * row + column * column) * 4096);
        let won = |claim: u8| 512 - far - if claim == 1 { 120 } else { 0 };
        let reached = pois.iter().filter(|p| p.1 < 2 && sixteenths(wide(p.0), at) <= limit(10_076));
        worth.insert((row, column), reached.map(|p| won(p.1)).sum::<i64>());
    }
    let ring = |ring: i64| {
        let around = [(1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1)];
        around.map(|(x, y)| worth[&(y * ring, x * ring)])
    };
    let rings: List<i64> = [worth[&(0, 0)]].into_iter().chain(ring(1)).chain(ring(2)).collect();
    let mut best = (0, (0, 0));
    for (&(row, column), &worth) in &worth {
        let far = isqrt((row * row + column * column) * 4096);
        let unit = if row * row + column * column > 1 { (column * 4096 / far, row * 4096 / far) } else { (0, 0) };
        let worth = (worth * (1024 + ahead(unit))) >> 10;
        if worth > best.0 {
            best = (worth, (column * 4096, row * 4096));
        }
    }
    let of_pois = best;
    let half = i64::from(scene.half_side);
    for &(ux, uy) in &UNIT_VECTORS {
        let (ux, uy) = (i64::from(ux), i64::from(uy));
        let place = (ux * 16, uy * 16);
        let inside = |at: i64| (half - (at - half).abs()).clamp(0, 32 * 1024) / 1024;
        let own = wide(scene.own.position);
        let likely = (inside(own.0 + place.0) * inside(own.1 + place.1)) >> 5;
        let hint = |p: &&(Vec2, u8)| {
            let (x, y) = (wide(p.0).0 >> 8, wide(p.0).1 >> 8);
            (x - ux * 40 / 1024).pow(2) + (y - uy * 40 / 1024).pow(2) <= 36 * 36
        };
        let hinted = if likely > 0 { (40 * pois.iter().filter(hint).count() as i64).min(195) } else { 0 };
        let sees = |n: &&Neighbour| {
            let (x, y) = (wide(n.offset).0 >> 9, wide(n.offset).1 >> 9);
            (x - ux * 32 / 1024).pow(2) + (y - uy * 32 / 1024).pow(2) <= 30 * 30
        };
        let left = scene.neighbours.as_slice().iter().filter(sees).map(|n| if yields(n) { 41 } else { 0 });
        let worth = ((((170 * likely) >> 5) + hinted) * left.min().unwrap_or(64)) >> 4;
        let worth = (worth * (1024 + ahead((ux / 16, uy / 16)))) >> 10;
        if worth > best.0 {
            best = (worth, place);
        }
    }
    let mut fine = (0, best.1, 0);
    if best.0 > 0 && best == of_pois {
        for (row, column) in (-3i64..=3).flat_map(|row| (-3i64..=3).map(move |column| (row, column))) {
            let at = (best.1.0 + column * 1024, best.1.1 + row * 1024);
            let count: i64 = (pois.iter().filter(|p| p.1 < 2))
                .map(|p| {
                    let from = (wide(p.0).0 - best.1.0, wide(p.0).1 - best.1.1);
                    let d2 = sixteenths(from, (column * 1024, row * 1024));
                    let share = [(8_909, 2), (9_574, 2), (10_240, 1)].iter().filter(|s| d2 <= limit(s.0));
                    share.map(|s| s.1).sum::<i64>() * if p.1 == 1 { 3 } else { 4 }
                })
                .sum();
            let (long, short) = (at.0.abs().max(at.1.abs()), at.0.abs().min(at.1.abs()));
            let worth = count * (8 * 4096 - ((1007 * long + 441 * short) >> 10));
            if worth > fine.0 {
                fine = (worth, at, count);
            }
        }
    }
    let mut chosen = Chosen {
        rings: rings.try_into().unwrap(),
        worth: best.0,
        coarse: best.1,
        fine: fine.1,
        acceleration: (0, 0),
        count: fine.2,
    };
    if best.0 > 0 {
        let far = isqrt(fine.1.0.pow(2) + fine.1.1.pow(2));
        let rounded = |c: i64| (c.abs() * 4096 + far / 2) / far * c.signum();
        let wanted = if far > 4096 { (rounded(fine.1.0), rounded(fine.1.1)) } else { fine.1 };
        chosen.acceleration = (wanted.0 - v.0, wanted.1 - v.1);
    }
    chosen
}

fn near(range_u: i32) -> impl Strategy<Value = Vec2> {
    let t = range_u * TICKS_PER_U;
    // Whole units too, so that distances repeat and limits are met exactly.
    let whole =
        (-range_u..=range_u, -range_u..=range_u).prop_map(|(x, y)| Vec2::from_ticks(x * TICKS_PER_U, y * TICKS_PER_U));
    prop_oneof![(-t..=t, -t..=t).prop_map(|(x, y)| Vec2::from_ticks(x, y)), whole]
}

fn neighbour() -> impl Strategy<Value = Neighbour> {
    (0u16..30, near(20), near(4), any::<i8>()).prop_map(|(id, offset, velocity, tie)| Neighbour {
        id,
        offset,
        velocity,
        tie,
    })
}

proptest! {
    #[test]
    fn an_observation_is_what_the_table_says(
        (x, y) in (0..=SIDE, 0..=SIDE),
        velocity in prop_oneof![near(5), near(12)],
        (id, tie) in (0u16..30, any::<i8>()),
        around in prop::collection::vec(neighbour(), 0..24),
        offsets in prop::collection::vec(near(15), 0..70),
        turn in any::<prop::sample::Index>(),
    ) {
        let position = Vec2::from_ticks(x, y);
        let mut neighbours = Neighbours::new();
        around.iter().for_each(|&n| neighbours.insert(n));
        let own = State { position, velocity };
        let scene = Scene { id, own, tie, half_side: SIDE / 2, neighbours: &neighbours };
        let mut pois: List<_> = offsets.iter().map(|&o| position + o).collect();
        let got = observe(&scene, pois.iter().copied());
        prop_assert_eq!(&got[..], &naive(&scene, &pois)[..]);
        // Neither the order of the PoIs nor that of the neighbours shows.
        pois.reverse();
        let at = if pois.is_empty() { 0 } else { turn.index(pois.len()) };
        pois.rotate_left(at);
        prop_assert_eq!(got, observe(&scene, pois.iter().copied()));
        let mut again = Neighbours::new();
        around.iter().rev().for_each(|&n| again.insert(n));
        let distinct: std::collections::BTreeSet<_> = around.iter().map(Neighbour::key).collect();
        prop_assume!(distinct.len() == around.len());
        prop_assert_eq!(neighbours.as_slice(), again.as_slice());
    }

    #[test]
    fn the_nearest_neighbours_in_range_are_kept(around in prop::collection::vec(neighbour(), 0..40)) {
        let mut neighbours = Neighbours::new();
        around.iter().for_each(|&n| neighbours.insert(n));
        let mut expected = around;
        expected.retain(|n| n.offset.within(COMMUNICATION_RANGE).is_some());
        expected.sort_by_key(Neighbour::key);
        expected.truncate(MAX_NEIGHBOURS);
        let keys = |l: &[Neighbour]| l.iter().map(Neighbour::key).collect::<List<_>>();
        prop_assert_eq!(keys(neighbours.as_slice()), keys(&expected));
    }
}
