"""A fleet of real autopilots, as a process that speaks simlink's lines: config, commands, events."""

import json
import os
import select
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simlink.events import EventLog
from simlink.geodesy import Plane
from simlink.hub import first_line

from sitl import arducopter, px4
from sitl.observer import Observer
from sitl.process import Process, SitlError
from sitl.spec import VehicleSpec

_TURN_S = 0.05
_LINK_RETRY_S = 0.5
_BEHIND_STEPS = 5


class Fleet:
    """Starts the instances of a configuration, reports where they truly are at each step, and ends them."""

    def __init__(self, config: dict[str, Any], emit: Callable[..., None]) -> None:
        origin = config["origin"]
        self._plane = Plane(origin["lat"], origin["lon"], origin["alt"])
        self._scale = float(config["scale_m"])
        self._step_ms = int(config["step_ms"])
        self._epoch_ms = int(config["epoch_unix_ms"])
        self._emit = emit
        self._started = time.monotonic()
        self._step = 0
        self._px4_links: list[px4.Links] = []
        self._link_at = 0.0
        self.stopped = False
        self.observers: list[Observer] = []
        self.processes: list[Process] = []
        self._build: Path | None = None
        try:
            self._start(config)
        except BaseException:
            self.end()
            raise

    def _start(self, config: dict[str, Any]) -> None:
        folder, speed = Path(config["folder"]), float(config.get("speed", 1.0))
        parameters = config.get("parameters", {})
        program = arducopter.program(config["program"]) if config["autopilot"] == "arducopter" else None
        self._build = px4.folder(config["program"]) if program is None else None
        for index, vehicle in enumerate(config["vehicles"]):
            x, y = vehicle["start_u"]
            lat, lon = self._plane.degrees(x * self._scale, y * self._scale)
            observer = Observer(int(vehicle["system"]))
            self.observers.append(observer)
            alt = self._plane.altitude_m
            port = int(vehicle["port"])
            spec = VehicleSpec(index, observer.system, lat, lon, alt, node_port=port, observer_port=observer.port)
            place = folder / f"uav-{vehicle['id']}"
            if program is not None:
                self.processes.append(arducopter.start(program, spec, place, speed, parameters))
            else:
                self.processes.append(px4.start(self._build, spec, place, speed, parameters))
                self._px4_links.append(px4.Links(self._build, spec))

    def run(self, control: int, line: bytes = b"") -> None:
        """Observes until it is stopped; `control` has the commands, of which `line` was read already."""
        self.report("ready", vehicles=len(self.processes))
        poll = select.poll()
        poll.register(control, select.POLLIN)
        for observer in self.observers:
            poll.register(observer.fileno(), select.POLLIN)
        line = self._commands(line)
        while not self.stopped:
            for fd, _ in poll.poll(_TURN_S * 1000):
                if fd == control:
                    chunk = os.read(control, 65_536)
                    self.stopped |= not chunk
                    line = self._commands(line + chunk)
            self.turn(time.monotonic())

    def _commands(self, text: bytes) -> bytes:
        """Carries out the whole lines of a text; returns what follows them."""
        *lines, rest = text.split(b"\n")
        for line in filter(None, lines):
            self.command(line)
        return rest

    def turn(self, now: float) -> None:
        """Takes in what the vehicles said and reports the steps that all of them have reached."""
        for process in self.processes:
            process.check()
        if self._px4_links and now >= self._link_at:
            self._link_at = now + _LINK_RETRY_S
            self._px4_links = [links for links in self._px4_links if not links.add()]
        for observer in self.observers:
            observer.receive(now)
        while self._report_truth():
            pass

    def command(self, text: bytes) -> None:
        """Carries out a control line."""
        try:
            ((name, value),) = json.loads(text).items()
            if name == "stop":
                self.stopped = True
            elif name == "epoch_unix_ms":
                self._epoch_ms, self._step = int(value), 0
            else:
                raise ValueError(f"there is no command `{name}`; known: epoch_unix_ms, stop")
        except (ValueError, AttributeError, TypeError) as error:
            self.report("error", text=str(error))

    def report(self, event: str, **fields: Any) -> None:
        """Writes an event; its time is the host's since the start."""
        self._emit(event, t_ms=round((time.monotonic() - self._started) * 1000), **fields)

    def _report_truth(self) -> bool:
        due_ms = self._epoch_ms + self._step * self._step_ms
        places = [observer.place_at(due_ms) for observer in self.observers]
        if any(place is None for place in places):
            # A vehicle that ceased to tell keeps the others' places from being reported, but not for long.
            newest = max((o.places[-1].unix_ms for o in self.observers if o.places), default=0.0)
            if newest - due_ms < _BEHIND_STEPS * self._step_ms:
                return False
        else:
            metres = [self._plane.metres(place.lat, place.lon) for place in places if place is not None]
            on_map = [[round(v / self._scale, 5) for v in pair] for pair in metres]
            self.report("truth", step=self._step, u=on_map)
        self._step += 1
        return True

    def end(self) -> None:
        """Ends all instances."""
        for process in self.processes:
            process.end()
        for observer in self.observers:
            observer.close()


def main() -> int:
    """Runs a fleet from one line of JSON on stdin; returns the exit status."""
    control = sys.stdin.fileno()
    line, rest = first_line(control)
    try:
        fleet = Fleet(json.loads(line), EventLog(sys.stdout))
    except (ValueError, KeyError) as error:
        print(f"sitl: the first line of stdin is no configuration: {error!r}", file=sys.stderr)
        return 2
    except SitlError as error:
        print(f"sitl: {error}", file=sys.stderr)
        return 2
    try:
        fleet.run(control, rest)
    except SitlError as error:
        print(f"sitl: {error}", file=sys.stderr)
        return 1
    except (KeyboardInterrupt, BrokenPipeError):
        return 0
    finally:
        fleet.end()
    return 0
