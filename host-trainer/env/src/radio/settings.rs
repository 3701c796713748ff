//! What a link does to datagrams.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Longest delay and longest jitter, ms: ten minutes.
const LONGEST_MS: u32 = 600_000;

/// Settings of a link. [`Default`] is the perfect one, which brings every datagram at once.
///
/// In text they are `key=value` with commas between, such as `loss=0.1,burst=3,delay_ms=2000`;
/// `perfect` stands for the default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RadioSettings {
    /// Share of datagrams that is lost, 0 to 1.
    pub loss: f64,
    /// Mean number of datagrams of one direction that are lost in a row (Gilbert and Elliott's
    /// model: a direction is either good or gone). At least 1/(1 − loss), which is what chance
    /// makes; none for chance, each datagram by itself.
    pub burst: Option<f64>,
    /// Time on the way, ms, up to ten minutes.
    pub delay_ms: u32,
    /// Time added to it, ms: uniform in 0 to this, up to ten minutes, drawn for each datagram.
    /// So one may overtake another.
    pub jitter_ms: u32,
    /// Share of datagrams that arrive twice, 0 to 1; the second copy has a jitter and a damage
    /// of its own.
    pub duplicate: f64,
    /// Share of datagrams, 0 to 1, that are held back until the next one of the same direction
    /// has arrived. At most one is held at a time, so at most every other one is.
    pub reorder: f64,
    /// Share of datagrams that arrive with 1 to 4 bits flipped, 0 to 1. Nothing stands in for
    /// a checksum: whoever sends datagrams without one learns what that means.
    pub corrupt: f64,
    /// How far the radio reaches, u (the limit is inside); none for everywhere.
    pub range_u: Option<f32>,
}

/// Names of the settings in text, in order.
pub const KEYS: [&str; 8] = ["loss", "burst", "delay_ms", "jitter_ms", "duplicate", "reorder", "corrupt", "range_u"];

/// A link that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RadioError {
    /// A share outside 0 to 1, or not a number.
    #[error("link: {key} = {value} is no share; use 0 to 1")]
    Share {
        /// Which setting.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// Bursts shorter than chance makes them, or not a finite number.
    #[error(
        "link: burst = {burst} with loss = {loss}; chance alone loses {least:.2} in a row: use more, or leave burst out"
    )]
    Burst {
        /// Mean length asked for.
        burst: f64,
        /// Share lost.
        loss: f64,
        /// Shortest mean length.
        least: f64,
    },
    /// A delay or a jitter that is too long.
    #[error("link: {key} = {ms}; use up to {LONGEST_MS} ms")]
    Long {
        /// Which setting.
        key: &'static str,
        /// Its value, ms.
        ms: u32,
    },
    /// A range below zero, or not a number.
    #[error("link: range_u = {0}; use a number above 0, or leave it out to reach everywhere")]
    Range(f32),
    /// More nodes than a link serves.
    #[error("link: {0} nodes; use 1 to {max}", max = super::MAX_NODES)]
    Nodes(usize),
    /// A policy that was made for another swarm.
    #[error("link: made for {nodes} UAVs, the scenario has {uavs}; make it for as many")]
    OtherNodes {
        /// UAVs it was made for.
        nodes: usize,
        /// UAVs in the scenario.
        uavs: usize,
    },
    /// A part of the text is not `key=value`.
    #[error("link: `{0}` is not key=value; an example is loss=0.1,burst=3,delay_ms=2000")]
    Form(String),
    /// No setting of this name.
    #[error("link: no setting `{0}`; there are {keys}", keys = KEYS.join(", "))]
    Unknown(String),
    /// A setting that comes twice.
    #[error("link: `{0}` is set twice")]
    Twice(&'static str),
    /// A value that is no number.
    #[error("link: {key} = `{value}` is not a number of this kind")]
    Value {
        /// Which setting.
        key: &'static str,
        /// Its value.
        value: String,
    },
}

impl RadioSettings {
    /// Checks every setting.
    ///
    /// # Errors
    /// The first setting that cannot be.
    pub fn validate(&self) -> Result<(), RadioError> {
        let shares =
            [("loss", self.loss), ("duplicate", self.duplicate), ("reorder", self.reorder), ("corrupt", self.corrupt)];
        if let Some(&(key, value)) = shares.iter().find(|(_, v)| !(0.0..=1.0).contains(v)) {
            return Err(RadioError::Share { key, value });
        }
        if let Some(burst) = self.burst {
            let least = 1.0 / (1.0 - self.loss);
            // With nothing or everything lost there are no bursts to speak of.
            let matters = self.loss > 0.0 && self.loss < 1.0;
            // A little less is a rounded 1/(1 − loss).
            if !burst.is_finite() || burst < 1.0 || (matters && burst < least - 0.005) {
                return Err(RadioError::Burst { burst, loss: self.loss, least });
            }
        }
        for (key, ms) in [("delay_ms", self.delay_ms), ("jitter_ms", self.jitter_ms)] {
            if ms > LONGEST_MS {
                return Err(RadioError::Long { key, ms });
            }
        }
        match self.range_u {
            Some(range) if !(range.is_finite() && range > 0.0) => Err(RadioError::Range(range)),
            _ => Ok(()),
        }
    }

