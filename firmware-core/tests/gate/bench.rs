//! A vehicle that does what it is told at once, and a gate that is asked every 200 ms.

use firmware_core::gate::{
    FlightMode, Gate, Geofence, Inputs, Limits, Measured, Phase, Proposal, Request, Setpoint, Vector, Verdict,
};

/// Time between ticks, ms.
pub const TICK_MS: u32 = 200;
/// Altitude that the actor asks for, mm.
pub const ALTITUDE_MM: i32 = 30_000;
/// Velocity that the actor asks for, mm/s.
pub const CRUISE: Vector = Vector::new(3000, -1000);

/// A gate and what it is fed.
pub struct Bench {
    pub gate: Gate,
    /// Inputs of the next tick; the clocks, the state and the decision's time are kept up to date.
    pub inputs: Inputs,
    /// Whether the state moves on, and by how much it is moved besides.
    pub frozen: bool,
    /// Whether telemetry of the state still comes.
    pub measuring: bool,
    /// Whether heartbeats still come.
    pub beating: bool,
    /// Whether the vehicle's clock still comes.
    pub linked: bool,
    /// Whether the actor still decides.
    pub deciding: bool,
    /// What the vehicle's clock shows.
    pub clock_ms: u32,
}

impl Bench {
    /// On the ground, healthy, nobody asked for anything.
    pub fn new(limits: Limits) -> Self {
        let side = Vector::new(1_000_000, 1_000_000);
        let fence = Geofence::rectangle(Vector::ZERO - side, side).unwrap();
        let clock_ms = 50_000;
        let inputs = Inputs {
            now_ms: None,
            wall_ms: 7_000_000,
            state: Some(Measured { altitude_mm: 0, ..Measured::default() }),
            ekf_ok: true,
            gps_fix: Some(3),
            mode: FlightMode::Other,
            battery_permille: Some(900),
            self_test: true,
            ..Inputs::default()
        };
        let gate = Gate::new(limits, fence).unwrap();
        Self { gate, inputs, frozen: false, measuring: true, beating: true, linked: true, deciding: true, clock_ms }
    }

    /// Started by the operator, in GUIDED and armed, but still climbing.
    pub fn in_takeoff(limits: Limits) -> Self {
        let mut bench = Self::new(limits);
        bench.inputs.operator = Some(Request::Start);
        let _ = bench.run(bench.gate.limits().clear_ms + TICK_MS);
        (bench.inputs.mode, bench.inputs.armed) = (FlightMode::Guided, true);
        assert_eq!(bench.tick(), Verdict::BringUp(None));
        bench
    }

    /// Climbs to the actor's altitude at 5 m/s.
    pub fn climb(&mut self) {
        while self.inputs.state.unwrap().altitude_mm < ALTITUDE_MM {
            self.inputs.state.as_mut().unwrap().altitude_mm += 1000;
            let _ = self.tick();
        }
    }

    /// In flight, streaming.
    pub fn in_flight(limits: Limits) -> Self {
        let mut bench = Self::in_takeoff(limits);
        bench.climb();
        bench.inputs.airborne = true;
        let _ = bench.run(4000);
        assert_eq!(bench.gate.phase(), Phase::Flight);
        assert!(matches!(bench.tick(), Verdict::Stream(_)));
        bench
    }

    /// One tick, [`TICK_MS`] after the last.
    pub fn tick(&mut self) -> Verdict {
        self.tick_after(TICK_MS, TICK_MS)
    }

    /// One tick after these times of the vehicle's clock and the own computer's.
    pub fn tick_after(&mut self, vehicle_ms: u32, wall_ms: u32) -> Verdict {
        self.clock_ms = self.clock_ms.wrapping_add(vehicle_ms);
        self.inputs.wall_ms = self.inputs.wall_ms.wrapping_add(wall_ms);
        let (now, inputs) = (self.clock_ms, &mut self.inputs);
        if self.linked {
            inputs.now_ms = Some(now);
            if self.beating {
                inputs.heartbeat_ms = Some(now);
            }
            if let Some(state) = inputs.state.as_mut().filter(|_| self.measuring) {
                state.time_ms = now;
                if !self.frozen {
                    state.position = state.position + state.velocity.scaled(vehicle_ms, 1000);
                }
            }
        }
        if self.deciding {
            inputs.proposal = Some(Proposal {
                decided_ms: now,
                velocity: CRUISE,
                acceleration: Vector::ZERO,
                altitude_mm: ALTITUDE_MM,
            });
        }
        let verdict = self.gate.tick(inputs);
        inputs.operator = None;
        if let (Some(state), Some(setpoint)) = (&mut inputs.state, verdict.setpoint())
            && self.measuring
            && self.linked
            && inputs.mode == FlightMode::Guided
            && !self.frozen
        {
            state.velocity = setpoint.velocity;
        }
        verdict
    }

    /// Ticks for this time; the last verdict.
    pub fn run(&mut self, ms: u32) -> Verdict {
        let ticks = ms.div_ceil(TICK_MS).max(1);
        (0..ticks).map(|_| self.tick()).last().unwrap()
    }
}

/// A setpoint that asks for standing still.
pub fn is_still(setpoint: Setpoint) -> bool {
    setpoint.velocity == Vector::ZERO && setpoint.acceleration == Vector::ZERO && setpoint.climb_mm_s == 0
}
