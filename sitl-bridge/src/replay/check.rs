//! Decisions that were flown against those that a node makes again.

use crate::frame::Frame;
use crate::messages::{SetPositionTargetLocalNed, id};
use crate::mission::Scale;
use crate::node::{Counters, Decision, FeedForward, VelocityProfile};
use crate::swarm_link::neighbour_message;
use firmware_core::action::{ACTIONS, Action};
use firmware_core::message::{FeatureMessage, Header, Message};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Two setpoints are the same flight when they differ by no more than this, m/s and m/s².
const SAME: f64 = 0.002;

/// What differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DifferenceKind {
    /// Another action was flown than is decided now.
    Action,
    /// The UAV saw something else: its feature is another.
    Feature,
    /// It was decided in flight, and is not now: the log lacks what the decision was made on.
    NotDecided,
    /// The decision was not flown: in flight the gate held the vehicle.
    NotFlown,
}

/// A decision that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The step.
    pub step: u32,
    /// The UAV.
    pub uav: u16,
    /// What differs.
    pub kind: DifferenceKind,
    /// The action that was flown, where it can be told.
    pub recorded: Option<u8>,
    /// The action that is decided now, if any.
    pub replayed: Option<u8>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let action = |a: Option<u8>| a.map_or_else(|| "none".into(), |a| format!("{a}"));
        let (recorded, replayed) = (action(self.recorded), action(self.replayed));
        write!(f, "step {}, UAV {}: ", self.step, self.uav)?;
        match self.kind {
            DifferenceKind::Action => write!(f, "flown was action {recorded}, decided is {replayed}"),
            DifferenceKind::Feature => {
                write!(f, "another feature was told: the UAV saw something else (action {replayed} all the same)")
            }
            DifferenceKind::NotDecided => {
                write!(f, "it was decided in flight; what it was decided on is not in the log")
            }
            DifferenceKind::NotFlown => write!(f, "flown was no action, the gate held; decided is {replayed}"),
        }
    }
}

/// What came of a replay.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Decisions of the node that was run again.
    pub decisions: u64,
    /// … for which a setpoint stands in the log.
    pub compared: u64,
    /// … and which are the same.
    pub equal: u64,
    /// Decisions without a setpoint in the log: the gate was silent.
    pub without_setpoint: u64,
    /// Setpoints of compared decisions, and those that are not the same to the millimetre: the
    /// gate may have been limiting otherwise.
    pub setpoints: u64,
    /// See `setpoints`.
    pub other_setpoints: u64,
    /// The actor that was flown, as feature messages name it; `None` where there is none.
    pub flown_actor: Option<u32>,
    /// Features in the log that were held against those made now.
    pub features: u64,
    /// … and which are of steps that were not decided in now.
    pub features_elsewhere: u64,
    /// Steps in the air without a decision, in the node that was run again.
    pub missed_decisions: u64,
    /// The decisions that differ.
    pub differences: Vec<Difference>,
}

impl ReplayReport {
    /// Whether every decision that could be compared is the same.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.differences.is_empty()
    }

    /// Whether no step of the log is one that was decided in now, though there are some: the mission begins
    /// at another time.
    #[must_use]
    pub const fn counts_otherwise(&self) -> bool {
        self.decisions > 0 && self.features > 0 && self.features_elsewhere == self.features
    }
}

/// Horizontal velocity and acceleration of a setpoint, east and north.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SetpointValues {
    velocity: [f64; 2],
    acceleration: [f64; 2],
}

impl SetpointValues {
    /// The vehicle's time and the horizontal values of a SET_POSITION_TARGET_LOCAL_NED.
    fn read(frame: &Frame) -> Option<(u32, Self)> {
        if frame.message_id() != id::SET_POSITION_TARGET_LOCAL_NED {
            return None;
        }
        let setpoint = SetPositionTargetLocalNed::read(frame.payload());
        let horizontal = |[north, east, _]: [f32; 3]| [f64::from(east), f64::from(north)];
        let (velocity, acceleration) = (horizontal(setpoint.velocity_mps), horizontal(setpoint.acceleration_mps2));
        Some((setpoint.boot_ms, Self { velocity, acceleration }))
    }

