"""Checks the messages on a swarm link: form, sequence, steps, motion, one policy for all."""

import math
from collections import Counter, deque
from dataclasses import dataclass, field
from typing import Any

from simlink.endpoint import Endpoint
from simlink.neighbours import frames
from simlink.neighbours.message import Beacon, Feature, Message, MessageError

TICKS_PER_U = 1024
FASTEST_U = 6.0
"""u/step: what a receiver extrapolates with at most."""
JUMP_U = 2.0
"""Allowed deviation of a position besides."""
_KEPT_PROBLEMS = 100
_REMEMBERED = 256


@dataclass
class Sender:
    """Counts and last messages of one UAV."""

    beacons: int = 0
    features: int = 0
    lost: int = 0
    repeated: int = 0
    last: dict[type, Message] = field(default_factory=dict)
    first_step: int | None = None
    last_step: int | None = None
    beacon_steps: deque[int] = field(default_factory=lambda: deque(maxlen=_REMEMBERED))
    feature_steps: deque[int] = field(default_factory=lambda: deque(maxlen=_REMEMBERED))


class Checker:
    """Checks datagrams; keeps counts by sender and by problem."""

    def __init__(self, key: bytes | None = None, step_ms: int | None = None) -> None:
        self._endpoint = Endpoint(255, frames.COMPONENT, key)
        self._step_ms = step_ms
        self.senders: dict[int, Sender] = {}
        self.actors: Counter[int] = Counter()
        self.widths: Counter[int] = Counter()
        self.rejected: Counter[str] = Counter()
        self.wrong: Counter[str] = Counter()
        self.problems: list[str] = []
        self.others = 0

    def check(self, datagram: bytes) -> list[Message]:
        """Checks a datagram; returns its well-formed messages."""
        messages = []
        for frame in self._endpoint.unpack(datagram):
            try:
                message = frames.unwrap(frame)
            except MessageError as error:
                self.rejected[error.reason] += 1
                self._wrong(f"malformed_{error.reason}", f"system {frame.get_srcSystem()}: {error}")
                continue
            if message is None:
                self.others += 1
            else:
                self._check(message)
                messages.append(message)
        return messages

    def _wrong(self, kind: str, text: str) -> None:
        self.wrong[kind] += 1
        if len(self.problems) < _KEPT_PROBLEMS:
            self.problems.append(f"{kind}: {text}")

    def _check(self, message: Message) -> None:
        sender = self.senders.setdefault(message.id, Sender())
        if not self._in_sequence(sender, message):
            return
        sender.first_step = message.step if sender.first_step is None else sender.first_step
        sender.last_step = message.step
        if isinstance(message, Beacon):
            sender.beacons += 1
            self._check_beacon(sender, message)
            sender.beacon_steps.append(message.step)
        else:
            sender.features += 1
            self._check_feature(sender, message)
        sender.last[type(message)] = message

    def _in_sequence(self, sender: Sender, message: Message) -> bool:
        last = sender.last.get(type(message))
        if last is None:
            return True
        ahead = (message.sequence - last.sequence) & 0xFFFF
        if ahead == 0:
            sender.repeated += 1
            if message != last:
                self._wrong("id_collision", f"UAV {message.id}: two messages with sequence {message.sequence}")
            return False
        if ahead >= 0x8000:
            sender.repeated += 1
            self._wrong("old_sequence", f"UAV {message.id}: {message.sequence} after {last.sequence}")
            return False
        sender.lost += ahead - 1
        return True

    def _check_beacon(self, sender: Sender, beacon: Beacon) -> None:
        speed = math.hypot(beacon.vx, beacon.vy) / TICKS_PER_U
        if speed > FASTEST_U:
            self._wrong("too_fast", f"UAV {beacon.id}: {speed:.1f} u/step")
        last = sender.last.get(Beacon)
        if not isinstance(last, Beacon):
            return
        steps = _ahead(beacon.step, last.step)
        passed_ms = _ahead(beacon.time_ms, last.time_ms)
        if steps < 0 or passed_ms < 0:
            self._wrong("clock_back", f"UAV {beacon.id}: {steps} steps and {passed_ms} ms after the last")
        elif self._step_ms and abs(passed_ms - steps * self._step_ms) > self._step_ms:
            self._wrong("clock", f"UAV {beacon.id}: {passed_ms} ms for {steps} steps of {self._step_ms} ms")
        step_part = passed_ms / self._step_ms if self._step_ms else steps + 1
        way_u = math.hypot(beacon.x - last.x, beacon.y - last.y) / TICKS_PER_U
        if way_u > JUMP_U + FASTEST_U * max(step_part, 0.0):
            self._wrong("teleport", f"UAV {beacon.id}: {way_u:.1f} u in {steps} steps")

    def _check_feature(self, sender: Sender, feature: Feature) -> None:
        self.actors[feature.actor] += 1
        self.widths[len(feature.values)] += 1
        if len(self.actors) > 1 and feature.actor != self.actors.most_common(1)[0][0]:
            self._wrong("foreign_actor", f"UAV {feature.id}: actor {feature.actor:08x}")
        if len(self.widths) > 1 and len(feature.values) != self.widths.most_common(1)[0][0]:
            self._wrong("foreign_width", f"UAV {feature.id}: {len(feature.values)} values")
        if feature.step in sender.feature_steps:
            self._wrong("second_feature", f"UAV {feature.id}: two features of step {feature.step}")
        sender.feature_steps.append(feature.step)
        last = sender.last.get(Feature)
        if last is not None and _ahead(feature.step, last.step) < 0:
            self._wrong("step_back", f"UAV {feature.id}: step {feature.step} after {last.step}")
        if feature.step not in sender.beacon_steps:
            self._wrong("feature_without_beacon", f"UAV {feature.id}: step {feature.step}")

    def report(self) -> dict[str, Any]:
        """Everything as one JSON object; `sound` when nothing was wrong."""
        endpoint = self._endpoint
        return {
            "sound": not self.wrong and not endpoint.damaged and not endpoint.unauthentic,
            "senders": {
                str(identity): {
                    "beacons": sender.beacons,
                    "features": sender.features,
                    "lost": sender.lost,
                    "repeated": sender.repeated,
                    "steps": [sender.first_step, sender.last_step],
                }
                for identity, sender in sorted(self.senders.items())
            },
            "actors": [f"{actor:08x}" for actor, _ in self.actors.most_common()],
            "widths": sorted(self.widths),
            "damaged": endpoint.damaged,
            "unauthentic": endpoint.unauthentic,
            "other_frames": self.others,
            "rejected": dict(sorted(self.rejected.items())),
            "wrong": dict(sorted(self.wrong.items())),
            "problems": self.problems,
        }


def _ahead(new: int, old: int) -> int:
    """`new` - `old` of numbers that wrap at 32 bits."""
    return (new - old + 0x8000_0000 & 0xFFFF_FFFF) - 0x8000_0000
