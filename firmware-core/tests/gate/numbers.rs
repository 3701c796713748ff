//! Telemetry's floats, and the number that says "still the same gate".

use firmware_core::gate::telemetry::{TelemetryError, millimetres, millimetres_per_second};
use firmware_core::gate::{FINGERPRINT_TICKS, fingerprint};
use proptest::prelude::*;

#[test]
fn what_is_no_number_is_refused() {
    for v in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -f32::NAN] {
        assert_eq!(millimetres(v), Err(TelemetryError::NotFinite));
        assert_eq!(millimetres_per_second(v), Err(TelemetryError::NotFinite));
    }
    for v in [f32::MAX, -f32::MAX, 1e9, 100_001.0, -100_001.0] {
        assert_eq!(millimetres(v), Err(TelemetryError::OutOfRange));
    }
    assert_eq!(millimetres_per_second(100.1), Err(TelemetryError::OutOfRange));
    assert_eq!(millimetres(-100_000.0), Ok(-100_000_000));
    assert_eq!(millimetres(1e-40), Ok(0));
    assert_eq!((millimetres(1.0006), millimetres(-1.0006)), (Ok(1001), Ok(-1001)));
}

proptest! {
    #[test]
    fn every_bit_pattern_is_refused_or_right(bits: u32) {
        let v = f32::from_bits(bits);
        match millimetres(v) {
            Ok(mm) => prop_assert!((f64::from(mm) - f64::from(v) * 1000.0).abs() <= 4.5, "{v} {mm}"),
            Err(TelemetryError::NotFinite) => prop_assert!(!v.is_finite()),
            Err(TelemetryError::OutOfRange) => prop_assert!(v.abs() >= 99_999.0),
        }
    }
}

/// Changes on purpose only, and is the same on every target (`cargo xtask targets`).
#[test]
fn the_signature_is_still_the_same() {
    assert_eq!(format!("{:016x}", fingerprint(FINGERPRINT_TICKS)), "f25a4065fac4ae73");
}
