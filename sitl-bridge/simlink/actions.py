"""The 17 actions of the scenario, in float32."""

import math

from simlink.float32 import f32

SPEED_CAP_U = 4.0
"""Greatest speed, u/step."""

_S = f32(math.sqrt(0.5))
_DIRECTIONS = ((1.0, 0.0), (_S, -_S), (0.0, -1.0), (-_S, -_S), (-1.0, 0.0), (-_S, _S), (0.0, 1.0), (_S, _S))

ACCELERATIONS = tuple((a * x, a * y) for a in (4.0, 2.0) for x, y in _DIRECTIONS) + ((0.0, 0.0),)
"""Acceleration (east, north) of each action, u/step²."""

COAST = len(ACCELERATIONS) - 1
"""The action that does not accelerate."""


def nearest(east: float, north: float) -> int:
    """The action whose acceleration is nearest to this one, u/step²."""
    return min(range(len(ACCELERATIONS)), key=lambda k: math.dist(ACCELERATIONS[k], (east, north)))


def next_velocity(action: int, vx: float, vy: float) -> tuple[float, float]:
    """Velocity after one step of `action`, u/step: v + a, shortened to the speed cap."""
    ax, ay = ACCELERATIONS[action]
    return capped(f32(vx + ax), f32(vy + ay))


def capped(vx: float, vy: float) -> tuple[float, float]:
    """`(vx, vy)`, u/step, shortened to the speed cap; in the order of operations of the on-board code."""
    speed = f32(math.sqrt(f32(f32(vx * vx) + f32(vy * vy))))
    if speed > SPEED_CAP_U:
        shorter = f32(SPEED_CAP_U / speed)
        return f32(vx * shorter), f32(vy * shorter)
    return vx, vy
