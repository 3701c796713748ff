//! Where a trainer's time goes, part by part: `cargo bench -p covey-net`.

mod work;

use covey_net::kernel::{Epilogue, Init, Product};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use firmware_core::actor::{Actor, Aggregation};
use work::{Environment, Flight, Networks, large};

/// World-steps of a minibatch of the default size, 4,000 samples.
const MINIBATCH: usize = 200;

fn environment(c: &mut Criterion) {
    let mut group = c.benchmark_group("episode");
    for k in [1, 7] {
        let mut environment = Environment::new(&large(k));
        group.throughput(Throughput::Elements(environment.agent_steps()));
        group.bench_function(format!("environment, {} UAVs", 20 * k * k), |b| b.iter(|| environment.episode()));
    }
    let file = work::actor_file();
    let mut flight = Flight::new(&large(1), Actor::load(&file).expect("a sound actor file"));
    group.throughput(Throughput::Elements(flight.agent_steps()));
    group.bench_function("flown by the int8 actor, 20 UAVs", |b| b.iter(|| flight.episode()));
}

fn networks(c: &mut Criterion) {
    let mut group = c.benchmark_group("micro-batch");
    for aggregation in Aggregation::ALL {
        let mut networks = Networks::new(aggregation, MINIBATCH);
        let name = aggregation.name();
        group.throughput(Throughput::Elements(networks.micro_batch()));
        group.bench_function(format!("actor forward, {name}"), |b| b.iter(|| networks.actor_forward()));
        group.bench_function(format!("actor gradient, {name}"), |b| b.iter(|| networks.actor_gradient()));
    }
    let mut networks = Networks::new(Aggregation::Gcn, MINIBATCH);
    group.throughput(Throughput::Elements(networks.micro_batch()));
    group.bench_function("critic forward", |b| b.iter(|| networks.critic_forward()));
    group.bench_function("critic gradient", |b| b.iter(|| networks.critic_gradient()));
    group.throughput(Throughput::Elements(networks.samples()));
    group.bench_function("gradients of a minibatch, gcn", |b| b.iter(|| networks.minibatch()));
}

/// Products of the layers' shapes for a micro-batch of 120 samples, by the share of values that count.
fn products(c: &mut Criterion) {
    const ROWS: usize = 120;
    let mut group = c.benchmark_group("product");
    for (terms, columns) in [(160, 64), (128, 64), (64, 64), (64, 24)] {
        for percent in [30, 50, 100] {
            let words = usize::div_ceil(terms, 64);
            let counts = |k: usize| k.wrapping_mul(0x9e37_79b9) % 1000 / 10 < percent;
            let values: Vec<f32> = (0..ROWS * terms).map(|k| f32::from(u8::from(counts(k)))).collect();
            let mut masks = vec![0; ROWS * words];
            let mut counted = 0;
            for k in (0..ROWS * terms).filter(|k| counts(*k)) {
                masks[k / terms * words + k % terms / 64] |= 1 << (k % terms % 64);
                counted += columns as u64;
            }
            let weights = vec![0.5; terms * columns];
            let product = Product {
                rows: ROWS,
                terms,
                columns,
                values: &values,
                steps: [terms, 1],
                masks: &masks,
                mask_step: words,
                weights: &weights,
                weight_step: columns,
            };
            let (mut out, mut active) = (vec![0.0; ROWS * columns], vec![0; ROWS]);
            group.throughput(Throughput::Elements(counted));
            group.bench_function(format!("{terms}x{columns}, {percent} % count"), |b| {
                b.iter(|| product.run(Init::Zero, Epilogue::Relu { masks: &mut active, step: 1 }, &mut out, columns));
            });
        }
    }
}

criterion_group!(benches, environment, networks, products);
criterion_main!(benches);
