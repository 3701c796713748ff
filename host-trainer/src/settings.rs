//! Every setting of a training run: name, type, default, bounds and meaning, in one
//! table. A TOML file and `--set key=value` write to the same keys; unknown keys and
//! bad values are errors that say what would be right.

use covey_env::radio::MAX_NODES;
use covey_env::random::{below, stream};
use covey_env::{ObservationForm, PoiDistribution, Scenario};
use firmware_core::actor::Aggregation;
use serde::{Deserialize, Serialize};
use std::path::Path;
use thiserror::Error;

/// Why settings were refused.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("cannot read the settings file {path}")]
    Read {
        /// The file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file is no TOML.
    #[error("{path} is not valid TOML: {message}")]
    Syntax {
        /// The file.
        path: String,
        /// Where and why.
        message: String,
    },
    /// No such key.
    #[error("there is no setting `{key}`{hint}; `host-trainer settings` lists them all")]
    UnknownKey {
        /// The key.
        key: String,
        /// The nearest right one.
        hint: String,
    },
    /// A value of another type.
    #[error("setting `{key}` wants {wanted}, not {found}")]
    Type {
        /// The key.
        key: &'static str,
        /// Wanted type.
        wanted: &'static str,
        /// What was given.
        found: String,
    },
    /// A value out of bounds.
    #[error("setting `{key}` is {found}; it must be {allowed}")]
    Range {
        /// The key.
        key: &'static str,
        /// What was given.
        found: String,
        /// The bounds.
        allowed: &'static str,
    },
    /// What is wrong in a file.
    #[error("{path}: {error}")]
    In {
        /// The file.
        path: String,
        /// What is wrong.
        error: Box<Self>,
    },
    /// `--set` without `=`.
    #[error("`--set {0}` has no value; write `--set key=value`")]
    NoValue(String),
    /// Values that do not go together.
    #[error("{0}")]
    Together(String),
}

/// A row of the table of settings.
#[derive(Debug)]
pub struct Key {
    /// Name.
    pub name: &'static str,
    /// Default, as TOML.
    pub default: fn() -> String,
    /// Bounds.
    pub allowed: &'static str,
    /// Meaning, line by line.
    pub doc: &'static [&'static str],
}

macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $key:ident: $type:ty = $default:expr, $allowed:literal, $check:expr;)*) => {
        /// The settings of a training run.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct Settings { $($(#[doc = $doc])+ pub $key: $type,)* }

        impl Default for Settings {
            fn default() -> Self { Self { $($key: $default,)* } }
        }

        /// Every setting, in order.
        pub const KEYS: &[Key] = &[$(Key {
            name: stringify!($key),
            default: || Value::show(&Settings::default().$key),
            allowed: $allowed,
            doc: &[$($doc),+],
        },)*];

        impl Settings {
            fn put(&mut self, key: &str, value: &toml::Value) -> Result<(), SettingsError> {
                match key {
                    $(stringify!($key) => {
                        let v = <$type as Value>::read(value).ok_or_else(|| SettingsError::Type {
                            key: stringify!($key), wanted: <$type as Value>::KIND, found: value.to_string(),
                        })?;
                        let check: fn(&$type) -> bool = $check;
                        if !check(&v) {
                            return Err(SettingsError::Range {
                                key: stringify!($key), found: value.to_string(), allowed: $allowed,
                            });
                        }
                        self.$key = v;
                        Ok(())
                    })*
                    _ => Err(unknown(key)),
                }
            }

            /// The first setting in which two differ: name, own value, other's value.
            #[must_use]
            pub fn first_difference(&self, other: &Self) -> Option<(String, String, String)> {
                $(if self.$key != other.$key {
                    return Some((stringify!($key).to_owned(), Value::show(&self.$key), Value::show(&other.$key)));
                })*
                None
            }

            /// The settings that a TOML text does not name.
            #[must_use]
            pub fn unnamed(text: &str) -> Vec<&'static str> {
                let table: toml::Table = text.parse().unwrap_or_default();
                [$(stringify!($key)),*].into_iter().filter(|key| !table.contains_key(*key)).collect()
            }

            /// The settings as a commented TOML file.
            #[must_use]
            pub fn to_toml(&self) -> String {
                let mut out = String::new();
                $(
                    for line in [$($doc),+] { out += &format!("#{line}\n"); }
                    out += &format!("{} = {}\n\n", stringify!($key), Value::show(&self.$key));
                )*
                out
            }
        }
    };
}

