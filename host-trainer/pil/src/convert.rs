//! Conversions between the types of a host and the records of the protocol.

use crate::answers::{BoardReport, HearOutcome, Observed};
use crate::error::PilError;
use firmware_core::geometry::{OBSERVATION_RANGE_U, State, TICKS_PER_U, Vec2};
use firmware_core::neighbour_table::Moment;
use firmware_core::pil::{Decided, MAX_POIS, Observe, POI_BYTES, Reply, Report, Request, RequestError};

/// Decodes an answer and converts it with `pick`; an answer that `pick` does not take is unexpected.
pub(crate) fn read<T>(
    record: &[u8],
    request: &'static str,
    pick: impl FnOnce(Reply<'_>) -> Option<Result<T, PilError>>,
) -> Result<T, PilError> {
    match postcard::take_from_bytes(record) {
        Ok((Reply::Refused(RequestError::Version(version)), [])) => Err(PilError::Version(version)),
        Ok((Reply::Refused(refusal), [])) => Err(PilError::Refused(refusal)),
        Ok((reply, [])) => pick(reply).unwrap_or(Err(PilError::Unexpected { request })),
        _ => Err(PilError::Unexpected { request }),
    }
}

/// The PoIs in view of the position `own` (ticks), encoded as a request holds them.
pub(crate) fn in_view(own: Vec2, pois: impl IntoIterator<Item = Vec2>) -> Result<Vec<u8>, PilError> {
    let mut offsets = Vec::new();
    for poi in pois {
        let offset = poi - own;
        if offset.within(OBSERVATION_RANGE_U * TICKS_PER_U).is_some() {
            // In view: at most 13,312 ticks.
            offsets.extend_from_slice(&(offset.x as i16).to_le_bytes());
            offsets.extend_from_slice(&(offset.y as i16).to_le_bytes());
        }
    }
    if offsets.len() > MAX_POIS * POI_BYTES {
        return Err(PilError::TooManyPois(offsets.len() / POI_BYTES));
    }
    Ok(offsets)
}

/// The request to observe a step.
pub(crate) const fn observe_request(now: Moment, own: State, pois: &[u8]) -> Request<'_> {
    let (position, velocity) = ([own.position.x, own.position.y], [own.velocity.x, own.velocity.y]);
    Request::Observe(Observe { now, position, velocity, pois })
}

/// The answer to a neighbour's message.
pub(crate) const fn heard(reply: Reply<'_>) -> Option<Result<HearOutcome, PilError>> {
    match reply {
        Reply::Heard { outcome, kept } => Some(Ok(HearOutcome { outcome, kept })),
        _ => None,
    }
}

/// The answer to an observation of `step`.
pub(crate) fn observed(step: u32, reply: Reply<'_>) -> Option<Result<Observed, PilError>> {
    match reply {
        Reply::Observed(o) if o.step == step => {
            Some(Ok(Observed { degree: o.degree, tie: o.tie, message: o.message.to_vec() }))
        }
        _ => None,
    }
}

/// The decision of `step`.
pub(crate) const fn decided(step: u32, reply: Reply<'_>) -> Option<Result<Decided, PilError>> {
    match reply {
        Reply::Decided(d) if d.step == step => Some(Ok(d)),
        _ => None,
    }
}

/// The report of a board that may fly; a fault is an error.
pub(crate) fn board(reply: Reply<'_>) -> Option<Result<BoardReport, PilError>> {
    match reply {
        Reply::Report(Report { actor: Err(fault), .. }) => Some(Err(PilError::Refused(RequestError::Actor(fault)))),
        Reply::Report(report) => Some(Ok(report.into())),
        _ => None,
    }
}
