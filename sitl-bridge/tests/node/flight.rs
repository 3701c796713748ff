//! A node and its vehicle in virtual time.

pub use crate::mission::mission;
use crate::vehicle::{TICK_MS, Vehicle};
use firmware_core::actor::Actor;
use firmware_core::gate::Limits;
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Notice};
use sitl_bridge::frame::{Frame, Source};
use sitl_bridge::mission::{Mission, PoiMap};
use sitl_bridge::node::{
    Decision, FeedForward, HostTime, Node, NodeOutput, Settings, StepStart, StepTiming, gate_limits,
};
use sitl_bridge::signing::{LinkSigning, Session};
use std::sync::Arc;

/// Host time that a tick takes in a simulation, ms: it runs at twenty times real time.
const WALL_MS: u64 = 10;

pub fn actor() -> Actor<'static> {
    let bytes = include_bytes!("../../../firmware-core/tests/data/sample-gcn.actor");
    let actor = Actor::load(bytes).expect("sound");
    actor.self_test().expect("sound");
    actor
}

pub fn settings(id: u16, mission: &Mission, take_off: bool) -> Settings<'static> {
    Settings {
        id,
        system: id as u8 + 1,
        vehicle_system: 7,
        actor: actor(),
        mission: Arc::new(mission.clone()),
        pois: Arc::new(PoiMap::new(&mission.pois)),
        timing: StepTiming::default(),
        limits: gate_limits(Limits::simulation(), mission),
        feed_forward: FeedForward::Ramp,
        take_off,
        wait_for: 1,
        strict: false,
        rate_hz: 5.0,
        source: Source::Datagrams,
        autopilot_signing: LinkSigning::off(),
        swarm_signing: LinkSigning::off(),
        record: false,
        advice: "is it switched on?".into(),
    }
}

pub struct Flight {
    pub node: Node<'static>,
    pub vehicle: Vehicle,
    pub wall_ms: u64,
    /// Host time that a tick takes, ms.
    pub wall_ms_a_tick: u64,
    out: NodeOutput,
    pub notices: Vec<Notice>,
    pub begun: Vec<StepStart>,
    pub decisions: Vec<Decision>,
    /// Frames for the autopilot that a cut link lost.
    pub lost: Vec<Frame>,
    /// Frames for the swarm and the vehicle's time when they were sent.
    pub told: Vec<(u32, Frame)>,
}

impl Flight {
    pub fn new(id: u16, firmware: Firmware, take_off: bool) -> Self {
        Self::at(id, firmware, take_off, Vec2::from_u(100.0, 100.0))
    }

    pub fn at(id: u16, firmware: Firmware, take_off: bool, place: Vec2) -> Self {
        let mission = mission();
        let settings = settings(id, &mission, take_off);
        Self::with(settings, firmware, place)
    }

    pub fn with(settings: Settings<'static>, firmware: Firmware, place: Vec2) -> Self {
        let real_time = settings.limits.real_time;
        Self {
            vehicle: Vehicle::new(firmware, &settings.mission, place),
            node: Node::new(settings, Session::new()).unwrap(),
            wall_ms: 1_000_000,
            wall_ms_a_tick: if real_time { u64::from(TICK_MS) } else { WALL_MS },
            out: NodeOutput::default(),
            notices: Vec::new(),
            begun: Vec::new(),
            decisions: Vec::new(),
            lost: Vec::new(),
            told: Vec::new(),
        }
    }

    pub fn now(&self) -> HostTime {
        HostTime { wall_ms: self.wall_ms, unix_us: 1_790_000_000_000_000 + self.wall_ms * 1000 }
    }

    /// One tick of the vehicle; returns what the node told the swarm.
    pub fn tick(&mut self) -> Vec<Frame> {
        self.wall_ms += self.wall_ms_a_tick;
        let now = self.now();
        for frame in self.vehicle.tick() {
            assert!(self.node.receive_autopilot(frame.bytes(), now, &mut self.out), "the vehicle is not answered");
        }
        self.turn()
    }

    /// The vehicle's heartbeat, by itself between two ticks.
    pub fn heartbeat(&mut self) {
        let now = self.now();
        let frame = self.vehicle.heartbeat();
        assert!(self.node.receive_autopilot(frame.bytes(), now, &mut self.out), "the vehicle is not answered");
        self.turn();
    }

    /// A tick of the vehicle with the link cut.
    pub fn tick_unheard(&mut self) {
        self.vehicle.tick();
        self.wall_ms += self.wall_ms_a_tick;
        let now = self.now();
        self.node.tick(now, &mut self.out);
        self.notices.append(&mut self.out.notices);
        self.lost.append(&mut self.out.to_autopilot);
        self.out.clear();
    }

    /// A turn of the node in which only the host's time passes.
    pub fn idle(&mut self, wall_ms: u64) -> Vec<Frame> {
        self.wall_ms += wall_ms;
        self.turn()
    }

    fn turn(&mut self) -> Vec<Frame> {
        let now = self.now();
        self.node.tick(now, &mut self.out);
        for frame in std::mem::take(&mut self.out.to_autopilot) {
            self.vehicle.hear(&frame);
        }
        self.notices.append(&mut self.out.notices);
        self.begun.append(&mut self.out.steps);
        self.decisions.append(&mut self.out.decisions);
        let told = std::mem::take(&mut self.out.to_swarm);
        self.told.extend(told.iter().map(|&frame| (self.vehicle.boot_ms, frame)));
        self.out.clear();
        told
    }

    /// A tick of two vehicles, or of one that is not the node's.
    pub fn hear_all(&mut self, frames: &[Frame]) {
        self.wall_ms += self.wall_ms_a_tick;
        let now = self.now();
        for frame in frames {
            self.node.receive_autopilot(frame.bytes(), now, &mut self.out);
        }
        self.turn();
    }

    /// Something of the autopilot between two ticks.
    pub fn hear_autopilot(&mut self, frame: &Frame) {
        let now = self.now();
        self.node.receive_autopilot(frame.bytes(), now, &mut self.out);
        self.turn();
    }

    pub fn hear_swarm(&mut self, frame: &Frame) {
        let now = self.now();
        self.node.receive_swarm(frame.bytes(), now, &mut self.out);
    }

    pub fn ticks(&mut self, n: u32) {
        for _ in 0..n {
            self.tick();
        }
    }

    /// Ticks until `done` or for `seconds` of the vehicle's time; says whether it was done.
    pub fn until(&mut self, seconds: u32, done: impl Fn(&Self) -> bool) -> bool {
        for _ in 0..seconds * 1000 / TICK_MS {
            if done(self) {
                return true;
            }
            self.tick();
        }
        done(self)
    }

    pub fn said(&self, text: &str) -> bool {
        self.notices.iter().any(|notice| notice.text.contains(text))
    }

    pub fn words(&self) -> Vec<&str> {
        self.notices.iter().map(|notice| notice.text.as_str()).collect()
    }
}