settings! {
    /// UAVs in a world.
    uavs: u16 = 20, "1 to 10000", |v| (1..=10_000).contains(v);
    /// Fewest UAVs in the worlds of every second shard: each round draws their number anew, up
    /// to `uavs_max`. The curves are those of the other worlds.
    uavs_min: u16 = 10, "1 to 10000", |v| (1..=10_000).contains(v);
    /// Most UAVs in the worlds of every second shard. 0: all worlds have `uavs`.
    uavs_max: u16 = 40, "0 to 10000", |v| (0..=10_000).contains(v);
    /// Share of the worlds of every second shard whose PoIs follow the other law.
    other_distribution_share: f64 = 0.25, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Points of interest in a world.
    pois: u16 = 120, "1 to 60000", |v| (1..=60_000).contains(v);
    /// PoiDistribution of the PoIs: "clustered" or "uniform".
    poi_distribution: PoiDistribution = PoiDistribution::Clustered, "\"clustered\" or \"uniform\"", |_| true;
    /// Steps of an episode.
    steps: u32 = 100, "1 to 100000", |v| (1..=100_000).contains(v);
    /// Side of the map, u.
    side: f64 = 200.0, "60 to 10000 u", |v| (60.0..=10_000.0).contains(v);
    /// What UAVs observe: "compact", numbers made for the task, or "cells", the paper's id and
    /// position in binary and maps of what is around.
    observation: ObservationForm = ObservationForm::Compact, "\"compact\" or \"cells\"", |_| true;
    /// Aggregation of neighbours' features: "none", "gcn" or "gat".
    graph: Graph = Graph(Aggregation::Gcn), "\"none\", \"gcn\" or \"gat\"", |_| true;
    /// Width of the first hidden layer, actor and critic.
    hidden: u16 = 128, "2 to 128, even", |v| (2..=128).contains(v) && v % 2 == 0;
    /// Width of the feature that UAVs broadcast.
    feature: u16 = 64, "2 to 64, even", |v| (2..=64).contains(v) && v % 2 == 0;
    /// Width of the hidden layer of the policy and value heads.
    head: u16 = 64, "2 to 128, even", |v| (2..=128).contains(v) && v % 2 == 0;
    /// Steps for which a UAV keeps its tie-breaker: who goes first stays so for a whole flight
    /// when this is longer than one.
    tie_period: u32 = 1_000_000, "1 to 1000000", |v| (1..=1_000_000).contains(v);
    /// Greatest share of messages between UAVs that is lost in training: each episode of each
    /// world draws its own from 0 to this. 0 for a link that loses none.
    radio_loss: f64 = 0.0, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Greatest delay of those messages, whole steps: each episode of each world draws its own
    /// from 0 to this.
    radio_delay: u32 = 0, "0 to 2 steps", |v| (0..=2).contains(v);
    /// Seed of everything random in the run.
    seed: u64 = 10, "0 to 9223372036854775807", |v| i64::try_from(*v).is_ok();
    /// Training episodes, at most: whole rounds of `num_envs`, at least one.
    episodes: u32 = 6016, "1 to 100000000", |v| (1..=100_000_000).contains(v);
    /// Worlds that run side by side: one round is an episode of each.
    num_envs: u32 = 64, "1 to 65536", |v| (1..=65_536).contains(v);
    /// Steps between updates; must divide `steps`.
    rollout_steps: u32 = 25, "1 to 100000", |v| (1..=100_000).contains(v);
    /// Passes over a segment in an update.
    epochs: u32 = 5, "1 to 100", |v| (1..=100).contains(v);
    /// Agent samples in a minibatch (rounded to whole world-steps).
    minibatch: u32 = 4000, "1 to 10000000", |v| (1..=10_000_000).contains(v);
    /// Parts into which worlds and minibatches are split. At most as many threads are of
    /// use; results depend on this number, never on the number of threads.
    shards: u32 = 4, "1 to 256", |v| (1..=256).contains(v);
    /// Adam's learning rate at the start.
    learning_rate: f64 = 8e-4, "above 0, at most 1", |v| *v > 0.0 && *v <= 1.0;
    /// Share of the learning rate that is left at the end (it falls linearly).
    learning_rate_end: f64 = 0.02, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Discount of future reward, per step. 1 with `lambda` 1 and `rollout_steps` = `steps` is
    /// the paper's return.
    gamma: f64 = 0.94, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Lambda of generalised advantage estimation.
    lambda: f64 = 0.95, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Whether the last state of an episode counts with its value (episodes end by
    /// truncation). With `gamma` 1 it never does, since that value has no bound.
    bootstrap_end: bool = true, "true or false", |_| true;
    /// Clip range of the probability ratio.
    clip: f64 = 0.2, "above 0, below 1", |v| *v > 0.0 && *v < 1.0;
    /// Weight of the entropy bonus at the start.
    entropy: f64 = 0.01, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Weight of the entropy bonus at the end (it falls linearly).
    entropy_end: f64 = 0.0003, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Greatest global norm of the actor's gradient, and of the critic's.
    gradient_norm: f64 = 0.5, "above 0", |v| *v > 0.0;
    /// Error (in standard deviations of the return) beyond which the value loss is linear.
    huber: f64 = 1.0, "above 0", |v| *v > 0.0;
    /// Share of the old mean and deviation of returns kept at each update.
    value_norm_decay: f64 = 0.9, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// Share of a UAV's training reward that is replaced by the mean over all UAVs. The
    /// reported reward stays the scenario's.
    team_share: f64 = 0.0, "0 to 1", |v| (0.0..=1.0).contains(v);
    /// What a UAV pays in training for each PoI that it and exactly one other of its group
    /// cover, over its energy: 1 is what that takes from the other's individual coverage, which
    /// the scenario's reward leaves to the other alone. The reported reward stays the scenario's.
    overlap_cost: f64 = 1.0, "0 to 10", |v| (0.0..=10.0).contains(v);
    /// Weight of the observation's own advice at the start: how strongly the policy is pulled
    /// towards the action that flies to the place which the observation names the best
    /// (cross-entropy). It falls linearly to 0; 0 learns without advice.
    cloning_weight: f64 = 1.0, "0 to 100", |v| (0.0..=100.0).contains(v);
    /// Episodes until the advice ends.
    cloning_episodes: u32 = 960, "1 to 100000000", |v| (1..=100_000_000).contains(v);
    /// Share of the averaged weights kept at each update; the exported actor is this running
    /// average of the trained one. 0 exports the last weights.
    ema_decay: f64 = 0.99, "0 to 0.9999", |v| (0.0..=0.9999).contains(v);
    /// The exported actor's logits are divided by this: below 1 it draws less at random than
    /// in training, above 1 more.
    temperature: f64 = 0.8, "0.05 to 20", |v| (0.05..=20.0).contains(v);
    /// Episodes between checkpoints.
    checkpoint_every: u32 = 320, "1 to 100000000", |v| (1..=100_000_000).contains(v);
    /// Held-out worlds of the evaluation at the end.
    eval_worlds: u32 = 200, "2 to 100000", |v| (2..=100_000).contains(v);
    /// Seed of the held-out worlds.
    eval_seed: u64 = 777, "0 to 9223372036854775807", |v| i64::try_from(*v).is_ok();
    /// Worlds flown to calibrate the quantisation.
    calibration_worlds: u32 = 16, "1 to 10000", |v| (1..=10_000).contains(v);
}

/// Aggregation as a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Graph(pub Aggregation);

/// A type that settings can have.
trait Value: Sized {
    const KIND: &'static str;
    fn read(v: &toml::Value) -> Option<Self>;
    fn show(&self) -> String;
}

macro_rules! integers {
    ($($t:ty),*) => {$(impl Value for $t {
        const KIND: &'static str = "a whole number";
        fn read(v: &toml::Value) -> Option<Self> { v.as_integer()?.try_into().ok() }
        fn show(&self) -> String { self.to_string() }
    })*};
}
integers!(u16, u32, u64);

impl Value for f64 {
    const KIND: &'static str = "a number";
    fn read(v: &toml::Value) -> Option<Self> {
        v.as_float().or_else(|| v.as_integer().map(|i| i as Self)).filter(|f| f.is_finite())
    }
    fn show(&self) -> String {
        format!("{self:?}")
    }
}

impl Value for bool {
    const KIND: &'static str = "true or false";
    fn read(v: &toml::Value) -> Option<Self> {
        v.as_bool()
    }
    fn show(&self) -> String {
        self.to_string()
    }
}

/// Its name in settings and on the command line.
#[must_use]
pub const fn distribution_name(law: PoiDistribution) -> &'static str {
    match law {
        PoiDistribution::Clustered => "clustered",
        PoiDistribution::Uniform => "uniform",
    }
}