    fn set(&mut self, key: &'static str, value: &str) -> Result<(), RadioError> {
        fn number<T: FromStr>(key: &'static str, value: &str) -> Result<T, RadioError> {
            value.parse().map_err(|_| RadioError::Value { key, value: value.to_owned() })
        }
        match key {
            "loss" => self.loss = number(key, value)?,
            "burst" => self.burst = Some(number(key, value)?),
            "delay_ms" => self.delay_ms = number(key, value)?,
            "jitter_ms" => self.jitter_ms = number(key, value)?,
            "duplicate" => self.duplicate = number(key, value)?,
            "reorder" => self.reorder = number(key, value)?,
            "corrupt" => self.corrupt = number(key, value)?,
            _ => self.range_u = Some(number(key, value)?),
        }
        Ok(())
    }
}

/// What [`FromStr`] reads, without what is as in the perfect link.
impl fmt::Display for RadioSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |v: f64| (v != 0.0).then(|| v.to_string());
        let time = |v: u32| (v != 0).then(|| v.to_string());
        let values = [
            share(self.loss),
            self.burst.map(|v| v.to_string()),
            time(self.delay_ms),
            time(self.jitter_ms),
            share(self.duplicate),
            share(self.reorder),
            share(self.corrupt),
            self.range_u.map(|v| v.to_string()),
        ];
        let set: Vec<_> = KEYS.iter().zip(values).filter_map(|(key, v)| Some(format!("{key}={}", v?))).collect();
        f.write_str(if set.is_empty() { "perfect" } else { "" })?;
        f.write_str(&set.join(","))
    }
}

impl FromStr for RadioSettings {
    type Err = RadioError;

    fn from_str(text: &str) -> Result<Self, RadioError> {
        let mut settings = Self::default();
        if text.trim() == "perfect" {
            return Ok(settings);
        }
        let mut seen = Vec::new();
        for part in text.split(',') {
            let Some((key, value)) = part.split_once('=') else {
                return Err(RadioError::Form(part.trim().to_owned()));
            };
            let Some(key) = KEYS.into_iter().find(|k| *k == key.trim()) else {
                return Err(RadioError::Unknown(key.trim().to_owned()));
            };
            if seen.contains(&key) {
                return Err(RadioError::Twice(key));
            }
            seen.push(key);
            settings.set(key, value.trim())?;
        }
        settings.validate()?;
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(text: &str) -> String {
        text.parse::<RadioSettings>().unwrap_err().to_string()
    }

    #[test]
    fn text_says_what_it_means() {
        let link: RadioSettings = "loss=0.25, burst=4 ,delay_ms=2000,range_u=34".parse().unwrap();
        let expected = RadioSettings {
            loss: 0.25,
            burst: Some(4.0),
            delay_ms: 2000,
            range_u: Some(34.0),
            ..RadioSettings::default()
        };
        assert_eq!(link, expected);
        assert_eq!(link.to_string(), "loss=0.25,burst=4,delay_ms=2000,range_u=34");
        assert_eq!("perfect".parse(), Ok(RadioSettings::default()));
        assert_eq!(RadioSettings::default().to_string(), "perfect");
    }

    #[test]
    fn what_cannot_be_is_named() {
        let cases: [(&str, &[&str]); 13] = [
            ("loss=1.5", &["loss = 1.5", "0 to 1"]),
            ("corrupt=NaN", &["corrupt = NaN", "0 to 1"]),
            ("duplicate=-0.1", &["duplicate = -0.1"]),
            ("loss=0.5,burst=1.5", &["burst = 1.5", "2.00 in a row"]),
            ("burst=inf", &["burst = inf"]),
            ("delay_ms=-1", &["delay_ms", "`-1`"]),
            ("delay_ms=1000000", &["delay_ms = 1000000", "600000 ms"]),
            ("range_u=0", &["range_u = 0", "above 0"]),
            ("loss", &["`loss` is not key=value"]),
            ("", &["`` is not key=value"]),
            ("los=0.1", &["no setting `los`", "loss, burst, delay_ms"]),
            ("loss=0.1,loss=0.2", &["`loss` is set twice"]),
            ("loss=much", &["loss = `much`"]),
        ];
        for (text, words) in cases {
            let said = error(text);
            assert!(words.iter().all(|w| said.contains(w)), "{text}: {said}");
        }
        // What chance makes, to two decimals, is allowed; and without loss any burst is.
        assert!("loss=0.3,burst=1.43".parse::<RadioSettings>().is_ok());
        assert!("burst=1".parse::<RadioSettings>().is_ok());
    }

    proptest! {
        #[test]
        fn what_is_shown_is_read_again(
            (loss, burst) in (0.0f64..=1.0, prop::option::of(1.0f64..50.0)),
            (delay_ms, jitter_ms) in (0u32..=600_000, 0u32..=600_000),
            [duplicate, reorder, corrupt] in prop::array::uniform3(0.0f64..=1.0),
            range_u in prop::option::of(0.1f32..1e6),
        ) {
            let link = RadioSettings { loss, burst, delay_ms, jitter_ms, duplicate, reorder, corrupt, range_u };
            match link.validate() {
                Ok(()) => prop_assert_eq!(link.to_string().parse(), Ok(link)),
                Err(e) => prop_assert_eq!(link.to_string().parse::<RadioSettings>(), Err(e)),
            }
        }
    }
}