    fn of(profile: &VelocityProfile, boot_ms: u32, feed_forward: FeedForward) -> Self {
        let (v, a) = profile.at(boot_ms, feed_forward);
        let si = |thousandths: i32| f64::from(thousandths) / 1000.0;
        Self { velocity: [si(v.east), si(v.north)], acceleration: [si(a.east), si(a.north)] }
    }

    /// Sum of squares over the four numbers.
    fn apart(&self, other: &Self) -> f64 {
        let square = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        square(self.velocity, other.velocity) + square(self.acceleration, other.acceleration)
    }

    fn is(&self, other: &Self) -> bool {
        self.apart(other) <= SAME * SAME
    }

    /// The gate's brake.
    fn stands(&self) -> bool {
        self.velocity == [0.0; 2] && self.acceleration == [0.0; 2]
    }
}

/// A decision and what is known of how it was flown.
#[derive(Debug)]
struct Case {
    decision: Decision,
    profile: VelocityProfile,
    recorded: Vec<(u32, SetpointValues)>,
    replayed: Vec<(u32, SetpointValues)>,
}

/// Holds decisions made again against what stands in the log. Feed it in the log's order.
#[derive(Debug)]
pub struct ReplayCheck {
    uav: u16,
    scale: Scale,
    feed_forward: FeedForward,
    case: Option<Case>,
    /// Features by step: told in flight, and now.
    told: BTreeMap<u32, FeatureMessage>,
    rebroadcast: BTreeMap<u32, FeatureMessage>,
    /// Actions decided now.
    decided: BTreeMap<u32, u8>,
    report: ReplayReport,
}

impl ReplayCheck {
    /// For UAV `uav`, whose flight had this scale and feed-forward.
    #[must_use]
    pub fn new(uav: u16, scale: Scale, feed_forward: FeedForward) -> Self {
        Self {
            uav,
            scale,
            feed_forward,
            case: None,
            told: BTreeMap::new(),
            rebroadcast: BTreeMap::new(),
            decided: BTreeMap::new(),
            report: ReplayReport::default(),
        }
    }

    /// A setpoint in the log.
    pub fn flown(&mut self, frame: &Frame) {
        if let (Some(case), Some(flown)) = (&mut self.case, SetpointValues::read(frame)) {
            case.recorded.push(flown);
        }
    }

    /// A setpoint that is sent now.
    pub fn replayed_setpoint(&mut self, frame: &Frame) {
        if let (Some(case), Some(flown)) = (&mut self.case, SetpointValues::read(frame)) {
            case.replayed.push(flown);
        }
    }

    /// A message to the swarm in the log.
    pub fn told(&mut self, frame: &Frame) {
        if let Some((step, feature)) = feature(frame) {
            self.report.flown_actor = Some(feature.actor());
            self.told.insert(step, feature);
        }
    }

    /// A message to the swarm that is sent now.
    pub fn rebroadcast(&mut self, frame: &Frame) {
        if let Some((step, feature)) = feature(frame) {
            self.rebroadcast.insert(step, feature);
        }
    }

    /// A decision that is made now. Its own setpoint, sent in the same turn, follows.
    pub fn decided(&mut self, decision: &Decision, profile: &VelocityProfile) {
        self.close();
        self.decided.insert(decision.step, decision.action);
        self.report.decisions += 1;
        self.case = Some(Case { decision: *decision, profile: *profile, recorded: Vec::new(), replayed: Vec::new() });
    }

