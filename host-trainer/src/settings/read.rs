//! Settings from TOML and to TOML.

use super::error::SettingsError;
use super::key::{Key, keys};
use super::renamed::{Renamed, current_name, renamed};
use super::table::Settings;
use serde::Deserialize as _;
use std::collections::BTreeMap;
use std::path::Path;
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Table, Value};

impl Settings {
    /// Reads a TOML text over these settings: those that it does not name stay. Returns the
    /// settings that it gives by an old name.
    ///
    /// # Errors
    /// See [`SettingsError`]; `path` is named in them. The settings are then as before.
    pub fn merge(&mut self, text: &str, path: &str) -> Result<Vec<Renamed>, SettingsError> {
        let table = parse(text)
            .map_err(|e: toml::de::Error| SettingsError::Syntax { path: path.to_owned(), message: e.to_string() })?;
        self.apply(table).map_err(|e| SettingsError::In { path: path.to_owned(), error: Box::new(e) })
    }

    /// Reads a TOML file over these settings, as [`Self::merge`].
    ///
    /// # Errors
    /// See [`SettingsError`].
    pub fn merge_file(&mut self, path: &Path) -> Result<Vec<Renamed>, SettingsError> {
        let name = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|source| SettingsError::Read { path: name.clone(), source })?;
        self.merge(&text, &name)
    }

    /// Sets one setting from `key=value`; a value that is not TOML is taken as a string. Returns
    /// the old name, if that was used.
    ///
    /// # Errors
    /// See [`SettingsError`].
    pub fn set(&mut self, assignment: &str) -> Result<Option<Renamed>, SettingsError> {
        let (key, value) = assignment.split_once('=').ok_or_else(|| SettingsError::NoValue(assignment.to_owned()))?;
        let (key, value) = (key.trim(), value.trim());
        let parsed = parse(&format!("v = {value}")).ok().and_then(|mut t| t.remove("v"));
        let value = parsed.unwrap_or_else(|| Value::String(value.to_owned()));
        Ok(self.apply(Table::from_iter([(key.to_owned(), value)]))?.pop())
    }

    /// Puts values in the place of those here, all or none.
    fn apply(&mut self, changes: Table) -> Result<Vec<Renamed>, SettingsError> {
        let mut old_names = Vec::new();
        let mut given = BTreeMap::new();
        for (key, value) in &changes {
            if let Some(found) = renamed(key) {
                if changes.contains_key(found.new) {
                    return Err(SettingsError::BothNames { old: found.old, new: found.new });
                }
                old_names.push(found);
            }
            let key = find(current_name(key))?;
            // A whole number above i64::MAX comes as a string.
            if let Some(number) =
                value.as_str().and_then(|text| text.parse::<u64>().ok()).filter(|_| key.bounds.is_whole())
            {
                given.insert(&key.name, number.into());
                continue;
            }
            if !key.bounds.fits(value) {
                let (wanted, found) = (key.bounds.wanted(), value.to_string());
                return Err(SettingsError::Type { key: &key.name, wanted, found });
            }
            given.insert(&key.name, serde_json::to_value(value).unwrap_or_default());
        }
        let mut values = self.values();
        for (name, value) in given {
            values[name] = value;
        }
        let mut changed: Self =
            serde_path_to_error::deserialize(&values).map_err(|e| out_of_range(&e.path().to_string(), &values))?;
        std::mem::swap(self, &mut changed);
        if let Err(e) = self.check_bounds() {
            *self = changed;
            return Err(e);
        }
        Ok(old_names)
    }

    /// Name and value of every setting, the value as TOML.
    #[must_use]
    pub fn entries(&self) -> Vec<(&'static str, String)> {
        // JSON writes these values as TOML does.
        let values = self.values();
        keys().iter().map(|key| (key.name.as_str(), values[&key.name].to_string())).collect()
    }

    /// The settings as a commented TOML file, which [`Self::merge`] reads back.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let entry = |(key, (name, value)): (&Key, (_, String))| {
            let doc: String = key.doc.iter().map(|line| format!("# {line}\n")).collect();
            format!("{doc}{name} = {value}\n\n")
        };
        keys().iter().zip(self.entries()).map(entry).collect()
    }

    /// The first setting in which two differ: name, own value, other's value.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> Option<(String, String, String)> {
        let pairs = self.entries().into_iter().zip(other.entries());
        let mut different = pairs.filter(|(own, other)| own.1 != other.1);
        different.next().map(|((key, own), (_, other))| (key.to_owned(), own, other))
    }

    /// The settings that a TOML text names neither by today's name nor by an old one.
    #[must_use]
    pub fn unnamed(text: &str) -> Vec<&'static str> {
        let table = parse(text).unwrap_or_default();
        let named: Vec<&str> = table.keys().map(|key| current_name(key)).collect();
        keys().iter().map(|key| key.name.as_str()).filter(|name| !named.contains(name)).collect()
    }
}

/// Parses TOML. Its whole numbers end at i64::MAX and seeds do not: a longer one comes as a string of its digits.
fn parse(text: &str) -> Result<Table, toml::de::Error> {
    let mut document = DeTable::parse(text)?;
    let mut long = Vec::new();
    for (key, value) in document.get_mut().iter_mut() {
        let DeValue::Integer(number) = value.get_ref() else { continue };
        let number = u64::from_str_radix(number.as_str(), number.radix());
        if let Some(number) = number.ok().filter(|&n| i64::try_from(n).is_err()) {
            long.push((key.get_ref().to_string(), Value::String(number.to_string())));
            *value.get_mut() = DeValue::Boolean(false);
        }
    }
    let mut table = Table::deserialize(Deserializer::from(document))?;
    table.extend(long);
    Ok(table)
}

