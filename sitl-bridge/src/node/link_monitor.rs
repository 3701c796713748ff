//! When the autopilot and the swarm were last heard.

use super::host_time::HostTime;
use crate::autopilot::Notice;

/// The autopilot's silence is reported after this, ms of the host's clock.
const SILENCE_MS: u64 = 5000;

/// The state of a node's two links.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinkMonitor {
    /// Host's clock at the first turn.
    started_wall_ms: Option<u64>,
    /// Host's clock when the autopilot was last heard.
    autopilot_wall_ms: Option<u64>,
    silence_reported: bool,
    /// Vehicle's and host's clock when a neighbour's message was last taken.
    swarm: Option<(u32, u64)>,
}

impl LinkMonitor {
    /// Silence is counted from the first call at the latest.
    pub const fn start(&mut self, now: HostTime) {
        if self.started_wall_ms.is_none() {
            self.started_wall_ms = Some(now.wall_ms);
        }
    }

    /// The autopilot was heard. Returns a notice when its silence had been reported.
    pub fn autopilot_heard(&mut self, now: HostTime) -> Option<Notice> {
        self.autopilot_wall_ms = Some(now.wall_ms);
        std::mem::take(&mut self.silence_reported).then(|| Notice::info("the autopilot is heard again"))
    }

    /// A neighbour's message was taken at `boot_ms` of the vehicle's clock.
    pub const fn swarm_heard(&mut self, boot_ms: u32, now: HostTime) {
        self.swarm = Some((boot_ms, now.wall_ms));
    }

    /// Returns a notice, with `advice` on what to check, once the autopilot has been silent for too
    /// long.
    pub fn check_silence(&mut self, now: HostTime, advice: &str) -> Option<Notice> {
        let since = self.autopilot_wall_ms.or(self.started_wall_ms).unwrap_or(now.wall_ms);
        if self.silence_reported || now.wall_ms.saturating_sub(since) < SILENCE_MS {
            return None;
        }
        self.silence_reported = true;
        Some(Notice::warning(format!("nothing heard for 5 s; {advice}")))
    }

    /// Age of the autopilot's last message by the host's clock, ms.
    pub fn autopilot_age_ms(&self, now: HostTime) -> Option<u64> {
        self.autopilot_wall_ms.map(|then| now.wall_ms.saturating_sub(then))
    }

    /// Age of the swarm's last message by the host's clock, ms.
    pub fn swarm_age_ms(&self, now: HostTime) -> Option<u64> {
        self.swarm.map(|(_, then)| now.wall_ms.saturating_sub(then))
    }

    /// Vehicle's clock when a neighbour's message was last taken, ms.
    pub fn swarm_boot_ms(&self) -> Option<u32> {
        self.swarm.map(|(boot_ms, _)| boot_ms)
    }
}
