//! What a UAV has heard of its neighbours.
//!
//! The table keeps the last beacon and the last feature of up to [`MAX_NEIGHBOURS`]
//! UAVs. A late beacon is extrapolated by its velocity and a late feature used as it is,
//! both until they are [`MAX_AGE_STEPS`] old. When the table is full the nearest stay.
//! Training uses the same table, so a dense swarm and a bad link bring no surprise.
//!
//! All times are of the swarm's common clock. Clocks, steps and sequence numbers wrap
//! around; of two of them the newer is the one that is less than half a turn ahead. A
//! beacon or feature that lies in the future by more than [`MAX_AHEAD_STEPS`] is not
//! taken and one that is kept is forgotten: so a clock that jumps back leaves no ghosts.

mod entry;

use crate::actor::{ActorInput, Aggregation, MAX_FEATURE, NeighbourFeature, QuantisedActor};
use crate::geometry::{SPEED_CAP_U, Vec2};
use crate::message::{Beacon, Feature, Message};
use crate::observation::{MAX_NEIGHBOURS, Neighbours};
use entry::Entry;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Greatest age of a beacon or a feature in use, steps (the limit is inside).
pub const MAX_AGE_STEPS: i32 = 2;
/// How far ahead of the own clock a beacon or a feature may be, steps (the limit is inside).
pub const MAX_AHEAD_STEPS: i32 = 1;
/// Step length where nothing else is set, ms.
pub const DEFAULT_STEP_MS: u16 = 2000;
/// Greatest step length, ms; keeps the extrapolation inside 32 bits.
pub const STEP_MS_LIMIT: u16 = 32_767;
/// Fastest that a UAV is believed to fly, u/step: half more than the speed cap, for wind
/// and overshoot. Faster velocity components are taken as this.
pub const BELIEVED_SPEED_U: i32 = SPEED_CAP_U * 3 / 2;
/// Jump of a measured position that is no reason for doubt, u.
pub const POSITION_NOISE_U: i32 = 2;

/// A moment on the swarm's common clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Moment {
    /// Number of the step.
    pub step: u32,
    /// Time, ms.
    pub time_ms: u32,
}

/// The policy whose features a table takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolicyId {
    /// Its content hash.
    pub hash: u32,
    /// Values of its features, up to [`MAX_FEATURE`]; 0 when it uses none.
    pub width: u8,
}

impl PolicyId {
    /// That of an actor.
    #[must_use]
    pub fn of<O: ActorInput>(actor: &QuantisedActor<'_, O>) -> Self {
        let width = match actor.aggregation() {
            Aggregation::None => 0,
            // Loading bounds it by 64.
            Aggregation::Gcn | Aggregation::Gat => actor.dimensions().feature as u8,
        };
        Self { hash: actor.message_hash(), width }
    }
}

/// What became of a message. The order of the variants is part of the PIL protocol's protocol
/// (see [`crate::pil`]).
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Answer {
    /// Taken: the first beacon of this sender.
    New,
    /// Taken: the first beacon of this sender, in the place of a farther one (its id).
    Replaced(u16),
    /// Taken: the sender's beacon or feature is the new one.
    Updated,
    /// Taken: a second beacon confirms a jump that looked impossible.
    Confirmed,
    /// Waiting: the sender moved farther than it can fly. The old beacon stays until
    /// another one confirms the jump.
    Suspicious,
    /// Not taken: it carries the own id.
    OwnId,
    /// Not taken: this very sequence number was heard before.
    Repeated,
    /// Not taken: a newer one of the same sender was heard before.
    Older,
    /// Not taken: more than [`MAX_AGE_STEPS`] old.
    Late,
    /// Not taken: more than [`MAX_AHEAD_STEPS`] in the future; a clock is wrong.
    Ahead,
    /// Not taken: the table is full of nearer neighbours.
    TooFar,
    /// Not taken: a feature of a sender without a beacon in the table.
    UnknownSender,
    /// Not taken: a feature of another policy.
    ForeignActor,
    /// Not taken: a feature of the own policy with a wrong number of values.
    WrongWidth,
}

impl Answer {
    /// Whether the table now holds the message.
    #[must_use]
    pub const fn is_taken(self) -> bool {
        matches!(self, Self::New | Self::Replaced(_) | Self::Updated | Self::Confirmed)
    }
}

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
    pub fn hear(&mut self, message: &Message, own_position: Vec2, now: Moment) -> Answer {
        self.expire(now);
        if message.header().id == self.own_id {
            return Answer::OwnId;
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

    fn hear_beacon(&mut self, beacon: &Beacon, own_position: Vec2, now: Moment) -> Answer {
        let step_ms = self.step_ms();
        match age(now.time_ms, beacon.time_ms(), step_ms) {
            Age::Late => return Answer::Late,
            Age::Ahead => return Answer::Ahead,
            Age::Usable => {}
        }
        match self.find_mut(beacon.header().id) {
            Some(entry) => entry.hear(beacon, step_ms),
            None => self.admit(Entry::new(beacon), own_position, now),
        }
    }

    fn hear_feature(&mut self, feature: &Feature, now: Moment) -> Answer {
        if feature.actor() != self.policy.hash {
            return Answer::ForeignActor;
        }
        if feature.values().len() != usize::from(self.policy.width) {
            return Answer::WrongWidth;
        }
        match age(now.step, feature.header().step, 1) {
            Age::Late => Answer::Late,
            Age::Ahead => Answer::Ahead,
            Age::Usable => match self.find_mut(feature.header().id) {
                Some(entry) => entry.hear_feature(feature),
                None => Answer::UnknownSender,
            },
        }
    }

    fn admit(&mut self, entry: Entry, own_position: Vec2, now: Moment) -> Answer {
        let Err(entry) = self.entries.push(entry) else { return Answer::New };
        let step_ms = self.step_ms();
        let rank = |e: &Entry| e.rank(own_position, now, step_ms);
        match self.entries.iter_mut().max_by_key(|e| rank(e)) {
            Some(farthest) if rank(&entry) < rank(farthest) => {
                let evicted = farthest.id;
                *farthest = entry;
                Answer::Replaced(evicted)
            }
            _ => Answer::TooFar,
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

/// How old something is, in classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Age {
    Ahead,
    Usable,
    Late,
}

/// Classes the difference of two wrapping times; `step` is the length of a step in their unit.
const fn age(now: u32, then: u32, step: i32) -> Age {
    let age = now.wrapping_sub(then) as i32;
    if age < -MAX_AHEAD_STEPS * step {
        Age::Ahead
    } else if age > MAX_AGE_STEPS * step {
        Age::Late
    } else {
        Age::Usable
    }
}
