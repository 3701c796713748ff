//! Loading an actor, and from an observation to an action.

use crate::slice::slice;
use crate::status::Status;
use core::mem::MaybeUninit;
use firmware_core::action::ACTIONS;
use firmware_core::actor::{Actor, Feature, MAX_DEGREE, MAX_FEATURE, Mode, NeighbourFeature, fingerprint};
use firmware_core::observation::{LEN, MAX_NEIGHBOURS};

/// Marks a [`CoveyActor`] with an actor inside, which passed its self-test or not. Anything
/// else, the zeros that the header asks for among it, means that there is none.
const LOADED: u64 = 0x636f_7665_795f_6c64;
const TESTED: u64 = 0x636f_7665_795f_6f6b;

/// `covey_actor`
#[repr(C)]
pub struct CoveyActor {
    state: u64,
    /// Initialised when `state` is one of the two marks.
    actor: MaybeUninit<Actor<'static>>,
}

/// As the header has it: `uint64_t opaque[8 + 8 * sizeof(void *)]`.
const OPAQUE: usize = 8 * (8 + size_of::<[usize; 8]>());
const _: () = assert!(size_of::<CoveyActor>() <= OPAQUE);
const _: () = assert!(align_of::<CoveyActor>() <= align_of::<u64>());

impl CoveyActor {
    fn loaded(&self) -> Result<&Actor<'static>, Status> {
        if self.state != LOADED && self.state != TESTED {
            return Err(Status::NotLoaded);
        }
        // SAFETY: `covey_load` sets the mark only after writing the actor.
        Ok(unsafe { self.actor.assume_init_ref() })
    }

    fn tested(&self) -> Result<&Actor<'static>, Status> {
        let actor = self.loaded()?;
        if self.state == TESTED { Ok(actor) } else { Err(Status::NotTested) }
    }
}

/// `covey_feature`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyFeature {
    /// What others combine: `h`, or with GATv2 `W_r h`.
    pub values: [i8; MAX_FEATURE],
    /// The receiver's half of the attention score.
    pub attention_destination: i16,
    /// The sender's half.
    pub attention_source: i16,
    /// `h`.
    pub own: [i8; MAX_FEATURE],
}

/// `covey_neighbour_feature`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyNeighbourFeature {
    /// What it broadcast, as many as the actor's features are wide.
    pub values: *const i8,
    /// The sender's degree, 1 to 17.
    pub degree: u8,
    /// The sender's half of the attention score.
    pub attention_source: i16,
}

/// `covey_decision`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyDecision {
    /// The logits.
    pub logits: [i16; ACTIONS],
    /// Index of the action.
    pub action: u8,
}

fn code(result: Result<(), Status>) -> i32 {
    result.err().unwrap_or(Status::Ok) as i32
}

/// Reads an actor file in place.
///
/// # Safety
/// `actor` is NULL or valid for writes; `file` is NULL, or valid for `length` bytes and
/// unchanged as long as the actor is used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_load(actor: *mut CoveyActor, file: *const u8, length: usize) -> i32 {
    if actor.is_null() || file.is_null() {
        return Status::Null as i32;
    }
    // SAFETY: valid for writes by this function's contract; `state` may be uninitialised and
    // is only written.
    unsafe { (&raw mut (*actor).state).write(0) };
    // SAFETY: valid and unchanged for as long as the actor is used by this function's contract.
    let file: &'static [u8] = unsafe { core::slice::from_raw_parts(file, length) };
    code(Actor::load(file).map_err(Status::from).map(|loaded| {
        // SAFETY: as above; the actor is written before its mark.
        unsafe {
            (&raw mut (*actor).actor).write(MaybeUninit::new(loaded));
            (&raw mut (*actor).state).write(LOADED);
        }
    }))
}

/// Recomputes the file's self-test vectors.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_self_test(actor: *mut CoveyActor) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let Some(actor) = (unsafe { actor.as_mut() }) else { return Status::Null as i32 };
    let passed = actor.loaded().and_then(|a| a.self_test().map_err(|_| Status::SelfTestFailed));
    if actor.loaded().is_ok() {
        actor.state = if passed.is_ok() { TESTED } else { LOADED };
    }
    code(passed)
}

/// What `read` makes of the actor; `none` when none is loaded.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
unsafe fn read<T>(actor: *const CoveyActor, none: T, read: impl FnOnce(&Actor<'static>) -> T) -> T {
    // SAFETY: NULL or valid by this function's contract.
    match unsafe { actor.as_ref() }.map(CoveyActor::loaded) {
        Some(Ok(actor)) => read(actor),
        _ => none,
    }
}

/// Content hash of the actor.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_content_hash(actor: *const CoveyActor) -> u64 {
    // SAFETY: this function's contract is the other's.
    unsafe { read(actor, 0, Actor::content_hash) }
}

