"""Beacons and features, version 1, as docs/messages.md lays them out."""

import struct
from dataclasses import dataclass

VERSION = 1
BEACON_KIND, FEATURE_KIND = 1, 2
COORDINATE_LIMIT = 1 << 28
"""Ticks."""
MAX_DEGREE, MAX_WIDTH = 17, 64

_BEACON = struct.Struct("<BBHHIIiihhb")
_FEATURE = struct.Struct("<BBHHIBIhB")
BEACON_LENGTH, FEATURE_HEAD_LENGTH = _BEACON.size, _FEATURE.size
_WIDTH_AT = 17


class MessageError(ValueError):
    """Bytes that are no message; `reason` is one word for counting."""

    def __init__(self, reason: str, text: str) -> None:
        super().__init__(text)
        self.reason = reason


@dataclass(frozen=True)
class Beacon:
    """Where a UAV is: ticks of 1/1024 u, ticks a step, ms of the common clock."""

    id: int
    sequence: int
    step: int
    time_ms: int
    x: int
    y: int
    vx: int
    vy: int
    tie: int

    def encode(self) -> bytes:
        """The 27 bytes; MessageError where the layout cannot hold a field."""
        if abs(self.x) > COORDINATE_LIMIT or abs(self.y) > COORDINATE_LIMIT:
            raise MessageError("position", f"({self.x}, {self.y}) is beyond {COORDINATE_LIMIT} ticks")
        if self.tie == -128:
            raise MessageError("tie", "the least tie-breaker is -127")
        return _packed(
            _BEACON,
            VERSION,
            BEACON_KIND,
            self.id,
            self.sequence,
            self.step,
            self.time_ms,
            self.x,
            self.y,
            self.vx,
            self.vy,
            self.tie,
        )


@dataclass(frozen=True)
class Feature:
    """What a UAV's encoder made of its observation."""

    id: int
    sequence: int
    step: int
    degree: int
    actor: int
    attended: int
    values: tuple[int, ...]

    def encode(self) -> bytes:
        """The bytes; MessageError where the layout cannot hold a field."""
        _check_feature(self.degree, len(self.values))
        head = _packed(
            _FEATURE,
            VERSION,
            FEATURE_KIND,
            self.id,
            self.sequence,
            self.step,
            self.degree,
            self.actor,
            self.attended,
            len(self.values),
        )
        return head + _packed(struct.Struct(f"{len(self.values)}b"), *self.values)


Message = Beacon | Feature


def decode(data: bytes) -> Message:
    """The message that fills `data`; MessageError with the first thing that is wrong."""
    if len(data) < 2:
        raise MessageError("too_short", f"{len(data)} bytes")
    if data[0] != VERSION:
        raise MessageError("version", f"version {data[0]}, this reads {VERSION}")
    if data[1] == BEACON_KIND:
        return _decode_beacon(data)
    if data[1] == FEATURE_KIND:
        return _decode_feature(data)
    raise MessageError("kind", f"kind {data[1]} is neither beacon nor feature")


def length(data: bytes) -> int:
    """How long the message that begins `data` says it is; at most FEATURE_HEAD_LENGTH + 255."""
    if data[1:2] == bytes([FEATURE_KIND]):
        return FEATURE_HEAD_LENGTH + (data[_WIDTH_AT] if len(data) > _WIDTH_AT else 0)
    return BEACON_LENGTH


def _decode_beacon(data: bytes) -> Beacon:
    _expect(data, BEACON_LENGTH)
    _, _, *fields = _BEACON.unpack(data)
    beacon = Beacon(*fields)
    if abs(beacon.x) > COORDINATE_LIMIT or abs(beacon.y) > COORDINATE_LIMIT:
        raise MessageError("position", f"({beacon.x}, {beacon.y}) is beyond {COORDINATE_LIMIT} ticks")
    if beacon.tie == -128:
        raise MessageError("tie", "tie-breaker -128")
    return beacon


def _decode_feature(data: bytes) -> Feature:
    if len(data) < FEATURE_HEAD_LENGTH:
        raise MessageError("too_short", f"{len(data)} bytes of {FEATURE_HEAD_LENGTH}")
    _, _, identity, sequence, step, degree, actor, attended, width = _FEATURE.unpack_from(data)
    _check_feature(None, width)
    _expect(data, FEATURE_HEAD_LENGTH + width)
    _check_feature(degree, width)
    values = struct.unpack_from(f"{width}b", data, FEATURE_HEAD_LENGTH)
    return Feature(identity, sequence, step, degree, actor, attended, values)


def _check_feature(degree: int | None, width: int) -> None:
    if not 1 <= width <= MAX_WIDTH:
        raise MessageError("width", f"{width} values, a feature has 1 to {MAX_WIDTH}")
    if degree is not None and not 1 <= degree <= MAX_DEGREE:
        raise MessageError("degree", f"degree {degree} is not 1 to {MAX_DEGREE}")


def _expect(data: bytes, needed: int) -> None:
    if len(data) != needed:
        raise MessageError("too_short" if len(data) < needed else "too_long", f"{len(data)} bytes of {needed}")


def _packed(layout: struct.Struct, *fields: int) -> bytes:
    try:
        return layout.pack(*fields)
    except struct.error as error:
        raise MessageError("field", f"a field does not fit: {error}") from None