impl Value for PoiDistribution {
    const KIND: &'static str = "\"clustered\" or \"uniform\"";
    fn read(v: &toml::Value) -> Option<Self> {
        [Self::Clustered, Self::Uniform].into_iter().find(|l| v.as_str() == Some(distribution_name(*l)))
    }
    fn show(&self) -> String {
        format!("{:?}", distribution_name(*self))
    }
}

impl Value for ObservationForm {
    const KIND: &'static str = "\"compact\" or \"cells\"";
    fn read(v: &toml::Value) -> Option<Self> {
        Self::ALL.into_iter().find(|f| v.as_str() == Some(f.name()))
    }
    fn show(&self) -> String {
        format!("{:?}", self.name())
    }
}

impl Value for Graph {
    const KIND: &'static str = "\"none\", \"gcn\" or \"gat\"";
    fn read(v: &toml::Value) -> Option<Self> {
        Aggregation::ALL.into_iter().find(|g| v.as_str() == Some(g.name())).map(Self)
    }
    fn show(&self) -> String {
        format!("{:?}", self.0.name())
    }
}

fn unknown(key: &str) -> SettingsError {
    let near =
        KEYS.iter().max_by(|a, b| strsim::jaro_winkler(a.name, key).total_cmp(&strsim::jaro_winkler(b.name, key)));
    let hint = near.map_or_else(String::new, |k| format!("; the nearest is `{}`", k.name));
    SettingsError::UnknownKey { key: key.to_owned(), hint }
}

