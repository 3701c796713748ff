//! What follows from the settings: worlds, rounds and the schedules over a run.

use super::table::Settings;
use covey_env::random::{below, stream};
use covey_env::{PoiDistribution, Scenario};

impl Settings {
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

    /// Distribution of the PoIs in world `world` of shard `shard`, which has `worlds` of them.
    #[must_use]
    pub fn distribution_in(&self, shard: u32, world: usize, worlds: usize) -> PoiDistribution {
        let others = (self.other_distribution_share * worlds as f64).round() as usize;
        match self.poi_distribution {
            usual if shard.is_multiple_of(2) || world >= others => usual,
            PoiDistribution::Clustered => PoiDistribution::Uniform,
            PoiDistribution::Uniform => PoiDistribution::Clustered,
        }
    }

    /// Whether messages are lost or late in training.
    #[must_use]
    pub fn lossy(&self) -> bool {
        self.radio_loss > 0.0 || self.radio_delay > 0
    }

    /// Rounds of `num_envs` episodes in the whole run.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        (self.episodes / self.num_envs).max(1)
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

    /// Weight of behaviour cloning in update `number` of the run, counted from 0.
    #[must_use]
    pub fn cloning_weight_at(&self, number: u64) -> f64 {
        let updates =
            f64::from(self.cloning_episodes) / f64::from(self.num_envs) * f64::from(self.steps / self.rollout_steps);
        self.cloning_weight * (1.0 - number as f64 / updates).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_shard_has_other_worlds() {
        let s = Settings { uavs_min: 3, uavs_max: 5, other_distribution_share: 0.25, ..Settings::default() };
        let sizes = |shard| (0..60).map(|round| s.uavs_in(round, shard)).collect::<std::collections::BTreeSet<_>>();
        assert_eq!((sizes(0), sizes(1), sizes(2)), ([20].into(), [3, 4, 5].into(), [20].into()));
        let distributions =
            |shard| (0..16).filter(|&world| s.distribution_in(shard, world, 16) == PoiDistribution::Uniform).count();
        assert_eq!((distributions(0), distributions(1), distributions(3)), (0, 4, 4));
        let steps = (0..7).flat_map(|round| (0..4).map(move |shard| (round, shard))).map(|(r, k)| s.uavs_in(r, k));
        assert_eq!(s.agent_steps(7), steps.map(|uavs| u64::from(uavs) * 16 * 100).sum::<u64>());
        let alike = Settings { uavs_max: 0, other_distribution_share: 0.0, ..Settings::default() };
        assert!((0..9).all(|round| alike.uavs_in(round, 1) == 20
            && alike.distribution_in(1, round as usize, 16) == PoiDistribution::Clustered));
        assert_eq!(alike.agent_steps(7), 7 * 64 * 20 * 100);
    }
}
