//! A node's settings.

use super::step_timing::StepTiming;
use super::velocity_profile::FeedForward;
use crate::autopilot::{Reliance, Speeds};
use crate::frame::Source;
use crate::mission::{Mission, PoiMap};
use crate::signing::LinkSigning;
use crate::swarm_link::{SwarmError, system_of};
use firmware_core::actor::Actor;
use firmware_core::gate::{GeofenceError, Limits, LimitsError};
use firmware_core::geometry::SPEED_CAP_U;
use std::sync::Arc;
use thiserror::Error;

/// Why no node can be made.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// The id has no MAVLink system id.
    #[error(transparent)]
    Swarm(#[from] SwarmError),
    /// The safety gate's limits contradict each other.
    #[error("the safety gate refuses the mission's settings: {0}")]
    Limits(#[from] LimitsError),
    /// The safety gate cannot use the mission's fence.
    #[error("the mission's fence cannot be used: {0}")]
    Fence(#[from] GeofenceError),
}

/// A node's settings.
#[derive(Clone, Debug)]
pub struct Settings<'a> {
    /// The UAV's id, 0 to 254.
    pub id: u16,
    /// MAVLink system id of the node on the autopilot's link.
    pub system: u8,
    /// MAVLink system id of the vehicle to fly; other vehicles on the link are not listened to.
    pub vehicle_system: u8,
    /// The actor, which has passed its self-test on this computer.
    pub actor: Actor<'a>,
    /// The mission.
    pub mission: Arc<Mission>,
    /// The mission's PoIs.
    pub pois: Arc<PoiMap>,
    /// The phases of a step.
    pub timing: StepTiming,
    /// The safety gate's limits; see [`gate_limits`].
    pub limits: Limits,
    /// Which acceleration setpoints feed forward.
    pub feed_forward: FeedForward,
    /// Whether the node arms the vehicle and takes off by itself.
    pub take_off: bool,
    /// So many UAVs start together, this one included: none moves sideways before all of them are in the air.
    /// With one each flies as soon as it is on its layer.
    pub wait_for: u16,
    /// Whether a start is refused while a parameter of the autopilot costs what `docs/safety.md` says;
    /// otherwise it is warned of.
    pub strict: bool,
    /// Rate at which positions are requested, Hz.
    pub rate_hz: f64,
    /// Whether the autopilot's link carries datagrams or a stream.
    pub source: Source,
    /// Signing of the autopilot's link.
    pub autopilot_signing: LinkSigning,
    /// Signing of the swarm's link.
    pub swarm_signing: LinkSigning,
    /// Whether received frames are handed out in [`super::NodeOutput::received`].
    pub record: bool,
    /// What the operator should check when the autopilot is not heard.
    pub advice: String,
}

impl<'a> Settings<'a> {
    /// UAV `id` with `actor`, which has passed its self-test, on `mission`, with the limits of real
    /// flight: its vehicle has system id + 1, it waits for its pilot to take off, requests five positions a second from a link with
    /// datagrams, and signs nothing.
    #[must_use]
    pub fn new(id: u16, actor: Actor<'a>, mission: Arc<Mission>) -> Self {
        Self {
            id,
            system: system_of(id).unwrap_or(u8::MAX),
            vehicle_system: system_of(id).unwrap_or(u8::MAX),
            actor,
            pois: Arc::new(PoiMap::new(&mission.pois)),
            timing: StepTiming::default(),
            limits: gate_limits(Limits::default(), &mission),
            feed_forward: FeedForward::Ramp,
            take_off: false,
            wait_for: 1,
            strict: false,
            rate_hz: 5.0,
            source: Source::Datagrams,
            autopilot_signing: LinkSigning::off(),
            swarm_signing: LinkSigning::off(),
            record: false,
            advice: String::new(),
            mission,
        }
    }

    /// What the node wants of the autopilot's parameters.
    pub(super) fn reliance(&self) -> Reliance {
        let scale = self.mission.scale;
        let cap = SPEED_CAP_U as f32;
        let speeds = Speeds { speed_mps: scale.mps(cap), acceleration_mps2: scale.mps2(cap) };
        Reliance { strict: self.strict, speeds }
    }
}

/// A vehicle on its layer may always be so far from it, mm: what a climb overshoots by.
const LEAST_LAYER_MM: u32 = 1500;

/// The safety gate's limits for a mission: `base` (real flight, simulation or ideal) adapted to its
/// scale, step length and altitude layers.
#[must_use]
pub fn gate_limits(base: Limits, mission: &Mission) -> Limits {
    let flight = Limits::default();
    let scale = mission.scale;
    // As much above the scenario's limits as `base` is above real flight's.
    let ratio = |ours: u32, flight: u32| f64::from(ours) / f64::from(flight);
    let speed = scale.mps(SPEED_CAP_U as f32) * ratio(base.max_speed_mm_s, flight.max_speed_mm_s);
    let acceleration =
        scale.mps2(SPEED_CAP_U as f32) * ratio(base.max_acceleration_mm_s2, flight.max_acceleration_mm_s2);
    // A diagonal of whole mm/s² may be longer than it should be by one.
    let acceleration_mm_s2 = (acceleration * 1000.0).ceil() as u32 + 2;
    let layers = mission.layers;
    let steps = |n: f64| (n * f64::from(scale.step_ms)) as u32;
    Limits {
        max_speed_mm_s: (speed * 1000.0).ceil() as u32 + 2,
        max_acceleration_mm_s2: acceleration_mm_s2,
        braking_mm_s2: base.braking_mm_s2.min(acceleration_mm_s2),
        altitude_floor_mm: base.altitude_floor_mm.min((layers.base_m * 500.0) as i32),
        altitude_ceiling_mm: (layers.highest_m() * 1000.0) as i32 + 10_000,
        layer_mm: ((layers.spacing_m * 500.0) as u32).max(LEAST_LAYER_MM),
        decision_ms: steps(2.25),
        swarm_ms: steps(3.0),
        // For PX4; the node sends them to no other autopilot.
        stream_before_mode: true,
        ..base
    }
}
