"""The status of a fleet on a terminal."""

import logging
from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from simlink.fleet import Fleet

REFRESH_S, REFRESH_PLAIN_S = 0.25, 10.0


class StatusLine:
    """One line that is redrawn in place; without a terminal a line now and then."""

    def __init__(self, out: TextIO, clock: Callable[[], float]) -> None:
        self._out, self._clock = out, clock
        self._is_terminal = out.isatty()
        self._refresh_s = REFRESH_S if self._is_terminal else REFRESH_PLAIN_S
        self._last: tuple[float, int] = (clock(), 0)

    def __call__(self, fleet: "Fleet") -> None:
        """Called at each tick."""
        now = self._clock()
        wall_s, t_ms = self._last
        if now - wall_s < self._refresh_s:
            return
        speed = (fleet.t_ms - t_ms) / 1000.0 / (now - wall_s)
        self._last = (now, fleet.t_ms)
        text = f"{fleet.t_ms / 1000.0:8.1f} s  x{speed:<5.1f} {summary(fleet)}"
        self._out.write(f"\r\x1b[2K{text}" if self._is_terminal else f"simlink: {text}\n")
        self._out.flush()


def summary(fleet: "Fleet") -> str:
    """The fleet in a line."""
    autopilots = [vehicle.autopilot for vehicle in fleet.vehicles]
    heard = sum(autopilot.controller_heard for autopilot in autopilots)
    parts = [
        f"{heard} of {len(autopilots)} controlled",
        f"{sum(autopilot.armed for autopilot in autopilots)} armed",
        f"{sum(autopilot.airborne for autopilot in autopilots)} in the air",
        f"{sum(autopilot.is_streaming for autopilot in autopilots)} streaming",
    ]
    if crashed := sum(autopilot.crashed for autopilot in autopilots):
        parts.append(f"{crashed} crashed")
    modes = Counter(autopilot.mode.name for autopilot in autopilots)
    return ", ".join(parts) + "; " + ", ".join(f"{name} {count}" for name, count in sorted(modes.items()))


class EventLines:
    """Events as lines of a log, for people."""

    _QUIET = ("truth", "ready")

    def __init__(self, logger: logging.Logger) -> None:
        self._logger = logger

    def __call__(self, event: str, **fields: Any) -> None:
        """Writes one event."""
        if event in self._QUIET:
            return
        seconds = fields.pop("t_ms") / 1000.0
        if event == "stats":
            self._logger.info("%.1f s simulated, %s times real time", seconds, fields["realtime_factor"])
            return
        who = f"vehicle {fields.pop('id')}: " if "id" in fields else ""
        rest = ", ".join(f"{name} {value}" for name, value in fields.items())
        self._logger.info("%.1f s  %s%s%s", seconds, who, event.replace("_", " "), f" ({rest})" if rest else "")
