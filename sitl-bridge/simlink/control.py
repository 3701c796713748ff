"""Commands to a running fleet, one JSON object a line."""

import json
import logging
from typing import TYPE_CHECKING, Any

from simlink.faults import Fault, FaultError

if TYPE_CHECKING:
    from simlink.fleet import Fleet

logger = logging.getLogger(__name__)


class Control:
    """Carries out control lines; a line that makes no sense is answered with an `error` event."""

    def __init__(self, fleet: "Fleet") -> None:
        self._fleet = fleet

    def take(self, line: bytes | None) -> None:
        """One line; None when there will be no more, which ends the flight."""
        if line is None:
            self._fleet.stopped = True
            return
        if not line.strip():
            return
        try:
            command = json.loads(line)
            if not isinstance(command, dict) or len(command) != 1:
                raise ValueError('a command is an object with one field, such as {"stop": true}')
            ((name, value),) = command.items()
            self._carry_out(name, value)
        except (ValueError, TypeError, KeyError) as error:
            logger.error("control: %s", error)
            self._fleet.report("error", reason=f"control: {error}")

    def _carry_out(self, name: str, value: Any) -> None:
        fleet = self._fleet
        match name:
            case "stop":
                fleet.stopped = True
            case "fault":
                fault = Fault.read(value)
                vehicle = fleet.vehicle(fault.id)
                if vehicle is None:
                    raise FaultError(f"there is no vehicle {fault.id}")
                vehicle.faults.add(fault)
            case "mode":
                vehicle = fleet.vehicle(value["id"])
                if vehicle is None:
                    raise ValueError(f"there is no vehicle {value['id']}")
                vehicle.pilot_mode(value["name"])
            case "epoch_unix_ms":
                fleet.epoch_unix_ms = int(value)
            case "speed":
                if not value > 0:
                    raise ValueError(f"the speed is greater than 0, not {value}")
                fleet.speed = float(value)
            case "stats":
                fleet.report("stats", **fleet.stats())
            case _:
                raise ValueError(f"there is no command `{name}`; known: fault, mode, speed, epoch_unix_ms, stats, stop")
