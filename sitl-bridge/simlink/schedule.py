"""Which messages an autopilot sends, and how often."""

from collections.abc import Callable, Iterator

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink import telemetry
from simlink.px4 import Px4
from simlink.vehicle_state import VehicleState

GLOBAL_POSITION_INT = mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT
LOCAL_POSITION_NED = mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED

Builder = Callable[[VehicleState], mavlink.MAVLink_message]

BUILDERS: dict[int, Builder] = {
    message.id: builder
    for message, builder in (
        (mavlink.MAVLink_heartbeat_message, telemetry.heartbeat),
        (mavlink.MAVLink_system_time_message, telemetry.system_time),
        (mavlink.MAVLink_sys_status_message, telemetry.sys_status),
        (mavlink.MAVLink_battery_status_message, telemetry.battery_status),
        (mavlink.MAVLink_gps_raw_int_message, telemetry.gps_raw_int),
        (mavlink.MAVLink_gps_global_origin_message, telemetry.gps_global_origin),
        (mavlink.MAVLink_home_position_message, telemetry.home_position),
        (mavlink.MAVLink_extended_sys_state_message, telemetry.extended_sys_state),
        (mavlink.MAVLink_ekf_status_report_message, telemetry.ekf_status_report),
        (mavlink.MAVLink_estimator_status_message, telemetry.estimator_status),
        (mavlink.MAVLink_attitude_message, telemetry.attitude),
        (mavlink.MAVLink_vfr_hud_message, telemetry.vfr_hud),
        (mavlink.MAVLink_autopilot_version_message, telemetry.autopilot_version),
        (mavlink.MAVLink_global_position_int_message, telemetry.global_position_int),
        (mavlink.MAVLink_local_position_ned_message, telemetry.local_position_ned),
    )
}
"""Every message that can be asked for, in the order in which they are sent: the position comes last."""

_NEED_ORIGIN = (LOCAL_POSITION_NED, mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN, mavlink.MAVLINK_MSG_ID_HOME_POSITION)


def is_known(vehicle: VehicleState, message: int) -> bool:
    """Whether the message has content: those that depend on the EKF origin are not sent before there is one, and
    PX4 then sends no global position either.
    """
    if vehicle.autopilot.has_origin:
        return True
    return message not in _NEED_ORIGIN and not (message == GLOBAL_POSITION_INT and isinstance(vehicle.autopilot, Px4))


PX4_STREAMS = {
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1000,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 1000,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 1000,
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 1000,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 1000,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 2000,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 2000,
    GLOBAL_POSITION_INT: 200,
    LOCAL_POSITION_NED: 200,
}
"""Intervals of the messages that PX4 sends without a request besides HEARTBEAT, ms; ArduPilot sends none."""


class Schedule:
    """The message intervals. Messages of one interval are sent in the same tick."""

    def __init__(self, streams: dict[int, int]) -> None:
        self._defaults = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1000, **streams}
        self.reset()

    def reset(self) -> None:
        """Back to the intervals after boot."""
        self._intervals: dict[int, int] = {}
        self._last: dict[int, int] = {}
        for message, interval in self._defaults.items():
            self.set(message, interval)

    def set(self, message: int, interval_ms: int) -> bool:
        """Sends `message` every `interval_ms`; 0 back to the default, -1 never. False when there is no such message."""
        if message not in BUILDERS:
            return False
        if interval_ms == 0:
            interval_ms = self._defaults.get(message, -1)
        self._intervals.pop(message, None)
        if interval_ms > 0:
            self._intervals[message] = interval_ms
            order = {m: i for i, m in enumerate(BUILDERS)}
            self._intervals = dict(sorted(self._intervals.items(), key=lambda item: order[item[0]]))
        return True

    def interval_ms(self, message: int) -> int:
        """ms between two; -1 when it is not sent."""
        return self._intervals.get(message, -1)

    def due(self, t_ms: int) -> Iterator[int]:
        """The messages that are due at `t_ms`."""
        for message, interval in self._intervals.items():
            slot = t_ms // interval
            if self._last.get(message) != slot:
                self._last[message] = slot
                yield message
