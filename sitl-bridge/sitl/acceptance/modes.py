"""Flight modes by name, as each autopilot numbers them, and the command that a pilot's switch stands for."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.acceptance.case import ARDUCOPTER

_COPTER = {"STABILIZE": 0, "GUIDED": 4, "LOITER": 5, "RTL": 6, "LAND": 9, "BRAKE": 17}
_PX4_MAIN = {"POSCTL": (3, 0), "OFFBOARD": (6, 0), "LOITER": (4, 3), "RTL": (4, 5), "LAND": (4, 6), "TAKEOFF": (4, 2)}


def custom_mode(autopilot: str, name: str) -> int:
    """`custom_mode` of a HEARTBEAT in this mode."""
    if autopilot == ARDUCOPTER:
        return _COPTER[name]
    main, sub = _PX4_MAIN[name]
    return main << 16 | sub << 24


def name_of(autopilot: str, number: int | None) -> str:
    """The name of a `custom_mode`."""
    table = _COPTER if autopilot == ARDUCOPTER else _PX4_MAIN
    return next((name for name in table if custom_mode(autopilot, name) == number), str(number))


def set_mode(autopilot: str, name: str) -> tuple[int, ...]:
    """MAV_CMD_DO_SET_MODE with its parameters."""
    numbers = (_COPTER[name],) if autopilot == ARDUCOPTER else _PX4_MAIN[name]
    return mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, *numbers


def controlled(autopilot: str) -> str:
    """The mode in which the node flies."""
    return "GUIDED" if autopilot == ARDUCOPTER else "OFFBOARD"
