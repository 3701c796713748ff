//! One sender in the neighbour table.

use super::age::{Age, age};
use super::moment::Moment;
use super::outcome::MessageOutcome;
use crate::actor::{MAX_FEATURE, NeighbourFeature};
use crate::geometry::{SPEED_CAP_U, TICKS_PER_U, Vec2, div_round};
use crate::message::{Beacon, FeatureMessage};
use crate::observation::Neighbour;
use core::cmp::Ordering;

/// Fastest that a UAV is believed to fly, u/step: half more than the speed cap, for wind
/// and overshoot. Faster velocity components are taken as this.
pub const BELIEVED_SPEED_U: i32 = SPEED_CAP_U * 3 / 2;
/// Jump of a measured position that is no reason for doubt, u.
pub const POSITION_NOISE_U: i32 = 2;

const BELIEVED_SPEED: i32 = BELIEVED_SPEED_U * TICKS_PER_U;
/// How far a UAV can stray from its extrapolation, ticks a step: it flies the cap one way
/// where it was expected to fly the cap the other way.
const STRAY: i32 = 2 * SPEED_CAP_U * TICKS_PER_U;

/// The last beacon believed.
#[derive(Clone, Copy, Debug)]
struct Fix {
    position: Vec2,
    velocity: [i16; 2],
    time_ms: u32,
    sequence: u16,
    tie: i8,
}

impl Fix {
    fn of(beacon: &Beacon) -> Self {
        let state = beacon.state();
        let believed = |v: i32| v.clamp(-BELIEVED_SPEED, BELIEVED_SPEED) as i16;
        Self {
            position: state.position,
            velocity: [believed(state.velocity.x), believed(state.velocity.y)],
            time_ms: beacon.time_ms(),
            sequence: beacon.header().sequence,
            tie: beacon.tie(),
        }
    }
}

/// The last beacon that has to be confirmed.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    position: Vec2,
    time_ms: u32,
    sequence: u16,
}

/// The last feature.
#[derive(Clone, Debug)]
struct Heard {
    step: u32,
    sequence: u16,
    attention_source: i16,
    degree: u8,
    values: [i8; MAX_FEATURE],
}

/// What is known of one sender.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) id: u16,
    fix: Fix,
    doubt: Option<Doubt>,
    feature: Option<Heard>,
}

impl Entry {
    pub(super) fn new(beacon: &Beacon) -> Self {
        Self { id: beacon.header().id, fix: Fix::of(beacon), doubt: None, feature: None }
    }

    /// Takes in another beacon, not too old.
    pub(super) fn hear(&mut self, beacon: &Beacon, step_ms: i32) -> MessageOutcome {
        let (sequence, time_ms) = (beacon.header().sequence, beacon.time_ms());
        if let Some(outcome) = not_newer(sequence, self.fix.sequence) {
            return outcome;
        }
        let position = beacon.state().position;
        let reaches = |from: Vec2, then: u32| is_flyable(position - from, time_ms.wrapping_sub(then) as i32, step_ms);
        let doubt = self.doubt.map(|d| (not_newer(sequence, d.sequence), d));
        let outcome = match doubt {
            Some((Some(MessageOutcome::Repeated), _)) => return MessageOutcome::Repeated,
            _ if reaches(self.fix.position, self.fix.time_ms) => MessageOutcome::Updated,
            Some((None, d)) if reaches(d.position, d.time_ms) => MessageOutcome::Confirmed,
            // Overtaken by the one in doubt: it neither confirms nor replaces it.
            Some((Some(_), _)) => return MessageOutcome::Suspicious,
            _ => {
                self.doubt = Some(Doubt { position, time_ms, sequence });
                return MessageOutcome::Suspicious;
            }
        };
        self.fix = Fix::of(beacon);
        self.doubt = None;
        outcome
    }

    /// Takes in a feature of the own policy, not too old.
    pub(super) fn hear_feature(&mut self, feature: &FeatureMessage) -> MessageOutcome {
        let sequence = feature.header().sequence;
        if let Some(outcome) = self.feature.as_ref().and_then(|f| not_newer(sequence, f.sequence)) {
            return outcome;
        }
        let mut values = [0; MAX_FEATURE];
        for (kept, &v) in values.iter_mut().zip(feature.values()) {
            *kept = v;
        }
        let step = feature.header().step;
        self.feature = Some(Heard {
            step,
            sequence,
            attention_source: feature.attention_source(),
            degree: feature.degree(),
            values,
        });
        MessageOutcome::Updated
    }

