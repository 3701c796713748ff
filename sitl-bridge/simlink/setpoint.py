"""SET_POSITION_TARGET_LOCAL_NED and its type mask."""

import math
from dataclasses import dataclass
from enum import Enum, auto

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_POSITION, _VELOCITY, _ACCELERATION = 0x007, 0x038, 0x1C0
FRAMES = (mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_LOCAL_OFFSET_NED)


class Kind(Enum):
    """What a setpoint controls."""

    POSITION = auto()
    VELOCITY = auto()
    ACCELERATION = auto()
    STOP = auto()


@dataclass
class Setpoint:
    """A target in metres east, north, up; what the mask ignores is zero."""

    kind: Kind
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    acceleration: tuple[float, float, float]
    has_velocity: bool
    has_acceleration: bool

    @property
    def is_finite(self) -> bool:
        """Whether no used number is NaN or infinite."""
        return all(math.isfinite(v) for v in (*self.position, *self.velocity, *self.acceleration))


def read(message: mavlink.MAVLink_set_position_target_local_ned_message) -> Setpoint:
    """The setpoint in a message.

    Position, velocity and acceleration each count as a whole or not at all: when one axis is ignored, all three
    are. With nothing left, or a position and an acceleration without a velocity, the vehicle stops.
    """
    mask = message.type_mask
    has_position, has_velocity = not mask & _POSITION, not mask & _VELOCITY
    has_acceleration = not mask & _ACCELERATION
    if has_position and (has_velocity or not has_acceleration):
        kind = Kind.POSITION
    elif has_position:
        kind = Kind.STOP
    elif has_velocity:
        kind = Kind.VELOCITY
    else:
        kind = Kind.ACCELERATION if has_acceleration else Kind.STOP
    zero = (0.0, 0.0, 0.0)
    return Setpoint(
        kind,
        (message.y, message.x, -message.z) if has_position else zero,
        (message.vy, message.vx, -message.vz) if has_velocity else zero,
        (message.afy, message.afx, -message.afz) if has_acceleration else zero,
        has_velocity,
        has_acceleration,
    )
