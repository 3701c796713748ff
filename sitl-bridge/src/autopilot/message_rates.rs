//! Which telemetry a node requests, and how often.

use super::firmware::Firmware;
use crate::messages::id;

/// Message ids to request with MAV_CMD_SET_MESSAGE_INTERVAL and their rates, Hz. SYSTEM_TIME comes
/// as often as positions: when positions cease, it is by this clock that the gate notices.
pub(super) fn message_rates(firmware: Option<Firmware>, position_hz: f64) -> [(u32, f64); 9] {
    let estimator = if firmware == Some(Firmware::Px4) { id::ESTIMATOR_STATUS } else { id::EKF_STATUS_REPORT };
    [
        (id::LOCAL_POSITION_NED, position_hz),
        (id::GLOBAL_POSITION_INT, position_hz),
        (id::SYSTEM_TIME, position_hz),
        (estimator, 2.0),
        (id::GPS_RAW_INT, 1.0),
        (id::SYS_STATUS, 1.0),
        (id::GPS_GLOBAL_ORIGIN, 0.5),
        (id::EXTENDED_SYS_STATE, 1.0),
        // One battery at a time.
        (id::BATTERY_STATUS, 2.0),
    ]
}
