//! What computes the networks in training: the CPU's threads, or a device such as a GPU.
//!
//! | file | what |
//! |---|---|
//! | `interface` | the trait [`Backend`] |
//! | `workspace` | activations and gradients of a thread's work |
//! | `cpu` | [`CpuBackend`]: the networks of `covey_net`, by many threads |
//! | `device` | [`DeviceBackend`]: a [`covey_net::Engine`] |
//! | `device_check` | a device's numbers compared with the CPU's |

mod cpu;
mod device;
mod device_check;
mod interface;
mod workspace;

pub(crate) use cpu::CpuBackend;
pub(crate) use device::DeviceBackend;
pub(crate) use interface::{Backend, Collection};
