//! Bounds of single settings, and what must go together.

use super::error::SettingsError;
use super::key::{Key, keys};
use super::table::Settings;
use covey_env::ObservationForm;
use covey_env::radio::MAX_NODES;
use serde_json::Value;

impl Settings {
    /// Checks bounds, and then what single bounds cannot.
    ///
    /// # Errors
    /// [`SettingsError::Range`], or [`SettingsError::Together`], which names the settings that do
    /// not go together.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.check_bounds()?;
        let most = usize::from(self.uavs.max(self.uavs_max));
        let complaint = if !self.steps.is_multiple_of(self.rollout_steps) {
            format!(
                "`rollout_steps` ({}) must divide `steps` ({}); try {}",
                self.rollout_steps,
                self.steps,
                (1..=self.rollout_steps).rev().find(|s| self.steps.is_multiple_of(*s)).unwrap_or(1)
            )
        } else if self.eval_seed == self.seed {
            format!(
                "`eval_seed` and `seed` are both {}: held-out worlds must not be training worlds; change one of them",
                self.seed
            )
        } else if self.shards > self.num_envs {
            format!("`shards` ({}) must not exceed `num_envs` ({})", self.shards, self.num_envs)
        } else if self.lossy() && most > MAX_NODES {
            format!(
                "up to {most} UAVs (`uavs` and `uavs_max`), but with `radio_loss` or `radio_delay` there may be at \
                 most {MAX_NODES}"
            )
        } else if self.uavs_max > 0 && self.uavs_min > self.uavs_max {
            format!("`uavs_min` ({}) must not exceed `uavs_max` ({}), or `uavs_max` be 0", self.uavs_min, self.uavs_max)
        } else if self.observation == ObservationForm::Cells && self.cloning_weight > 0.0 {
            "an observation in cells names no place to fly to: with `observation = \"cells\"` set `cloning_weight` to 0"
                .to_owned()
        } else {
            return Ok(());
        };
        Err(SettingsError::Together(complaint))
    }

    /// Checks the bounds of every setting by itself.
    pub(super) fn check_bounds(&self) -> Result<(), SettingsError> {
        let values = self.values();
        let outside = keys().iter().find(|key| !key.bounds.allow(&values[&key.name]));
        outside.map_or(Ok(()), |key| Err(key.out_of_range(&values[&key.name])))
    }

    /// The settings as a JSON object.
    pub(super) fn values(&self) -> Value {
        // Numbers, words and truth values always encode.
        serde_json::to_value(self).unwrap_or_default()
    }
}

impl Key {
    /// What is said of a value out of bounds.
    pub(super) fn out_of_range(&'static self, found: &Value) -> SettingsError {
        // JSON knows no other name for them.
        let found = if found.is_null() { "no finite number".to_owned() } else { found.to_string() };
        SettingsError::Range { key: &self.name, found, allowed: self.bounds.to_string() }
    }
}
