//! The table of neighbours.

use super::age::{Age, age};
use super::entry::Entry;
use super::moment::Moment;
use super::outcome::MessageOutcome;
use crate::actor::{MAX_FEATURE, NeighbourFeature, PolicyId};
use crate::geometry::Vec2;
use crate::message::{Beacon, FeatureMessage, Message};
use crate::observation::{MAX_NEIGHBOURS, Neighbours};
use heapless::Vec;

/// Step length where nothing else is set, ms.
pub const DEFAULT_STEP_MS: u16 = 2000;
/// Greatest step length, ms; keeps the extrapolation inside 32 bits.
pub const STEP_MS_LIMIT: u16 = 32_767;
/// The neighbours a UAV has heard of. About 2 KiB.
#[derive(Clone, Debug)]
pub struct NeighbourTable {
    own_id: u16,
    step_ms: u16,
    policy: PolicyId,
    entries: Vec<Entry, MAX_NEIGHBOURS>,
}

impl NeighbourTable {
    /// An empty table of UAV `own_id`. `step_ms` is the length of a step, 1 to
    /// [`STEP_MS_LIMIT`] (what is outside counts as the nearest).
    #[must_use]
    pub const fn new(own_id: u16, policy: PolicyId, step_ms: u16) -> Self {
        Self { own_id, step_ms: valid_step(step_ms), policy, entries: Vec::new() }
    }

    /// Becomes [`Self::new`] in place, for boards whose stack has no room for a table.
    pub fn reset(&mut self, own_id: u16, policy: PolicyId, step_ms: u16) {
        (self.own_id, self.policy, self.step_ms) = (own_id, policy, valid_step(step_ms));
        self.entries.clear();
    }

    /// Takes in a message heard at `now`, with the own position (ticks) at that time.
    pub fn hear(&mut self, message: &Message, own_position: Vec2, now: Moment) -> MessageOutcome {
        self.expire(now);
        if message.header().id == self.own_id {
            return MessageOutcome::OwnId;
        }
        match message {
            Message::Beacon(beacon) => self.hear_beacon(beacon, own_position, now),
            Message::Feature(feature) => self.hear_feature(feature, now),
        }
    }

    /// Forgets what is too old, or too far in the future, at `now`. [`Self::hear`] and
    /// [`Self::view`] do it too.
    pub fn expire(&mut self, now: Moment) {
        let step_ms = self.step_ms();
        self.entries.retain_mut(|e| e.expire(now, step_ms));
    }

    /// Fills `out` with the neighbours in communication range of `own_position` (ticks)
    /// at `now`, nearest first, each where its last beacon says that it is by then.
    pub fn view(&mut self, own_position: Vec2, now: Moment, out: &mut Neighbours) {
        self.expire(now);
        out.clear();
        for e in &self.entries {
            out.insert(e.seen_from(own_position, now, self.step_ms()));
        }
    }

    /// The features at hand of the neighbours in `view` with their ids, in its order. A
    /// neighbour without a feature young enough at `step` is left out.
    pub fn features<'a>(
        &'a self,
        view: &'a Neighbours,
        step: u32,
    ) -> impl Iterator<Item = (u16, NeighbourFeature<'a>)> + Clone {
        let width = usize::from(self.policy.width).min(MAX_FEATURE);
        view.as_slice().iter().filter_map(move |n| Some((n.id, self.find(n.id)?.feature_at(step, width)?)))
    }

    /// Number of UAVs in the table, in range or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether nobody is in the table.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    fn step_ms(&self) -> i32 {
        i32::from(self.step_ms)
    }

    fn find(&self, id: u16) -> Option<&Entry> {
        self.entries.iter().find(|e| e.id == id)
    }

    fn find_mut(&mut self, id: u16) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|e| e.id == id)
    }

    fn hear_beacon(&mut self, beacon: &Beacon, own_position: Vec2, now: Moment) -> MessageOutcome {
        let step_ms = self.step_ms();
        match age(now.time_ms, beacon.time_ms(), step_ms) {
            Age::Late => return MessageOutcome::Late,
            Age::Ahead => return MessageOutcome::Ahead,
            Age::Usable => {}
        }
        match self.find_mut(beacon.header().id) {
            Some(entry) => entry.hear(beacon, step_ms),
            None => self.admit(Entry::new(beacon), own_position, now),
        }
    }

    fn hear_feature(&mut self, feature: &FeatureMessage, now: Moment) -> MessageOutcome {
        if feature.actor() != self.policy.hash {
            return MessageOutcome::ForeignActor;
        }
        if feature.values().len() != usize::from(self.policy.width) {
            return MessageOutcome::WrongWidth;
        }
        match age(now.step, feature.header().step, 1) {
            Age::Late => MessageOutcome::Late,
            Age::Ahead => MessageOutcome::Ahead,
            Age::Usable => match self.find_mut(feature.header().id) {
                Some(entry) => entry.hear_feature(feature),
                None => MessageOutcome::UnknownSender,
            },
        }
    }

    fn admit(&mut self, entry: Entry, own_position: Vec2, now: Moment) -> MessageOutcome {
        let Err(entry) = self.entries.push(entry) else { return MessageOutcome::New };
        let step_ms = self.step_ms();
        let rank = |e: &Entry| e.rank(own_position, now, step_ms);
        match self.entries.iter_mut().max_by_key(|e| rank(e)) {
            Some(farthest) if rank(&entry) < rank(farthest) => {
                let evicted = farthest.id;
                *farthest = entry;
                MessageOutcome::Replaced(evicted)
            }
            _ => MessageOutcome::TooFar,
        }
    }
}

const fn valid_step(step_ms: u16) -> u16 {
    match step_ms {
        0 => 1,
        ms if ms > STEP_MS_LIMIT => STEP_MS_LIMIT,
        ms => ms,
    }
}
