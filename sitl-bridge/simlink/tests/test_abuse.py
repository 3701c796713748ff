"""Whatever a controller sends, the fleet flies on: a bad node must show as an event, not as a dead simulator."""

import math
import random
import struct
import unittest

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink.protocol import Protocol
from simlink.tests.support import Controller, Flight

ODD_FLOATS = (0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-40, 21196.0, 65_536.0)
_LIMITS = {
    "b": (-128, 127),
    "B": (0, 255),
    "h": (-32_768, 32_767),
    "H": (0, 65_535),
    "i": (-(1 << 31), (1 << 31) - 1),
    "I": (0, (1 << 32) - 1),
    "q": (-(1 << 63), (1 << 63) - 1),
    "Q": (0, (1 << 64) - 1),
}


def anything(kind: type[mavlink.MAVLink_message], r: random.Random) -> bytes:
    """A payload of this message with odd numbers in it, meant for system 1 more often than not."""
    fields = {}
    for name, code in zip(kind.ordered_fieldnames, kind.native_format[1:].decode(), strict=True):
        if code in "fd":
            fields[name] = r.choice((*ODD_FLOATS, r.uniform(-50, 50), float(r.randrange(600))))
        elif code in _LIMITS:
            low, high = _LIMITS[code]
            fields[name] = r.choice((low, high, 0, 1, r.randint(low, high)))
        else:
            fields[name] = r.randbytes(16)
    message = kind.__new__(kind)
    kind.__init__(message, **fields)
    if hasattr(message, "target_system"):
        message.target_system = r.choice((0, 1, 1, 1, 7))
        message.target_component = r.choice((0, 1, 1, 191))
    if hasattr(message, "command"):
        message.command = r.choice((*range(16, 24), 176, 178, 400, 410, 511, 512, 520, 31_000))
    return message


class Abuse(unittest.TestCase):
    def storm(self, dialect: str, seed: int) -> Flight:
        r = random.Random(seed)
        controller = Controller(lambda _: {}, dialect=dialect)
        flight = Flight(controller, start_u=[[50, 50]], seed=seed)
        flight.run_for(15)
        protocol: Protocol = flight.fleet.vehicles[0]._protocol
        kinds = [mavlink.mavlink_map[number] for number in protocol._handlers]

        def send():
            for _ in range(5):
                kind = r.choice(kinds)
                try:
                    frame = controller.pack(anything(kind, r))
                except (struct.error, TypeError):
                    continue
                flight.hub.waiting.append((0, frame))

        flight.each_tick = send
        flight.run_for(120)
        return flight

    def test_any_message_with_any_numbers(self):
        answered = 0
        for seed in range(4):
            for dialect in ("ardupilot", "px4"):
                flight = self.storm(dialect, seed)
                answered += len(flight.controllers[0].acks)
                self.assertGreater(flight.fleet.vehicles[0].endpoint.received, 100)
        self.assertGreater(answered, 300)

    def test_a_climb_without_end_stays_a_number(self):
        controller = Controller(lambda _: dict(mask=0x0C3F, acceleration=(0, 0, -3e38)))
        flight = Flight(controller)
        flight.run_for(3600)
        self.assertGreater(controller.last["GLOBAL_POSITION_INT"].relative_alt, 1_000_000)
        self.assertLess(abs(controller.last["GLOBAL_POSITION_INT"].vz), 6000)

    def test_a_clock_that_jumps_below_zero_wraps(self):
        flight = Flight(
            Controller(lambda _: {}), faults=[{"id": 1, "kind": "clock_jump", "by_ms": -60_000, "at_ms": 12_000}]
        )
        flight.run_for(20)
        self.assertEqual(flight.controllers[0].last["SYSTEM_TIME"].time_boot_ms, (1 << 32) - 40_000)
