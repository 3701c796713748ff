"""Point-mass dynamics of a multicopter behind an autopilot's velocity control, with limits, a lag and drag.

The autopilot shapes the velocity that it is asked for, within an acceleration and a jerk, and tracks the shaped one. The
numbers were fitted to ArduCopter 4.7-dev in its own simulation (SITL): steps, ramps of 2.5 m/s² with no, half and the whole
acceleration fed forward, and reversals, between 0 and 5 m/s; what is left is 0.11 m/s (root mean square).
"""

import math

ACCELERATION_LIMIT = 2.5
"""Horizontal, m/s² (ArduPilot's WPNAV_ACCEL); what is fed forward comes on top, as it does there."""
SHAPING_GAIN_PER_S = 1.7
JERK_LIMIT = 3.8
"""m/s³, of the shaped velocity."""
VERTICAL_ACCELERATION_LIMIT = 2.5
ATTITUDE_LAG_S = 0.27
"""The lean that makes an acceleration takes this long."""
DRAG_PER_S = 0.05
"""Of the speed through the air."""
VELOCITY_GAIN_PER_S = 5.8
INTEGRAL_GAIN_PER_S2 = 0.5
INTEGRAL_LIMIT = 2.0
"""m/s²; wind that drags harder than this carries the vehicle away."""
GRAVITY = 9.81
LONGEST_SLICE_S = 0.05


class Body:
    """Position (m east, north, up of the origin), velocity (m/s) and wind (m/s)."""

    __slots__ = (
        "_integral_e",
        "_integral_n",
        "_shaped",
        "acceleration_e",
        "acceleration_n",
        "east",
        "flown_m",
        "north",
        "ground",
        "up",
        "ve",
        "vn",
        "vu",
        "wind_e",
        "wind_n",
    )

    def __init__(self, east: float, north: float, up: float, wind: tuple[float, float] = (0.0, 0.0)) -> None:
        self.east, self.north, self.up = east, north, up
        self.ground = up
        self.wind_e, self.wind_n = wind
        self.flown_m = 0.0
        self.stop()

    def stop(self) -> None:
        """Stops at once."""
        self.vu = 0.0
        self.stop_horizontally()

    def stop_horizontally(self) -> None:
        """Stops at once over the ground."""
        self.ve = self.vn = 0.0
        self.acceleration_e = self.acceleration_n = 0.0
        self._integral_e = self._integral_n = 0.0
        self._shaped: tuple[float, float, float, float] | None = None

    @property
    def speed(self) -> float:
        """Over ground, m/s."""
        return math.hypot(self.ve, self.vn)

    @property
    def height_m(self) -> float:
        """Above the ground it started from."""
        return self.up - self.ground

    def follow(self, dt: float, ve: float, vn: float, vu: float, ff_e: float = 0.0, ff_n: float = 0.0) -> None:
        """Tracks a velocity (m/s) with a feed-forward acceleration (m/s²)."""
        shaped_e, shaped_n, shaped_ae, shaped_an = self._shape(dt, ve, vn, ff_e, ff_n)
        error_e, error_n = shaped_e - self.ve, shaped_n - self.vn
        self._integral_e = _clamp(self._integral_e + INTEGRAL_GAIN_PER_S2 * error_e * dt, INTEGRAL_LIMIT)
        self._integral_n = _clamp(self._integral_n + INTEGRAL_GAIN_PER_S2 * error_n * dt, INTEGRAL_LIMIT)
        want_e = shaped_ae + VELOCITY_GAIN_PER_S * error_e + self._integral_e
        want_n = shaped_an + VELOCITY_GAIN_PER_S * error_n + self._integral_n
        self._move(dt, want_e, want_n, self._climb(dt, vu))

    def _shape(self, dt: float, ve: float, vn: float, ff_e: float, ff_n: float) -> tuple[float, float, float, float]:
        """The velocity that is tracked instead of the one asked for, and its acceleration."""
        # After another kind of flight it begins where the vehicle is.
        at_e, at_n, ae, an = self._shaped or (self.ve, self.vn, self.acceleration_e, self.acceleration_n)
        want_e, want_n = _shorten(SHAPING_GAIN_PER_S * (ve - at_e), SHAPING_GAIN_PER_S * (vn - at_n), ACCELERATION_LIMIT)
        jerk_e, jerk_n = _shorten(want_e + ff_e - ae, want_n + ff_n - an, JERK_LIMIT * dt)
        ae, an = ae + jerk_e, an + jerk_n
        self._shaped = at_e + ae * dt, at_n + an * dt, ae, an
        return self._shaped

    def push(self, dt: float, acceleration_e: float, acceleration_n: float, acceleration_u: float) -> None:
        """Only accelerates: nothing holds a velocity or an altitude, and nothing caps the speed."""
        self._shaped = None
        lift = _clamp(acceleration_u, VERTICAL_ACCELERATION_LIMIT) - DRAG_PER_S * self.vu
        self._move(dt, *_shorten(acceleration_e, acceleration_n, ACCELERATION_LIMIT), lift)

    def drift(self, dt: float) -> None:
        """Level and at its altitude, but nobody holds the position."""
        self._shaped = None
        self._move(dt, 0.0, 0.0, self._climb(dt, 0.0))

    def fall(self, dt: float) -> None:
        """Motors off in the air."""
        self._move(dt, 0.0, 0.0, -GRAVITY - DRAG_PER_S * self.vu)

    def climb(self, dt: float, vu: float) -> None:
        """Only climbs, at `vu` m/s; the horizontal state stays as it is."""
        self.vu += self._climb(dt, vu) * dt
        self.up += self.vu * dt

    def _climb(self, dt: float, vu: float) -> float:
        return _clamp((vu - self.vu) / max(dt, 0.3), VERTICAL_ACCELERATION_LIMIT)

    def _move(self, dt: float, want_e: float, want_n: float, acceleration_u: float) -> None:
        share = 1.0 - math.exp(-dt / ATTITUDE_LAG_S)
        self.acceleration_e += (want_e - self.acceleration_e) * share
        self.acceleration_n += (want_n - self.acceleration_n) * share
        east = self.acceleration_e - DRAG_PER_S * (self.ve - self.wind_e)
        north = self.acceleration_n - DRAG_PER_S * (self.vn - self.wind_n)
        step_e = (self.ve + 0.5 * east * dt) * dt
        step_n = (self.vn + 0.5 * north * dt) * dt
        self.east += step_e
        self.north += step_n
        self.flown_m += math.hypot(step_e, step_n)
        self.ve += east * dt
        self.vn += north * dt
        self.up += (self.vu + 0.5 * acceleration_u * dt) * dt
        self.vu += acceleration_u * dt


def slices(dt: float) -> tuple[int, float]:
    """How many equal slices of at most LONGEST_SLICE_S make `dt` seconds, and how long each is."""
    count = max(1, math.ceil(dt / LONGEST_SLICE_S - 1e-9))
    return count, dt / count


def _shorten(east: float, north: float, limit: float) -> tuple[float, float]:
    """The vector, no longer than the limit."""
    size = math.hypot(east, north)
    share = limit / size if size > limit else 1.0
    return east * share, north * share


def _clamp(value: float, limit: float) -> float:
    return limit if value > limit else -limit if value < -limit else value
