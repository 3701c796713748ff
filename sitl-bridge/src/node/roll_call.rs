//! Who has been heard in a step, and who is still awaited.

use firmware_core::geometry::{COMMUNICATION_RANGE_U, SPEED_CAP_U, State, TICKS_PER_U, Vec2};
use firmware_core::message::Message;
use firmware_core::neighbour_table::{MAX_AGE_STEPS, MessageOutcome};
use std::collections::BTreeMap;

/// How far a UAV can be from where it is expected after a step, ticks: it flies the cap one way where it
/// was expected to fly the cap the other way.
const STRAY: i32 = 2 * SPEED_CAP_U * TICKS_PER_U;
/// A sender whose feature did not follow its beacon in so many steps in a row sends none.
const FEATURES_MISSED: u8 = 2;

/// What was last heard of a sender.
#[derive(Clone, Copy, Debug)]
struct Sender {
    state: State,
    beacon_step: u32,
    feature_step: Option<u32>,
    /// Steps in a row whose beacon was not followed by a feature.
    missed: u8,
}

impl Sender {
    /// Whether it may be in range of `own` position `age` steps after its beacon.
    fn may_be_in_range(&self, age: i32, own: Vec2) -> bool {
        let State { position, velocity } = self.state;
        let offset = |position: i32, velocity: i32, own: i32| {
            i64::from(position) + i64::from(velocity) * i64::from(age) - i64::from(own)
        };
        let x = offset(position.x, velocity.x, own.x);
        let y = offset(position.y, velocity.y, own.y);
        let reach = i64::from(COMMUNICATION_RANGE_U * TICKS_PER_U + STRAY * age);
        x.saturating_mul(x).saturating_add(y.saturating_mul(y)) <= reach * reach
    }
}

/// Who has been heard in the step under way, and who is still awaited. There are as many senders at most as
/// MAVLink has system ids.
#[derive(Clone, Debug, Default)]
pub(super) struct RollCall {
    senders: BTreeMap<u16, Sender>,
}

impl RollCall {
    /// Forgets everybody.
    pub fn clear(&mut self) {
        self.senders.clear();
    }

    /// A step begins: who was not heard for long is forgotten.
    pub fn begin_step(&mut self, step: u32) {
        self.senders.retain(|_, sender| {
            let answered = sender.feature_step == Some(sender.beacon_step);
            if sender.beacon_step == step.wrapping_sub(1) {
                sender.missed = if answered { 0 } else { sender.missed.saturating_add(1) };
            }
            (0..=MAX_AGE_STEPS).contains(&age(step, sender.beacon_step))
        });
    }

    /// Notes a message and what the neighbour table made of it. One that the table has no use for was still
    /// heard: no other will come in its place.
    pub fn hear(&mut self, message: &Message, outcome: MessageOutcome) {
        let header = message.header();
        if matches!(
            outcome,
            MessageOutcome::OwnId
                | MessageOutcome::Repeated
                | MessageOutcome::Older
                | MessageOutcome::Late
                | MessageOutcome::Ahead
        ) {
            return;
        }
        match (message, self.senders.get_mut(&header.id)) {
            (Message::Beacon(beacon), Some(sender)) => {
                sender.beacon_step = header.step;
                if outcome != MessageOutcome::Suspicious {
                    sender.state = beacon.state();
                }
            }
            (Message::Beacon(beacon), None) => {
                let (state, beacon_step) = (beacon.state(), header.step);
                self.senders.insert(header.id, Sender { state, beacon_step, feature_step: None, missed: 0 });
            }
            (Message::Feature(_), Some(sender)) => sender.feature_step = Some(header.step),
            (Message::Feature(_), None) => {}
        }
    }

    /// Whether somebody's beacon of `step` is awaited at `own` position: one who was heard in the last two
    /// steps and may be in range.
    pub fn awaits_beacon(&self, step: u32, own: Vec2) -> bool {
        self.senders.values().any(|sender| {
            let age = age(step, sender.beacon_step);
            (1..=MAX_AGE_STEPS).contains(&age) && sender.may_be_in_range(age, own)
        })
    }

    /// Whether a feature of `step` is awaited of one of these neighbours: of one whose beacon of this step came.
    pub fn awaits_feature(&self, step: u32, neighbours: impl IntoIterator<Item = u16>) -> bool {
        let mut senders = neighbours.into_iter().filter_map(|id| self.senders.get(&id));
        senders.any(|s| s.beacon_step == step && s.feature_step != Some(step) && s.missed < FEATURES_MISSED)
    }
}

/// Steps since `then`; negative when it lies ahead.
const fn age(step: u32, then: u32) -> i32 {
    step.wrapping_sub(then).cast_signed()
}
