//! Reading the parameters that the node relies on, warning of what they cost, and refusing the start with them.

use super::client::Autopilot;
use super::notice::Notice;
use super::parameters::Parameters;
use super::reliance::{Circumstances, Rule, rules};
use super::standing::Speeds;
use crate::messages::{ParamRequestRead, ParameterValue};
use std::collections::BTreeMap;

/// What a node wants of the autopilot's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reliance {
    /// Whether a start is refused where a warning is due.
    pub strict: bool,
    /// The scenario's greatest speed and acceleration.
    pub speeds: Speeds,
}

/// The parameters of one autopilot.
#[derive(Clone, Debug)]
pub(super) struct ParameterWatch {
    reliance: Reliance,
    parameters: Parameters,
    /// Warnings that were told, by the rule's first name.
    told: BTreeMap<&'static str, String>,
    /// The strict check of this start was passed.
    passed: bool,
}

/// What the strict check says to a start.
pub(super) enum StrictCheck {
    Pass,
    /// Answers are still to come.
    Wait,
    /// Refused for this reason.
    Refuse(String),
}

impl ParameterWatch {
    pub const fn new(reliance: Reliance) -> Self {
        Self { reliance, parameters: Parameters::new(), told: BTreeMap::new(), passed: false }
    }

    /// Begins anew, as for another start.
    pub fn restart(&mut self) {
        self.parameters.ask_again();
        self.passed = false;
    }
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
        for (name, text) in self.findings() {
            if self.watch.told.get(name) != Some(&text) {
                notices.push(Notice::warning(text.clone()));
                self.watch.told.insert(name, text);
            }
        }
    }

    /// Whether the parameters allow a start.
    pub(super) fn strict_check(&mut self) -> StrictCheck {
        if !self.watch.reliance.strict || self.watch.passed {
            return StrictCheck::Pass;
        }
        if !self.watch.parameters.is_finished() {
            return StrictCheck::Wait;
        }
        let findings: Vec<String> = self.findings().into_iter().map(|(_, text)| text).collect();
        if !findings.is_empty() {
            return StrictCheck::Refuse(format!("--strict: {}", findings.join("; ")));
        }
        self.watch.passed = true;
        StrictCheck::Pass
    }

    /// What the parameters cost, in words; nothing before all had their time to be answered.
    fn findings(&self) -> Vec<(&'static str, String)> {
        let Some(firmware) = self.firmware.filter(|_| self.watch.parameters.is_finished()) else { return Vec::new() };
        let home_mm = self.state.odometry.map(|odometry| odometry.alt_mm - odometry.relative_mm);
        let at = Circumstances {
            system: self.identity.own_system(),
            speeds: self.watch.reliance.speeds,
            layer_m: home_mm.map(|home_mm| f64::from(self.bring_up.layer_mm() - home_mm) / 1000.0),
            others: &self.watch.parameters,
        };
        rules(firmware).iter().filter_map(|rule| Some((rule.names[0].0, finding(rule, &at)?))).collect()
    }
}

fn finding(rule: &Rule, at: &Circumstances<'_>) -> Option<String> {
    let Some((name, told, value)) = rule.value(at.others) else {
        let unknown = rule.unknown?;
        return Some(format!("the autopilot does not tell its {}: unknown is {unknown}", rule.names[0].0));
    };
    // As a float of 32 bits it was told.
    let told = (told * 1e4).round() / 1e4;
    Some(format!("{name} is {told}: {}", (rule.cost)(value, at)?))
}
