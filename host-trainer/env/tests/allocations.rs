//! In steady state neither a world nor a swarm over a radio channel allocates or frees memory.

use covey_env::radio::RadioPolicy;
use covey_env::{Neighbourhood, Observer, Policy, Scenario, World};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Mode};
use firmware_core::observation::LEN;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // The thread may be ending, and its count gone.
    let _ = CALLS.try_with(|c| c.set(c.get() + 1));
}

// SAFETY: everything is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps `alloc`'s contract, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        count();
        // SAFETY: `at` came from `alloc` above, that is from the system's allocator.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_warm_world_allocates_nothing() {
    let scenario = Scenario::default();
    let mut world = World::new(&scenario).unwrap();
    let mut observer = Observer::new(1, 1);
    let mut observations = vec![[0; LEN]; scenario.uavs];
    let mut neighbourhoods = vec![Neighbourhood::default(); scenario.uavs];
    let mut actions = vec![Action::COAST; scenario.uavs];
    let mut episode = || {
        let before = CALLS.get();
        world.reset(3, 4);
        while !world.done() {
            let t = world.steps_done() as usize;
            for (i, a) in actions.iter_mut().enumerate() {
                *a = Action::new(((i * 3 + t * t) % 17) as u8).unwrap();
            }
            world.step(&actions);
            observer.observe(&world, &mut observations, &mut neighbourhoods);
        }
        CALLS.get() - before
    };
    assert!(episode() > 0, "the first episode warms up, so the count works");
    assert_eq!(episode(), 0);
}

#[test]
fn a_warm_swarm_over_a_bad_radio_allocates_nothing() {
    let file = include_bytes!("../../../firmware-core/tests/data/sample-gcn.actor");
    let actor = Actor::load(file).unwrap();
    let scenario = Scenario { steps: 30, ..Scenario::default() };
    let settings = "loss=0.2,burst=3,jitter_ms=5000,duplicate=0.3,reorder=0.3,corrupt=0.2".parse().unwrap();
    let mut world = World::new(&scenario).unwrap();
    let mut policy = RadioPolicy::new(actor, 1, Mode::Sample, &settings, scenario.uavs).unwrap();
    let mut actions = vec![Action::COAST; scenario.uavs];
    let mut episode = || {
        let before = CALLS.get();
        world.reset(3, 4);
        policy.begin(&world);
        while !world.done() {
            policy.act(&world, &mut actions);
            world.step(&actions);
        }
        CALLS.get() - before
    };
    assert!(episode() > 0, "the first episode warms up, so the count works");
    // Its last datagrams on their way come back when the next begins.
    episode();
    assert_eq!(episode(), 0);
}
