//! What hinders a start: heights above home, the place, and other UAVs.

use super::output::NodeOutput;
use super::state_machine::Node;
use crate::autopilot::{Notice, Odometry, Stage, VehicleState};
use crate::frame::Rejected;
use crate::mission::Mission;
use firmware_core::gate::{Phase, Reason, Verdict};

/// A layer lower than this above home is at the ground, m.
const LEAST_ABOVE_HOME_M: f64 = 2.0;
/// Least GPS_FIX_TYPE whose place is believed.
const LEAST_FIX: u8 = 3;

impl Node<'_> {
    /// Starts whatever the heights and whoever else flies: for flights that were recorded before there were such
    /// checks.
    pub const fn skip_start_checks(&mut self) {
        self.start_checks = false;
    }

    /// Why the vehicle must not fly the mission, once the gate would let it: in words, with what to do.
    pub(super) fn refusal(&self) -> Option<String> {
        let begins = matches!(self.gate.verdict(), Verdict::BringUp(_)) || self.gate.phase() == Phase::Flight;
        if !self.start_checks || !begins || self.autopilot.is_taking_off() {
            return None;
        }
        let (mission, id) = (&self.settings.mission, self.settings.id);
        let collisions = self.swarm_link.counts().get(Rejected::IdCollision);
        let layer = mission.layers.check(id).err().map(|error| error.to_string());
        layer
            .or_else(|| self.muster.refusal(collisions, self.timebase.now_ms()))
            .or_else(|| height_refusal(mission, id, &self.autopilot.state.odometry?))
    }

    /// Tells the operator who waits for a start what it waits for: while the gate lets nothing through the
    /// autopilot's client does not.
    pub(super) fn tell_what_is_missing(&mut self, out: &mut NodeOutput) {
        if self.autopilot.is_taking_off() && !self.autopilot.is_airborne() {
            out.notices.extend(self.muster.take_off(self.timebase.now_ms()));
        }
        let (state, mission) = (&self.autopilot.state, &self.settings.mission);
        if !matches!(self.autopilot.stage(), Stage::Idle | Stage::BringUp | Stage::Subscribing) {
            return;
        }
        let waits = self.gate.phase() == Phase::BringUp && !self.autopilot.is_airborne();
        let place = far_away(state, mission).or_else(|| {
            let outside = waits && self.gate.verdict().reason() == Some(Reason::OutsideFence);
            state.odometry.filter(|_| outside).map(|odometry| outside_fence(&odometry, mission))
        });
        if let Some(text) = place.filter(|_| !self.place_told) {
            self.place_told = true;
            out.notices.push(Notice::warning(text));
            return;
        }
        let is_silent = matches!(self.gate.verdict(), Verdict::Silent(_));
        let ready = self.autopilot.stage() != Stage::Subscribing;
        if let Some(missing) = state.missing().filter(|_| waits && is_silent && ready) {
            let now_ms = self.timebase.now_ms();
            self.autopilot.remind(now_ms, &mut out.notices, || format!("waiting for {missing}"));
        }
    }
}

/// Why the UAV's layer is no height to fly at from where the vehicle stands.
fn height_refusal(mission: &Mission, id: u16, odometry: &Odometry) -> Option<String> {
    let metres = |mm: i32| f64::from(mm) / 1000.0;
    let (layer_m, origin_m) = (metres(mission.layers.altitude_mm(id)), metres(mission.plane.alt_mm));
    let home_m = metres(odometry.alt_mm.saturating_sub(odometry.relative_mm));
    let above_home_m = origin_m + layer_m - home_m;
    let limits = mission.heights;
    let layer = format!("its layer, {layer_m:.1} m above the mission's origin, is {above_home_m:.1} m above home");
    if above_home_m < LEAST_ABOVE_HOME_M {
        return Some(format!(
            "{layer} ({home_m:.1} m above sea level): at or under the ground, {LEAST_ABOVE_HOME_M} m is the least. Is \
             origin.alt_m = {origin_m} this place's altitude, in metres above sea level? If so, raise altitude.base_m"
        ));
    }
    if above_home_m > limits.highest_above_home_m {
        return Some(format!(
            "{layer} ({home_m:.1} m above sea level), {} m is the limit (altitude.highest_above_home_m). Are \
             origin.alt_m = {origin_m} and the layers in metres, not in feet, and is that this place's altitude?",
            limits.highest_above_home_m
        ));
    }
    let apart_m = (home_m - origin_m).abs();
    (apart_m > limits.home_within_m).then(|| {
        format!(
            "{layer}: home lies {home_m:.1} m above sea level, {apart_m:.1} m {} the mission's origin, {} m is the limit \
             (altitude.home_within_m). Is origin.alt_m = {origin_m} this place's altitude, in metres above sea level, \
             not in feet?",
            if home_m < origin_m { "below" } else { "above" },
            limits.home_within_m
        )
    })
}

/// The vehicle's position lies beyond the mission's plane.
fn far_away(state: &VehicleState, mission: &Mission) -> Option<String> {
    let (lat, lon) = state.beyond?;
    state.gps_fix.filter(|&(fix, _)| fix >= LEAST_FIX)?;
    let [lat, lon] = [lat, lon].map(|e7| f64::from(e7) / 1e7);
    let (olat, olon) = mission.plane.origin_degrees();
    Some(format!(
        "the vehicle is at latitude {lat:.5}, longitude {lon:.5}, {:.0} km from the mission's origin at latitude {olat:.5}, \
         longitude {olon:.5}: is it this place's mission? (origin.lat, origin.lon)",
        mission.plane.distance_km(lat, lon)
    ))
}

/// The vehicle stands outside the fence.
fn outside_fence(odometry: &Odometry, mission: &Mission) -> String {
    let middle_mm = mission.side_u * mission.scale.unit_m * 500.0;
    let away_m = (odometry.place.east_mm - middle_mm).hypot(odometry.place.north_mm - middle_mm) / 1000.0;
    format!(
        "the vehicle is outside the mission's fence, {away_m:.0} m from the middle of its map: carry it there, or mend the \
         mission's origin or fence"
    )
}
