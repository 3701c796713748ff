//! Exponential moving average of parameters.

/// Moves `average` towards `parameters` after update `update` of the run, counted from 0; `decay`
/// is the share of the average that stays. Early on it is the plain mean over all updates so far,
/// or the initial parameters would linger.
pub fn update_ema(average: &mut [f32], parameters: &[f32], decay: f64, update: u64) {
    let keep = decay.min(update as f64 / (update as f64 + 1.0)) as f32;
    for (average, value) in average.iter_mut().zip(parameters) {
        *average = keep * *average + (1.0 - keep) * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn early_on_it_is_the_mean_and_then_decays() {
        let mut average = [9.0];
        for (update, value) in [4.0, 2.0, 6.0].into_iter().enumerate() {
            update_ema(&mut average, &[value], 0.9, update as u64);
        }
        assert!((average[0] - 4.0f32).abs() < 1e-6, "{average:?}");
        update_ema(&mut average, &[14.0], 0.9, 1000);
        assert!((average[0] - 5.0).abs() < 1e-6, "{average:?}");
    }

    #[test]
    fn without_decay_it_is_the_last_value() {
        let mut average = [1.0];
        update_ema(&mut average, &[3.0], 0.0, 7);
        assert_eq!(average, [3.0]);
    }
}
