//! Choices that settings, flags and files name by a word. Their types belong to other crates, so
//! this is the one place that knows their words.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use covey_env::{ObservationForm, PoiDistribution};
use firmware_core::actor::{Aggregation, Mode};
use schemars::{Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};

/// A type whose values have words.
pub trait Choice: Copy + PartialEq + Send + Sync + 'static {
    /// Every value with its word and what it means.
    const ALL: &'static [(Self, &'static str, &'static str)];
}

impl Choice for Aggregation {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::None, "none", "Plain PPO: neighbours' features are not used"),
        (Self::Gcn, "gcn", "Graph convolution"),
        (Self::Gat, "gat", "Graph attention"),
        (Self::GatV2, "gatv2", "Graph attention in the form of Brody et al."),
        (Self::Sage, "sage", "GraphSAGE: the mean of the neighbours"),
    ];
}

impl Choice for PoiDistribution {
    const ALL: &'static [(Self, &'static str, &'static str)] =
        &[(Self::Clustered, "clustered", "Around three centres"), (Self::Uniform, "uniform", "All over the map")];
}

impl Choice for ObservationForm {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Compact, "compact", "Numbers made for the task"),
        (Self::Cells, "cells", "The paper's id, binary position and maps"),
    ];
}

impl Choice for Mode {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Sample, "sample", "Drawn in proportion to their probabilities"),
        (Self::Argmax, "argmax", "The most probable one"),
    ];
}

/// The word of a value.
#[must_use]
pub fn word_of<T: Choice>(choice: T) -> &'static str {
    T::ALL.iter().find(|c| c.0 == choice).map_or("", |c| c.1)
}

fn from_word<T: Choice>(word: &str) -> Option<T> {
    T::ALL.iter().find(|c| c.1 == word).map(|c| c.0)
}

fn words<T: Choice>() -> Vec<&'static str> {
    T::ALL.iter().map(|c| c.1).collect()
}

/// For `#[serde(with = "choice")]`.
pub fn serialize<T: Choice, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(word_of(*choice))
}

/// For `#[serde(with = "choice")]`.
pub fn deserialize<'de, T: Choice, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let word = String::deserialize(deserializer)?;
    from_word(&word).ok_or_else(|| D::Error::custom(format_args!("none of {}", words::<T>().join(", "))))
}

/// For `#[schemars(schema_with = "…")]`: a string that is one of the words.
pub fn schema<T: Choice>(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "string", "enum": words::<T>() })
}

/// For `#[arg(value_parser = …)]`: the words are listed in the help and in errors.
pub fn parser<T: Choice>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|(_, word, meaning)| PossibleValue::new(*word).help(*meaning));
    PossibleValuesParser::new(values).try_map(|word| from_word(&word).ok_or("not one of them"))
}
