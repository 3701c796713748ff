"""Commands to a running fleet, one JSON object a line."""

import json
from dataclasses import dataclass
from typing import Any

from simlink.faults import Fault


@dataclass(frozen=True)
class Stop:
    """Ends the flight."""


@dataclass(frozen=True)
class AddFault:
    """Adds a fault to a vehicle."""

    fault: Fault


@dataclass(frozen=True)
class PilotMode:
    """The pilot of vehicle `id` switches to the mode `name`."""

    id: Any
    name: str


@dataclass(frozen=True)
class SetEpoch:
    """Step 0 begins at this Unix time, ms."""

    unix_ms: int


@dataclass(frozen=True)
class SetSpeed:
    """The wall clock runs at so many times real time."""

    speed: float


@dataclass(frozen=True)
class ReportStats:
    """Writes a `stats` event."""


Command = Stop | AddFault | PilotMode | SetEpoch | SetSpeed | ReportStats


def parse(line: bytes | None) -> Command | None:
    """The command in a control line; None for an empty line. The end of the lines (None) is a Stop.

    Raises ValueError, TypeError or KeyError when the line is no command.
    """
    if line is None:
        return Stop()
    if not line.strip():
        return None
    command = json.loads(line)
    if not isinstance(command, dict) or len(command) != 1:
        raise ValueError('a command is an object with one field, such as {"stop": true}')
    ((name, value),) = command.items()
    match name:
        case "stop":
            return Stop()
        case "fault":
            return AddFault(Fault.read(value))
        case "mode":
            return PilotMode(value["id"], value["name"])
        case "epoch_unix_ms":
            return SetEpoch(int(value))
        case "speed":
            if not value > 0:
                raise ValueError(f"the speed is greater than 0, not {value}")
            return SetSpeed(float(value))
        case "stats":
            return ReportStats()
        case _:
            raise ValueError(f"there is no command `{name}`; known: fault, mode, speed, epoch_unix_ms, stats, stop")
