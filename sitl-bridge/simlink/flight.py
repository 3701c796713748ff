"""The flight controller: from behaviour and setpoint to the motion of the body."""

import math

from simlink.body import Body, slices
from simlink.modes import Behaviour
from simlink.setpoint import Kind, Setpoint

CLIMB_MPS = 2.5
SINK_MPS, TOUCHDOWN_MPS, TOUCHDOWN_BELOW_M = 1.5, 0.5, 5.0
CRUISE_MPS = 5.0
SPEED_LIMIT_MPS = 10.0
POSITION_GAIN_PER_S = 0.7
ACCELERATION_BIAS = 0.05
"""m/s²: what an open-loop acceleration is wrong by; nothing corrects it."""


class Flight:
    """Controls the body by the present behaviour."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.grounded = True
        self.return_height_m = 0.0
        """Height above home to which a return climbs first."""
        self._behaviour = Behaviour.LEVEL
        self._climb_to: float | None = None
        self._hold: tuple[float, float, float] | None = None
        self._setpoint: Setpoint | None = None
        self._ve = self._vn = 0.0
        self._home = (body.east, body.north, body.up)
        self._at_height = False

    @property
    def climbing(self) -> bool:
        """Whether a take-off is under way."""
        return self._climb_to is not None

    @property
    def target_kind(self) -> Kind | None:
        """What the last setpoint controls."""
        return self._setpoint.kind if self._setpoint else None

    @property
    def setpoint(self) -> Setpoint | None:
        """The setpoint that is followed."""
        return self._setpoint

    def enter(self, behaviour: Behaviour) -> None:
        """Begins another behaviour."""
        self._behaviour = behaviour
        self._setpoint = self._hold = None
        self._at_height = False
        if behaviour is not Behaviour.TAKEOFF:
            self._climb_to = None

    def take_off(self, up: float) -> None:
        """Climbs straight to `up` m above the origin; then stays there."""
        self._climb_to = up
        self._home = (self._body.east, self._body.north, self._body.up)
        self._hold = (self._body.east, self._body.north, up)

    def follow(self, setpoint: Setpoint) -> None:
        """Follows a setpoint, which ends a take-off that is going on."""
        self._setpoint = setpoint
        self._climb_to = self._hold = None
        self._ve, self._vn, _ = setpoint.velocity

    def stop(self) -> None:
        """Drops the setpoint: brakes and holds the position."""
        self._setpoint = None

    def advance(self, dt: float, armed: bool, moves_by_itself: bool) -> float | None:
        """Moves the body; returns the speed at which it met the ground, if it did, m/s."""
        body = self._body
        if self.grounded and not (armed and self._climb_to is not None):
            return None
        count, slice_s = slices(dt)
        for _ in range(count):
            if not armed:
                body.fall(slice_s)
            elif self._climb_to is not None:
                self._take_off(slice_s, self._climb_to, moves_by_itself)
            elif self._behaviour in (Behaviour.RETURN, Behaviour.LAND):
                self._go_down(slice_s)
            elif not moves_by_itself:
                body.climb(slice_s, self._vertical())
            else:
                self._fly(slice_s)
            if body.up <= body.ground and body.vu <= 0.0 and not self.grounded:
                impact = -body.vu
                body.up = body.ground
                body.stop()
                self.grounded = True
                self._climb_to = None
                return impact
        return None

    def _take_off(self, dt: float, up: float, moves_by_itself: bool) -> None:
        body = self._body
        vu = _clamp(up - body.up, CLIMB_MPS)
        if moves_by_itself and self._hold:
            self._body.follow(dt, *self._towards(self._hold[0], self._hold[1]), vu)
        else:
            body.climb(dt, vu)
        if body.height_m > 0.1:
            self.grounded = False
        if abs(up - body.up) < 0.2 and abs(body.vu) < 0.3:
            self._climb_to = None

    def _fly(self, dt: float) -> None:
        body, setpoint = self._body, self._setpoint
        if self._behaviour is Behaviour.LEVEL:
            body.drift(dt)
        elif setpoint is None or setpoint.kind is Kind.STOP:
            self._stay(dt)
        elif setpoint.kind is Kind.VELOCITY:
            ae, an, _ = setpoint.acceleration
            # Between two setpoints the velocity goes on along the acceleration.
            self._ve, self._vn = _capped(self._ve + ae * dt, self._vn + an * dt, SPEED_LIMIT_MPS)
            body.follow(dt, self._ve, self._vn, _clamp(setpoint.velocity[2], CLIMB_MPS), ae, an)
        elif setpoint.kind is Kind.ACCELERATION:
            ae, an, au = setpoint.acceleration
            body.push(dt, ae + ACCELERATION_BIAS, an, au - ACCELERATION_BIAS)
        else:
            east, north, up = setpoint.position
            ve, vn = self._towards(east, north)
            body.follow(dt, ve + setpoint.velocity[0], vn + setpoint.velocity[1], _clamp(up - body.up, CLIMB_MPS))

    def _stay(self, dt: float) -> None:
        body = self._body
        if self._hold is None:
            body.follow(dt, 0.0, 0.0, 0.0)
            if body.speed < 0.3:
                self._hold = (body.east, body.north, body.up)
            return
        east, north, up = self._hold
        body.follow(dt, *self._towards(east, north), _clamp(up - body.up, SINK_MPS))

    def _go_down(self, dt: float) -> None:
        body = self._body
        if self._hold is None:
            self._hold = (body.east, body.north, body.up)
        east, north, _ = self._hold
        vu = -TOUCHDOWN_MPS if body.height_m < TOUCHDOWN_BELOW_M else -SINK_MPS
        if self._behaviour is Behaviour.RETURN:
            height = self._home[2] + self.return_height_m
            self._at_height = self._at_height or body.up >= height - 0.3
            if not self._at_height:
                vu = min(CLIMB_MPS, height - body.up)
            else:
                east, north, _ = self._home
                if math.hypot(east - body.east, north - body.north) > 1.0:
                    vu = 0.0
        body.follow(dt, *self._towards(east, north), vu)

    def _vertical(self) -> float:
        """Climb rate while nothing but the altitude moves by itself, m/s."""
        if self._setpoint is not None and self._behaviour is Behaviour.GUIDED:
            if self._setpoint.kind is Kind.POSITION:
                return _clamp(self._setpoint.position[2] - self._body.up, CLIMB_MPS)
            return _clamp(self._setpoint.velocity[2], CLIMB_MPS)
        return _clamp(self._hold[2] - self._body.up, SINK_MPS) if self._hold else 0.0

    def _towards(self, east: float, north: float) -> tuple[float, float]:
        body = self._body
        return _capped((east - body.east) * POSITION_GAIN_PER_S, (north - body.north) * POSITION_GAIN_PER_S, CRUISE_MPS)


def _capped(east: float, north: float, limit: float) -> tuple[float, float]:
    size = math.hypot(east, north)
    return (east * limit / size, north * limit / size) if size > limit else (east, north)


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
