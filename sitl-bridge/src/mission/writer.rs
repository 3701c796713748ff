//! A mission as a file, and its hash.

use super::definition::{HeightLimits, Layers, Mission};
use firmware_core::actor::Mode;
use firmware_core::geometry::{TICKS_PER_U, Vec2};
use sha2::Digest as _;
use std::fmt::Write as _;

impl Mission {
    /// SHA-256 over the mission as [`Mission::to_toml`] writes it without comment and at epoch 0: the same for
    /// the same mission whatever file it came from, and whenever it begins.
    #[must_use]
    pub fn hash(&self) -> [u8; 32] {
        let text = Self { epoch_unix_ms: 0, ..self.clone() }.to_toml("");
        sha2::Sha256::digest(text.as_bytes()).into()
    }

    /// The limits of heights that are not the usual ones: a mission from before there were any has the hash that
    /// it had.
    fn heights_as_written(&self) -> String {
        let (limits, usual) = (self.heights, HeightLimits::default());
        let fields = [
            ("highest_above_home_m", limits.highest_above_home_m, usual.highest_above_home_m),
            ("home_within_m", limits.home_within_m, usual.home_within_m),
            ("check_m", limits.check_m, usual.check_m),
        ];
        let written = fields.into_iter().filter(|(_, value, usual)| value != usual);
        written.map(|(name, value, _)| format!("{name} = {value:?}\n")).collect()
    }

    /// The mission as a file that reads back as the same; `title` becomes a comment.
    #[must_use]
    pub fn to_toml(&self, title: &str) -> String {
        let (lat, lon) = self.plane.origin_degrees();
        let mut out = String::new();
        for line in title.lines() {
            let _ = writeln!(out, "# {line}");
        }
        let decide = if self.mode == Mode::Argmax { "argmax" } else { "sample" };
        let Layers { base_m, spacing_m, count } = self.layers;
        let heights = self.heights_as_written();
        let _ = write!(
            out,
            "# The map is a square; x points east, y north, and its south-west corner lies here:
origin = {{ lat = {lat:.7}, lon = {lon:.7}, alt_m = {:?} }}
scale_m = {:?}      # metres in a map unit (u)
step_ms = {}
side_u = {:?}
policy_seed = {}
decide = \"{decide}\"
epoch_unix_ms = {}  # step 0 begins at this Unix time

pois_u = [
",
            f64::from(self.plane.alt_mm) / 1000.0,
            self.scale.unit_m,
            self.scale.step_ms,
            self.side_u,
            self.policy_seed,
            self.epoch_unix_ms,
        );
        write_points(&mut out, &self.pois);
        let _ = write!(
            out,
            "]

[altitude]  # above the origin; UAV id flies in layer id mod layers
base_m = {base_m:?}
spacing_m = {spacing_m:?}
layers = {count}
{heights}
[fence]
polygon_u = [
"
        );
        write_points(&mut out, &self.fence);
        out.push_str("]\n");
        out
    }
}

/// Ticks have at most ten binary places, which are written in full.
fn write_points(out: &mut String, points: &[Vec2]) {
    for p in points {
        let [x, y] = [p.x, p.y].map(|ticks| f64::from(ticks) / f64::from(TICKS_PER_U));
        let _ = writeln!(out, "  [{x:?}, {y:?}],");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mission::{Loaded, Origin};
    use covey_env::{PoiDistribution, Scenario, World};
    use proptest::prelude::*;
    use std::path::Path;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn a_written_mission_reads_back_the_same(
            index in 0u64..1000, side_u in 20.0f32..2000.0, lat in -80.0f64..80.0, lon in -180.0f64..180.0, uniform: bool,
        ) {
            let distribution = if uniform { PoiDistribution::Uniform } else { PoiDistribution::Clustered };
            let mut world = World::new(&Scenario { side_u, distribution, ..Scenario::default() }).unwrap();
            world.reset(777, index);
            let mut mission = Mission::of_world(&world, Origin { lat, lon, alt_m: 12.345 }).unwrap();
            mission.mode = if uniform { Mode::Argmax } else { Mode::Sample };
            mission.policy_seed = index.wrapping_mul(0x1_0000_0001);
            mission.epoch_unix_ms = 1_790_000_000_000;
            if uniform {
                mission.heights.home_within_m = 31.25;
            }
            let text = mission.to_toml("one\ntwo");
            let read = Loaded::from_bytes(text.as_bytes(), Path::new("m.toml")).unwrap();
            prop_assert_eq!((read.mission.hash(), read.mission), (mission.hash(), mission));
            prop_assert_eq!(read.remarks, []);
        }
    }
}
