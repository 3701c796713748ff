//! What a recording says of the node that made it.

use super::settings::{Settings, gate_limits};
use super::velocity_profile::FeedForward;
use crate::tlog::Flight;
use firmware_core::gate::Limits;
use std::fmt::Write as _;

impl Settings<'_> {
    /// The settings that decisions depend on, for the recording.
    #[must_use]
    pub fn flight(&self) -> Flight {
        let kinds = [("flight", Limits::default()), ("simulation", Limits::simulation()), ("ideal", Limits::ideal())];
        let limits = kinds.into_iter().find(|(_, base)| gate_limits(*base, &self.mission) == self.limits);
        let hash = self.mission.hash().iter().fold(String::new(), |mut hash, byte| {
            let _ = write!(hash, "{byte:02x}");
            hash
        });
        Flight::default()
            .with("version", env!("CARGO_PKG_VERSION"))
            .with("id", self.id)
            .with("system", self.system)
            .with("mission", hash)
            .with("actor", format_args!("{:08x}", self.actor.message_hash()))
            .with("limits", limits.map_or("other", |(name, _)| name))
            .with("feed_forward", if self.feed_forward == FeedForward::Ramp { "ramp" } else { "action" })
            .with("take_off", u8::from(self.take_off))
            .with("wait_for", self.wait_for)
            .with("strict", u8::from(self.strict))
            .with("rate_hz", self.rate_hz)
            .with("pace", self.timing.pace.name())
            .with("encode_ms", self.timing.encode_ms)
            .with("decide_ms", self.timing.decide_ms)
            .with("telemetry_ms", self.timing.telemetry_ms)
            .with("lead_ms", self.timing.lead_ms)
            .with("beacon_ms", self.timing.beacon_ms.unwrap_or(0))
    }
}