fn find(name: &str) -> Result<&'static Key, SettingsError> {
    let like = |key: &Key| strsim::jaro_winkler(&key.name, name);
    keys().iter().find(|key| key.name == name).ok_or_else(|| SettingsError::UnknownKey {
        key: name.to_owned(),
        nearest: keys().iter().max_by(|a, b| like(a).total_cmp(&like(b))).map_or("", |key| &key.name),
    })
}

/// The type was right, so the number is too large or too small for the field.
fn out_of_range(name: &str, values: &serde_json::Value) -> SettingsError {
    find(name).map_or_else(|unknown| unknown, |key| key.out_of_range(&values[name]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use covey_env::ObservationForm;
    use firmware_core::actor::Aggregation;

    #[test]
    fn written_settings_read_back() {
        let mut a = Settings { graph: Aggregation::Gat, learning_rate: 3e-7, seed: u64::MAX, ..Settings::default() };
        a.set("poi_distribution=uniform").unwrap();
        let mut b = Settings::default();
        assert_eq!(b.merge(&a.to_toml(), "test").unwrap(), []);
        assert_eq!(a, b);
        assert!(Settings::unnamed(&a.to_toml()).is_empty());
    }

    #[test]
    fn seeds_of_the_whole_range_are_read_however_they_are_given() {
        for seed in [0, i64::MAX as u64, i64::MAX as u64 + 1, u64::MAX] {
            let mut s = Settings::default();
            s.set(&format!("seed={seed}")).unwrap();
            s.merge(&format!("uavs = 3\neval_seed = {}", seed ^ 1), "f").unwrap();
            assert_eq!((s.seed, s.eval_seed, s.uavs), (seed, seed ^ 1, 3));
            assert_eq!(s.validate().map_err(|e| e.to_string()), Ok(()));
            let mut read = Settings::default();
            read.merge(&s.to_toml(), "f").unwrap();
            assert_eq!(read, s);
        }
    }

    #[test]
    fn errors_name_the_remedy() {
        let mut s = Settings::default();
        fn say<T: std::fmt::Debug>(result: Result<T, SettingsError>) -> String {
            result.unwrap_err().to_string()
        }
        assert!(say(s.merge("lerning_rate = 1e-3", "f")).contains("nearest is `learning_rate`"));
        assert!(say(s.set("uavs=many")).contains("wants a whole number"));
        assert!(say(s.set("uavs=0")).contains("must be 1 to 10000"));
        assert!(say(s.set("uavs=70000")).contains("`uavs` is 70000; it must be 1 to 10000"));
        assert!(say(s.set("seed=18446744073709551616")).contains("`seed` wants a whole number"));
        assert!(say(s.set("seed=-1")).contains("must be at least 0"));
        assert!(say(s.set("uavs=-1")).contains("must be 1 to 10000"));
        assert!(say(s.set("huber=0")).contains("must be above 0"));
        assert!(say(s.set("gamma=nan")).contains("wants a number, not nan"));
        assert!(say(s.set("side=30")).contains("must be 60 to 10000 u"));
        assert!(say(s.set("hidden=3")).contains("must be 2 to 128, even"));
        assert!(say(s.set("graph=gnn")).contains("\"none\", \"gcn\", \"gat\", \"gatv2\" or \"sage\""));
        assert!(say(s.set("uavs")).contains("key=value"));
        assert!(say(s.merge("a = = 1", "f.toml")).contains("f.toml is not valid TOML"));
        assert_eq!(s, Settings::default(), "a refused setting has changed something");
        s.set("rollout_steps=30").unwrap();
        assert!(say(s.validate()).contains("try 25"));
        let mut s = Settings { uavs_min: 9, uavs_max: 8, ..Settings::default() };
        assert!(say(s.validate()).contains("`uavs_min` (9) must not exceed `uavs_max` (8)"));
        s = Settings { observation: ObservationForm::Cells, ..Settings::default() };
        assert!(say(s.validate()).contains("set `cloning_weight` to 0"));
        s = Settings { clip: f64::NAN, ..Settings::default() };
        assert!(say(s.validate()).contains("`clip`"));
    }

    #[test]
    fn old_names_are_taken_and_told() {
        let mut s = Settings::default();
        let told =
            s.merge("segment = 50\nworlds = 8\nother_law = 0.5\nscenario = \"uniform\"\nclip = 0.1", "f").unwrap();
        assert_eq!((s.rollout_steps, s.num_envs, s.other_distribution_share, s.clip), (50, 8, 0.5, 0.1));
        assert_eq!(told.len(), 4);
        let told = s.set("teacher=0").unwrap().expect("an old name");
        assert_eq!((told.to_string().as_str(), s.cloning_weight), ("`teacher` is now `cloning_weight`", 0.0));
        let both = s.merge("segment = 50\nrollout_steps = 25", "f").unwrap_err().to_string();
        assert!(both.contains("keep `rollout_steps` alone"), "{both}");
        let bounds = s.set("uavs_most=-1").unwrap_err().to_string();
        assert!(bounds.contains("`uavs_max`"), "{bounds}");
        assert!(!Settings::unnamed("segment = 50").contains(&"rollout_steps"));
    }
}
