//! Reading the parameters that the node relies on, warning of what they cost, and refusing the start with them.

use super::client::Autopilot;
use super::notice::Notice;
use super::reliance::{Circumstances, Rule, rules};
use crate::messages::{ParamRequestRead, ParameterValue};

/// What the strict check says to a start.
enum StrictCheck {
    Pass,
    /// Answers are still to come.
    Wait,
    /// Refused for this reason.
    Refuse(String),
}

impl Autopilot {
    /// The parameter to ask the autopilot for at `now_ms` of the node's clock, if one is due. It waits for
    /// nothing, and nothing but a strict start waits for it.
    pub fn poll_parameters(&mut self, now_ms: i64) -> Option<ParamRequestRead> {
        self.target?;
        let name = self.watch.parameters.poll(rules(self.firmware?), now_ms)?;
        Some(ParamRequestRead { name })
    }

    pub(super) fn take_parameter(&mut self, value: &ParameterValue) {
        let Some(firmware) = self.firmware else { return };
        self.watch.parameters.take(rules(firmware), &value.name, firmware.parameter(value));
    }

    /// Tells what the parameters cost, each time it is another thing.
    pub(super) fn report_parameters(&mut self, notices: &mut Vec<Notice>) {
        for finding in self.findings() {
            // Once for each value: the height above home in the words is never quite the same.
            if self.watch.told.insert(finding.name, finding.value) != Some(finding.value) {
                notices.push(Notice::warning(finding.text));
            }
        }
    }

    /// Whether the parameters allow a start.
    fn strict_check(&mut self) -> StrictCheck {
        if !self.watch.reliance.strict || self.watch.passed {
            return StrictCheck::Pass;
        }
        if !self.watch.parameters.is_finished() {
            return StrictCheck::Wait;
        }
        let findings: Vec<String> = self.findings().into_iter().map(|finding| finding.text).collect();
        if !findings.is_empty() {
            return StrictCheck::Refuse(format!("--strict: {}", findings.join("; ")));
        }
        self.watch.passed = true;
        StrictCheck::Pass
    }

    /// Whether the parameters allow a start; if not, the operator is told.
    pub(super) fn may_fly(&mut self, now_ms: i64, notices: &mut Vec<Notice>) -> bool {
        match self.strict_check() {
            StrictCheck::Pass => return true,
            StrictCheck::Wait => self.remind(now_ms, notices, || "waiting for the autopilot's parameters".into()),
            StrictCheck::Refuse(reason) => self.give_up(&reason, notices),
        }
        false
    }

    /// What the parameters cost, in words; nothing before all had their time to be answered.
    fn findings(&self) -> Vec<Finding> {
        let Some(firmware) = self.firmware.filter(|_| self.watch.parameters.is_finished()) else { return Vec::new() };
        let home_mm = self.state.odometry.map(|odometry| odometry.alt_mm - odometry.relative_mm);
        let at = Circumstances {
            system: self.identity.own_system(),
            speeds: self.watch.reliance.speeds,
            layer_m: home_mm.map(|home_mm| f64::from(self.bring_up.layer_mm() - home_mm) / 1000.0),
            others: self.watch.parameters.values(),
        };
        rules(firmware).iter().filter_map(|rule| finding(rule, &at)).collect()
    }
}

/// What a parameter costs.
struct Finding {
    /// The rule's first name.
    name: &'static str,
    /// The value that was told.
    value: Option<f64>,
    text: String,
}

fn finding(rule: &Rule, at: &Circumstances<'_>) -> Option<Finding> {
    let first = rule.names[0].0;
    let Some((name, told, value)) = rule.value(at.others) else {
        let text = format!("the autopilot does not tell its {first}: unknown is {}", rule.unknown?);
        return Some(Finding { name: first, value: None, text });
    };
    // As a float of 32 bits it was told.
    let rounded = (told * 1e4).round() / 1e4;
    let text = format!("{name} is {rounded}: {}", (rule.cost)(value, at)?);
    Some(Finding { name: first, value: Some(told), text })
}
