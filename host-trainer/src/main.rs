//! Command line of the trainer.

use host_trainer::settings::Settings;
use host_trainer::train::{Trainer, Workers};

fn main() {
    // SAFETY: sets allocator parameters before any thread starts.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 30);
        libc::mallopt(libc::M_TRIM_THRESHOLD, i32::MAX);
        libc::mallopt(libc::M_TOP_PAD, 64 << 20);
    }
    let mut s = Settings::default();
    let mut threads = 2;
    for a in std::env::args().skip(1) {
        if let Some(t) = a.strip_prefix("threads=") {
            threads = t.parse().unwrap();
        } else {
            s.set(&a).unwrap();
        }
    }
    let workers = Workers::new(threads).unwrap();
    let mut t = Trainer::new(s).unwrap();
    let t0 = std::time::Instant::now();
    while !t.done() {
        let r = t.round(&workers);
        println!(
            "ep {} cov {:.4} last {:.4} en {:.3} ind {:.2} grp {:.2} rew {:.1} pl {:.4} vl {:.4} ent {:.3} kl {:.4} clip {:.3} ev {:.3} | {:.0} steps/s",
            r.episodes,
            r.coverage,
            r.coverage_last,
            r.energy,
            r.individual,
            r.group,
            r.reward,
            r.policy_loss,
            r.value_loss,
            r.entropy,
            r.kl,
            r.clip_fraction,
            r.explained_variance,
            r.agent_steps as f64 / t0.elapsed().as_secs_f64()
        );
    }
}
