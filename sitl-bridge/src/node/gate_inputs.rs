//! The safety gate's inputs from vehicle, swarm and decision.

use super::host_time::HostTime;
use super::velocity_profile::{FeedForward, VelocityProfile, thousandths};
use crate::autopilot::{Autopilot, Mode};
use crate::mission::Mission;
use firmware_core::gate::{self, Inputs, Measured, Proposal, Request, Vector};

/// What an estimator or a GPS reported counts for this long, ms of the vehicle's clock.
const HEALTH_MS: u32 = 3000;

/// The gate's inputs besides the vehicle's telemetry.
#[derive(Clone, Copy, Debug)]
pub(super) struct GateContext<'a> {
    pub mission: &'a Mission,
    /// The UAV's id.
    pub id: u16,
    pub feed_forward: FeedForward,
    /// The flight last decided on.
    pub profile: Option<&'a VelocityProfile>,
    /// Vehicle's clock when a neighbour's message was last taken, ms.
    pub swarm_ms: Option<u32>,
    /// The operator's request since the gate was last asked.
    pub request: Option<Request>,
    pub height_doubted: bool,
    pub swarm_incomplete: bool,
}

/// The gate's inputs. Invalid numbers of the autopilot are reported once and then forgotten.
pub(super) fn gate_inputs(autopilot: &mut Autopilot, context: &GateContext<'_>, now: HostTime) -> Inputs {
    let invalid = autopilot.state.take_invalid();
    let vehicle = &autopilot.state;
    let now_ms = vehicle.now_ms();
    let fresh = |then: u32| now_ms.wrapping_sub(then) <= HEALTH_MS;
    let state = vehicle.odometry.map(|odometry| Measured {
        time_ms: odometry.boot_ms,
        position: Vector::new(odometry.place.east_mm.round() as i32, odometry.place.north_mm.round() as i32),
        altitude_mm: odometry.alt_mm.saturating_sub(context.mission.plane.alt_mm),
        velocity: Vector::new(thousandths(odometry.velocity_mps[0]), thousandths(odometry.velocity_mps[1])),
        climb_mm_s: thousandths(odometry.velocity_mps[2]),
    });
    let proposal = context.profile.map(|profile| {
        let (velocity, acceleration) = profile.at(now_ms, context.feed_forward);
        let altitude_mm = context.mission.layers.altitude_mm(context.id);
        Proposal { decided_ms: profile.decided_ms, velocity, acceleration, altitude_mm }
    });
    Inputs {
        now_ms: vehicle.clock.newest(),
        wall_ms: now.wall_ms as u32,
        state,
        refused: invalid,
        sources_disagree: vehicle.sources_disagree(),
        ekf_ok: vehicle.estimator.is_some_and(|(healthy, then)| healthy && fresh(then)),
        gps_fix: vehicle.gps_fix.filter(|&(_, then)| fresh(then)).map(|(kind, _)| kind),
        heartbeat_ms: vehicle.heartbeat.map(|(_, then)| then),
        battery_permille: vehicle.battery_percent().map(|percent| u16::from(percent) * 10),
        mode: match autopilot.mode() {
            None => gate::FlightMode::Unknown,
            Some(Mode::Guided) => gate::FlightMode::Guided,
            Some(Mode::TakeoffOrHold | Mode::Other(_)) => gate::FlightMode::Other,
        },
        armed: autopilot.is_armed(),
        airborne: autopilot.is_airborne(),
        swarm_ms: context.swarm_ms,
        height_doubted: context.height_doubted,
        swarm_incomplete: context.swarm_incomplete,
        // A node is only made with an actor that passed it.
        self_test: true,
        operator: context.request,
        proposal,
    }
}
