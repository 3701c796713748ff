use super::branch_and_bound::solve;
use super::candidates::{Set, keep_maximal, maximal_sets};
use super::disc::smallest_enclosing_disc;
use super::local_search::Selection;
use super::maximum_cover::EDGE_SLACK_U;
use super::{best_sites, maximum_cover, maximum_cover_within};
use crate::scenario::{PoiDistribution, Scenario};
use crate::world::World;
use proptest::prelude::*;

/// The most that `n` of the sets cover, by trying every choice.
fn brute_force(sets: &[u64], n: usize, done: u64) -> u32 {
    if n == 0 {
        return done.count_ones();
    }
    let next = |(j, s): (usize, &u64)| brute_force(&sets[j + 1..], n - 1, done | s);
    sets.iter().enumerate().map(next).max().unwrap_or(0).max(done.count_ones())
}

fn masks(sets: &[Set]) -> Vec<u64> {
    sets.iter().map(|s| s.iter().fold(0, |m, &p| m | 1 << p)).collect()
}

fn some_pois() -> impl Strategy<Value = Vec<(f32, f32)>> {
    // Crowded enough for overlaps; some on whole units, so that distances repeat.
    let coordinate = prop_oneof![0.0f32..50.0, (0u8..50).prop_map(f32::from)];
    prop::collection::vec((coordinate.clone(), coordinate), 1..16)
}

proptest! {
    #[test]
    fn small_covers_are_the_best_there_are(pois in some_pois(), n in 1usize..5) {
        let points: Vec<_> = pois.iter().map(|&(x, y)| (f64::from(x), f64::from(y))).collect();
        let sets = maximal_sets(&points, 10.0 - EDGE_SLACK_U);
        let most = brute_force(&masks(&sets), n, 0) as usize;
        let cover = maximum_cover(&pois, n);
        prop_assert!(cover.proven);
        prop_assert_eq!(cover.covered, most);
        prop_assert!(cover.sites.len() <= n);
        let mut greedy = Selection::new(&sets, pois.len());
        greedy.add_greedily(n);
        prop_assert!(greedy.covered as usize <= most);
        let unfinished = maximum_cover_within(&pois, n, 0);
        prop_assert!(unfinished.covered <= most && most <= unfinished.upper_bound);
    }

    /// Sets that no geometry makes: there the relaxation has gaps and the search has to branch.
    #[test]
    fn the_search_is_exact_on_any_sets(
        mut sets in prop::collection::vec(prop::collection::btree_set(0u32..14, 1..5), 1..14),
        n in 1usize..5,
    ) {
        let mut sets: Vec<Set> = sets.drain(..).map(|s| s.into_iter().collect()).collect();
        keep_maximal(&mut sets);
        let solution = solve(&sets, 14, n, u64::MAX);
        let union = |chosen: &[u32]| masks(&sets).iter().enumerate()
            .filter(|(j, _)| chosen.contains(&(*j as u32))).fold(0, |m, (_, s)| m | s);
        prop_assert!(solution.chosen.len() <= n);
        prop_assert_eq!(union(&solution.chosen).count_ones(), solution.upper_bound);
        prop_assert_eq!(solution.upper_bound, brute_force(&masks(&sets), n, 0));
    }

    /// No disc on a fine lattice covers a set that is not among the candidates.
    #[test]
    fn candidates_leave_no_disc_out(pois in some_pois()) {
        let points: Vec<_> = pois.iter().map(|&(x, y)| (f64::from(x), f64::from(y))).collect();
        let sets = masks(&maximal_sets(&points, 10.0));
        for cell in 0..60 * 60 {
            let (x, y) = (f64::from(cell % 60) - 5.0, f64::from(cell / 60) - 5.0);
            let near = |&(px, py): &(f64, f64)| (px - x).hypot(py - y) <= 10.0;
            let covered = points.iter().enumerate().filter(|(_, p)| near(p)).fold(0u64, |m, (i, _)| m | 1 << i);
            prop_assert!(sets.iter().any(|s| covered & !s == 0));
        }
    }

    #[test]
    fn the_smallest_disc_holds_its_points_and_is_tight(pois in some_pois()) {
        let points: Vec<_> = pois.iter().map(|&(x, y)| (f64::from(x), f64::from(y))).collect();
        let ((x, y), r) = smallest_enclosing_disc(&points);
        let far = points.iter().map(|p| (p.0 - x).hypot(p.1 - y)).fold(0.0, f64::max);
        prop_assert!((far - r).abs() < 1e-6);
        // Any other centre is farther from some point.
        for k in 0..16 {
            let (s, c) = (f64::from(k) * 0.4).sin_cos();
            let moved = points.iter().map(|p| (p.0 - x - 0.01 * c).hypot(p.1 - y - 0.01 * s)).fold(0.0, f64::max);
            prop_assert!(moved > r - 1e-9);
        }
    }
}

#[test]
fn nothing_to_cover_and_nobody_to_cover_it() {
    let none = maximum_cover(&[], 3);
    assert_eq!((none.covered, none.sites.len(), none.proven), (0, 0, true));
    let nobody = maximum_cover(&[(1.0, 1.0)], 0);
    assert_eq!((nobody.covered, nobody.upper_bound, nobody.proven), (0, 0, true));
    let one = maximum_cover(&[(1.0, 2.0), (1.0, 2.0)], 5);
    assert_eq!((one.covered, one.sites.as_slice(), one.proven), (2, &[(1.0, 2.0)][..], true));
}

#[test]
fn whole_worlds_are_proven() {
    for (distribution, index) in
        [(PoiDistribution::Clustered, 0), (PoiDistribution::Clustered, 1), (PoiDistribution::Uniform, 0)]
    {
        let mut world = World::new(&Scenario { distribution, ..Scenario::default() }).unwrap();
        world.reset(777, index);
        let cover = best_sites(&world);
        assert!(cover.proven, "{cover:?}");
        assert_eq!(cover.sites.len(), 20);
        let poi: Vec<_> = world.poi_x().iter().copied().zip(world.poi_y().iter().copied()).collect();
        world.set_positions(&cover.sites, &poi).unwrap();
        assert_eq!(world.covered(), cover.covered);
    }
}
