"""The scenario's own dynamics: a jump at each step boundary, nothing in between."""

from dataclasses import dataclass

from simlink import actions
from simlink.float32 import TICKS_PER_U, f32, ticks


@dataclass(frozen=True)
class Scale:
    """What a map unit and a step are in flight, and how wide the map is."""

    scale_m: float = 2.5
    step_ms: int = 2000
    map_side_u: float = 200.0

    @property
    def step_s(self) -> float:
        """Length of a step, s."""
        return self.step_ms / 1000.0

    def velocity_u(self, mps: float) -> float:
        """m/s in u/step."""
        return mps * self.step_s / self.scale_m

    def acceleration_u(self, mps2: float) -> float:
        """m/s² in u/step²."""
        return mps2 * self.step_s * self.step_s / self.scale_m


class IdealState:
    """Position (u) and velocity (u/step) of one UAV, float32, as the training environment holds them."""

    __slots__ = ("_scale", "vx", "vy", "x", "y")

    def __init__(self, scale: Scale, x: float, y: float) -> None:
        self._scale = scale
        self.x, self.y = f32(x), f32(y)
        self.vx = self.vy = 0.0

    def act(self, action: int) -> None:
        """One step of an action of the scenario."""
        self._fly(*actions.next_velocity(action, self.vx, self.vy))

    def coast_at(self, vx: float, vy: float) -> None:
        """One step at this velocity, u/step, shortened to the speed cap."""
        self._fly(*actions.capped(f32(vx), f32(vy)))

    def stop(self) -> None:
        """Holds still."""
        self.vx = self.vy = 0.0

    def _fly(self, vx: float, vy: float) -> None:
        self.vx, self.vy = vx, vy
        side = f32(self._scale.map_side_u)
        self.x = min(max(f32(self.x + vx), 0.0), side)
        self.y = min(max(f32(self.y + vy), 0.0), side)

    def position_m(self) -> tuple[float, float]:
        """East and north, m, of the position rounded to ticks."""
        return self._metres(self.x, self._scale.scale_m), self._metres(self.y, self._scale.scale_m)

    def velocity_mps(self) -> tuple[float, float]:
        """East and north, m/s, of the velocity rounded to ticks."""
        factor = self._scale.scale_m / self._scale.step_s
        return self._metres(self.vx, factor), self._metres(self.vy, factor)

    @staticmethod
    def _metres(u: float, factor: float) -> float:
        return ticks(u) / TICKS_PER_U * factor