/// The part of the content hash that feature messages carry.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_message_hash(actor: *const CoveyActor) -> u32 {
    // SAFETY: this function's contract is the other's.
    unsafe { read(actor, 0, Actor::message_hash) }
}

/// Width of the features.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_feature_width(actor: *const CoveyActor) -> u8 {
    // SAFETY: this function's contract is the other's. Loading bounds the width by 64.
    unsafe { read(actor, 0, |a| a.dimensions().feature as u8) }
}

/// The signature over `cases` neighbourhoods.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_signature(actor: *const CoveyActor, cases: u32) -> u64 {
    // SAFETY: this function's contract is the other's.
    unsafe { read(actor, 0, |a| fingerprint(a, cases)) }
}

/// The tie-breaker that UAV `id` announces for `step`.
///
/// # Safety
/// `actor` is NULL or valid and was zeroed or loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_tie_breaker(actor: *const CoveyActor, seed: u64, id: u16, step: u32) -> i8 {
    // SAFETY: this function's contract is the other's.
    unsafe { read(actor, 0, |a| a.tie_breaker(seed, id, step)) }
}

/// Encodes an observation.
///
/// # Safety
/// `actor` and `feature` are NULL or valid, the actor was zeroed or loaded, `observation` is NULL or valid for [`LEN`] numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_encode(
    actor: *const CoveyActor,
    observation: *const i8,
    feature: *mut CoveyFeature,
) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let (actor, observation, feature) =
        unsafe { (actor.as_ref(), observation.cast::<[i8; LEN]>().as_ref(), feature.as_mut()) };
    let (Some(actor), Some(observation), Some(feature)) = (actor, observation, feature) else {
        return Status::Null as i32;
    };
    code(actor.tested().map(|actor| {
        let Feature { own, values, attention_destination, attention_source } = actor.encode(observation);
        *feature = CoveyFeature { values, attention_destination, attention_source, own };
    }))
}

/// Decides.
///
/// # Safety
/// `actor`, `own` and `decision` are NULL or valid, the actor was zeroed or loaded; `neighbours` is NULL or valid for `count`
/// items, and the values of each are NULL or valid for the actor's feature width.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // C has no named arguments either way.
pub unsafe extern "C" fn covey_decide(
    actor: *const CoveyActor,
    own: *const CoveyFeature,
    degree: u8,
    neighbours: *const CoveyNeighbourFeature,
    count: usize,
    mode: i32,
    seed: u64,
    id: u16,
    step: u32,
    decision: *mut CoveyDecision,
) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let (actor, own, decision) = unsafe { (actor.as_ref(), own.as_ref(), decision.as_mut()) };
    let (Some(actor), Some(own), Some(decision)) = (actor, own, decision) else { return Status::Null as i32 };
    let actor = match actor.tested() {
        Ok(actor) => actor,
        Err(status) => return status as i32,
    };
    let mode = match mode {
        0 => Mode::Sample,
        1 => Mode::Argmax,
        _ => return Status::Argument as i32,
    };
    let is_degree = |d: u8| (1..=MAX_DEGREE).contains(&d);
    if count > MAX_NEIGHBOURS || !is_degree(degree) {
        return Status::Argument as i32;
    }
    // SAFETY: NULL or valid for `count` items by this function's contract.
    let Some(neighbours) = (unsafe { slice(neighbours, count) }) else { return Status::Null as i32 };
    if neighbours.iter().any(|n| n.values.is_null()) {
        return Status::Null as i32;
    }
    // The degree counts this UAV too.
    if count >= usize::from(degree) || neighbours.iter().any(|n| !is_degree(n.degree)) {
        return Status::Argument as i32;
    }
    let width = usize::from(actor.dimensions().feature);
    let features = neighbours.iter().map(|n| {
        // SAFETY: not NULL, and valid for the feature width by this function's contract.
        let values = unsafe { core::slice::from_raw_parts(n.values, width) };
        NeighbourFeature { values, degree: n.degree, attention_source: n.attention_source }
    });
    let own = Feature {
        own: own.own,
        values: own.values,
        attention_destination: own.attention_destination,
        attention_source: own.attention_source,
    };
    decision.logits = actor.logits(&own, degree, features);
    decision.action = actor.choose(&decision.logits, mode, seed, id, step).index();
    Status::Ok as i32
}
