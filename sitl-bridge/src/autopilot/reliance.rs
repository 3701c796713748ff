//! What a node relies on in the autopilot's parameters, and what it costs where they are otherwise.
//!
//! Names, values and defaults are those of ArduCopter 4.7 and PX4 1.15; `docs/safety.md` has the table for
//! operators.

use super::firmware::Firmware;
use super::parameter_values::ParameterValues;
use super::standing::{Speeds, left_standing_m};

/// Longest time without setpoints that costs no more than it must, s; and its rounding.
const TIMEOUT_S: f64 = 1.05;
/// Shorter than this, and two setpoints that are late make the vehicle brake, s.
const SHORTEST_S: f64 = 0.45;
/// A fence's ceiling that is so near above a layer is felt there, m.
const BELOW_CEILING_M: f64 = 2.0;
/// Bit of FENCE_TYPE: the fence has a ceiling.
const CEILING: u32 = 1;

/// What the cost of a value depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circumstances<'a> {
    /// System that the node sends as.
    pub system: u8,
    pub speeds: Speeds,
    /// Height of the vehicle's layer above its home, m, once home is known.
    pub layer_m: Option<f64>,
    pub others: &'a ParameterValues,
}

/// What is relied on in one parameter.
#[derive(Debug)]
pub(super) struct Rule {
    /// Its name, those of other versions, and what to multiply their values with.
    pub names: &'static [(&'static str, f64)],
    /// What it may cost when the autopilot does not tell it; `None` where versions without it are as good.
    pub unknown: Option<&'static str>,
    /// What a value costs; `None` when nothing.
    pub cost: fn(f64, &Circumstances<'_>) -> Option<String>,
}

impl Rule {
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|&(known, _)| known == name)
    }

    /// The name under which the autopilot told it, the value it told, and that value in the unit of the first
    /// name.
    pub fn value(&self, values: &ParameterValues) -> Option<(&'static str, f64, f64)> {
        self.names.iter().find_map(|&(name, unit)| {
            let told = values.get(name)?;
            Some((name, told, told * unit))
        })
    }
}

/// The rules for a firmware.
pub(super) const fn rules(firmware: Firmware) -> &'static [Rule] {
    match firmware {
        Firmware::ArduPilot => &ARDUPILOT,
        Firmware::Px4 => &PX4,
    }
}

const ARDUPILOT: [Rule; 9] = [
    Rule {
        names: &[("GUID_TIMEOUT", 1.0)],
        unknown: Some("how far the vehicle goes on when the node dies"),
        cost: timeout,
    },
    Rule {
        names: &[("FS_GCS_ENABLE", 1.0)],
        unknown: Some("whether anything happens when the node dies"),
        cost: |value, _| {
            (value == 0.0).then(|| {
                "nothing happens when the node dies: the vehicle hovers until its battery is low. 1 returns".into()
            })
        },
    },
    Rule { names: &[("MAV_GCS_SYSID_HI", 1.0)], unknown: None, cost: |_, _| None },
    Rule {
        names: &[("MAV_GCS_SYSID", 1.0), ("SYSID_MYGCS", 1.0)],
        unknown: Some("whether the node's heartbeats count"),
        cost: ground_station,
    },
    Rule {
        names: &[("RTL_ALT_M", 1.0), ("RTL_ALT", 0.01)],
        unknown: Some("whether vehicles keep their altitude layers on a return"),
        cost: return_altitude,
    },
    Rule {
        names: &[("FENCE_ENABLE", 1.0)],
        unknown: Some("whether the autopilot has a fence of its own"),
        cost: |value, _| {
            (value == 0.0).then(|| "the autopilot has no fence of its own: nothing but this node keeps one".into())
        },
    },
    Rule {
        names: &[("FENCE_ACTION", 1.0)],
        unknown: None,
        cost: |value, at| {
            let only_told = value == 0.0 && fenced(at);
            only_told.then(|| "the autopilot only tells of its own fence, and flies through it".into())
        },
    },
    Rule { names: &[("FENCE_TYPE", 1.0)], unknown: None, cost: |_, _| None },
    Rule { names: &[("FENCE_ALT_MAX", 1.0)], unknown: None, cost: ceiling },
];

