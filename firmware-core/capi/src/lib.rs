#![doc = include_str!("../README.md")]
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
mod navigation;
mod scene;
mod slice;
mod status;

pub use actor::{
    CoveyActor, CoveyDecision, CoveyFeature, CoveyNeighbourFeature, covey_content_hash, covey_decide, covey_encode,
    covey_feature_width, covey_load, covey_message_hash, covey_self_test, covey_signature, covey_tie_breaker,
};
pub use navigation::{
    CoveyMap, covey_heading_cdeg, covey_heading_rad, covey_map_degrees, covey_map_position, covey_map_velocity,
};
pub use scene::{CoveyNeighbour, CoveyScene, CoveyVec2, CoveyView, covey_observe};
pub use status::{Status, covey_status_text};
