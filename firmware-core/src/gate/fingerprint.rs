//! One number that says "still the same gate", on every target.

use super::circle::Circle;
use super::geofence::Geofence;
use super::inputs::{FlightMode, Inputs, Measured, Proposal, Request};
use super::limits::{Limits, SwarmLoss};
use super::safety_gate::Gate;
use super::vector::Vector;
use super::verdict::Verdict;
use crate::hash::Fnv1a;
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Ticks in a full fingerprint.
pub const FINGERPRINT_TICKS: u32 = 20_000;

/// A hash over the verdicts of `ticks` ticks ([`FINGERPRINT_TICKS`] by convention) of one long made-up flight, in which a
/// reckless actor flies at the fence, everything goes wrong now and then, and the operator starts again. 0 when there is
/// no such gate, which does not happen.
#[must_use]
pub fn fingerprint(ticks: u32) -> u64 {
    let corners = [(0, 0), (180, 0), (180, 80), (80, 90), (70, 180), (0, 150)];
    let fence = Geofence::polygon(&corners.map(|(east, north)| Vector::new(east * 1000, north * 1000)));
    let circle = Circle { centre: Vector::new(60_000, 60_000), radius_mm: 110_000 };
    let limits = Limits { swarm_loss: SwarmLoss::Hold, real_time: false, ..Limits::default() };
    let gate = fence.and_then(|fence| fence.and_circle(circle)).ok().and_then(|fence| Gate::new(limits, fence).ok());
    let Some(mut gate) = gate else { return 0 };
    let mut flight = Flight::new();
    let mut hash = Fnv1a::new();
    for _ in 0..ticks {
        let verdict = gate.tick(flight.next());
        flight.follow(&verdict);
        add(&mut hash, &verdict);
    }
    hash.finish()
}

/// A vehicle that follows, and everything that happens to it.
struct Flight {
    random: Xoshiro128PlusPlus,
    inputs: Inputs,
    clock_ms: u32,
    state: Measured,
    /// What the actor proposes lasts for some ticks.
    proposal: Proposal,
}

impl Flight {
    fn new() -> Self {
        let state = Measured { position: Vector::new(40_000, 40_000), altitude_mm: 30_000, ..Measured::default() };
        Self {
            random: Xoshiro128PlusPlus::seed_from_u64(0x5afe),
            inputs: Inputs::default(),
            // The clock wraps on the way.
            clock_ms: u32::MAX - 600_000,
            state,
            proposal: Proposal::default(),
        }
    }

    /// Uniform in ±`reach`.
    fn part(&mut self, reach: i32) -> i32 {
        let span = u64::from(reach.unsigned_abs()) * 2 + 1;
        ((u64::from(self.random.next_u32()) * span) >> 32) as i32 - reach
    }

    fn vector(&mut self, reach: i32) -> Vector {
        Vector::new(self.part(reach), self.part(reach))
    }

    fn next(&mut self) -> &Inputs {
        let r = self.random.next_u32();
        self.clock_ms = self.clock_ms.wrapping_add(if r >> 28 == 0 { 1200 } else { 200 });
        // One tick in 64 something happens.
        let event = if r & 63 == 0 { (r >> 8) & 31 } else { 32 };
        match event {
            0 => self.clock_ms = self.clock_ms.wrapping_add_signed(self.part(30_000)),
            1 => self.state.position = self.vector(200_000),
            2 => self.state.altitude_mm = self.part(150_000),
            3 => self.state.velocity = self.vector(12_000),
            _ => {}
        }
        if r & 7 == 1 {
            self.proposal =
                Proposal { velocity: self.vector(7000), acceleration: self.vector(3000), ..Proposal::default() };
            // Mostly about where it flies, so that it is on its layer.
            let reach = if (r >> 20) & 7 == 0 { 100_000 } else { 2000 };
            self.proposal.altitude_mm = 30_000 + self.part(reach);
        }
        let now = self.clock_ms;
        (self.state.time_ms, self.proposal.decided_ms) = (now, now);
        // What goes wrong lasts for about eight ticks.
        let fault = if r & 63 == 0 { event } else { 32 };
        let heals = (r >> 13) & 7 == 0;
        let i = &mut self.inputs;
        let kept = |fault_now: bool, was: bool| fault_now || (was && !heals);
        i.wall_ms = i.wall_ms.wrapping_add(200);
        i.now_ms = Some(now);
        i.state = if kept(fault == 4, i.state.is_none_or(|s| now.wrapping_sub(s.time_ms) > 200)) {
            i.state
        } else {
            Some(self.state)
        };
        i.heartbeat_ms = if fault == 5 { i.heartbeat_ms } else { Some(now) };
        i.swarm_ms = if fault == 6 { None } else { Some(now) };
        i.refused = fault == 7;
        i.sources_disagree = kept(fault == 8, i.sources_disagree);
        i.ekf_ok = !kept(fault == 9, !i.ekf_ok);
        i.gps_fix = if kept(fault == 10, i.gps_fix == Some(1)) { Some(1) } else { Some(4) };
        i.mode = if kept(fault == 11, i.mode == FlightMode::Other) { FlightMode::Other } else { FlightMode::Guided };
        i.armed = fault != 12;
        i.airborne = !kept(fault == 13, !i.airborne);
        i.battery_permille = if kept(fault == 14, i.battery_permille == Some(100)) { Some(100) } else { Some(700) };
        i.self_test = fault != 15;
        i.height_doubted = kept(fault == 20, i.height_doubted);
        i.swarm_incomplete = kept(fault == 21, i.swarm_incomplete);
        i.proposal = if kept(fault == 16, i.proposal.is_none()) { None } else { Some(self.proposal) };
        i.operator = match fault {
            17 => Some(Request::Release),
            18 => Some(Request::Return),
            19.. if r >> 25 == 0 => Some(Request::Start),
            _ => None,
        };
        &self.inputs
    }

    /// Follows the setpoint, but for a gust.
    fn follow(&mut self, verdict: &Verdict) {
        if let Some(setpoint) = verdict.setpoint() {
            self.state.velocity = setpoint.velocity + self.vector(200);
            self.state.altitude_mm = self.state.altitude_mm.saturating_add(setpoint.climb_mm_s / 5);
        }
        self.state.position = self.state.position + self.state.velocity.scaled(200, 1000);
    }
}

/// Adds a verdict in words of 32 bits.
fn add(hash: &mut Fnv1a, verdict: &Verdict) {
    let kind = match verdict {
        Verdict::Silent(_) => 0,
        Verdict::BringUp(_) => 1,
        Verdict::Stream(_) => 2,
        Verdict::Hold(..) => 3,
        Verdict::Return(_) => 4,
    };
    let reason = verdict.reason().map_or(0, |reason| reason as u32 + 1);
    let setpoint = verdict.setpoint().unwrap_or_default();
    let limited = setpoint.limited;
    let flags = [limited.speed, limited.acceleration, limited.fence, limited.altitude];
    let flags = flags.into_iter().fold(0, |word, flag| word * 2 + u32::from(flag));
    let words = [
        kind,
        reason,
        flags,
        setpoint.velocity.east.cast_unsigned(),
        setpoint.velocity.north.cast_unsigned(),
        setpoint.climb_mm_s.cast_unsigned(),
        setpoint.acceleration.east.cast_unsigned(),
        setpoint.acceleration.north.cast_unsigned(),
        setpoint.altitude_mm.cast_unsigned(),
    ];
    words.into_iter().for_each(|word| hash.write_word(word));
}
