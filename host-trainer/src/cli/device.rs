//! `--device` of `train` and `bench`.

use clap::ValueEnum;

/// What computes the networks in training.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Device {
    /// This computer's processor.
    Cpu,
    /// An NVIDIA GPU; only in a program built with `--features cuda`.
    Cuda,
    /// A GPU through Vulkan, Metal or DirectX 12; only in a program built with `--features wgpu`.
    Wgpu,
}
