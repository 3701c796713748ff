//! Finding the device.

use burn::tensor::Device;
#[cfg(feature = "wgpu")]
use burn::tensor::DeviceKind;
#[cfg(any(feature = "cuda", feature = "wgpu"))]
use burn::tensor::DeviceType;
use thiserror::Error;

/// Kinds of devices that this build knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An NVIDIA GPU through CUDA.
    #[cfg(feature = "cuda")]
    Cuda,
    /// A GPU through Vulkan, Metal or DirectX 12.
    #[cfg(feature = "wgpu")]
    Wgpu,
    /// burn's own CPU device.
    #[cfg(feature = "flex")]
    Flex,
}

/// There is no such device here.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("no device for `{kind}` found: {wanted}")]
pub struct NoDevice {
    /// What was asked for.
    pub kind: &'static str,
    /// What it takes.
    pub wanted: &'static str,
}

impl Kind {
    /// Opens the first device of this kind; returns it with a name for messages.
    ///
    /// # Errors
    /// When there is none.
    pub(crate) fn open(self) -> Result<(Device, String), NoDevice> {
        match self {
            #[cfg(feature = "cuda")]
            Self::Cuda => {
                let wanted = "it takes an NVIDIA GPU and its driver (libcuda.so.1)";
                found(DeviceType::Cuda, || Device::cuda(0), NoDevice { kind: "cuda", wanted })
            }
            #[cfg(feature = "wgpu")]
            Self::Wgpu => {
                let wanted = "it takes a GPU with a driver for Vulkan, Metal or DirectX 12";
                let best = || Device::wgpu(DeviceKind::DefaultDevice);
                found(DeviceType::Wgpu, best, NoDevice { kind: "wgpu", wanted })
            }
            #[cfg(feature = "flex")]
            Self::Flex => Ok((Device::flex(), "flex".to_owned())),
        }
    }
}

/// Opens a device if there is any of its type.
#[cfg(any(feature = "cuda", feature = "wgpu"))]
fn found(of: DeviceType, open: impl FnOnce() -> Device, none: NoDevice) -> Result<(Device, String), NoDevice> {
    if Device::enumerate(of).into_vec().is_empty() {
        return Err(none);
    }
    let device = open();
    let name = device.identity().map_or_else(|| none.kind.to_owned(), |i| format!("{}, {}", none.kind, i.name));
    Ok((device, name))
}
