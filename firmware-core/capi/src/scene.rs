//! From what a UAV knows to its observation.

use crate::slice::slice;
use crate::status::Status;
use firmware_core::geometry::{State, Vec2};
use firmware_core::observation::{LEN, MAX_NEIGHBOURS, Neighbour, Neighbours, Scene, observe};

/// `covey_vec2`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct CoveyVec2 {
    /// East, ticks or ticks/step.
    pub x: i32,
    /// North.
    pub y: i32,
}

impl From<CoveyVec2> for Vec2 {
    fn from(v: CoveyVec2) -> Self {
        Self::from_ticks(v.x, v.y)
    }
}

/// `covey_neighbour`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyNeighbour {
    /// Ticks.
    pub position: CoveyVec2,
    /// Ticks/step.
    pub velocity: CoveyVec2,
    /// Its id.
    pub id: u16,
    /// Its tie-breaker.
    pub tie: i8,
}

/// `covey_scene`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyScene {
    /// Own position, ticks.
    pub position: CoveyVec2,
    /// Own velocity, ticks/step.
    pub velocity: CoveyVec2,
    /// Half the side of the map, ticks.
    pub half_side: i32,
    /// Own id.
    pub id: u16,
    /// Own tie-breaker.
    pub tie: i8,
    /// Neighbours, any number.
    pub neighbours: *const CoveyNeighbour,
    /// How many.
    pub neighbour_count: usize,
    /// Points of interest, any number.
    pub pois: *const CoveyVec2,
    /// How many.
    pub poi_count: usize,
}

/// `covey_view`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyView {
    /// The observation.
    pub observation: [i8; LEN],
    /// Neighbours kept and the UAV itself.
    pub degree: u8,
    /// Ids of the neighbours kept, nearest first, then zeros.
    pub kept: [u16; MAX_NEIGHBOURS],
}

/// Builds the observation of a scene.
///
/// # Safety
/// `scene` and `view` are NULL or valid, as are the scene's own pointers for their counts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_observe(scene: *const CoveyScene, view: *mut CoveyView) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let (scene, view) = unsafe { (scene.as_ref(), view.as_mut()) };
    let (Some(scene), Some(view)) = (scene, view) else { return Status::Null as i32 };
    // SAFETY: the scene's pointers are NULL or valid for their counts by this function's contract.
    let (around, pois) =
        unsafe { (slice(scene.neighbours, scene.neighbour_count), slice(scene.pois, scene.poi_count)) };
    let (Some(around), Some(pois)) = (around, pois) else { return Status::Null as i32 };
    let own = State { position: scene.position.into(), velocity: scene.velocity.into() };
    let mut neighbours = Neighbours::new();
    for n in around.iter().filter(|n| n.id != scene.id) {
        let offset = Vec2::from(n.position) - own.position;
        neighbours.insert(Neighbour { id: n.id, offset, velocity: n.velocity.into(), tie: n.tie });
    }
    let CoveyScene { id, tie, half_side, .. } = *scene;
    view.observation =
        observe(&Scene { id, own, tie, half_side, neighbours: &neighbours }, pois.iter().map(|&p| p.into()));
    view.degree = neighbours.as_slice().len() as u8 + 1;
    view.kept = [0; MAX_NEIGHBOURS];
    for (kept, n) in view.kept.iter_mut().zip(neighbours.as_slice()) {
        *kept = n.id;
    }
    Status::Ok as i32
}
