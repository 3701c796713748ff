"""Ideal flights against the training environment's, and against an independent implementation's."""

import json
import struct
import unittest
from pathlib import Path

from simlink import actions
from simlink.float32 import f32, ticks
from simlink.ideal import IdealState, Scale
from simlink.tests.support import Controller, Flight

DATA = Path(__file__).parents[3] / "tests"
EPOCH_MS, START_UNIX_MS = 40_000, 1_700_000_000_000
SCALE = Scale()


def bits(value: float) -> str:
    return struct.pack(">f", value).hex()


def acceleration(action: int) -> tuple[float, float, float]:
    """North, east, down in m/s²."""
    east, north = actions.ACCELERATIONS[action]
    factor = SCALE.scale_m / SCALE.step_s**2
    return north * factor, east * factor, 0.0


class Numbers(unittest.TestCase):
    def test_ticks_round_halves_away_from_zero(self):
        for value, want in ((0.5, 1), (-0.5, -1), (1.5, 2), (2.4, 2), (-2.6, -3), (0.0, 0)):
            self.assertEqual(ticks(value / 1024), want, value)

    def test_every_action_is_found_again_by_its_acceleration(self):
        for action, (east, north) in enumerate(actions.ACCELERATIONS):
            self.assertEqual(actions.nearest(east, north), action)
            self.assertEqual(actions.nearest(east + 0.3, north - 0.3), action)

    def test_speed_is_capped(self):
        vx, vy = actions.next_velocity(7, 4.0, 0.0)
        self.assertAlmostEqual(vx * vx + vy * vy, 16.0, places=4)
        self.assertEqual(actions.next_velocity(actions.COAST, 1.5, -2.0), (1.5, -2.0))


class Environment(unittest.TestCase):
    def test_a_flight_of_the_environment_bit_for_bit(self):
        lines = [line for line in (DATA / "data/ideal_flight.txt").read_text().splitlines() if line[0] != "#"]
        start = [struct.unpack(">f", bytes.fromhex(word))[0] for word in lines[0].split()]
        states = [IdealState(SCALE, x, y) for x, y in zip(start[::2], start[1::2], strict=True)]
        self.assertGreater(len(lines), 50)
        edges = capped = 0
        for step, line in enumerate(lines[1:]):
            words = line.split()
            for uav, state in enumerate(states):
                state.act(int(words[uav]))
                want = words[len(states) + 4 * uav :][:4]
                self.assertEqual([bits(v) for v in (state.x, state.y, state.vx, state.vy)], want, (step, uav))
                edges += state.x in (0.0, 200.0) or state.y in (0.0, 200.0)
                capped += abs(state.vx**2 + state.vy**2 - 16.0) < 1e-4
        self.assertTrue(edges > 10 and capped > 10, "the flight shows neither edges nor the cap")


class WholeFlight(unittest.TestCase):
    """A golden episode flown by setpoints over the simulated link."""

    @classmethod
    def setUpClass(cls):
        cls.golden = json.loads((DATA / "golden/cluster-5.json").read_text())
        pilots = [Controller(cls.follow(uav)) for uav in range(cls.golden["n_uav"])]
        cls.flight = Flight(
            *pilots,
            start_u=cls.golden["uav"],
            dynamics="ideal",
            epoch_unix_ms=START_UNIX_MS + EPOCH_MS,
            seed=3,
        )
        cls.reported = []
        cls.flight.each_tick = cls.note
        cls.flight.run_until(lambda: cls.flight.fleet.step >= 100, 400)
        cls.truth = cls.flight.named("truth")

    @classmethod
    def follow(cls, uav: int):
        def setpoint(controller: Controller) -> dict:
            step = (controller.last["LOCAL_POSITION_NED"].time_boot_ms - EPOCH_MS) // SCALE.step_ms
            if step < 0:
                return {"acceleration": (0.0, 0.0, 0.0)}
            return {"acceleration": acceleration(cls.golden["actions"][min(step, 99)][uav])}

        return setpoint

    @classmethod
    def note(cls):
        if cls.flight.fleet.t_ms % SCALE.step_ms == 0:
            local = [controller.last.get("LOCAL_POSITION_NED") for controller in cls.flight.controllers]
            cls.reported.append((cls.flight.fleet.step, local))

    def test_positions_follow_the_golden_episode(self):
        self.assertEqual([event["step"] for event in self.truth], list(range(101)))
        for event in self.truth[1:]:
            for have, want in zip(event["u"], self.golden["steps"][event["step"] - 1]["pos"], strict=True):
                self.assertAlmostEqual(have[0], want[0], delta=1e-3)
                self.assertAlmostEqual(have[1], want[1], delta=1e-3)

    def test_what_is_reported_gives_back_the_very_ticks(self):
        truth = {event["step"]: event for event in self.truth}
        checked = 0
        for step, messages in self.reported:
            if step not in truth:
                continue
            for message, (x, y), (vx, vy) in zip(messages, truth[step]["u"], truth[step]["v"], strict=True):
                have = [round(m / SCALE.scale_m * 1024) for m in (message.y, message.x)]
                speed = [round(m * SCALE.step_s / SCALE.scale_m * 1024) for m in (message.vy, message.vx)]
                self.assertEqual(have, [ticks(f32(x)), ticks(f32(y))])
                self.assertEqual(speed, [ticks(f32(vx)), ticks(f32(vy))])
                checked += 1
        self.assertGreater(checked, 400)

    def test_nothing_moves_between_steps(self):
        self.assertEqual([], self.flight.named("crash", "timeout", "failsafe", "lockstep_timeout"))