const PX4: [Rule; 5] = [
    Rule {
        names: &[("COM_OF_LOSS_T", 1.0)],
        unknown: Some("how far the vehicle goes on when the node dies"),
        cost: timeout,
    },
    Rule {
        names: &[("COM_OBL_RC_ACT", 1.0)],
        unknown: Some("what happens when setpoints cease"),
        cost: |value, _| {
            let mode = match value as i64 {
                3..=5 => return None,
                0 => "Position",
                1 => "Altitude",
                2 => "Stabilized",
                _ => return Some("when setpoints cease the motors are stopped in the air. 5 holds the place".into()),
            };
            Some(format!(
                "when setpoints cease the autopilot changes to {mode} mode, for a pilot at the sticks. 5 holds the place"
            ))
        },
    },
    Rule {
        names: &[("NAV_DLL_ACT", 1.0)],
        unknown: Some("whether anything happens when the ground station is lost"),
        cost: |value, _| {
            match value as i64 {
            0 => Some(
                "when node and ground station are lost nothing brings the vehicle home: it hovers until its battery is \
                 low. 2 returns, and needs a ground station to arm"
                    .into(),
            ),
            5.. => Some("when the ground station is lost the motors are stopped in the air. 2 returns".into()),
            _ => None,
        }
        },
    },
    Rule {
        names: &[("RTL_RETURN_ALT", 1.0)],
        unknown: Some("whether vehicles keep their altitude layers on a return"),
        cost: return_altitude,
    },
    Rule {
        names: &[("GF_ACTION", 1.0)],
        unknown: Some("what happens at the autopilot's own fence"),
        cost: |value, _| {
            let only_told = value < 2.0;
            only_told.then(|| "the autopilot only tells of its own fence, and flies through it. 3 returns".into())
        },
    },
];

/// How long the last setpoint is followed.
fn timeout(seconds: f64, at: &Circumstances<'_>) -> Option<String> {
    let metres = |seconds| left_standing_m(seconds, at.speeds).ceil();
    if seconds > TIMEOUT_S {
        let (far, near) = (metres(seconds), metres(1.0));
        return Some(format!("after the node dies the vehicle goes on for up to {far} m; with 1 it is {near} m"));
    }
    (seconds < SHORTEST_S).then(|| "the vehicle brakes whenever two setpoints are late. 1 is long enough".into())
}

/// Whose heartbeats ArduPilot watches.
fn ground_station(first: f64, at: &Circumstances<'_>) -> Option<String> {
    // From 4.7 on a range of systems may be ground stations; its end counts where it is not below its beginning.
    let last = at.others.get("MAV_GCS_SYSID_HI").map_or(first, |last| last.max(first));
    let own = f64::from(at.system);
    (own < first || own > last).then(|| {
        format!(
            "heartbeats of this node, which sends as system {own}, do not count: nothing happens when it dies. Set it \
             to {own}, or start with --system {first}"
        )
    })
}

/// The height to which a return climbs first, above home; 0 or less keeps the present one.
fn return_altitude(altitude_m: f64, at: &Circumstances<'_>) -> Option<String> {
    let layer_m = at.layer_m.filter(|&layer_m| altitude_m > 0.0 && layer_m < altitude_m)?;
    Some(format!(
        "on a return this vehicle climbs from its layer, {layer_m:.0} m above home, to {altitude_m:.0} m, as all do that \
         fly lower: they lose their altitude layers. Choose less than the lowest layer"
    ))
}

fn fenced(at: &Circumstances<'_>) -> bool {
    at.others.get("FENCE_ENABLE").is_some_and(|enabled| enabled != 0.0)
}

/// The ceiling of ArduPilot's own fence, above home.
fn ceiling(ceiling_m: f64, at: &Circumstances<'_>) -> Option<String> {
    let layer_m = at.layer_m.filter(|&layer_m| fenced(at) && layer_m + BELOW_CEILING_M > ceiling_m)?;
    // Its default is all kinds.
    let has_ceiling = at.others.get("FENCE_TYPE").is_none_or(|kinds| kinds as u32 & CEILING != 0);
    has_ceiling.then(|| {
        format!(
            "the autopilot's own fence ends below this vehicle's layer, {layer_m:.0} m above home: it returns there"
        )
    })
}
