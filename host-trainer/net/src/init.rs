//! Orthogonal initialisation.

use crate::parameter_layout::ParameterLayout;
use covey_env::random::{normal_pair, stream};
use rand_chacha::ChaCha8Rng;

/// Fresh parameters of a layout: every weight matrix orthogonal (Saxe et al. 2014) times its gain,
/// biases zero. `purpose` and `seed` name the random stream.
#[must_use]
pub fn initialise(layout: &ParameterLayout, purpose: &str, seed: u64) -> Vec<f32> {
    let mut random = stream(purpose, seed, 0);
    let mut values = Vec::with_capacity(layout.len());
    for block in layout.blocks() {
        if block.gain == 0.0 {
            values.extend(std::iter::repeat_n(0.0, block.len()));
        } else {
            values.extend(orthogonal(block.inputs, block.outputs, &mut random).into_iter().map(|v| v * block.gain));
        }
    }
    values
}

/// A matrix of `rows × columns` whose shorter side is orthonormal: Gram–Schmidt, twice
/// for accuracy, on normal vectors along the longer side.
fn orthogonal(rows: usize, columns: usize, random: &mut ChaCha8Rng) -> Vec<f32> {
    let (count, length) = if rows < columns { (rows, columns) } else { (columns, rows) };
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(count);
    while basis.len() < count {
        let mut v: Vec<f64> = (0..length).map(|_| normal_pair(random).0).collect();
        for _ in 0..2 {
            for b in &basis {
                let along: f64 = v.iter().zip(b).map(|(x, y)| x * y).sum();
                v.iter_mut().zip(b).for_each(|(x, y)| *x -= along * y);
            }
        }
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm > 1e-6 {
            v.iter_mut().for_each(|x| *x /= norm);
            basis.push(v);
        }
    }
    let at = |r: usize, c: usize| if rows < columns { basis[r][c] } else { basis[c][r] };
    (0..rows * columns).map(|k| at(k / columns, k % columns) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_orthonormal() {
        let (r, c) = (40, 12);
        let m = orthogonal(r, c, &mut stream("test", 1, 0));
        for i in 0..c {
            for j in 0..c {
                let dot: f32 = (0..r).map(|k| m[k * c + i] * m[k * c + j]).sum();
                assert!((dot - f32::from(i == j)).abs() < 1e-5, "{i} {j} {dot}");
            }
        }
    }
}
