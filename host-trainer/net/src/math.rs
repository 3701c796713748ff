//! Exponential and logarithm of single floats, without branches so that they vectorise,
//! and the same to the bit on every processor.

/// eˣ for x in −87 to 88, clamped beyond; relative error below 2·10⁻⁷. NaN gives NaN.
#[inline(always)]
#[must_use]
pub fn exp(x: f32) -> f32 {
    // Adding and taking away 1.5·2²³ rounds to a whole number.
    const ROUND: f32 = 12_582_912.0;
    let x = if x > 88.0 { 88.0 } else { x };
    let x = if x < -87.0 { -87.0 } else { x };
    let shifted = x.mul_add(std::f32::consts::LOG2_E, ROUND);
    let n = shifted - ROUND;
    // ln 2 in two parts: the first has few digits, so that n times it is exact.
    let r = n.mul_add(-0.693_359_4, x);
    let r = n.mul_add(2.121_944_4e-4, r);
    let mut p = 1.0 / 5040.0;
    for c in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        p = r.mul_add(p, c);
    }
    let power = shifted.to_bits().wrapping_add(127).wrapping_shl(23);
    p * f32::from_bits(power)
}

/// ln x for normal x above zero; absolute error below 2·10⁻⁷ or as many of the result.
#[inline(always)]
#[must_use]
pub fn ln(x: f32) -> f32 {
    // x = m·2ⁿ with m in √½ to √2.
    let bits = x.to_bits();
    let n = (bits.wrapping_sub(0x3f35_04f3) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((n as u32) << 23));
    // ln m = 2 artanh s, s = (m − 1)/(m + 1), |s| < 0.172.
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let mut p = 1.0 / 9.0;
    for c in [1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0] {
        p = z.mul_add(p, c);
    }
    let twice = s + s;
    let m = (twice * z).mul_add(p, twice);
    let n = n as f32;
    n.mul_add(0.693_359_4, n.mul_add(-2.121_944_4e-4, m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn exp_is_near(x in -87.0f32..88.0) {
            let exact = f64::from(x).exp();
            prop_assert!((f64::from(exp(x)) - exact).abs() < 2e-7 * exact, "{} {exact}", exp(x));
        }

        #[test]
        fn ln_is_near(x in 1e-30f32..1e30, near in 0.5f32..2.0) {
            for x in [x, near] {
                let exact = f64::from(x).ln();
                prop_assert!((f64::from(ln(x)) - exact).abs() < 2e-7 * exact.abs().max(1.0), "{} {exact}", ln(x));
            }
        }
    }

    #[test]
    fn ends_are_clamped() {
        assert_eq!((exp(0.0), ln(1.0)), (1.0, 0.0));
        assert!(exp(f32::NEG_INFINITY) < 2e-38 && exp(1e9) > 1e38 && exp(f32::NAN).is_nan());
    }
}
