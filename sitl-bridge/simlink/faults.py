"""Scripted faults: which fault of which autopilot, when and for how long."""

from dataclasses import dataclass, field
from typing import Any

KINDS = {
    "gps_lost": "no GPS fix; the EKF drops its absolute position a second later",
    "pose_frozen": "position messages go on with new times and the old position",
    "pose_stale": "position messages cease",
    "nan": "LOCAL_POSITION_NED carries a NaN and an infinity",
    "ekf_bad": "the EKF reports large variances and no absolute position",
    "clock_jump": "the boot clock jumps by `by_ms`",
    "clock_unset": "SYSTEM_TIME counts from 1970, as a clock that was never set",
    "link_cut": "nothing is sent or taken",
    "reboot": "silent for `for_ms` (2000), then starts from nothing: disarmed, boot clock from zero",
    "pilot_mode": "the pilot switches to `mode`",
    "battery_low": "the battery falls to `percent` (12)",
    "teleport": "the position jumps by `by_u`: [x, y] in map units",
    "disarm": "the motors stop",
}
"""Every kind and what it does."""

PHASES = ("takeoff", "transit", "hold")
_OPTIONS = {"clock_jump": "by_ms", "pilot_mode": "mode", "battery_low": "percent", "teleport": "by_u"}


class FaultError(ValueError):
    """A fault that makes no sense; the message says why."""


@dataclass(frozen=True)
class Fault:
    """One fault of one vehicle."""

    id: int
    kind: str
    at_ms: int | None = None
    phase: str | None = None
    after_ms: int = 0
    for_ms: int | None = None
    option: Any = None

    @classmethod
    def read(cls, raw: Any) -> "Fault":
        """From a JSON object.

        Raises FaultError when a field is missing, unknown or not of its kind.
        """
        if not isinstance(raw, dict) or not isinstance(raw.get("id"), int):
            raise FaultError(f"a fault is an object with a vehicle's `id` and a `kind`, not {raw!r}")
        kind = raw.get("kind")
        if kind not in KINDS:
            raise FaultError(f"there is no fault {kind!r}; known: {', '.join(KINDS)}")
        option = _OPTIONS.get(kind)
        known = {"id", "kind", "at_ms", "phase", "after_ms", "for_ms", *([option] if option else [])}
        if unknown := raw.keys() - known:
            raise FaultError(f"fault {kind} has no field `{min(unknown)}`; it has {', '.join(sorted(known))}")
        for name in ("at_ms", "after_ms", "for_ms"):
            if (value := raw.get(name)) is not None and (not isinstance(value, int) or value < 0):
                raise FaultError(f"fault {kind}: {name} is whole milliseconds, not {value!r}")
        if (phase := raw.get("phase")) is not None and phase not in PHASES:
            raise FaultError(f"fault {kind}: there is no phase {phase!r}; known: {', '.join(PHASES)}")
        return cls(
            raw["id"],
            kind,
            raw.get("at_ms"),
            phase,
            raw.get("after_ms") or 0,
            raw.get("for_ms"),
            _option(kind, raw.get(option) if option else None),
        )


def _option(kind: str, value: Any) -> Any:
    if kind == "clock_jump" and not isinstance(value, int):
        raise FaultError(f"fault clock_jump needs `by_ms`, whole milliseconds, not {value!r}")
    if kind == "pilot_mode" and not isinstance(value, str):
        raise FaultError(f"fault pilot_mode needs `mode`, a mode's name, not {value!r}")
    if kind == "teleport":
        pair = [value, 0] if isinstance(value, int | float) else value
        if not (isinstance(pair, list) and len(pair) == 2 and all(isinstance(v, int | float) for v in pair)):
            raise FaultError(f"fault teleport needs `by_u`: [x, y] in map units, not {value!r}")
        return tuple(pair)
    if kind == "battery_low":
        percent = 12 if value is None else value
        if not isinstance(percent, int | float) or not 0 <= percent <= 100:
            raise FaultError(f"fault battery_low: `percent` is 0 to 100, not {value!r}")
        return percent
    return value


@dataclass
class FaultPlan:
    """The faults of one vehicle: pending and active ones."""

    waiting: list[Fault] = field(default_factory=list)
    _armed: list[tuple[int, Fault]] = field(default_factory=list)
    _until: dict[str, float] = field(default_factory=dict)

    def add(self, fault: Fault) -> None:
        """Adds one; without a time or a phase it begins at the next tick."""
        self.waiting.append(fault)

    def is_active(self, kind: str) -> bool:
        """Whether a fault of this kind lasts."""
        return kind in self._until

    def advance(self, t_ms: int, phase: str | None) -> tuple[list[Fault], list[str]]:
        """The faults that begin and the kinds that end by `t_ms`, when the vehicle flies in `phase`."""
        if not (self.waiting or self._armed or self._until):
            return [], []
        for fault in self.waiting[:]:
            if fault.phase is None or fault.phase == phase:
                start = t_ms if fault.at_ms is None else max(t_ms if fault.phase else 0, fault.at_ms)
                self._armed.append((start + fault.after_ms, fault))
                self.waiting.remove(fault)
        ended = [kind for kind, until in self._until.items() if t_ms >= until]
        for kind in ended:
            del self._until[kind]
        begun = [fault for start, fault in self._armed if t_ms >= start]
        self._armed = [(start, fault) for start, fault in self._armed if t_ms < start]
        for fault in begun:
            self._until[fault.kind] = float("inf") if fault.for_ms is None else t_ms + fault.for_ms
        return begun, ended
