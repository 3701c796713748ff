//! Watching over what the autopilot sends: its message rates, who sends with its id, and its clock.

use super::client::Autopilot;
use super::message_rates::message_rates;
use super::notice::Notice;
use super::shared_id::Senders;
use super::stage::Stage;
use crate::messages::mav_cmd;

/// Without positions for so long, while heartbeats come, the rates are requested again, ms: a rebooted
/// ArduPilot sends nothing else until it is asked. Each time in vain the wait doubles, to 24 s.
const POSITIONS_MS: i64 = 3000;
const MOST_DOUBLED: u32 = 3;
/// Corrections of the clock are told at once, then summed over this, ms.
const CORRECTIONS_MS: i64 = 30_000;

impl Autopilot {
    /// Requests the message intervals one after another.
    pub(super) fn subscribe(&mut self, now_ms: i64) {
        if self.command.is_some_and(|command| command.is_accepted()) {
            self.next_rate += 1;
            self.command = None;
        }
        let Some(&(id, hz)) = message_rates(self.firmware, self.rate_hz).get(self.next_rate) else {
            (self.stage, self.positions_ms) = (Stage::Idle, now_ms);
            return;
        };
        let interval_us = (1e6 / hz).round() as f32;
        self.request(mav_cmd::SET_MESSAGE_INTERVAL, [id as f32, interval_us, 0.0, 0.0, 0.0, 0.0, 0.0], now_ms);
    }

    /// Requests the rates again when heartbeats come and positions do not, as after a reboot.
    pub(super) fn check_rates(&mut self, now_ms: i64, notices: &mut Vec<Notice>) {
        let wait_ms = POSITIONS_MS << self.asked_again.min(MOST_DOUBLED);
        let waits = matches!(self.stage, Stage::Idle | Stage::Flying) && !self.has_order();
        if !waits || now_ms - self.positions_ms < wait_ms {
            return;
        }
        if self.asked_again == 0 {
            notices.push(Notice::info("heartbeats come, and positions do not: asking for the message rates again"));
        }
        self.asked_again += 1;
        (self.stage, self.next_rate, self.command) = (Stage::Subscribing, 0, None);
    }

    /// Refuses to fly two vehicles at once.
    pub(super) fn check_senders(&mut self, notices: &mut Vec<Notice>) {
        let system = self.target.map_or(0, |(system, _)| system);
        match self.state.senders() {
            Senders::One => {}
            Senders::Doubtful => {
                if !std::mem::replace(&mut self.doubt_reported, true) {
                    notices.push(Notice::warning(format!(
                        "many messages of system {system} come out of order: do two vehicles send with this system id?"
                    )));
                }
            }
            Senders::Two => self.give_up(
                &format!("two vehicles send as system {system}: give each its own (MAV_SYSID, PX4: MAV_SYS_ID)"),
                notices,
            ),
        }
    }

    /// Tells of corrections of the clock: of the first at once, of others summed up.
    pub(super) fn report_corrections(&mut self, now_ms: i64, notices: &mut Vec<Notice>) {
        let (count, sum) = self.corrections;
        if count == 0 || now_ms - self.corrections_told_ms < CORRECTIONS_MS {
            return;
        }
        (self.corrections, self.corrections_told_ms) = ((0, 0), now_ms);
        let times = if count == 1 { String::new() } else { format!("{count} times, ") };
        notices.push(Notice::warning(format!("the autopilot corrected its clock {times}by {sum} ms")));
    }
}
