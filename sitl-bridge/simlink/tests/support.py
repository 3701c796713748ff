"""A fleet without sockets: its wall clock is a number, its controllers are scripts."""

import math
from collections.abc import Callable
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink import config
from simlink.fleet import Fleet

GUIDED, OFFBOARD = 4, 6
LOCAL, GLOBAL = mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT
VELOCITY_AND_ACCELERATION = 0x0C07


class ScriptedHub:
    """Hands every frame to its vehicle's controller; when nothing is under way, waiting lets the wall clock jump."""

    def __init__(self) -> None:
        self.wall = 0.0
        self.controllers: list[Controller] = []
        self.waiting: list[tuple[int, bytes | None]] = []

    def now(self) -> float:
        return self.wall

    def send(self, index: int, frame: bytes) -> None:
        for answer in self.controllers[index].take(frame):
            self.waiting.append((index, answer))

    def receive(self, timeout_s: float) -> list[tuple[int, bytes | None]]:
        if not self.waiting:
            self.wall += max(timeout_s, 0.0)
        arrived, self.waiting = self.waiting, []
        return arrived


class Controller:
    """Brings a vehicle into the air and answers each of its positions with a setpoint."""

    def __init__(self, setpoint: Callable[["Controller"], dict | None] | None = None, **options: Any) -> None:
        self.mav = mavlink.MAVLink(None, srcSystem=options.get("system", 255), srcComponent=191)
        self.vehicle = options.get("vehicle", 0)
        self.parser = mavlink.MAVLink(None)
        self.setpoint = setpoint
        self.px4 = options.get("dialect") == "px4"
        self.height = options.get("height", 10.0)
        self.takes_off = options.get("takes_off", True)
        self.heartbeats = True
        self.kind = options.get("kind", mavlink.MAV_TYPE_ONBOARD_CONTROLLER)
        self.silent = False
        self.frames: list[bytes] = []
        self.last: dict[str, Any] = {}
        self.texts: list[str] = []
        self.acks: list[tuple[int, int]] = []
        self.seen: dict[int, list[int]] = {}
        self.others: set[int] = set()
        self._asked = self._was_up = False
        self._heartbeat_ms = -10_000

    def take(self, frame: bytes) -> list[bytes]:
        """Gets one frame, returns the answers."""
        self.frames.append(frame)
        message = self.parser.decode(bytearray(frame))
        if self.vehicle and message.get_srcSystem() != self.vehicle:
            self.others.add(message.get_srcSystem())
            return []
        kind = message.get_type()
        self.last[kind] = message
        self.seen.setdefault(message.get_msgId(), []).append(getattr(message, "time_boot_ms", 0))
        if self.silent:
            return []
        answers: list[mavlink.MAVLink_message] = []
        match kind:
            case "STATUSTEXT":
                self.texts.append(message.text.rstrip("\0"))
            case "COMMAND_ACK":
                self.acks.append((message.command, message.result))
            case "HEARTBEAT":
                answers += self._on_heartbeat(message)
            case "LOCAL_POSITION_NED":
                answers += self._on_position(message)
        return [self.pack(answer) for answer in answers]

    def pack(self, message: mavlink.MAVLink_message) -> bytes:
        return message.pack(self.mav)

    def command(self, number: int, *parameters: float) -> mavlink.MAVLink_message:
        padded = (*parameters, *(0.0,) * (7 - len(parameters)))
        return mavlink.MAVLink_command_long_message(self.vehicle, 1, number, 0, *padded)

    def _on_heartbeat(self, message: mavlink.MAVLink_message) -> list[mavlink.MAVLink_message]:
        answers = [self.own_heartbeat()] if self.heartbeats else []
        if not self._asked:
            self._asked = True
            answers += [self.command(511, message_id, 200_000) for message_id in (32, 33)]
            answers += [self.command(511, message_id, 1_000_000) for message_id in (1, 2, 24, 49, 193, 230)]
        if not self.takes_off or self.airborne:
            return answers
        ready = message.system_status == mavlink.MAV_STATE_STANDBY
        armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        if ready and not armed:
            answers += [] if self.px4 else [self.command(176, 1, GUIDED)]
            answers += [self.command(400, 1), self.command(22, 0, 0, 0, math.nan, 0, 0, self._takeoff_altitude())]
        return answers

    def _takeoff_altitude(self) -> float:
        return self.height + (584.0 if self.px4 else 0.0)

    def own_heartbeat(self) -> mavlink.MAVLink_message:
        return mavlink.MAVLink_heartbeat_message(
            self.kind, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
        )

    @property
    def airborne(self) -> bool:
        position = self.last.get("GLOBAL_POSITION_INT")
        self._was_up |= position is not None and position.relative_alt > (self.height - 0.5) * 1000
        return self._was_up

    @property
    def mode(self) -> int:
        return self.last["HEARTBEAT"].custom_mode

    def _on_position(self, message: mavlink.MAVLink_message) -> list[mavlink.MAVLink_message]:
        if self.setpoint is None or not self.airborne:
            return []
        target = self.setpoint(self)
        answers = [] if target is None else [setpoint_message(**target, system=self.vehicle)]
        if self.px4 and self.mode >> 16 & 0xFF != OFFBOARD and len(self.acks) > 2 and message.time_boot_ms % 1000 == 0:
            answers.append(self.command(176, 1, OFFBOARD))
        return answers


