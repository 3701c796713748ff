"""The second MAVLink link of a vehicle: where it truly is, what mode it is in, and a pilot's switches."""

import socket
from bisect import bisect_left
from collections import deque
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

GROUND_STATION = 255
OBSERVER = 254
"""System id of one who only watches: no failsafe counts its heartbeats, and it sends none."""
TRUTH_HZ = 10
_TRUTH = (mavlink.MAVLINK_MSG_ID_SYSTEM_TIME, mavlink.MAVLINK_MSG_ID_SIMSTATE)
_ASKED_AGAIN_S = 2.0
_KEPT = 400


@dataclass(frozen=True)
class Place:
    """The simulator's own knowledge: Unix time in ms of the vehicle's clock, degrees, m above the sea or home."""

    unix_ms: float
    lat: float
    lon: float


class Observer:
    """One vehicle as its second link shows it. It asks for what it lacks, and again after a reboot."""

    def __init__(self, system: int, source: int = OBSERVER) -> None:
        self.system = system
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self._peer: tuple[str, int] | None = None
        self._parser = mavlink.MAVLink(None)
        self._parser.robust_parsing = True
        self._mav = mavlink.MAVLink(None, srcSystem=source, srcComponent=190)
        self._asked_at = -_ASKED_AGAIN_S
        self._seen_at: dict[int, float] = {}
        self._messages = _TRUTH if source == OBSERVER else (*_TRUTH, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
        self._offset_ms: float | None = None
        self._boot_ms = 0
        self.places: deque[Place] = deque(maxlen=_KEPT)
        self.last: dict[str, mavlink.MAVLink_message] = {}
        self.arrived: list[mavlink.MAVLink_message] = []

    @property
    def port(self) -> int:
        """Its UDP port on this computer."""
        return self._socket.getsockname()[1]

    def fileno(self) -> int:
        """The socket, to wait for."""
        return self._socket.fileno()

    def close(self) -> None:
        """Closes the link."""
        self._socket.close()

    def send(self, message: mavlink.MAVLink_message) -> None:
        """Sends a message, once the vehicle was heard."""
        if self._peer is not None:
            self._socket.sendto(message.pack(self._mav), self._peer)

    def command(self, number: int, *parameters: float) -> None:
        """Sends COMMAND_LONG to the vehicle."""
        padded = (*parameters, *(0.0,) * (7 - len(parameters)))
        self.send(mavlink.MAVLink_command_long_message(self.system, 1, number, 0, *padded))

    def receive(self, now: float) -> None:
        """Takes in what has arrived. `now`: a clock of the host, s."""
        while True:
            try:
                datagram, self._peer = self._socket.recvfrom(65_536)
            except (BlockingIOError, ConnectionRefusedError):
                break
            for message in self._parser.parse_buffer(bytearray(datagram)) or []:
                if message.get_srcSystem() == self.system and message.get_srcComponent() == 1:
                    self._take(message, now)
        if self._peer is not None and now - self._asked_at >= _ASKED_AGAIN_S:
            self._asked_at = now
            for number, rate in self._wanted().items():
                if now - self._seen_at.get(number, -_ASKED_AGAIN_S) >= _ASKED_AGAIN_S:
                    self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, number, 1e6 / rate)

    def place_at(self, unix_ms: float) -> Place | None:
        """Where the vehicle was at a time of its clock; None while the time has not come, or is forgotten."""
        times = [place.unix_ms for place in self.places]
        after = bisect_left(times, unix_ms)
        if after in (0, len(times)):
            return None
        a, b = self.places[after - 1], self.places[after]
        share = (unix_ms - a.unix_ms) / max(b.unix_ms - a.unix_ms, 1e-9)
        return Place(unix_ms, a.lat + share * (b.lat - a.lat), a.lon + share * (b.lon - a.lon))

    @property
    def mode(self) -> int | None:
        """`custom_mode` of the last HEARTBEAT."""
        heartbeat = self.last.get("HEARTBEAT")
        return None if heartbeat is None else heartbeat.custom_mode

    @property
    def armed(self) -> bool:
        """Whether the last HEARTBEAT said so."""
        heartbeat = self.last.get("HEARTBEAT")
        return heartbeat is not None and bool(heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)

    def _wanted(self) -> dict[int, float]:
        return dict.fromkeys(self._messages, TRUTH_HZ)

    def _take(self, message: mavlink.MAVLink_message, now: float) -> None:
        kind = message.get_type()
        self._seen_at[message.get_msgId()] = now
        self.last[kind] = message
        self.arrived.append(message)
        if len(self.arrived) > _KEPT:
            del self.arrived[: _KEPT // 2]
        if kind == "SYSTEM_TIME":
            if message.time_boot_ms < self._boot_ms:  # it was started again
                self.places.clear()
            self._boot_ms = message.time_boot_ms
            self._offset_ms = message.time_unix_usec / 1000.0 - message.time_boot_ms if message.time_unix_usec else None
        elif kind == "SIMSTATE" and self._offset_ms is not None:
            # It has no time of its own; SYSTEM_TIME comes in the same turn of the autopilot's scheduler.
            self._add(Place(self._offset_ms + self._boot_ms, message.lat / 1e7, message.lng / 1e7))
        elif kind == "HIL_STATE_QUATERNION" and self._offset_ms is not None:
            self._add(Place(self._offset_ms + message.time_usec / 1000.0, message.lat / 1e7, message.lon / 1e7))

    def _add(self, place: Place) -> None:
        if not self.places or place.unix_ms > self.places[-1].unix_ms:
            self.places.append(place)