impl Settings {
    /// Weight of the advice in update `number` of the run, counted from 0.
    #[must_use]
    pub fn cloning_weight_at(&self, number: u64) -> f64 {
        let updates =
            f64::from(self.cloning_episodes) / f64::from(self.num_envs) * f64::from(self.steps / self.rollout_steps);
        self.cloning_weight * (1.0 - number as f64 / updates).max(0.0)
    }

    /// Reads a TOML text over these settings.
    ///
    /// # Errors
    /// See [`SettingsError`]; `path` is named in them.
    pub fn merge(&mut self, text: &str, path: &str) -> Result<(), SettingsError> {
        let table: toml::Table = text
            .parse()
            .map_err(|e: toml::de::Error| SettingsError::Syntax { path: path.to_owned(), message: e.to_string() })?;
        table
            .iter()
            .try_for_each(|(key, value)| self.put(key, value))
            .map_err(|e| SettingsError::In { path: path.to_owned(), error: Box::new(e) })
    }

    /// Reads a TOML file over these settings.
    ///
    /// # Errors
    /// See [`SettingsError`].
    pub fn merge_file(&mut self, path: &Path) -> Result<(), SettingsError> {
        let name = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|source| SettingsError::Read { path: name.clone(), source })?;
        self.merge(&text, &name)
    }

    /// Sets one key from `key=value`; a value that is no TOML is taken as a string.
    ///
    /// # Errors
    /// See [`SettingsError`].
    pub fn set(&mut self, assignment: &str) -> Result<(), SettingsError> {
        let (key, value) = assignment.split_once('=').ok_or_else(|| SettingsError::NoValue(assignment.to_owned()))?;
        let (key, value) = (key.trim(), value.trim());
        let parsed = format!("v = {value}").parse::<toml::Table>().ok().and_then(|mut t| t.remove("v"));
        self.put(key, &parsed.unwrap_or_else(|| toml::Value::String(value.to_owned())))
    }

    /// Checks what single bounds cannot.
    ///
    /// # Errors
    /// [`SettingsError::Together`] names the settings that do not go together.
    pub fn check(&self) -> Result<(), SettingsError> {
        if !self.steps.is_multiple_of(self.rollout_steps) {
            return Err(SettingsError::Together(format!(
                "`rollout_steps` ({}) must divide `steps` ({}); try {}",
                self.rollout_steps,
                self.steps,
                (1..=self.rollout_steps).rev().find(|s| self.steps.is_multiple_of(*s)).unwrap_or(1)
            )));
        }
        if self.eval_seed == self.seed {
            return Err(SettingsError::Together(format!(
                "`eval_seed` and `seed` are both {}: held-out worlds must not be training worlds; change one of them",
                self.seed
            )));
        }
        if self.shards > self.num_envs {
            return Err(SettingsError::Together(format!(
                "`shards` ({}) must not exceed `num_envs` ({})",
                self.shards, self.num_envs
            )));
        }
        let most = usize::from(self.uavs.max(self.uavs_max));
        if self.lossy() && most > MAX_NODES {
            return Err(SettingsError::Together(format!(
                "up to {most} UAVs (`uavs` and `uavs_max`), but with `radio_loss` or `radio_delay` there may be at \
                 most {MAX_NODES}"
            )));
        }
        if self.uavs_max > 0 && self.uavs_min > self.uavs_max {
            return Err(SettingsError::Together(format!(
                "`uavs_min` ({}) must not exceed `uavs_max` ({}), or `uavs_max` be 0",
                self.uavs_min, self.uavs_max
            )));
        }
        if self.observation == ObservationForm::Cells && self.cloning_weight > 0.0 {
            return Err(SettingsError::Together(
                "an observation in cells gives no advice: with `observation = \"cells\"` set `cloning_weight` to 0"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// Whether messages are lost or late in training.
    #[must_use]
    pub fn lossy(&self) -> bool {
        self.radio_loss > 0.0 || self.radio_delay > 0
    }

    /// The worlds to train on.
    #[must_use]
    pub fn world(&self) -> Scenario {
        Scenario {
            uavs: usize::from(self.uavs),
            pois: usize::from(self.pois),
            distribution: self.poi_distribution,
            side_u: self.side as f32,
            steps: self.steps,
        }
    }

    /// UAVs in the worlds of shard `shard` in round `round`, both counted from 0.
    #[must_use]
    pub fn uavs_in(&self, round: u32, shard: u32) -> u16 {
        if self.uavs_max == 0 || shard.is_multiple_of(2) {
            return self.uavs;
        }
        let mut random = stream("swarm sizes", self.seed, u64::from(round) * u64::from(self.shards) + u64::from(shard));
        self.uavs_min + below(&mut random, u32::from(self.uavs_max - self.uavs_min) + 1) as u16
    }

    /// PoiDistribution of the PoIs in world `world` of the `num_envs` of shard `shard`.
    #[must_use]
    pub fn law_in(&self, shard: u32, world: usize, worlds: usize) -> PoiDistribution {
        let others = (self.other_distribution_share * worlds as f64).round() as usize;
        match self.poi_distribution {
            law if shard.is_multiple_of(2) || world >= others => law,
            PoiDistribution::Clustered => PoiDistribution::Uniform,
            PoiDistribution::Uniform => PoiDistribution::Clustered,
        }
    }

    /// Agent-steps in the first `rounds` rounds.
    #[must_use]
    pub fn agent_steps(&self, rounds: u32) -> u64 {
        let (worlds, shards) = (u64::from(self.num_envs), u64::from(self.shards));
        let size = |shard: u64| (shard + 1) * worlds / shards - shard * worlds / shards;
        if self.uavs_max == 0 {
            return u64::from(rounds) * worlds * u64::from(self.uavs) * u64::from(self.steps);
        }
        let in_round = |round| (0..shards).map(|k| size(k) * u64::from(self.uavs_in(round, k as u32))).sum::<u64>();
        (0..rounds).map(in_round).sum::<u64>() * u64::from(self.steps)
    }

    /// Rounds of `num_envs` episodes in the whole run.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        (self.episodes / self.num_envs).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_settings_read_back() {
        let mut a = Settings { graph: Graph(Aggregation::Gat), learning_rate: 3e-4, ..Settings::default() };
        a.set("poi_distribution=uniform").unwrap();
        let mut b = Settings::default();
        b.merge(&a.to_toml(), "test").unwrap();
        assert_eq!(a, b);
    }

    #[test]
    fn every_second_shard_has_other_worlds() {
        let s = Settings { uavs_min: 3, uavs_max: 5, other_distribution_share: 0.25, ..Settings::default() };
        let sizes = |shard| (0..60).map(|round| s.uavs_in(round, shard)).collect::<std::collections::BTreeSet<_>>();
        assert_eq!((sizes(0), sizes(1), sizes(2)), ([20].into(), [3, 4, 5].into(), [20].into()));
        let laws = |shard| (0..16).filter(|&world| s.law_in(shard, world, 16) == PoiDistribution::Uniform).count();
        assert_eq!((laws(0), laws(1), laws(3)), (0, 4, 4));
        let steps = (0..7).flat_map(|round| (0..4).map(move |shard| (round, shard))).map(|(r, k)| s.uavs_in(r, k));
        assert_eq!(s.agent_steps(7), steps.map(|uavs| u64::from(uavs) * 16 * 100).sum::<u64>());
        let alike = Settings { uavs_max: 0, other_distribution_share: 0.0, ..Settings::default() };
        assert!(
            (0..9).all(|round| alike.uavs_in(round, 1) == 20
                && alike.law_in(1, round as usize, 16) == PoiDistribution::Clustered)
        );
        assert_eq!(alike.agent_steps(7), 7 * 64 * 20 * 100);
    }

    #[test]
    fn errors_name_the_remedy() {
        let mut s = Settings::default();
        let say = |r: Result<(), SettingsError>| r.unwrap_err().to_string();
        assert!(say(s.merge("lerning_rate = 1e-3", "f")).contains("nearest is `learning_rate`"));
        assert!(say(s.set("uavs=many")).contains("wants a whole number"));
        assert!(say(s.set("uavs=0")).contains("must be 1 to 10000"));
        assert!(say(s.set("graph=gnn")).contains("\"gcn\""));
        assert!(say(s.set("uavs")).contains("key=value"));
        assert!(say(s.merge("a = = 1", "f.toml")).contains("f.toml is not valid TOML"));
        s.set("rollout_steps=30").unwrap();
        assert!(say(s.check()).contains("try 25"));
        let mut s = Settings { uavs_min: 9, uavs_max: 8, ..Settings::default() };
        assert!(say(s.check()).contains("`uavs_min` (9) must not exceed `uavs_max` (8)"));
        s = Settings { observation: ObservationForm::Cells, ..Settings::default() };
        assert!(say(s.check()).contains("set `cloning_weight` to 0"));
    }
}
