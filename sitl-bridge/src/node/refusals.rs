//! Tells the operator which frames signing refused, by name: at once, then summed up.

use super::host_time::HostTime;
use crate::autopilot::Notice;
use crate::frame::{Counts, Rejected};

/// Further refusals of one kind are summed over this, ms of the host's clock.
const SUMMED_MS: u64 = 30_000;

/// Which of a node's links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    Autopilot,
    Swarm,
}

/// A kind of refusal, how many were told, and when the last were.
#[derive(Clone, Copy, Debug)]
struct Told {
    reason: Rejected,
    count: u64,
    wall_ms: Option<u64>,
}

/// The refusals of one link.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refusals {
    link: Link,
    told: [Told; 4],
}

impl Refusals {
    pub const fn new(link: Link) -> Self {
        const fn none(reason: Rejected) -> Told {
            Told { reason, count: 0, wall_ms: None }
        }
        let (key, unsigned) = (none(Rejected::WrongKey), none(Rejected::Unsigned));
        let (old, id) = (none(Rejected::OldTimestamp), none(Rejected::IdCollision));
        Self { link, told: [key, unsigned, old, id] }
    }

    /// Notices of what was refused since they were last given.
    pub fn update(&mut self, counts: &Counts, now: HostTime, notices: &mut Vec<Notice>) {
        for told in &mut self.told {
            let count = counts.get(told.reason);
            let waits = told.wall_ms.is_some_and(|then| now.wall_ms.saturating_sub(then) < SUMMED_MS);
            if count == told.count || waits {
                continue;
            }
            let new = count - told.count;
            let since = if told.wall_ms.is_some() { " more" } else { "" };
            (told.count, told.wall_ms) = (count, Some(now.wall_ms));
            let frames = if new == 1 { "frame" } else { "frames" };
            let what = in_words(self.link, told.reason);
            notices.push(Notice::warning(format!("{what} ({new}{since} {frames} refused)")));
        }
    }
}

/// What was wrong, and what to do.
const fn in_words(link: Link, reason: Rejected) -> &'static str {
    match (link, reason) {
        (Link::Autopilot, Rejected::WrongKey) => {
            "the autopilot signs with another key: give both the same (see docs/mavlink.md, \"The autopilot's key\")"
        }
        (Link::Swarm, Rejected::WrongKey) => "a UAV of the swarm signs with another key: all need the same",
        (Link::Autopilot, Rejected::Unsigned) => {
            "the autopilot does not sign: give it the key, or sign the swarm's link only with --autopilot-unsigned"
        }
        (Link::Swarm, Rejected::Unsigned) => "a UAV of the swarm does not sign: it needs the key too",
        (Link::Autopilot, Rejected::OldTimestamp) => {
            "the autopilot's signatures are more than a minute old: its clock is late, or this computer's is early"
        }
        (Link::Swarm, Rejected::OldTimestamp) => {
            "a UAV's signatures are more than a minute old: its clock is late, or this computer's is early"
        }
        (_, Rejected::IdCollision) => "another UAV of the swarm has the same id: give each its own --id",
        _ => "frames were refused",
    }
}
