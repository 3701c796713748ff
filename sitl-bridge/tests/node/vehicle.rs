//! A vehicle for tests: an autopilot that answers at once and moves as it is told, in virtual
//! time. Just enough of ArduPilot's and PX4's ways to bring a node into flight.

use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::Firmware;
use sitl_bridge::frame::{Encoder, Frame};
use sitl_bridge::messages::{Telemetry, VELOCITY_AND_ACCELERATION, mav_cmd};
use sitl_bridge::mission::{Mission, Place};
use std::collections::BTreeMap;

/// A SET_POSITION_TARGET_LOCAL_NED as it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    /// Vehicle's clock when it arrived, ms.
    pub at_ms: u32,
    /// Time in it: vehicle's clock as the node last heard it, ms.
    pub boot_ms: u32,
    /// East and north, m/s.
    pub velocity: [f32; 2],
    /// Up, m/s.
    pub climb: f32,
    /// East and north, m/s².
    pub acceleration: [f32; 2],
}

pub struct Vehicle {
    pub firmware: Firmware,
    pub boot_ms: u32,
    pub unix_ms: i64,
    pub armed: bool,
    pub custom_mode: u32,
    /// East and north of the origin, mm.
    pub place: Place,
    /// Height above home.
    pub height_mm: f64,
    /// Home's altitude above the mission's origin, mm.
    pub home_mm: f64,
    /// What the estimator's height is wrong by, and by how much the GPS's differs from it, mm.
    pub height_error_mm: f64,
    pub gps_error_mm: f64,
    /// Flags that the estimator does not set.
    pub lost_flags: u16,
    pub velocity: [f64; 2],
    /// Where the autopilot's own takeoff climbs to, mm above home.
    target_mm: Option<f64>,
    /// Vertical speed that was asked for, m/s.
    climb: f64,
    /// Vertical speed in the last tick, m/s.
    climbs: f64,
    /// Velocity changes by no more than this, m/s²; at once where there is none.
    pub acceleration_mps2: Option<f64>,
    asked: [f64; 2],
    pub healthy: bool,
    pub battery: i8,
    /// Batteries told of by themselves: id, MAV_BATTERY_FUNCTION, percent.
    pub batteries: Vec<(u8, u8, i8)>,
    /// Commands heard: MAV_CMD and the parameters.
    pub commands: Vec<(u16, [f32; 7])>,
    pub setpoints: Vec<Setpoint>,
    pub heartbeats: u32,
    /// Answers to these commands: MAV_RESULT, 0 where there is none.
    pub refuse: Option<(u16, u8, &'static str)>,
    /// Commands are not answered.
    pub mute: bool,
    /// This command is neither carried out nor answered.
    pub ignore: Option<u16>,
    /// This command is carried out, and its answer is lost.
    pub lose_answers: Option<u16>,
    /// No HEARTBEAT is sent.
    pub without_heartbeats: bool,
    /// It climbs no higher, mm.
    pub ceiling_mm: Option<f64>,
    /// PX4 leaves OFFBOARD for AUTO.LOITER after so long without setpoints, ms.
    pub offboard_loss_ms: Option<u32>,
    /// SYSTEM_TIME has the time of day.
    pub knows_time: bool,
    pub with_local: bool,
    /// LOCAL_POSITION_NED carries no numbers.
    pub broken: bool,
    /// Kind of GPS fix.
    pub gps_fix: u8,
    /// Position and velocity go on being told as they were.
    pub frozen: Option<(Place, [f64; 2])>,
    /// ArduPilot after a boot: heartbeats only, until a rate of positions is requested.
    pub waits_for_rates: bool,
    /// Unix time that passes in a second of its own clock, s.
    pub unix_rate: f64,
    /// No positions are sent.
    pub without_positions: bool,
    /// Parameters that are told when asked for; by default none that costs anything.
    pub parameters: BTreeMap<&'static str, f32>,
    /// Names that were asked for.
    pub asked_for: Vec<String>,
    encoder: Encoder,
    replies: Vec<Frame>,
    ticks: u32,
    streamed_ms: Option<u32>,
    /// Time without setpoints, ms.
    unstreamed_ms: u32,
    mission: Mission,
}

pub const TICK_MS: u32 = 200;

/// PX4's parameters that are whole numbers.
const INTEGERS: [&str; 3] = ["COM_OBL_RC_ACT", "NAV_DLL_ACT", "GF_ACTION"];

/// What `docs/safety.md` recommends.
fn parameters(firmware: Firmware) -> BTreeMap<&'static str, f32> {
    let all: &[(&str, f32)] = match firmware {
        Firmware::ArduPilot => &[
            ("GUID_TIMEOUT", 1.0),
            ("FS_GCS_ENABLE", 1.0),
            ("MAV_GCS_SYSID", 1.0),
            ("MAV_GCS_SYSID_HI", 255.0),
            ("RTL_ALT_M", 5.0),
            ("FENCE_ENABLE", 1.0),
            ("FENCE_ACTION", 1.0),
            ("FENCE_TYPE", 7.0),
            ("FENCE_ALT_MAX", 100.0),
        ],
        Firmware::Px4 => &[
            ("COM_OF_LOSS_T", 1.0),
            ("COM_OBL_RC_ACT", 5.0),
            ("NAV_DLL_ACT", 2.0),
            ("RTL_RETURN_ALT", 5.0),
            ("GF_ACTION", 3.0),
        ],
    };
    all.iter().copied().collect()
}

