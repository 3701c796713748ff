//! The parameters of the channel model as text: `key=value`, with commas between.

use super::error::RadioError;
use super::parameters::KEYS;
use super::settings::RadioSettings;
use std::fmt;
use std::str::FromStr;

/// The text that [`FromStr`] reads, without the parameters that are as in the perfect channel.
impl fmt::Display for RadioSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let probability = |v: f64| (v != 0.0).then(|| v.to_string());
        let time = |v: u32| (v != 0).then(|| v.to_string());
        let values = [
            probability(self.loss),
            self.burst.map(|v| v.to_string()),
            time(self.delay_ms),
            time(self.jitter_ms),
            probability(self.duplicate),
            probability(self.reorder),
            probability(self.corrupt),
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
                return Err(RadioError::Syntax(part.trim().to_owned()));
            };
            let Some(key) = KEYS.into_iter().find(|k| *k == key.trim()) else {
                return Err(RadioError::Unknown(key.trim().to_owned()));
            };
            if seen.contains(&key) {
                return Err(RadioError::Twice(key));
            }
            seen.push(key);
            set(&mut settings, key, value.trim())?;
        }
        settings.validate()?;
        Ok(settings)
    }
}

/// Sets one of [`KEYS`].
fn set(settings: &mut RadioSettings, key: &'static str, value: &str) -> Result<(), RadioError> {
    fn number<T: FromStr>(key: &'static str, value: &str) -> Result<T, RadioError> {
        value.parse().map_err(|_| RadioError::Value { key, value: value.to_owned() })
    }
    match key {
        "loss" => settings.loss = number(key, value)?,
        "burst" => settings.burst = Some(number(key, value)?),
        "delay_ms" => settings.delay_ms = number(key, value)?,
        "jitter_ms" => settings.jitter_ms = number(key, value)?,
        "duplicate" => settings.duplicate = number(key, value)?,
        "reorder" => settings.reorder = number(key, value)?,
        "corrupt" => settings.corrupt = number(key, value)?,
        _ => settings.range_u = Some(number(key, value)?),
    }
    Ok(())
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
        let settings: RadioSettings = "loss=0.25, burst=4 ,delay_ms=2000,range_u=34".parse().unwrap();
        let expected = RadioSettings {
            loss: 0.25,
            burst: Some(4.0),
            delay_ms: 2000,
            range_u: Some(34.0),
            ..RadioSettings::default()
        };
        assert_eq!(settings, expected);
        assert_eq!(settings.to_string(), "loss=0.25,burst=4,delay_ms=2000,range_u=34");
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
        // The mean of independent losses, rounded to two decimals, is allowed; and without losses any burst is.
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
            let settings = RadioSettings { loss, burst, delay_ms, jitter_ms, duplicate, reorder, corrupt, range_u };
            match settings.validate() {
                Ok(()) => prop_assert_eq!(settings.to_string().parse(), Ok(settings)),
                Err(e) => prop_assert_eq!(settings.to_string().parse::<RadioSettings>(), Err(e)),
            }
        }
    }
}
