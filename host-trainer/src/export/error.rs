//! Why a policy could not be exported.

use covey_env::ScenarioError;
use firmware_core::actor::file::StoreError;
use firmware_core::actor::{LoadError, SelfTestError};
use thiserror::Error;

/// Why a policy could not be quantised.
#[derive(Debug, Error)]
pub enum QuantiseError {
    /// A weight or bias is infinite or not a number.
    #[error(
        "row {row} of the {layer} layer is not finite: training went wrong; resume from an earlier checkpoint with a lower learning_rate"
    )]
    NotFinite {
        /// Name of the layer.
        layer: &'static str,
        /// Row, which is one output of the layer.
        row: usize,
    },
    /// A row's multiplier is beyond its range.
    #[error("the weights in row {row} of the {layer} layer are too large for int8: train with a lower learning_rate")]
    TooLarge {
        /// Name of the layer.
        layer: &'static str,
        /// Row, which is one output of the layer.
        row: usize,
    },
    /// The scenario of the calibration cannot be built.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The file could not be composed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The composed file does not load: a defect of this program.
    #[error("the exported file does not load")]
    Load(#[from] LoadError),
    /// The composed file fails its self-test: a defect of this program.
    #[error("the exported file fails its own test")]
    SelfTest(#[from] SelfTestError),
}
