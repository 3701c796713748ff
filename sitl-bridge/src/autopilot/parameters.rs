//! The autopilot's parameters that a node relies on, read one by one beside everything else.

use super::parameter_values::ParameterValues;
use super::reliance::Rule;

/// Between two requests, ms: a slow radio keeps room for commands.
const SPACING_MS: i64 = 100;
/// What was not answered is asked for again after this, ms …
const AGAIN_MS: i64 = 1000;
/// … so often in all.
const ROUNDS: u8 = 4;

/// What is known of the parameters.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    values: ParameterValues,
    /// Rounds of requests that were begun, and the index of the next name in this one.
    round: u8,
    next: usize,
    due_ms: i64,
    finished: bool,
}

impl Parameters {
    pub const fn new() -> Self {
        Self { values: ParameterValues::new(), round: 0, next: 0, due_ms: i64::MIN / 2, finished: false }
    }

    /// Forgets what was answered and asks again.
    pub fn ask_again(&mut self) {
        *self = Self::new();
    }

    /// Whether all were answered, or asked for as often as they are.
    pub const fn is_finished(&self) -> bool {
        self.finished
    }

    /// What was told so far.
    pub const fn values(&self) -> &ParameterValues {
        &self.values
    }

    /// Takes in a value. Parameters that nobody relies on are passed over.
    pub fn take(&mut self, rules: &[Rule], name: &str, value: f64) {
        if let Some(name) = names(rules).find(|&known| known == name) {
            self.values.set(name, value);
        }
    }

    /// The name to ask for at `now_ms`, if one is due.
    pub fn poll(&mut self, rules: &[Rule], now_ms: i64) -> Option<&'static str> {
        if self.finished || now_ms < self.due_ms {
            return None;
        }
        if self.next == 0 && self.round > 0 {
            // The last round had its time. One that older versions lack is not waited for.
            let missing = rules.iter().any(|rule| rule.unknown.is_some() && rule.value(&self.values).is_none());
            if !missing || self.round == ROUNDS {
                self.finished = true;
                return None;
            }
        }
        let open = |name: &str| rules.iter().any(|rule| rule.has(name) && rule.value(&self.values).is_none());
        let found = names(rules).enumerate().skip(self.next).find(|(_, name)| open(name));
        self.round += u8::from(self.next == 0);
        if let Some((index, name)) = found {
            (self.next, self.due_ms) = (index + 1, now_ms + SPACING_MS);
            return Some(name);
        }
        self.finished = !rules.iter().any(|rule| rule.value(&self.values).is_none());
        (self.next, self.due_ms) = (0, now_ms + AGAIN_MS);
        None
    }
}

/// All names, those of other versions too.
fn names(rules: &[Rule]) -> impl Iterator<Item = &'static str> {
    rules.iter().flat_map(|rule| rule.names.iter().map(|&(name, _)| name))
}