impl Vehicle {
    pub fn new(firmware: Firmware, mission: &Mission, at: Vec2) -> Self {
        Self {
            firmware,
            boot_ms: 10_000,
            unix_ms: 1_790_000_000_000,
            armed: false,
            custom_mode: if firmware == Firmware::Px4 { (3 << 24) | (4 << 16) } else { 0 },
            place: mission.scale.place(at),
            height_mm: 0.0,
            home_mm: 0.0,
            height_error_mm: 0.0,
            gps_error_mm: 0.0,
            lost_flags: 0,
            velocity: [0.0; 2],
            target_mm: None,
            climb: 0.0,
            climbs: 0.0,
            acceleration_mps2: None,
            asked: [0.0; 2],
            healthy: true,
            battery: 90,
            batteries: Vec::new(),
            commands: Vec::new(),
            setpoints: Vec::new(),
            heartbeats: 0,
            refuse: None,
            mute: false,
            ignore: None,
            lose_answers: None,
            without_heartbeats: false,
            ceiling_mm: None,
            offboard_loss_ms: None,
            knows_time: true,
            with_local: true,
            broken: false,
            gps_fix: 3,
            frozen: None,
            waits_for_rates: false,
            unix_rate: 1.0,
            without_positions: false,
            parameters: parameters(firmware),
            asked_for: Vec::new(),
            encoder: Encoder::new(7, 1),
            replies: Vec::new(),
            ticks: 0,
            streamed_ms: None,
            unstreamed_ms: 0,
            mission: mission.clone(),
        }
    }

