"""Simulated neighbours that disturb a swarm on purpose.

A ghost listens to the swarm and sends when the swarm does: at the first beacon of a new step its own beacon with that
step and time, at the first feature its own feature. So it keeps up with a simulation at any speed.
"""

import random
from collections import deque
from dataclasses import dataclass, field

from simlink.endpoint import Endpoint
from simlink.neighbours import frames
from simlink.neighbours.checker import TICKS_PER_U
from simlink.neighbours.message import Beacon, Feature, Message

KINDS = {
    "ghost": "one UAV more, which flies along",
    "id-collision": "a second UAV with the id of another",
    "foreign-actor": "a UAV whose features come from another policy",
    "teleport": "a UAV that jumps 60 u every third step",
    "replay": "messages of others, sent again two steps later",
    "corrupt": "messages of others, with bits flipped, cut short, or two in one datagram with noise between",
    "unsigned": "a UAV that does not sign",
}
"""Every kind and what it does."""

JUMP_U, JUMP_STEPS, REPLAY_STEPS = 60, 3, 2


@dataclass
class Ghost:
    """Receives the swarm's datagrams and returns datagrams to send."""

    kind: str
    id: int = 200
    position_u: tuple[float, float] = (100.0, 100.0)
    velocity_u: tuple[float, float] = (1.0, 0.0)
    actor: int | None = None
    """Hash in its features; None: the swarm's own, or a foreign one for foreign-actor."""
    key: bytes | None = None
    seed: int = 1
    _sequence: int = 0
    _jumped: bool = False
    _step: int | None = None
    _feature_step: int | None = None
    _recorded: list[tuple[int, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"there is no ghost {self.kind!r}; known: {', '.join(KINDS)}")
        self._random = random.Random(self.seed)
        self._endpoint = frames.endpoint_of(self.id, None if self.kind == "unsigned" else self.key)
        self._hears = Endpoint(255, frames.COMPONENT, self.key)
        self._own: deque[bytes] = deque(maxlen=64)

    def receive(self, datagram: bytes) -> list[bytes]:
        """The answers to a datagram."""
        if datagram in self._own:
            return []
        out: list[bytes] = []
        for frame in self._hears.unpack(datagram):
            try:
                message = frames.unwrap(frame)
            except ValueError:
                continue
            if message is not None:
                out += self._answer(message, bytes(frame.get_msgbuf()))
        self._own.extend(out)  # to recognise them when multicast loops them back
        return out

    def _answer(self, message: Message, frame: bytes) -> list[bytes]:
        if self.kind == "replay":
            return self._replay(message, frame)
        if self.kind == "corrupt":
            return [self._corrupted(frame)]
        if isinstance(message, Beacon):
            if self.kind == "id-collision" and message.id == self.id:
                # Behind the true one it would only be taken for late.
                self._sequence = message.sequence
            if self._step is not None and message.step <= self._step:
                return []
            self._step = message.step
            return [frames.wrap(self._endpoint, self._beacon(message).encode())]
        said_already = self._feature_step is not None and message.step <= self._feature_step
        if said_already or message.step != self._step:
            return []
        self._feature_step = message.step
        return [frames.wrap(self._endpoint, self._feature(message).encode())]

    def _next_sequence(self) -> int:
        self._sequence = self._sequence + 1 & 0xFFFF
        return self._sequence

    def _beacon(self, heard: Beacon) -> Beacon:
        x, y = self.position_u
        vx, vy = self.velocity_u
        self.position_u = (x + vx, y + vy)
        if self.kind == "teleport" and heard.step % JUMP_STEPS == 0:
            self._jumped = not self._jumped
        jump = JUMP_U if self._jumped else 0
        ticks = [round(value * TICKS_PER_U) for value in (x + jump, y, vx, vy)]
        tie = self._random.randint(-127, 127)
        return Beacon(self.id, self._next_sequence(), heard.step, heard.time_ms, *ticks, tie)

    def _feature(self, heard: Feature) -> Feature:
        actor = self.actor
        if actor is None:
            actor = heard.actor ^ 0x5A5A_5A5A if self.kind == "foreign-actor" else heard.actor
        values = tuple(self._random.randint(-128, 127) for _ in heard.values)
        return Feature(self.id, self._next_sequence(), heard.step, 1, actor, 0, values)

    def _replay(self, message: Message, frame: bytes) -> list[bytes]:
        due = [old for step, old in self._recorded if message.step - step >= REPLAY_STEPS]
        self._recorded = [(step, old) for step, old in self._recorded if message.step - step < REPLAY_STEPS]
        self._recorded.append((message.step, frame))
        return due

    def _corrupted(self, frame: bytes) -> bytes:
        damaged = bytearray(frame)
        match self._random.randrange(4):
            case 0:
                for _ in range(self._random.randint(1, 8)):
                    damaged[self._random.randrange(len(damaged))] ^= 1 << self._random.randrange(8)
            case 1:
                del damaged[self._random.randrange(1, len(damaged)) :]
            case 2:
                noise = self._random.randbytes(self._random.randint(1, 40))
                damaged = damaged[:-3] + noise + damaged[:-1]
            case _:
                damaged = bytearray(self._random.randbytes(self._random.randint(1, 300)))
        return bytes(damaged)
