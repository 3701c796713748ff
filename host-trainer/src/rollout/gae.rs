//! Generalised advantage estimation (GAE).

/// Writes the advantages of one UAV over a rollout (Schulman et al. 2016, equation 16):
/// `A_t = δ_t + γλ A_{t+1}` with `δ_t = r_t + γ V_{t+1} − V_t`.
///
/// `rewards` and `advantages` have an entry a step, `values` one entry more: the value of the
/// state after the rollout, 0 where that does not count. All are in units of reward. With
/// `gamma` and `lambda` 1, `advantage + value` is the plain return of the paper's equation (9).
pub fn gae(rewards: &[f32], values: &[f32], gamma: f32, lambda: f32, advantages: &mut [f32]) {
    let mut next_advantage = 0.0;
    for t in (0..rewards.len()).rev() {
        let delta = rewards[t] + gamma * values[t + 1] - values[t];
        next_advantage = delta + gamma * lambda * next_advantage;
        advantages[t] = next_advantage;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_gamma_and_lambda_one_it_is_the_plain_return() {
        let (r, v) = ([1.0, 2.0, 3.0], [0.5, -1.0, 2.0, 0.0]);
        let mut a = [0.0; 3];
        gae(&r, &v, 1.0, 1.0, &mut a);
        let returns: Vec<f32> = a.iter().zip(v).map(|(a, v)| a + v).collect();
        assert_eq!(returns, [6.0, 5.0, 3.0]);
    }

    #[test]
    fn with_lambda_zero_it_is_the_one_step_error() {
        let mut a = [0.0; 2];
        gae(&[1.0, 2.0], &[0.0, 4.0, 8.0], 0.5, 0.0, &mut a);
        assert_eq!(a, [3.0, 2.0]);
    }
}