    /// Lets a tick pass and returns what the vehicle sends in it.
    pub fn tick(&mut self) -> Vec<Frame> {
        self.ticks += 1;
        self.boot_ms = self.boot_ms.wrapping_add(TICK_MS);
        self.unix_ms += (f64::from(TICK_MS) * self.unix_rate) as i64;
        let dt = f64::from(TICK_MS) / 1000.0;
        let height_mm = self.height_mm;
        if let Some(target) = self.target_mm {
            let target = self.ceiling_mm.map_or(target, |ceiling| target.min(ceiling));
            self.height_mm += (target - self.height_mm).clamp(-500.0, 500.0);
        }
        self.unstreamed_ms += TICK_MS;
        if self.offboard_loss_ms.is_some_and(|loss_ms| self.unstreamed_ms > loss_ms)
            && self.firmware == Firmware::Px4
            && self.is_guided()
        {
            self.custom_mode = (3 << 24) | (4 << 16);
            self.velocity = [0.0; 2];
        }
        self.height_mm += self.climb * dt * 1000.0;
        self.climbs = (self.height_mm - height_mm) / dt / 1000.0;
        if let Some(acceleration) = self.acceleration_mps2 {
            let change = [0, 1].map(|axis| self.asked[axis] - self.velocity[axis]);
            let share = (acceleration * dt / change[0].hypot(change[1]).max(1e-9)).min(1.0);
            self.velocity = [0, 1].map(|axis| self.velocity[axis] + change[axis] * share);
        }
        self.place.east_mm += self.velocity[0] * dt * 1000.0;
        self.place.north_mm += self.velocity[1] * dt * 1000.0;
        let mut out = std::mem::take(&mut self.replies);
        if self.ticks % 5 == 1 {
            if !self.without_heartbeats {
                out.push(self.heartbeat());
            }
            if self.waits_for_rates {
                return out;
            }
            let flags: u16 = match self.firmware {
                _ if !self.healthy => 0x3a7,
                // Seen on PX4: all ten flags on the ground, constant position among them.
                Firmware::Px4 if self.height_mm == 0.0 => 1023,
                _ => 0x33f,
            } & !self.lost_flags;
            let (id, at, len) = if self.firmware == Firmware::Px4 { (230, 40, 42) } else { (193, 20, 22) };
            let mut estimator = vec![0; len];
            estimator[at..].copy_from_slice(&flags.to_le_bytes());
            out.push(self.frame(id, &estimator));
            let mut gps = [0; 30];
            gps[16..20].copy_from_slice(&((self.altitude_mm() + self.gps_error_mm) as i32).to_le_bytes());
            gps[28] = self.gps_fix;
            out.push(self.frame(24, &gps));
            let mut status = [0; 31];
            status[30] = self.battery.to_le_bytes()[0];
            out.push(self.frame(1, &status));
            for (id, function, percent) in self.batteries.clone() {
                let mut status = [0; 36];
                (status[32], status[33], status[35]) = (id, function, percent.to_le_bytes()[0]);
                out.push(self.frame(147, &status));
            }
            let (lat, lon) = (self.mission.plane.lat_e7, self.mission.plane.lon_e7);
            out.push(self.frame(49, &[&lat.to_le_bytes()[..], &lon.to_le_bytes(), &[0; 4]].concat()));
            let unix_us = if self.knows_time { self.unix_ms as u64 * 1000 } else { 0 };
            out.push(self.frame(2, &[&unix_us.to_le_bytes()[..], &self.boot_ms.to_le_bytes()].concat()));
        }
        if self.without_positions || self.waits_for_rates {
            return out;
        }
        out.push(self.global());
        if self.with_local {
            out.push(self.local());
        }
        out
    }

    /// It boots again, as ArduPilot does.
    pub fn reboot(&mut self) {
        (self.boot_ms, self.armed, self.custom_mode, self.waits_for_rates) = (300, false, 0, true);
        (self.height_mm, self.velocity, self.target_mm, self.climb) = (0.0, [0.0; 2], None, 0.0);
    }

    /// The takeoff under way ends so much higher, mm.
    pub fn move_target(&mut self, by_mm: f64) {
        self.target_mm = self.target_mm.map(|target| target + by_mm);
    }

    /// The next heartbeat comes in a second.
    pub const fn restart_second(&mut self) {
        self.ticks = 1;
    }

    /// Whether the next tick tells of health, mode and time besides the position.
    pub const fn is_about_to_tell(&self) -> bool {
        self.ticks.is_multiple_of(5)
    }

    /// Horizontal, m/s.
    pub fn speed(&self) -> f64 {
        self.velocity[0].hypot(self.velocity[1])
    }

    /// What it tells of where it is and how fast.
    fn told(&self) -> (Place, [f64; 2]) {
        self.frozen.unwrap_or((self.place, self.velocity))
    }

    pub fn heartbeat(&mut self) -> Frame {
        let autopilot = if self.firmware == Firmware::Px4 { 12 } else { 3 };
        let base_mode = if self.armed { 0x81 } else { 0x01 };
        let mut payload = self.custom_mode.to_le_bytes().to_vec();
        payload.extend([2, autopilot, base_mode, 4, 3]);
        self.frame(0, &payload)
    }

