"""Others on a vehicle's port, as MAVProxy and mavlink-router put them there.

Seen with `sim_vehicle.py --count 3`: every vehicle is on every port.
"""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink import batteries
from simlink.endpoint import Endpoint

OTHER_SYSTEM = 253
"""System of the other vehicle."""

KINDS = ("vehicle", "camera", "companion")
"""Another ArduCopter in GUIDED and in the air; a camera and a companion computer with the vehicle's own system."""


NAMES = (*KINDS, *batteries.EXTRAS)
"""All that `--extra` knows."""


class Extra:
    """One of them. It sends HEARTBEATs, the vehicle also positions, and answers nothing."""

    def __init__(self, kind: str, system: int, key: bytes | None) -> None:
        system, component = {
            "vehicle": (OTHER_SYSTEM, mavlink.MAV_COMP_ID_AUTOPILOT1),
            "camera": (system, mavlink.MAV_COMP_ID_CAMERA),
            "companion": (system, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER2),
        }[kind]
        self._kind = kind
        self._endpoint = Endpoint(system, component, key)

    def frames(self, boot_ms: int) -> list[bytes]:
        """What it sends in a second."""
        return [self._endpoint.pack(message) for message in self._messages(boot_ms)]

    def _messages(self, boot_ms: int) -> list[mavlink.MAVLink_message]:
        match self._kind:
            case "camera":
                kind, autopilot, mode = mavlink.MAV_TYPE_CAMERA, mavlink.MAV_AUTOPILOT_INVALID, 0
            case "companion":
                kind, autopilot, mode = mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0
            case _:
                kind, autopilot, mode = mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 4
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self._kind == "vehicle" else 0
        base_mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed
        messages = [mavlink.MAVLink_heartbeat_message(kind, autopilot, base_mode, mode, mavlink.MAV_STATE_ACTIVE, 3)]
        if self._kind == "vehicle":
            place = (473_000_000, 85_000_000, 500_000, 50_000)
            messages.append(mavlink.MAVLink_global_position_int_message(boot_ms + 77_000, *place, 0, 0, 0, 0))
        return messages
