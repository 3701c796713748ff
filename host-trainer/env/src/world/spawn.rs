//! Where UAVs and PoIs are at reset.

use crate::random::{between, normal_pair, stream};
use crate::scenario::{PoiDistribution, Scenario};
use rand_chacha::ChaCha8Rng;

/// Number of clusters of PoIs in a clustered world.
const CENTRES: usize = 3;
// The following are fractions of the side; on the map of 200 u they are 30, 50, 20 and 20 u.
/// Least distance of a cluster's centre from the edge.
const CENTRE_MARGIN: f64 = 0.15;
/// Least distance between the centres of two clusters.
const CENTRE_SPACING: f64 = 0.25;
/// Standard deviation of a cluster along each axis.
const CLUSTER_SIGMA: f64 = 0.1;
/// Least distance of a UAV from the edge.
const SPAWN_MARGIN: f64 = 0.1;

/// Draws the positions of world `index` of `seed` into the given slices, u.
pub(crate) fn spawn(scenario: &Scenario, seed: u64, index: u64, uav: Points<'_>, poi: Points<'_>) {
    let side = f64::from(scenario.side_u);
    // The name of the stream is part of every world: it stays.
    let mut rng = stream("covey layout", seed, index);
    match scenario.distribution {
        PoiDistribution::Clustered => clustered(&mut rng, side, poi),
        PoiDistribution::Uniform => uniform(&mut rng, 0.0, side, poi),
    }
    uniform(&mut rng, SPAWN_MARGIN * side, (1.0 - SPAWN_MARGIN) * side, uav);
}

/// East and north coordinates of as many points.
pub(crate) type Points<'a> = (&'a mut [f32], &'a mut [f32]);

fn uniform(rng: &mut ChaCha8Rng, low: f64, high: f64, (xs, ys): Points<'_>) {
    for (x, y) in xs.iter_mut().zip(ys) {
        *x = between(rng, low, high) as f32;
        *y = between(rng, low, high) as f32;
    }
}

fn clustered(rng: &mut ChaCha8Rng, side: f64, (xs, ys): Points<'_>) {
    let centres = centres(rng, side);
    let (share, rest) = (xs.len() / CENTRES, xs.len() % CENTRES);
    let mut points = xs.iter_mut().zip(ys);
    for (c, centre) in centres.iter().enumerate() {
        // What three does not divide goes to the first centres.
        for (x, y) in points.by_ref().take(share + usize::from(c < rest)) {
            let (dx, dy) = normal_pair(rng);
            let scatter = |centre: f64, d: f64| (centre + CLUSTER_SIGMA * side * d).clamp(0.0, side) as f32;
            *x = scatter(centre.0, dx);
            *y = scatter(centre.1, dy);
        }
    }
}

fn centres(rng: &mut ChaCha8Rng, side: f64) -> [(f64, f64); CENTRES] {
    let (low, high) = (CENTRE_MARGIN * side, (1.0 - CENTRE_MARGIN) * side);
    let mut out = [(0.0, 0.0); CENTRES];
    let mut placed = 0;
    // Two centres forbid less than four fifths of the square, so this ends.
    while placed < CENTRES {
        let c = (between(rng, low, high), between(rng, low, high));
        let least = (CENTRE_SPACING * side) * (CENTRE_SPACING * side);
        let d2 = |o: &(f64, f64)| (c.0 - o.0) * (c.0 - o.0) + (c.1 - o.1) * (c.1 - o.1);
        let free = |o: &(f64, f64)| d2(o) >= least;
        if out.iter().take(placed).all(free) {
            out[placed] = c;
            placed += 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(scenario: &Scenario, index: u64) -> (Vec<f32>, Vec<f32>, Vec<f32>, Vec<f32>) {
        let zeros = |n| vec![0.0; n];
        let (n, p) = (scenario.uavs, scenario.pois);
        let (mut a, mut b, mut c, mut d) = (zeros(n), zeros(n), zeros(p), zeros(p));
        spawn(scenario, 777, index, (&mut a, &mut b), (&mut c, &mut d));
        (a, b, c, d)
    }

    #[test]
    fn a_world_depends_on_seed_and_index_only() {
        let s = Scenario::default();
        assert_eq!(sample(&s, 5), sample(&s, 5));
        assert_ne!(sample(&s, 5), sample(&s, 6));
    }

    #[test]
    fn everything_lies_in_its_square() {
        for distribution in [PoiDistribution::Clustered, PoiDistribution::Uniform] {
            let s = Scenario { distribution, pois: 121, ..Scenario::default() };
            for index in 0..50 {
                let (ux, uy, px, py) = sample(&s, index);
                assert!(ux.iter().chain(&uy).all(|v| (20.0..=180.0).contains(v)));
                assert!(px.iter().chain(&py).all(|v| (0.0..=200.0).contains(v)));
            }
        }
    }

    #[test]
    fn clusters_have_the_spread_of_their_distribution() {
        let s = Scenario::default();
        let (mut squares, mut n) = (0.0, 0.0);
        for index in 0..100 {
            let (_, _, px, _) = sample(&s, index);
            for cluster in px.chunks(40) {
                let mean = cluster.iter().sum::<f32>() / 40.0;
                squares += cluster.iter().map(|x| (x - mean).powi(2)).sum::<f32>();
                n += 39.0;
            }
        }
        let sigma = (squares / n).sqrt();
        // A little below 20: the edge clips.
        assert!((18.5..20.2).contains(&sigma), "{sigma}");
    }
}