    /// Above mean sea level by the estimator, mm.
    fn altitude_mm(&self) -> f64 {
        f64::from(self.mission.plane.alt_mm) + self.home_mm + self.height_mm + self.height_error_mm
    }

    fn global(&mut self) -> Frame {
        let (place, velocity) = self.told();
        let (lat, lon) = self.mission.plane.degrees_e7(place);
        let alt = self.altitude_mm() as i32;
        let mut payload = Vec::new();
        payload.extend(self.boot_ms.to_le_bytes());
        for v in [lat, lon, alt, (self.height_mm + self.height_error_mm) as i32] {
            payload.extend(v.to_le_bytes());
        }
        for v in [velocity[1], velocity[0], -self.climbs] {
            payload.extend(((v * 100.0) as i16).to_le_bytes());
        }
        payload.extend([0; 2]);
        self.frame(33, &payload)
    }

    fn local(&mut self) -> Frame {
        let metres = |mm: f64| (mm / 1000.0) as f32;
        let (place, velocity) = self.told();
        let north = if self.broken { f32::NAN } else { metres(place.north_mm) };
        let numbers = [
            north,
            metres(place.east_mm),
            -metres(self.height_mm + self.height_error_mm),
            velocity[1] as f32,
            velocity[0] as f32,
            -self.climbs as f32,
        ];
        let mut payload = self.boot_ms.to_le_bytes().to_vec();
        numbers.iter().for_each(|v| payload.extend(v.to_le_bytes()));
        self.frame(32, &payload)
    }

    fn text(&mut self, text: &str) -> Frame {
        let mut payload = vec![4];
        payload.extend(text.as_bytes());
        payload.resize(54, 0);
        self.frame(253, &payload)
    }

    fn frame(&mut self, id: u32, payload: &[u8]) -> Frame {
        self.encoder.encode_payload(id, payload).unwrap()
    }

    /// Takes in what the node sent.
    pub fn hear(&mut self, frame: &Frame) {
        match frame.message_id() {
            0 => self.heartbeats += 1,
            20 => self.tell_parameter(frame),
            76 => self.obey(frame),
            84 => self.follow(frame),
            other => panic!("the node sent message {other}"),
        }
    }

    /// Answers PARAM_REQUEST_READ.
    fn tell_parameter(&mut self, frame: &Frame) {
        let mut payload = frame.payload().to_vec();
        payload.resize(20, 0);
        assert_eq!(payload[..4], [0xff, 0xff, 7, 1], "by name, of this vehicle");
        let name = String::from_utf8(payload[4..].iter().copied().take_while(|&byte| byte != 0).collect()).unwrap();
        if let Some(&value) = self.parameters.get(name.as_str()).filter(|_| !self.mute) {
            let answer = self.parameter(&name, value);
            self.replies.push(answer);
        }
        self.asked_for.push(name);
    }

    /// PARAM_VALUE, with integers as each autopilot writes them.
    pub fn parameter(&mut self, name: &str, value: f32) -> Frame {
        let integer = self.firmware == Firmware::Px4 && INTEGERS.contains(&name);
        let (bytes, kind) = if integer { ((value as i32).to_le_bytes(), 6) } else { (value.to_le_bytes(), 9) };
        let mut payload = [&bytes[..], &[0; 4], name.as_bytes()].concat();
        payload.resize(24, 0);
        payload.push(kind);
        self.frame(22, &payload)
    }

    fn obey(&mut self, frame: &Frame) {
        let mut payload = frame.payload().to_vec();
        payload.resize(33, 0);
        let f = |i: usize| f32::from_le_bytes(payload[4 * i..4 * i + 4].try_into().unwrap());
        let params = [0, 1, 2, 3, 4, 5, 6].map(f);
        let id = u16::from_le_bytes([payload[28], payload[29]]);
        assert_eq!((payload[30], payload[31]), (7, 1), "addressed to somebody else");
        self.commands.push((id, params));
        if self.mute || self.ignore == Some(id) {
            return;
        }
        let result = match self.refuse {
            Some((refused, result, text)) if refused == id => {
                let text = self.text(text);
                self.replies.push(text);
                result
            }
            _ => self.carry_out(id, params),
        };
        if self.lose_answers == Some(id) {
            return;
        }
        let ack = self.frame(77, &[&id.to_le_bytes()[..], &[result]].concat());
        self.replies.push(ack);
    }