    /// The report, after the last record.
    #[must_use]
    pub fn finish(mut self, counters: &Counters) -> ReplayReport {
        self.close();
        for (&step, feature) in &self.told {
            let replayed = self.decided.get(&step).copied();
            let kind = match self.rebroadcast.get(&step) {
                Some(again) if again == feature => None,
                Some(_) => Some(DifferenceKind::Feature),
                None => Some(DifferenceKind::NotDecided),
            };
            self.report.features += 1;
            self.report.features_elsewhere += u64::from(kind == Some(DifferenceKind::NotDecided));
            let known = self.report.differences.iter().any(|d| d.step == step);
            if let Some(kind) = kind.filter(|_| !known) {
                let recorded = replayed.filter(|_| kind == DifferenceKind::Feature);
                self.report.differences.push(Difference { step, uav: self.uav, kind, recorded, replayed });
            }
        }
        self.report.differences.sort_by_key(|d| d.step);
        self.report.missed_decisions = counters.missed_decisions;
        self.report
    }

    fn close(&mut self) {
        let Some(case) = self.case.take() else { return };
        if case.recorded.is_empty() {
            self.report.without_setpoint += 1;
            return;
        }
        self.report.compared += 1;
        self.report.setpoints += case.recorded.len() as u64;
        let same = |(at, flown): &&(u32, SetpointValues)| {
            case.replayed.iter().any(|(other_at, other)| other_at == at && other.is(flown))
        };
        let other = case.recorded.iter().filter(|r| !same(r)).count() as u64;
        if other == 0 {
            self.report.equal += 1;
            return;
        }
        self.report.other_setpoints += other;
        let held = case.recorded.iter().all(|(_, flown)| flown.stands());
        let (kind, recorded) = if held && case.profile.action != Action::COAST {
            (DifferenceKind::NotFlown, None)
        } else {
            (DifferenceKind::Action, Some(self.nearest(&case)))
        };
        let replayed = case.decision.action;
        if recorded == Some(replayed) {
            self.report.equal += 1;
            return;
        }
        let step = case.decision.step;
        let replayed = Some(replayed);
        self.report.differences.push(Difference { step, uav: self.uav, kind, recorded, replayed });
    }

    /// The action that was flown: the one whose flight has most of the setpoints, for the gate's own are none of
    /// any action's, then the one whose flight is nearest; among equals the one decided now, for at the speed limit
    /// several actions ask for the same.
    fn nearest(&self, case: &Case) -> u8 {
        // A brake in between is the gate's or the operator's.
        let moves = case.recorded.iter().any(|(_, flown)| !flown.stands());
        let moving = || case.recorded.iter().filter(move |(_, flown)| !moves || !flown.stands());
        let fit = |index: u8| {
            let action = Action::new(index).unwrap_or(Action::COAST);
            let velocity = case.decision.state.velocity;
            let profile =
                VelocityProfile::new(action, case.profile.decided_ms, velocity, case.profile.from_mps(), self.scale);
            moving().fold((0_usize, 0.0), |(same, apart), (at, flown)| {
                let asked = SetpointValues::of(&profile, *at, self.feed_forward);
                (same + usize::from(asked.is(flown)), apart + asked.apart(flown))
            })
        };
        let own = case.decision.action;
        // What is sent now went through the gate, as what was sent in flight did.
        let through_the_gate = moving().fold((0_usize, 0.0), |(same, apart), (at, flown)| {
            let sent = case.replayed.iter().filter(|(sent_at, _)| sent_at == at).map(|(_, sent)| sent.apart(flown));
            let nearest = sent.fold(f64::INFINITY, f64::min);
            (same + usize::from(nearest <= SAME * SAME), apart + nearest)
        });
        let decided = if through_the_gate.1.is_finite() { through_the_gate } else { fit(own) };
        let allowed = SAME * SAME * case.recorded.len() as f64;
        (0..ACTIONS as u8)
            .fold((own, decided), |best, index| {
                let (same, apart) = fit(index);
                let is_better = same > best.1.0 || (same == best.1.0 && apart + allowed < best.1.1);
                if is_better { (index, (same, apart)) } else { best }
            })
            .0
    }
}

/// A step and its feature, but for the number of the message.
fn feature(frame: &Frame) -> Option<(u32, FeatureMessage)> {
    let Message::Feature(f) = neighbour_message(frame)? else { return None };
    let header = Header { sequence: 0, ..f.header() };
    Some((header.step, FeatureMessage::new(header, f.degree(), f.actor(), f.attention_source(), f.values()).ok()?))
}
