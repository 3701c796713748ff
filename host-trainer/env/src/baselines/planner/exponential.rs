//! An exponential function that compiles to vector instructions.

/// Replaces each x, at most 0, by eˣ: equal to `libm::exp` to the bit, but in a form without branches.
pub(super) fn exponentials(values: &mut [f64]) {
    /// Adding and subtracting 1.5·2⁵² rounds to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const P: [f64; 5] = [
        1.666_666_666_666_660_2e-1,
        -2.777_777_777_701_559_3e-3,
        6.613_756_321_437_934e-5,
        -1.653_390_220_546_525_2e-6,
        4.138_136_797_057_238_5e-8,
    ];
    // Beyond this the result would be subnormal.
    if values.iter().any(|&x| x < -700.0) {
        values.iter_mut().for_each(|x| *x = libm::exp(*x));
        return;
    }
    for value in values {
        let x = *value;
        // Whole part of x/ln 2 − ½ towards zero, or what libm takes near zero.
        let quotient = std::f64::consts::LOG2_E * x - 0.5;
        let rounded = (quotient + ROUND) - ROUND;
        let towards_zero = if rounded < quotient { rounded + 1.0 } else { rounded };
        let near = if x > -f64::from_bits(0x3fd6_2e43_0000_0000) { 0.0 } else { -1.0 };
        let n = if x > -f64::from_bits(0x3ff0_a2b2_0000_0000) { near } else { towards_zero };
        let (high, low) = (x - n * LN2_HIGH, n * LN2_LOW);
        let r = high - low;
        let z = r * r;
        let c = r - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))));
        let y = 1.0 + (r * c / (2.0 - c) - low + high);
        let power = f64::from_bits((n + (ROUND + 1023.0)).to_bits() << 52);
        *value = if x > -f64::from_bits(0x3e30_0001_0000_0000) { 1.0 + x } else { y * power };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn exponentials_are_libms(far in 0.0f64..1000.0, near in 0.0f64..2.0, power in 0i32..60) {
            let mut values = [-far.min(700.0), -near, -near * f64::powi(0.5, power), -0.0, 0.0];
            let exact = values.map(libm::exp);
            exponentials(&mut values);
            prop_assert_eq!(values.map(f64::to_bits), exact.map(f64::to_bits));
            let mut one = [-far];
            exponentials(&mut one);
            prop_assert_eq!(one[0].to_bits(), libm::exp(-far).to_bits());
        }
    }
}