    fn carry_out(&mut self, id: u16, params: [f32; 7]) -> u8 {
        match (id, self.firmware) {
            (mav_cmd::SET_MESSAGE_INTERVAL, _) => {
                self.waits_for_rates &= params[0] != 33.0;
                0
            }
            (mav_cmd::COMPONENT_ARM_DISARM, Firmware::ArduPilot) if self.custom_mode != 4 => 4,
            (mav_cmd::COMPONENT_ARM_DISARM, _) => {
                self.armed = params[0] == 1.0;
                0
            }
            (mav_cmd::NAV_TAKEOFF, _) if !self.armed => 4,
            // As ArduPilot refuses it in the air.
            (mav_cmd::NAV_TAKEOFF, Firmware::ArduPilot) if self.height_mm > 0.0 || self.custom_mode != 4 => 4,
            (mav_cmd::NAV_TAKEOFF, Firmware::ArduPilot) => {
                self.target_mm = Some(f64::from(params[6]) * 1000.0);
                0
            }
            (mav_cmd::NAV_TAKEOFF, Firmware::Px4) => {
                assert!(params[4].is_nan() && params[5].is_nan());
                self.target_mm =
                    Some(f64::from(params[6]) * 1000.0 - f64::from(self.mission.plane.alt_mm) - self.home_mm);
                self.custom_mode = (2 << 24) | (4 << 16);
                0
            }
            (mav_cmd::DO_SET_MODE, Firmware::ArduPilot) => {
                self.custom_mode = params[1] as u32;
                0
            }
            (mav_cmd::DO_SET_MODE, Firmware::Px4) => {
                let offboard = params[1] == 6.0;
                let streamed = self.setpoints.len() >= 5 && self.streamed_ms == Some(self.boot_ms);
                if offboard && !streamed {
                    return 1;
                }
                self.custom_mode = ((params[2] as u32) << 24) | ((params[1] as u32) << 16);
                0
            }
            _ => 3,
        }
    }

    fn follow(&mut self, frame: &Frame) {
        let mut payload = frame.payload().to_vec();
        payload.resize(53, 0);
        let f = |at: usize| f32::from_le_bytes(payload[at..at + 4].try_into().unwrap());
        let numbers: Vec<f32> = (0..11).map(|i| f(4 + 4 * i)).collect();
        assert!(numbers.iter().all(|v| v.is_finite()), "a setpoint with {numbers:?}");
        assert_eq!(u16::from_le_bytes([payload[48], payload[49]]), VELOCITY_AND_ACCELERATION);
        assert_eq!((payload[50], payload[51], payload[52]), (7, 1, 1));
        (self.streamed_ms, self.unstreamed_ms) = (Some(self.boot_ms), 0);
        let setpoint = Setpoint {
            at_ms: self.boot_ms,
            boot_ms: u32::from_le_bytes(payload[..4].try_into().unwrap()),
            velocity: [numbers[4], numbers[3]],
            climb: -numbers[5],
            acceleration: [numbers[7], numbers[6]],
        };
        self.setpoints.push(setpoint);
        if self.is_guided() {
            // Setpoints take over from the takeoff.
            (self.target_mm, self.climb) = (None, f64::from(setpoint.climb));
            self.asked = setpoint.velocity.map(f64::from);
            if self.acceleration_mps2.is_none() {
                self.velocity = self.asked;
            }
        }
    }

    /// Whether a takeoff was accepted.
    pub const fn takes_off(&self) -> bool {
        self.target_mm.is_some()
    }

    pub fn is_guided(&self) -> bool {
        self.custom_mode == if self.firmware == Firmware::Px4 { 6 << 16 } else { 4 }
    }

    /// Whether its telemetry is readable by the node's own reader (a test of this vehicle).
    pub fn reads_back(frame: &Frame) -> bool {
        Telemetry::read(frame.message_id(), frame.payload()).is_some()
    }
}