def setpoint_message(
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    acceleration: tuple[float, float, float] = (0.0, 0.0, 0.0),
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mask: int = VELOCITY_AND_ACCELERATION,
    frame: int = 1,
    system: int = 0,
) -> mavlink.MAVLink_message:
    """A setpoint; all triples are north, east, down."""
    return mavlink.MAVLink_set_position_target_local_ned_message(
        0, system, 1, frame, mask, *position, *velocity, *acceleration, 0.0, 0.0
    )


class Flight:
    """A fleet with one controller a vehicle, run as far as a test wants."""

    def __init__(self, *controllers: Controller, **fields: Any) -> None:
        vehicles = [
            {"id": i, "port": 14_550 + 10 * i, "dialect": "px4" if controller.px4 else "ardupilot"}
            for i, controller in enumerate(controllers, start=1)
        ]
        raw = {"vehicles": vehicles, "unix_ms": 1_700_000_000_000, **fields}
        self.events: list[dict] = []
        self.hub = ScriptedHub()
        self.hub.controllers = list(controllers)
        self.controllers = controllers
        self.until: Callable[[], bool] = lambda: True
        self.each_tick: Callable[[], None] = lambda: None
        self.fleet = Fleet(config.read(raw), self.hub, self._event, key=fields.get("key"), on_tick=self._on_tick)

    def _event(self, event: str, **fields: Any) -> None:
        self.events.append({"event": event, **fields})

    def _on_tick(self, fleet: Fleet) -> None:
        self.each_tick()
        if self.until():
            fleet.stopped = True

    def run_until(self, condition: Callable[[], bool], limit_s: float = 120.0) -> None:
        """Flies until `condition` holds at a tick; AssertionError when `limit_s` simulated seconds are not enough."""
        limit_ms = self.fleet.t_ms + limit_s * 1000
        self.until = lambda: condition() or self.fleet.t_ms >= limit_ms
        self.fleet.stopped = False
        self.fleet.run()
        assert condition(), f"not within {limit_s} s; events: {self.named()[-10:]}"

    def run_for(self, seconds: float) -> None:
        """Flies this many simulated seconds."""
        end = self.fleet.t_ms + seconds * 1000
        self.run_until(lambda: self.fleet.t_ms >= end, seconds + 1)

    def named(self, *names: str) -> list[dict]:
        """The events of these names; all but the bulky ones when none is given."""
        if names:
            return [event for event in self.events if event["event"] in names]
        return [event for event in self.events if event["event"] not in ("truth", "stats", "ready")]

    def body(self, index: int = 0):
        return self.fleet.vehicles[index].autopilot.body
