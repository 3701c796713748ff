//! Covey's actor for C and C++ flight software.
//!
//! `include/covey.h` is the interface and describes it, `docs/c-api.md` how to build and use
//! it. It is the only place around the actor with `unsafe`: pointers from C become references
//! here.
#![no_std]
#![deny(missing_docs)]

// A host brings its own way to panic; a board needs one to link, though no panic branch
// is left in the library when it is built with the `firmware` profile.
#[cfg(not(target_os = "none"))]
extern crate std;

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

mod actor;
mod scene;
mod status;

pub use actor::{
    CoveyActor, CoveyDecision, CoveyFeature, CoveyNeighbourFeature, covey_content_hash, covey_decide, covey_encode,
    covey_feature_width, covey_load, covey_message_hash, covey_self_test, covey_signature, covey_tie_breaker,
};
pub use scene::{CoveyNeighbour, CoveyScene, CoveyVec2, CoveyView, covey_observe};
pub use status::{Status, covey_status_text};

/// A slice from C.
///
/// # Safety
/// `data` is NULL, or valid for `count` items for as long as the slice is used.
unsafe fn slice<'a, T>(data: *const T, count: usize) -> Option<&'a [T]> {
    match count {
        0 => Some(&[]),
        _ if data.is_null() => None,
        // SAFETY: not NULL, and valid for `count` items by this function's contract.
        _ => Some(unsafe { core::slice::from_raw_parts(data, count) }),
    }
}
