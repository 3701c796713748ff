//! What training takes of the memory: the whole program at its peak, and what is asked of the
//! allocator once a trainer is warm.

mod common;

use common::{succeed, trainer};
use host_trainer::settings::Settings;
use host_trainer::train::{Stage, Trainer, Workers};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

struct Counting;

/// Calls of the allocator by all threads.
static CALLS: AtomicU64 = AtomicU64::new(0);

// SAFETY: everything is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps `alloc`'s contract, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: `at` came from `alloc` above, that is from the system's allocator.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of one stage in a warm trainer on one thread.
fn allocations(stage: Stage, settings: &[&str]) -> u64 {
    let mut s = Settings::default();
    for setting in settings {
        s.set(setting).expect("a sound setting");
    }
    let workers = Workers::new(1).expect("a thread");
    let mut trainer = Trainer::new(s).expect("a trainer");
    trainer.time(Stage::Update, &workers).expect("the CPU does not fail");
    trainer.time(stage, &workers).expect("the CPU does not fail");
    let before = CALLS.load(Ordering::Relaxed);
    trainer.time(stage, &workers).expect("the CPU does not fail");
    CALLS.load(Ordering::Relaxed) - before
}

/// One test, because all tests of a program share its memory.
#[test]
fn memory_is_small_and_a_warm_trainer_asks_for_none_step_by_step() {
    // A round with the default networks and worlds; a longer run keeps nothing of its rounds
    // but a row of metrics each.
    let folder = tempfile::tempdir().expect("a folder");
    let small = ["--episodes", "64", "--set", "eval_worlds=4", "--quiet", "--out"];
    succeed(trainer().arg("train").args(small).arg(folder.path().join("run")));
    let peak = peak_of_children_mib();
    assert!((4.0..128.0).contains(&peak), "training takes {peak:.0} MiB, at most 128 are allowed");

    let worlds = ["num_envs=8", "shards=2", "minibatch=400", "cloning_weight=0"];
    let count = |stage, settings: &[&str]| allocations(stage, &[&worlds, settings].concat());
    for stage in [Stage::Environment, Stage::Policy] {
        // Two rollouts each; lists that hand work to threads are made once a rollout.
        let (short, long) =
            (count(stage, &["steps=10", "rollout_steps=5"]), count(stage, &["steps=60", "rollout_steps=30"]));
        assert!(short > 0, "the count works");
        assert_eq!(short, long, "{stage:?}: allocations of steps");
    }
    // As many minibatches, of four times the samples: lists of what is in them grow a little.
    let update = |settings: &[&str]| {
        let settings = [&["steps=20", "rollout_steps=10"], settings].concat();
        // A new episode asks for something in every world.
        count(Stage::Update, &settings) - count(Stage::Policy, &settings)
    };
    let (small, large) = (update(&[]), update(&["num_envs=32", "minibatch=1600"]));
    assert!(large <= small + 16, "allocations of an update: {small}, with larger minibatches {large}");
}

/// Most memory that a program started here had at a time, MiB.
fn peak_of_children_mib() -> f64 {
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    // SAFETY: a structure of zeros is a valid `rusage`, which the call fills in.
    let usage = unsafe {
        assert_eq!(libc::getrusage(libc::RUSAGE_CHILDREN, usage.as_mut_ptr()), 0, "no figures of child processes");
        usage.assume_init()
    };
    // Kilobytes, but bytes on Apple's systems.
    let unit = if cfg!(target_vendor = "apple") { 1.0 } else { 1024.0 };
    usage.ru_maxrss as f64 * unit / f64::from(1 << 20)
}
