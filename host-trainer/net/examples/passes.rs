use covey_env::*;
use covey_net::*;
use firmware_core::action::{ACTIONS, Action};
use firmware_core::actor::{Aggregation, Dimensions};
use firmware_core::observation::LEN;
use std::time::Instant;
fn best(n: usize, mut f: impl FnMut()) -> f64 {
    let mut b = f64::MAX;
    for _ in 0..n {
        let t = Instant::now();
        f();
        b = b.min(t.elapsed().as_secs_f64());
    }
    b
}
fn main() {
    let inputs_n: u16 = std::env::args().nth(1).map_or(160, |a| a.parse().unwrap());
    let agg = match std::env::args().nth(2).as_deref() {
        Some("gat") => Aggregation::Gat,
        Some("none") => Aggregation::None,
        _ => Aggregation::Gcn,
    };
    let d = Dimensions { observation: inputs_n, hidden: 128, feature: 64, head: 64, actions: ACTIONS as u16 };
    let (al, cl) = (Layout::actor(d, agg), Layout::critic(d));
    let mut av = initialise(&al, "a", 1);
    // like a trained net: positive biases make ReLUs dense
    for p in al.pieces() {
        let b = match p.name {
            "encoder1 bias" => 0.05,
            "encoder2 bias" => 0.45,
            "head bias" => 1.0,
            "graph bias" => 0.15,
            _ => 0.0,
        };
        for v in &mut av[p.start..p.start + p.len()] {
            *v += b;
        }
    }
    let mut cv = initialise(&cl, "c", 1);
    for p in cl.pieces() {
        let b = match p.name {
            "encoder1 bias" => 0.05,
            "encoder2 bias" => 0.45,
            "head bias" => 1.0,
            _ => 0.0,
        };
        for v in &mut cv[p.start..p.start + p.len()] {
            *v += b;
        }
    }
    let s = Scenario { uavs: 20, pois: 120, side_u: 200.0, steps: 100, law: Law::Clustered };
    let worlds = 50;
    let (mut obs, mut links) = (vec![[0; LEN]; 20 * worlds], vec![Links::default(); 20 * worlds]);
    let mut w = World::new(&s).unwrap();
    for k in 0..worlds {
        w.reset(5, k as u64);
        let mut acts = vec![Action::COAST; 20];
        let mut centroid = baselines::Centroid::new(1, k as u64);
        centroid.begin(&w);
        for _ in 0..k * 2 {
            centroid.act(&w, &mut acts);
            w.step(&acts);
        }
        let o = k * 20..k * 20 + 20;
        Observer::new(9, 1).observe(&w, &mut obs[o.clone()], &mut links[o]);
    }
    let mut an = ActorNet::new(&al, agg);
    an.load(&av);
    let mut cn = CriticNet::new(&cl);
    cn.load(&cv);
    let (mut ap, mut cp) = (ActorPass::new(&al), CriticPass::new(&cl));
    let (mut ag, mut cg) = (ActorGradient::new(&al), CriticGradient::new(&cl));
    let mut x = Inputs::new(inputs_n.into());
    let per = worlds_in_pass(20, worlds);
    let n = (worlds * 20) as f64;
    let dens = |r: &Rows| {
        let mut c = 0;
        for k in 0..r.rows() {
            c += r.row(k).iter().filter(|v| **v != 0.0).count();
        }
        c as f64 / (r.rows() * r.width()) as f64
    };
    x.clear(20);
    x.push(&obs, &links);
    ap.forward(&an, &x);
    cp.forward(&cn, &x);
    println!(
        "density x {:.3} hidden {:.3} feature {:.3} head {:.3}; pass {} worlds",
        dens(x.rows()),
        dens(ap.hidden()),
        dens(ap.feature()),
        dens(ap.head()),
        per
    );
    let (dx, dh, df, dd) = (dens(x.rows()), dens(ap.hidden()), dens(ap.feature()), dens(ap.head()));
    let (dc, dg) = ap.graph().map_or((0.0, 0.0), |(c, g)| (dens(c), dens(g)));
    println!("combined {dc:.3} graph {dg:.3}");
    let k = f64::from(inputs_n) * 128.0;
    let enc = dx * k * 2.0 + dh * 8192.0 * 2.0 + df * 8192.0;
    let mac_a = enc
        + 4096.0 * (df * 2.0 + dd + dc * 2.0 + dg + dg * 2.0 + dd * f64::from(u8::from(dc > 0.0)))
        + dd * 64.0 * 24.0
        + 17.0 * 128.0;
    let mac_c = enc + 4096.0 * (df * 2.0 + dd) + dd * 64.0 * 8.0 + 128.0 + 4096.0 * 3.0 / 20.0;
    println!("MACs a sample: actor {mac_a:.0} critic {mac_c:.0}");
    let mut run = |back: bool, which: u8| {
        best(300, || {
            for k in (0..worlds).step_by(per) {
                let r = k * 20..(k + per).min(worlds) * 20;
                x.clear(20);
                x.push(&obs[r.clone()], &links[r]);
                if which & 1 != 0 {
                    ap.forward(&an, &x);
                    if back {
                        ap.logits_mut()
                            .values_mut()
                            .iter_mut()
                            .enumerate()
                            .for_each(|(k, l)| *l = (k % 7) as f32 - 3.0);
                        ap.backward(&an, &x, &mut ag);
                    }
                }
                if which & 2 != 0 {
                    cp.forward(&cn, &x);
                    if back {
                        cp.values_mut()
                            .values_mut()
                            .iter_mut()
                            .enumerate()
                            .for_each(|(k, l)| *l = (k % 7) as f32 - 3.0);
                        cp.backward(&cn, &x, &mut cg);
                    }
                }
            }
        }) / n
            * 1e6
    };
    let (x0, fa, fc, ba, bc, b) =
        (run(false, 0), run(false, 1), run(false, 2), run(true, 1), run(true, 2), run(true, 3));
    println!(
        "us a sample: inputs {x0:.3} actor fwd {fa:.3} critic fwd {fc:.3} actor both {ba:.3} critic both {bc:.3} all {b:.3}"
    );
    println!(
        "GF/s: actor {:.1} critic {:.1} both {:.1}; dense equivalent {:.1}",
        mac_a * 2e-3 / ba,
        mac_c * 2e-3 / bc,
        (mac_a + mac_c) * 2e-3 / b,
        ((k + 8192.0) * 4.0 + 8192.0 * 2.0 + 4096.0 * 3.0 * 4.0 + 1088.0 * 3.0) * 2e-3 / b
    );
    let load = best(50, || {
        an.load(&av);
        cn.load(&cv);
    });
    let mut g = vec![0.0; al.len().max(cl.len())];
    let store = best(50, || {
        ag.store(&av, &mut g[..al.len()]);
        cg.store(&mut g[..cl.len()]);
    });
    println!("load {:.1} us store {:.1} us", load * 1e6, store * 1e6);
}
