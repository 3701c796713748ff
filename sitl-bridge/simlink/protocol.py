"""How an autopilot handles received messages: commands, setpoints, parameters."""

import math
import struct

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink import modes, schedule, setpoint, telemetry
from simlink.px4 import Px4
from simlink.schedule import Schedule
from simlink.vehicle_state import VehicleState

ACCEPTED = mavlink.MAV_RESULT_ACCEPTED
REJECTED = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
DENIED = mavlink.MAV_RESULT_DENIED
UNSUPPORTED = mavlink.MAV_RESULT_UNSUPPORTED
FAILED = mavlink.MAV_RESULT_FAILED

FORCE = 21196
"""The magic number that arms or disarms without checks."""
_AUTOPILOT = mavlink.MAV_COMP_ID_AUTOPILOT1


class Protocol:
    """Handles messages for one vehicle; answers go to its outbox."""

    def __init__(self, vehicle: VehicleState, streams: Schedule, outbox: list[mavlink.MAVLink_message]) -> None:
        self._vehicle, self._streams, self._outbox = vehicle, streams, outbox
        self._handlers = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._heartbeat,
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: self._setpoint,
            mavlink.MAVLINK_MSG_ID_COMMAND_LONG: self._command_long,
            mavlink.MAVLINK_MSG_ID_COMMAND_INT: self._command_int,
            mavlink.MAVLINK_MSG_ID_SET_MODE: self._set_mode,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: self._param_list,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: self._param_read,
            mavlink.MAVLINK_MSG_ID_PARAM_SET: self._param_set,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: self._mission_list,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._timesync,
        }
        self._commands = {
            mavlink.MAV_CMD_COMPONENT_ARM_DISARM: self._arm,
            mavlink.MAV_CMD_NAV_TAKEOFF: self._takeoff,
            mavlink.MAV_CMD_NAV_LAND: lambda *_: self._change_mode("LAND"),
            mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda *_: self._change_mode("RTL"),
            mavlink.MAV_CMD_DO_SET_MODE: self._do_set_mode,
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
            mavlink.MAV_CMD_REQUEST_MESSAGE: self._request,
            mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: lambda *_: self._send_version(),
            mavlink.MAV_CMD_GET_HOME_POSITION: lambda *_: self._request(mavlink.MAVLINK_MSG_ID_HOME_POSITION),
            mavlink.MAV_CMD_DO_CHANGE_SPEED: lambda *_: ACCEPTED,
        }

    def handle(self, message: mavlink.MAVLink_message) -> None:
        """Handles a message, if it is addressed to this autopilot."""
        handler = self._handlers.get(message.get_msgId())
        if handler is None:
            return
        if getattr(message, "target_system", 0) not in (0, self._vehicle.config.system):
            return
        if getattr(message, "target_component", 0) not in (0, _AUTOPILOT):
            return
        handler(message)

    def flush_texts(self) -> None:
        """Turns the autopilot's texts into STATUSTEXT messages."""
        for severity, text in self._vehicle.autopilot.texts:
            self._outbox.append(mavlink.MAVLink_statustext_message(severity, text.encode()[:50]))
        self._vehicle.autopilot.texts.clear()

    def _send(self, message: mavlink.MAVLink_message) -> int:
        self._outbox.append(message)
        return ACCEPTED

    def _send_version(self) -> int:
        return self._send(telemetry.autopilot_version(self._vehicle))

    def _heartbeat(self, message: mavlink.MAVLink_message) -> None:
        autopilot = self._vehicle.autopilot
        autopilot.controller_heard |= message.autopilot == mavlink.MAV_AUTOPILOT_INVALID
        if autopilot.is_ground_station(message.get_srcSystem(), message.type):
            autopilot.heartbeat()

    def _setpoint(self, message: mavlink.MAVLink_message) -> None:
        autopilot = self._vehicle.autopilot
        if message.coordinate_frame not in setpoint.FRAMES:
            autopilot.count("ignored_frame")
            return
        target = setpoint.read(message)
        if target.kind is setpoint.Kind.POSITION:
            e, n, u = self._vehicle.ekf_origin
            if message.coordinate_frame == mavlink.MAV_FRAME_LOCAL_OFFSET_NED:
                e, n, u = autopilot.body.east, autopilot.body.north, autopilot.body.up
            x, y, z = target.position
            target.position = (e + x, n + y, u + z)
        autopilot.accept_setpoint(target)

    # Commands

    def _command_long(self, m: mavlink.MAVLink_message) -> None:
        parameters = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
        self._command(m, m.command, parameters)

    def _command_int(self, m: mavlink.MAVLink_message) -> None:
        parameters = (m.param1, m.param2, m.param3, m.param4, m.x / 1e7, m.y / 1e7, m.z)
        self._command(m, m.command, parameters)

    def _command(self, message: mavlink.MAVLink_message, command: int, parameters: tuple[float, ...]) -> None:
        handler = self._commands.get(command)
        try:
            result = UNSUPPORTED if handler is None else handler(*parameters)
        except (ValueError, OverflowError):  # where a whole number should be there is none
            result = DENIED
        self.flush_texts()
        self._send(
            mavlink.MAVLink_command_ack_message(
                command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()
            )
        )

    def _arm(self, start: float, magic: float, *_: float) -> int:
        autopilot, force = self._vehicle.autopilot, magic == FORCE
        return ACCEPTED if (autopilot.arm(force) if start == 1.0 else autopilot.disarm(force)) else FAILED

    def _takeoff(self, *parameters: float) -> int:
        height, autopilot = parameters[6], self._vehicle.autopilot
        if isinstance(autopilot, Px4):
            # Above the sea; without a number a parameter says how high above the ground.
            known = math.isfinite(height)
            default = autopilot.body.up + autopilot.parameters["MIS_TAKEOFF_ALT"]
            up = height - self._vehicle.plane.altitude_m if known else default
        else:
            up = autopilot.body.up + height
        if not math.isfinite(up) or up <= autopilot.body.up:
            return DENIED
        return ACCEPTED if autopilot.take_off(up) else FAILED

    def _do_set_mode(self, base: float, main: float, sub: float, *_: float) -> int:
        if not int(base) & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            return DENIED
        number = int(main) << 16 | int(sub) << 24 if isinstance(self._vehicle.autopilot, Px4) else int(main)
        return self._change_to(modes.by_number(self._vehicle.autopilot.MODES, number))

    def _set_mode(self, message: mavlink.MAVLink_message) -> None:
        self._change_to(modes.by_number(self._vehicle.autopilot.MODES, message.custom_mode))
        self.flush_texts()

    def _change_mode(self, name: str) -> int:
        return self._change_to(modes.by_name(self._vehicle.autopilot.MODES, name))

    def _change_to(self, mode: modes.Mode | None) -> int:
        if mode is None:
            return FAILED
        if self._vehicle.autopilot.change_mode(mode, "command"):
            return ACCEPTED
        return REJECTED if isinstance(self._vehicle.autopilot, Px4) else FAILED

    def _set_interval(self, message: float, interval_us: float, *_: float) -> int:
        interval_ms = max(1, round(interval_us / 1000)) if interval_us > 0 else int(interval_us)
        return ACCEPTED if self._streams.set(int(message), interval_ms) else FAILED

    def _get_interval(self, message: float, *_: float) -> int:
        interval_ms = self._streams.interval_ms(int(message))
        interval_us = interval_ms * 1000 if interval_ms > 0 else -1
        return self._send(mavlink.MAVLink_message_interval_message(int(message), interval_us))

    def _request(self, message: float, *_: float) -> int:
        builder = schedule.BUILDERS.get(int(message))
        if builder is None or not schedule.is_known(self._vehicle, int(message)):
            return FAILED
        return self._send(builder(self._vehicle))

    # Parameters, missions, time

    def _param_value(self, name: str) -> None:
        autopilot = self._vehicle.autopilot
        parameters = autopilot.parameters
        value, kind = parameters[name], mavlink.MAV_PARAM_TYPE_REAL32
        if name in autopilot.INTEGERS:
            (value,), kind = struct.unpack("<f", struct.pack("<i", int(value))), mavlink.MAV_PARAM_TYPE_INT32
        index = list(parameters).index(name)
        self._send(mavlink.MAVLink_param_value_message(name.encode(), value, kind, len(parameters), index))

    def _param_list(self, _: mavlink.MAVLink_message) -> None:
        for name in self._vehicle.autopilot.parameters:
            self._param_value(name)

    def _param_read(self, message: mavlink.MAVLink_message) -> None:
        names = list(self._vehicle.autopilot.parameters)
        name = names[message.param_index] if 0 <= message.param_index < len(names) else _name(message.param_id)
        if name in names:
            self._param_value(name)

    def _param_set(self, message: mavlink.MAVLink_message) -> None:
        name, value = _name(message.param_id), message.param_value
        autopilot = self._vehicle.autopilot
        if name in autopilot.INTEGERS and message.param_type == mavlink.MAV_PARAM_TYPE_INT32:
            (value,) = struct.unpack("<i", struct.pack("<f", value))
        if name in autopilot.parameters and math.isfinite(value):
            autopilot.parameters[name] = float(value)
            self._param_value(name)

    def _mission_list(self, message: mavlink.MAVLink_message) -> None:
        self._send(
            mavlink.MAVLink_mission_count_message(
                message.get_srcSystem(), message.get_srcComponent(), 0, message.mission_type
            )
        )

    def _timesync(self, message: mavlink.MAVLink_message) -> None:
        if message.tc1 == 0:
            self._send(mavlink.MAVLink_timesync_message(self._vehicle.boot_us * 1000, message.ts1))


def _name(raw: str | bytes) -> str:
    text = raw.decode(errors="replace") if isinstance(raw, bytes) else raw
    return text.rstrip("\0")
