"""One vehicle of real firmware, its node, and a pilot beside them."""

import math
import select
import socket
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from pymavlink.dialects.v20 import ardupilotmega as mavlink
from simlink.geodesy import Plane

from sitl import arducopter, px4
from sitl.acceptance.bench import Bench
from sitl.acceptance.case import ARDUCOPTER, PX4, Failure
from sitl.acceptance.modes import custom_mode, name_of, set_mode
from sitl.acceptance.node import Node
from sitl.observer import GROUND_STATION, OBSERVER, Observer
from sitl.process import Process
from sitl.spec import VehicleSpec

_TURN_S = 0.05
_LINK_RETRY_S = 0.5
_LIMIT_S = 120.0
ORIGIN = Plane(47.397742, 8.545594, 488.0)


def free_port() -> int:
    """A UDP port on this computer that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Rig:
    """A vehicle, and who flies it. Ends all that it started when it is left."""

    def __init__(
        self,
        bench: Bench,
        index: int = 0,
        parameters: dict[str, float] | None = None,
        pilot: bool = True,
        node_link: str = "",
    ) -> None:
        self.bench, self.index, self.autopilot = bench, index, bench.autopilot
        # PX4 numbers its vehicles by its instances.
        self.system = index + 1 if bench.autopilot == ARDUCOPTER else bench.instance + index + 1
        self.node_port = free_port()
        self.observer = Observer(self.system, GROUND_STATION if pilot else OBSERVER)
        self._pilot = pilot
        self._beat_at = self._link_at = self._sticks_at = 0.0
        self._nodes: list[Node] = []
        lat, lon = ORIGIN.degrees(100.0 + 20.0 * index, 150.0)
        self._spec = VehicleSpec(
            bench.instance + index,
            self.system,
            lat,
            lon,
            ORIGIN.altitude_m,
            node_port=self.node_port,
            observer_port=self.observer.port,
            node_link=node_link,
        )
        place = bench.folder / f"vehicle-{index}"
        start = arducopter.start if self.autopilot == ARDUCOPTER else px4.start
        self._links = None if self.autopilot == ARDUCOPTER else px4.Links(bench.program, self._spec)
        # PX4 takes a pilot's modes only with sticks: those of a ground station, here, which a busy computer sends late.
        sticks = {"COM_RC_IN_MODE": 1, "COM_RC_LOSS_T": 30} if self.autopilot == PX4 and pilot else {}
        values = {**sticks, **(parameters or {})}
        self._process: Process = start(bench.program, self._spec, place, parameters=values)

    def __enter__(self) -> "Rig":
        return self

    def __exit__(self, *_: object) -> None:
        for node in self._nodes:
            node.end()
        self._process.end()
        self.observer.close()

    # The node

    def mission(self) -> Path:
        """A mission of world 0, whose steps have begun."""
        path = self.bench.folder / "mission.toml"
        if not path.exists():
            made = subprocess.run([str(self.bench.bridge), "mission"], capture_output=True, text=True, check=True)  # noqa: S603
            path.write_text(made.stdout)
        return path

    def node(self, *options: str, takes_off: bool = True, link: str = "") -> Node:
        """Starts a node for the vehicle."""
        link = link or f"udpin:127.0.0.1:{self.node_port}"
        arguments = ["--id", str(self.index), "--mission", str(self.mission()), "--autopilot", link]
        arguments += ["--vehicle-system", str(self.system), *(["--takeoff"] if takes_off else [])]
        recording = self.bench.folder / f"node-{self.index}-{len(self._nodes)}.tlog"
        node = Node(self.bench.bridge, [*arguments, *options], recording)
        self._nodes.append(node)
        return node

    def flying(self, *options: str) -> Node:
        """A node that has brought the vehicle into the air and whose actor flies it."""
        node = self.node(*options)
        self.until(lambda: node.said("the actor flies"), "the actor flies", node)
        return node

    # Waiting

    def turn(self) -> None:
        """Takes in what the vehicle says; a pilot's ground station and sticks stay alive."""
        now = time.monotonic()
        self._process.check()
        if self._links is not None and now >= self._link_at:
            self._link_at = now + _LINK_RETRY_S
            if self._links.add():
                self._links = None
        if self._pilot and self.autopilot == PX4 and now - self._sticks_at >= 0.1:
            self._sticks_at = now
            self.observer.send(mavlink.MAVLink_manual_control_message(self.system, 0, 0, 500, 0, 0))
        if self._pilot and now - self._beat_at >= 0.5:
            self._beat_at = now
            self.observer.send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3))
            if self.autopilot == ARDUCOPTER:
                # Arming wants the throttle low, LOITER in the air would descend with it.
                throttle = 1500 if self.observer.armed and self.height > 1.0 else 1000
                sticks = (1500, 1500, throttle, 1500)
                self.observer.send(mavlink.MAVLink_rc_channels_override_message(self.system, 1, *sticks, *(0,) * 4))
        self.observer.receive(now)

    def until(self, holds: Callable[[], bool], what: str, node: Node | None = None, limit_s: float = _LIMIT_S) -> None:
        """Waits until something holds; raises Failure after `limit_s`, with the node's last words."""
        end = time.monotonic() + limit_s
        while not holds():
            if time.monotonic() > end:
                last = "" if node is None else "; its last words: " + " / ".join(node.text.splitlines()[-4:])
                raise Failure(f"not within {limit_s:.0f} s: {what} (mode {self.mode}){last}")
            select.select([self.observer], [], [], _TURN_S)
            self.turn()

    def spend(self, seconds: float) -> None:
        """Lets the vehicle's own clock run on for so long."""
        end = self.clock_ms + seconds * 1000
        self.until(lambda: self.clock_ms >= end, f"{seconds} s on the vehicle's clock", limit_s=10 * seconds + 30)

    # The vehicle

    @property
    def clock_ms(self) -> float:
        """Its clock, ms since it booted."""
        time_message = self.observer.last.get("SYSTEM_TIME")
        return 0.0 if time_message is None else float(time_message.time_boot_ms)

    @property
    def mode(self) -> str:
        """Its flight mode."""
        return name_of(self.autopilot, self.observer.mode)

    def is_in(self, mode: str) -> bool:
        """Whether its last HEARTBEAT told this mode."""
        return self.observer.mode == custom_mode(self.autopilot, mode)

    def switch(self, mode: str) -> None:
        """The pilot switches the mode, and the vehicle has it."""
        end = time.monotonic() + 20
        asked = 0.0
        while not self.is_in(mode):
            if time.monotonic() > end:
                raise Failure(f"the vehicle does not take {mode}, it is in {self.mode}")
            if time.monotonic() - asked > 1:
                asked = time.monotonic()
                self.observer.command(*set_mode(self.autopilot, mode))
            select.select([self.observer], [], [], _TURN_S)
            self.turn()

    def set_parameter(self, name: str, value: float) -> None:
        """Sets a parameter of the autopilot that is a float there, or ArduPilot's."""
        kind = mavlink.MAV_PARAM_TYPE_REAL32
        self.observer.send(mavlink.MAVLink_param_set_message(self.system, 1, name.encode(), value, kind))

    @property
    def place(self) -> tuple[float, float]:
        """Where it truly is, m east and north."""
        if not self.observer.places:
            raise Failure("the simulator does not tell where the vehicle is")
        last = self.observer.places[-1]
        return ORIGIN.metres(last.lat, last.lon)

    @property
    def speed(self) -> float:
        """Its horizontal speed as it measures it, m/s."""
        message = self.observer.last.get("GLOBAL_POSITION_INT")
        return 0.0 if message is None else math.hypot(message.vx, message.vy) / 100

    @property
    def height(self) -> float:
        """Its height above home as it measures it, m."""
        message = self.observer.last.get("GLOBAL_POSITION_INT")
        return 0.0 if message is None else message.relative_alt / 1000

    def farthest(self, seconds: float) -> float:
        """Lets it fly on for so long; returns how far it was from here at most, m."""
        start, farthest = self.place, 0.0
        end = self.clock_ms + seconds * 1000
        while self.clock_ms < end:
            before = self.clock_ms
            self.until(lambda: self.clock_ms > before, "the vehicle's clock runs", limit_s=30)
            x, y = self.place
            farthest = max(farthest, math.hypot(x - start[0], y - start[1]))
        return farthest
