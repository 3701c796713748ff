use covey_env::*;
use covey_net::matrix::*;
use covey_net::*;
use firmware_core::action::Action;
use firmware_core::observation::LEN;
use std::time::Instant;
struct R(u64);
impl R {
    fn f(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}
fn rows(r: &mut R, n: usize, w: usize, d: f32) -> Rows {
    let mut x = Rows::new(w);
    x.resize(n);
    let s = x.step();
    for row in x.values_mut().chunks_exact_mut(s) {
        for v in &mut row[..w] {
            *v = if r.f() < d { r.f() + 0.01 } else { 0.0 };
        }
    }
    x.mark();
    x
}
fn main() {
    let mut r = R(88172645463325252);
    let n = 120;
    let sets = 16;
    let s = Scenario { uavs: 20, pois: 120, side_u: 200.0, steps: 100, law: Law::Clustered };
    let mut real = Vec::new();
    let mut w = World::new(&s).unwrap();
    for p in 0..sets {
        let (mut obs, mut links) = (vec![[0; LEN]; n], vec![Links::default(); n]);
        for k in 0..n / 20 {
            w.reset(5, (p * 6 + k) as u64);
            let mut acts = vec![Action::COAST; 20];
            let mut c = baselines::Centroid::new(1, k as u64);
            c.begin(&w);
            for _ in 0..(p * 6 + k) % 100 {
                c.act(&w, &mut acts);
                w.step(&acts);
            }
            let o = k * 20..k * 20 + 20;
            Observer::new(9, 1).observe(&w, &mut obs[o.clone()], &mut links[o]);
        }
        let mut x = Inputs::new(LEN);
        x.clear(20);
        x.push(&obs, &links);
        real.push(x.rows().clone());
    }
    let mut total = [0.0; 2];
    for (name, k, c, dx, dg, uses) in [
        ("enc1", 160, 128, 0.28, 0.58, [2.0, 0.0, 2.0, 0.0]),
        ("enc2", 128, 64, 0.58, 0.87, [2., 2., 2., 0.]),
        ("own", 64, 64, 0.87, 0.78, [2., 2., 2., 0.]),
        ("graph", 64, 64, 0.93, 0.55, [1., 1., 1., 0.]),
        ("agg", 64, 64, 0.55, 0.78, [1., 1., 1., 0.]),
        ("out", 64, 17, 0.78, 1.0, [1., 1., 0., 1.]),
        ("value", 64, 1, 0.78, 1.0, [1., 1., 0., 1.]),
    ] {
        let x: Vec<Rows> = (0..sets).map(|p| if k == 160 { real[p].clone() } else { rows(&mut r, n, k, dx) }).collect();
        let g: Vec<Rows> = (0..sets).map(|_| rows(&mut r, n, c, dg)).collect();
        let flat: Vec<f32> = (0..k * c).map(|_| r.f() - 0.5).collect();
        let (mut w, mut wt, mut dw, mut dwt) =
            (Panels::zeros(k, c), Panels::zeros(c, k), Panels::zeros(k, c), Panels::zeros(c, k));
        w.load(&flat);
        wt.load_transposed(&flat);
        let bias = vec![0.1f32; 128];
        let (mut out, mut dx_) = (Rows::new(c), Rows::new(k));
        let mut t = [0.0f64; 5];
        let mut bs = Panels::zeros(1, c);
        let mut ops: Vec<Box<dyn FnMut(usize)>> = Vec::new();
        ops.push(Box::new(|p| multiply(&x[p], &w, From::Bias(&bias), To::Relu, &mut out)));
        ops.push(Box::new(|p| multiply(&g[p], &wt, From::Zero, To::Gate(&x[p]), &mut dx_)));
        ops.push(Box::new(|p| add_outer(&x[p], &g[p], &mut dw)));
        ops.push(Box::new(|p| add_outer(&g[p], &x[p], &mut dwt)));
        ops.push(Box::new(|p| add_rows(&g[p], &mut bs)));
        for (t, op) in t.iter_mut().zip(&mut ops) {
            for p in 0..sets {
                let mut best = f64::MAX;
                // Other data in between, so that branches are not known by heart.
                for _ in 0..40 {
                    for q in 0..sets {
                        if q != p {
                            op(q);
                        }
                    }
                    let b = Instant::now();
                    op(p);
                    best = best.min(b.elapsed().as_secs_f64());
                }
                *t += best / (sets * n) as f64 * 1e6;
            }
        }
        drop(ops);
        let dens = |v: &[Rows]| {
            v.iter()
                .map(|x| {
                    let mut c = 0;
                    for k in 0..x.rows() {
                        c += x.row(k).iter().filter(|v| **v != 0.0).count();
                    }
                    c
                })
                .sum::<usize>() as f64
                / (sets * n * v[0].width()) as f64
        };
        let (dx, dg) = (dens(&x), dens(&g));
        let gf = |d: f64, cols: usize, rows: usize, t: f64| d * (rows * cols.div_ceil(8) * 8) as f64 * 2e-3 / t;
        println!(
            "{name:6} fwd {:.3} us ({:.1} GF/s)  bwd {:.3} ({:.1})  outer {:.3} ({:.1})  transposed {:.3} ({:.1})  bias {:.3}",
            t[0],
            gf(dx, c, k, t[0]),
            t[1],
            gf(dg, k, c, t[1]),
            t[2],
            gf(dx, c, k, t[2]),
            t[3],
            gf(dg, k, c, t[3]),
            t[4]
        );
        total[0] += uses.iter().zip(&t).map(|(u, t)| u * t).sum::<f64>();
    }
    println!("all {:.3}", total[0]);
}
