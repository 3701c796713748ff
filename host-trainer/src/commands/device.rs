//! `--device`: where the networks are computed in training.

use crate::cli::Device;
use crate::train::Trainer;
use miette::{Diagnostic, Result};
use thiserror::Error;

/// Why a device cannot be used.
#[derive(Debug, Diagnostic, Error)]
pub enum DeviceError {
    /// The program was built without it.
    #[error(
        "this program was built without `{0}`; build it with: cargo build --release -p host-trainer --features {0}"
    )]
    NotBuilt(&'static str),
    /// It is not there.
    #[cfg(any(feature = "cuda", feature = "wgpu"))]
    #[error("{0}; train with --device cpu")]
    NotFound(covey_burn::NoDevice),
}

/// The trainer with its networks on this device.
///
/// # Errors
/// When there is no such device, or it fails, or it computes something else than the CPU.
pub fn put(trainer: Trainer, device: Device) -> Result<Trainer> {
    match device {
        Device::Cpu => Ok(trainer),
        #[cfg(feature = "cuda")]
        Device::Cuda => on(trainer, covey_burn::Kind::Cuda),
        #[cfg(not(feature = "cuda"))]
        Device::Cuda => Err(DeviceError::NotBuilt("cuda").into()),
        #[cfg(feature = "wgpu")]
        Device::Wgpu => on(trainer, covey_burn::Kind::Wgpu),
        #[cfg(not(feature = "wgpu"))]
        Device::Wgpu => Err(DeviceError::NotBuilt("wgpu").into()),
    }
}

#[cfg(any(feature = "cuda", feature = "wgpu"))]
fn on(trainer: Trainer, kind: covey_burn::Kind) -> Result<Trainer> {
    use miette::IntoDiagnostic;
    let layouts = trainer.layouts().clone();
    let engine =
        covey_burn::BurnEngine::open(kind, layouts, trainer.settings().graph).map_err(DeviceError::NotFound)?;
    trainer.on(Box::new(engine)).into_diagnostic()
}