    /// Drops what is out of use; false when the whole entry is.
    pub(super) fn expire(&mut self, now: Moment, step_ms: i32) -> bool {
        if self.doubt.is_some_and(|d| age(now.time_ms, d.time_ms, step_ms) != Age::Usable) {
            self.doubt = None;
        }
        if self.feature.as_ref().is_some_and(|f| age(now.step, f.step, 1) != Age::Usable) {
            self.feature = None;
        }
        age(now.time_ms, self.fix.time_ms, step_ms) == Age::Usable
    }

    /// As seen from `own_position`, extrapolated to `now`. Not for an expired entry.
    pub(super) fn seen_from(&self, own_position: Vec2, now: Moment, step_ms: i32) -> Neighbour {
        let [x, y] = self.fix.velocity.map(i32::from);
        // |v| <= 6,144 and |age| <= 65,534, as this entry is not expired: below 2^29.
        let age_ms = self.age_ms(now);
        let moved = |v: i32| div_round(v.wrapping_mul(age_ms), step_ms.max(1));
        let position = self.fix.position + Vec2 { x: moved(x), y: moved(y) };
        Neighbour { id: self.id, offset: position - own_position, velocity: Vec2 { x, y }, tie: self.fix.tie }
    }

    /// Orders entries by the distance (ticks) at which they can be at most: the
    /// extrapolated one plus as much as the UAV can have strayed since its beacon. So a
    /// late beacon that hides a far neighbour never displaces a truly near one, and
    /// between beacons of one moment the nearer stays, then the lower id.
    pub(super) fn rank(&self, own_position: Vec2, now: Moment, step_ms: i32) -> (u32, u64, u16) {
        let offset = self.seen_from(own_position, now, step_ms).offset;
        let square = |v: i32| u64::from(v.unsigned_abs()).pow(2);
        // Offsets are below 2^30: the sum is below 2^61.
        let d2 = square(offset.x) + square(offset.y);
        let age_ms = self.age_ms(now).unsigned_abs();
        // Below 2^13 · 2^16. Two ticks more cover the roundings, here and in the square root.
        let strayed = match age_ms {
            0 => 0,
            _ => STRAY.unsigned_abs().wrapping_mul(age_ms) / step_ms.unsigned_abs().max(1) + 2,
        };
        (d2.isqrt() as u32 + strayed, d2, self.id)
    }

    /// The feature, if it is young enough at `step`.
    pub(super) fn feature_at(&self, step: u32, width: usize) -> Option<NeighbourFeature<'_>> {
        let f = self.feature.as_ref().filter(|f| age(step, f.step, 1) == Age::Usable)?;
        Some(NeighbourFeature {
            values: f.values.get(..width)?,
            degree: f.degree,
            attention_source: f.attention_source,
        })
    }

    fn age_ms(&self, now: Moment) -> i32 {
        now.time_ms.wrapping_sub(self.fix.time_ms) as i32
    }
}

/// The outcome to a sequence number that is not newer than the one kept.
fn not_newer(sequence: u16, kept: u16) -> Option<MessageOutcome> {
    match (sequence.wrapping_sub(kept) as i16).cmp(&0) {
        Ordering::Less => Some(MessageOutcome::Older),
        Ordering::Equal => Some(MessageOutcome::Repeated),
        Ordering::Greater => None,
    }
}

/// Whether a UAV can move by `jump` (ticks) in `ms`, either way, as far as is believed.
fn is_flyable(jump: Vec2, ms: i32, step_ms: i32) -> bool {
    let step_ms = step_ms.unsigned_abs().max(1);
    // Two beacons in use lie at most 3 steps apart: 20 u, within the range of `within`.
    let steps_ms = ms.unsigned_abs().min(step_ms.saturating_mul(3));
    let flown = BELIEVED_SPEED.unsigned_abs().saturating_mul(steps_ms) / step_ms;
    jump.within(POSITION_NOISE_U * TICKS_PER_U + flown as i32).is_some()
}
