//! What is known of each setting: name, default, bounds and meaning, read from the table's schema.

use super::table::Settings;
use schemars::schema_for;
use serde::Deserialize;
use serde_json::{Number, Value};
use std::fmt;
use std::sync::LazyLock;

/// A setting as `host-trainer settings` lists it.
#[derive(Debug)]
pub struct Key {
    /// Its name, as in files and `--set`.
    pub name: String,
    /// Its default, as TOML.
    pub default: String,
    /// Which values it may have.
    pub bounds: Bounds,
    /// What it means, line by line.
    pub doc: Vec<String>,
}

/// Which values a setting may have: a part of JSON Schema. Shown, it says so in words.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Bounds {
    /// "integer", "number", "boolean" or "string".
    #[serde(rename = "type")]
    kind: String,
    minimum: Option<Number>,
    exclusive_minimum: Option<Number>,
    maximum: Option<Number>,
    exclusive_maximum: Option<Number>,
    multiple_of: Option<u64>,
    #[serde(rename = "enum")]
    words: Vec<String>,
    #[serde(rename = "x-unit")]
    unit: Option<String>,
}

/// Every setting, in the table's order.
#[must_use]
pub fn keys() -> &'static [Key] {
    static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
        let schema = schema_for!(Settings);
        let of = |name: &str, part: &str| schema.pointer(&format!("/properties/{name}{part}"));
        // TOML is written in the order of the fields; a JSON object is sorted by name.
        let defaults = toml::to_string(&Settings::default()).unwrap_or_default();
        let key = |(name, default): (&str, &str)| Key {
            name: name.to_owned(),
            default: default.to_owned(),
            bounds: of(name, "").and_then(|bounds| Bounds::deserialize(bounds).ok()).unwrap_or_default(),
            doc: of(name, "/description").and_then(Value::as_str).unwrap_or("").lines().map(str::to_owned).collect(),
        };
        defaults.lines().filter_map(|line| line.split_once(" = ")).map(key).collect()
    });
    &KEYS
}

impl Bounds {
    /// The type in words: what a value of another type is told.
    #[must_use]
    pub fn wanted(&self) -> String {
        match self.kind.as_str() {
            "integer" => "a whole number".to_owned(),
            "number" => "a number".to_owned(),
            _ => self.to_string(),
        }
    }

    /// Whether it is a whole number.
    pub(super) fn is_whole(&self) -> bool {
        self.kind == "integer"
    }

    /// Whether a value is of this type, whatever its size.
    pub(super) fn fits(&self, value: &toml::Value) -> bool {
        match self.kind.as_str() {
            "integer" => value.is_integer(),
            "number" => value.is_integer() || value.as_float().is_some_and(f64::is_finite),
            "boolean" => value.is_bool(),
            _ => value.as_str().is_some_and(|word| self.words.iter().any(|w| w == word)),
        }
    }

    /// Whether a value of this type is within the bounds. Words and truth values always are; a
    /// number that is not finite, which JSON knows as null, never is.
    pub(super) fn allow(&self, value: &Value) -> bool {
        if !["integer", "number"].contains(&self.kind.as_str()) {
            return true;
        }
        let of = |bound: &Option<Number>| bound.as_ref().and_then(Number::as_f64);
        // Seeds are too long for a float to hold.
        let most = self.maximum.as_ref().and_then(Number::as_u64);
        let below_most = value.as_u64().zip(most).is_none_or(|(v, most)| v <= most);
        below_most
            && value.as_f64().is_some_and(|v| {
                of(&self.minimum).is_none_or(|least| v >= least)
                    && of(&self.exclusive_minimum).is_none_or(|bound| v > bound)
                    && of(&self.maximum).is_none_or(|most| v <= most)
                    && of(&self.exclusive_maximum).is_none_or(|bound| v < bound)
                    && self.multiple_of.is_none_or(|step| v % step as f64 == 0.0)
            })
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind.as_str() {
            "boolean" => return f.write_str("true or false"),
            "string" => {
                let quoted: Vec<_> = self.words.iter().map(|word| format!("{word:?}")).collect();
                let (last, others) = quoted.split_last().unzip();
                let others = others.unwrap_or_default().join(", ");
                return write!(f, "{others} or {}", last.map_or("", String::as_str));
            }
            _ => {}
        }
        let mut parts = Vec::new();
        match (&self.minimum, &self.maximum) {
            (Some(least), Some(most)) => parts.push(format!("{least} to {most}")),
            (least, most) => {
                parts.extend(least.iter().map(|v| format!("at least {v}")));
                parts.extend(self.exclusive_minimum.iter().map(|v| format!("above {v}")));
                parts.extend(most.iter().map(|v| format!("at most {v}")));
                parts.extend(self.exclusive_maximum.iter().map(|v| format!("below {v}")));
            }
        }
        if self.multiple_of == Some(2) {
            parts.push("even".to_owned());
        }
        f.write_str(&parts.join(", "))?;
        self.unit.iter().try_for_each(|unit| write!(f, " {unit}"))
    }
}
