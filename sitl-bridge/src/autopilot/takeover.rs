//! Whose the vehicle is: the node's, or of whoever changed its mode.

use super::client::{Autopilot, set_mode_params};
use super::command::PendingCommand;
use super::firmware::{Firmware, Mode};
use super::stage::Stage;
use crate::messages::mav_cmd;

/// A change of mode that was accepted has this long to show in a heartbeat, ms: longer, and somebody
/// changed it back. The heartbeat has to come later than that.
const EFFECT_MS: i64 = 2500;
/// A vehicle that holds its place so far below its layer was stopped in its climb, mm.
const STOPPED_BELOW_MM: i32 = 2000;

impl Autopilot {
    /// Takes note of a setpoint that is sent.
    pub const fn note_setpoint(&mut self) {
        self.control.streams = true;
    }

    /// Takes note of the mode in a heartbeat.
    pub(super) fn note_mode(&mut self, now_ms: i64) {
        let Some((heartbeat, firmware)) = self.state.heartbeat.map(|(heartbeat, _)| heartbeat).zip(self.firmware)
        else {
            return;
        };
        // A command whose answer was lost shows by its effect.
        if heartbeat.armed
            && let Some(arming) = self.command.as_mut().filter(|c| c.command() == mav_cmd::COMPONENT_ARM_DISARM)
            && arming.is_sent()
        {
            arming.accept(now_ms);
            self.control.arm();
        }
        let takeoff = self.command.filter(|c| c.command() == mav_cmd::NAV_TAKEOFF);
        let still_comes = takeoff.is_some_and(|c| c.accepted_ms().is_none_or(|at| now_ms - at < EFFECT_MS));
        let control = &mut self.control;
        control.heard_ms = now_ms;
        let streams = std::mem::take(&mut control.streams);
        let before = control.last.replace((heartbeat.custom_mode, heartbeat.armed));
        if !heartbeat.armed && before.is_some_and(|(_, armed)| armed) {
            (control.armed_here, control.climbs) = (false, false);
        }
        control.took_off |= control.climbs && firmware.is_taking_off(heartbeat.custom_mode);
        match firmware.mode(heartbeat.custom_mode) {
            Mode::Guided => {
                (control.ours, control.climbs) = (true, false);
                control.was_guided |= self.bring_up.has_begun();
            }
            // As it was when it was ordered.
            _ if control.is_in_ordered_mode() => {}
            Mode::TakeoffOrHold => match before.map(|(custom_mode, _)| firmware.mode(custom_mode)) {
                // PX4 holds by itself when setpoints cease; while they come, somebody holds it.
                Some(Mode::Guided) => control.ours = !streams,
                Some(Mode::TakeoffOrHold) => control.ours |= control.climbs,
                _ => control.ours = control.climbs,
            },
            Mode::Other(custom_mode) => {
                // When setpoints cease PX4 changes by itself to what its pilot set, once; in a manual mode it is
                // the pilot's.
                let was_guided = before.is_some_and(|(mode, _)| firmware.mode(mode) == Mode::Guided);
                let by_itself = was_guided && !streams && firmware.is_automatic(custom_mode);
                let stays = control.ours && before.is_some_and(|(mode, _)| mode == custom_mode);
                let stays = stays && firmware.is_automatic(custom_mode);
                // PX4 is armed in the mode it was found in, and changes it by the takeoff.
                let waits = control.armed_here && self.bring_up.waits_on_ground(custom_mode, &self.state);
                control.ours = by_itself || stays || waits;
                control.climbs &= still_comes;
            }
        }
    }

    /// Who has the vehicle instead of the node, in words: it is armed in another mode before an automatic
    /// start, somebody else armed it, or its mode was changed since the bring-up began.
    pub(super) fn taken_over(&mut self) -> Option<String> {
        let heartbeat = self.state.heartbeat?.0;
        let firmware = self.firmware?;
        let mode = firmware.mode(heartbeat.custom_mode);
        let name = firmware.mode_name(heartbeat.custom_mode);
        if mode == Mode::Guided {
            return None;
        }
        if !self.bring_up.may_take() && !self.bring_up.has_begun() && heartbeat.armed {
            return Some(format!("it is armed and in {name}, so somebody flies it: type `start` to take it"));
        }
        let began = self.bring_up.begin(heartbeat.custom_mode, heartbeat.armed);
        // ArduPilot is armed in GUIDED only; PX4 on the ground.
        let armed_here =
            firmware == Firmware::Px4 && self.control.armed_here && !self.bring_up.is_up_by_another(&self.state);
        if heartbeat.armed && !began.armed && !armed_here {
            return Some(format!("somebody else armed it, in {name}; type `start` to take the vehicle"));
        }
        if self.is_mode_expected(firmware, heartbeat.custom_mode, began.custom_mode) {
            return None;
        }
        Some(format!("the mode is {name}: somebody else changed it; type `start` to take the vehicle"))
    }

    /// Whether a mode other than GUIDED is one that the bring-up passes through.
    fn is_mode_expected(&self, firmware: Firmware, custom_mode: u32, began_in: u32) -> bool {
        let heard_ms = self.control.heard_ms;
        let is_over = |command: PendingCommand| command.accepted_ms().is_some_and(|at| heard_ms - at >= EFFECT_MS);
        let mode_params = set_mode_params(firmware.guided());
        if self.command.filter(|c| c.is(mav_cmd::DO_SET_MODE, &mode_params)).is_some_and(is_over)
            || self.control.was_guided
        {
            return false;
        }
        // What PX4 itself changes to on its takeoff, and on nothing else once it is under way.
        let climbs = firmware.mode(custom_mode) == Mode::TakeoffOrHold;
        if firmware == Firmware::Px4 && self.bring_up.has_commanded_takeoff() {
            let takeoff = self.command.filter(|c| c.command() == mav_cmd::NAV_TAKEOFF);
            let shows = takeoff.is_none_or(is_over) || self.control.took_off;
            return if climbs {
                !self.is_stopped_below(firmware, custom_mode)
            } else {
                !shows && custom_mode == began_in
            };
        }
        custom_mode == began_in
    }

    /// Whether setpoints may go out before the mode that follows them, as PX4 requires: in a bring-up, and not
    /// while a takeoff does not show.
    #[must_use]
    pub fn takes_early_setpoints(&self) -> bool {
        let other = matches!(self.mode(), Some(Mode::Other(_)));
        self.firmware == Some(Firmware::Px4)
            && self.stage == Stage::BringUp
            && !(other && self.bring_up.has_commanded_takeoff())
    }

    /// Whether it holds its place though its takeoff was not over.
    fn is_stopped_below(&self, firmware: Firmware, custom_mode: u32) -> bool {
        let below = self.state.odometry.is_some_and(|o| self.bring_up.layer_mm() - o.alt_mm > STOPPED_BELOW_MM);
        self.control.took_off && !firmware.is_taking_off(custom_mode) && below
    }
}
