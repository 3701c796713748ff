//! The overlap of a UAV with the others of its group, compared with a plain count.

use covey_env::baselines::Random;
use covey_env::{Policy, Scenario, World};
use firmware_core::action::Action;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, COVERAGE_RANGE_U};

fn squared(a: (f32, f32), b: (f32, f32)) -> f32 {
    let (x, y) = (a.0 - b.0, a.1 - b.1);
    x * x + y * y
}

/// A number for every UAV, the same for those connected over any number of hops.
fn groups(world: &World, uavs: usize) -> Vec<usize> {
    let mut group: Vec<usize> = (0..uavs).collect();
    let range = (COMMUNICATION_RANGE_U * COMMUNICATION_RANGE_U) as f32;
    for _ in 0..uavs {
        for i in 0..uavs {
            for j in 0..uavs {
                if squared(world.position(i), world.position(j)) <= range {
                    group[i] = group[i].min(group[j]);
                }
            }
        }
    }
    group
}

#[test]
fn overlaps_are_pois_that_just_two_of_a_group_cover() {
    let uavs = 40;
    let mut world = World::new(&Scenario { uavs, side_u: 100.0, ..Scenario::default() }).unwrap();
    let (mut actions, mut seen) = (vec![Action::COAST; uavs], 0);
    for index in 0..5 {
        world.reset(3, index);
        let mut policy = Random::new(3, index);
        while !world.done() {
            policy.act(&world, &mut actions);
            world.step(&actions);
            if !world.steps_done().is_multiple_of(10) {
                continue;
            }
            let group = groups(&world, uavs);
            let covers = |i: usize, p: usize| {
                let poi = (world.poi_x()[p], world.poi_y()[p]);
                squared(world.position(i), poi) <= (COVERAGE_RANGE_U * COVERAGE_RANGE_U) as f32
            };
            let with_one_other = |i: usize, p: usize| {
                covers(i, p) && (0..uavs).filter(|&j| group[j] == group[i] && covers(j, p)).count() == 2
            };
            let plain = (0..uavs).map(|i| (0..120).filter(|&p| with_one_other(i, p)).count() as u32);
            let plain: Vec<_> = plain.collect();
            assert_eq!(world.overlaps(), plain, "world {index}, step {}", world.steps_done());
            seen += plain.iter().sum::<u32>();
        }
    }
    assert!(seen > 1_000, "hardly any overlap was there to count: {seen}");
}
