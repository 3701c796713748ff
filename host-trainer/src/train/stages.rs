//! Parts of the work alone, for `bench` and tests.

use super::trainer::Trainer;
use crate::rollout::Workers;
use covey_net::EngineError;
use std::time::{Duration, Instant};

/// A part of training that can be timed alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The environment with observations, and random actions.
    Environment,
    /// Rollout: environment, actor, sampling, critic, advantages.
    Policy,
    /// The update on a rollout that was collected before.
    Update,
}

impl Trainer {
    /// Time of an episode's worth of one stage in every world. The state of the run
    /// moves on as in training, except that [`Stage::Environment`] learns nothing.
    ///
    /// # Errors
    /// When a device fails.
    pub fn time(&mut self, stage: Stage, threads: &Workers) -> Result<Duration, EngineError> {
        self.reset_to_equal_swarms(threads);
        let mut spent = Duration::ZERO;
        for rollout in 0..self.rollouts_in_round() {
            let start = Instant::now();
            match stage {
                Stage::Environment => self.random_rollouts(threads),
                Stage::Policy | Stage::Update => self.collect(false, threads)?,
            }
            let collected = start.elapsed();
            let start = Instant::now();
            if stage == Stage::Update {
                let plan = self.update_plan(rollout.into(), 0.0);
                self.update(&plan, threads)?;
            }
            spent += if stage == Stage::Update { start.elapsed() } else { collected };
        }
        Ok(spent)
    }

    /// Multiply-adds that the update of an episode's worth in every world takes, those with
    /// a zero left out; none that a device does. It learns as [`Self::time`] does.
    ///
    /// # Errors
    /// When a device fails.
    pub fn count_update(&mut self, threads: &Workers) -> Result<u64, EngineError> {
        self.backend_mut().start_counting();
        self.time(Stage::Update, threads)?;
        Ok(self.backend_mut().take_count())
    }
}
