"""What a vehicle makes of setpoints: type masks, frames, modes, bad numbers, and how it moves."""

import math
import unittest

from simlink.tests.support import Controller, Flight


def airborne(setpoint, **fields) -> Flight:
    """A flight whose vehicle streams."""
    flight = Flight(Controller(setpoint), **fields)
    flight.run_until(lambda: flight.fleet.vehicles[0].autopilot.is_streaming)
    return flight


class Switch:
    """Hovers until `now` is set, then asks for that."""

    def __init__(self):
        self.now: dict | None = {}

    def __call__(self, _: Controller) -> dict | None:
        return self.now


class TypeMasks(unittest.TestCase):
    """Measured on ArduCopter; see docs/simlink.md."""

    def speed_after(self, seconds: float, mask: int, **target) -> float:
        switch = Switch()
        flight = airborne(switch)
        flight.run_for(5)
        switch.now = dict(mask=mask, **target)
        flight.run_for(seconds)
        return flight.body().vn

    def test_velocity_only(self):
        self.assertAlmostEqual(self.speed_after(3, 0x0DC7, velocity=(5, 0, 0)), 4.8, delta=0.15)

    def test_velocity_and_acceleration(self):
        self.assertGreater(self.speed_after(3, 0x0C07, velocity=(5, 0, 0), acceleration=(0, 0, 0)), 4.5)

    def test_acceleration_only_has_no_altitude_hold_and_no_speed_cap(self):
        switch = Switch()
        flight = airborne(switch)
        flight.run_for(5)
        up = flight.body().up
        switch.now = dict(mask=0x0C3F, acceleration=(2.5, 0, 0))
        flight.run_for(8)
        self.assertGreater(flight.body().vn, 12.0)
        self.assertGreater(abs(flight.body().up - up), 1.0)
        self.assertGreater(abs(flight.body().ve), 0.1)

    def test_a_group_with_one_axis_ignored_does_not_count(self):
        # One axis of acceleration is ignored and nothing else is given: the vehicle stops.
        self.assertAlmostEqual(self.speed_after(5, 0x0D3F, velocity=(5, 0, 0), acceleration=(2, 0, 0)), 0.0, delta=0.05)
        # The same beside a velocity: the velocity alone counts.
        self.assertAlmostEqual(self.speed_after(3, 0x0D07, velocity=(5, 0, 0), acceleration=(2, 0, 0)), 4.8, delta=0.15)
        # One axis of the velocity ignored, no acceleration: stop.
        self.assertAlmostEqual(self.speed_after(5, 0x0DCF, velocity=(5, 0, 0)), 0.0, delta=0.05)
        # One axis of the velocity ignored: the acceleration alone counts, without a speed cap.
        self.assertGreater(self.speed_after(8, 0x0C0F, velocity=(5, 0, 0), acceleration=(2.5, 0, 0)), 10.0)

    def test_position(self):
        switch = Switch()
        flight = airborne(switch)
        switch.now = dict(mask=0x0DF8, position=(30, -10, -15))
        flight.run_for(30)
        east, north, up = (flight.body().east, flight.body().north, flight.body().up)
        self.assertLess(math.dist((east, north, up), (-10, 30, 15)), 0.5)

    def test_other_frames_are_ignored(self):
        switch = Switch()
        flight = airborne(switch)
        switch.now = dict(velocity=(5, 0, 0), frame=8)
        flight.run_for(2)
        self.assertLess(flight.body().speed, 0.1)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.counts["ignored_frame"], 10)


class Movement(unittest.TestCase):
    def test_a_step_of_full_acceleration_ends_0_3_u_short(self):
        # The node's ramp: the velocity goes up with the acceleration that is fed forward.
        begun = []

        def ramp(controller: Controller) -> dict:
            if not begun:
                return {}
            passed = (controller.last["LOCAL_POSITION_NED"].time_boot_ms - begun[0]) / 1000
            return dict(velocity=(2.5 * passed, 0, 0), acceleration=(2.5, 0, 0))

        flight = airborne(ramp)
        flight.run_for(5)
        begun.append(flight.fleet.t_ms + 200)
        flight.run_for(0.2)
        start = flight.body().north
        flight.run_for(2)
        short_u = (5.0 - (flight.body().north - start)) / 2.5
        self.assertAlmostEqual(short_u, 0.3, delta=0.1)

    def test_a_ramp_of_1_25_is_tracked(self):
        begun = []

        def ramp(controller: Controller) -> dict:
            if not begun:
                return {}
            passed = (controller.last["LOCAL_POSITION_NED"].time_boot_ms - begun[0]) / 1000
            return dict(velocity=(1.25 * passed, 0, 0), acceleration=(1.25, 0, 0))

        flight = airborne(ramp)
        flight.run_for(5)
        begun.append(flight.fleet.t_ms)
        flight.run_for(4)
        self.assertAlmostEqual(flight.body().vn, 5.0, delta=0.25)

    def test_acceleration_has_a_limit(self):
        flight = airborne(lambda _: dict(velocity=(5, 5, 0), mask=0x0DC7))
        flight.run_for(1)
        self.assertLess(flight.body().speed, 2.6)

    def test_wind_carries_nothing_away_that_hovers(self):
        flight = airborne(lambda _: {}, wind=[6.0, -3.0])
        flight.run_for(30)
        self.assertLess(flight.body().speed, 0.05)

    def test_gps_noise_is_seeded_and_of_its_size(self):
        def errors(seed: int) -> list[float]:
            flight = airborne(lambda _: {}, gps_noise_m=1.5, seed=seed)
            errors = []
            vehicle = flight.fleet.vehicles[0]
            flight.each_tick = lambda: errors.append(vehicle.estimate().east - vehicle.autopilot.body.east)
            flight.run_for(400)
            return errors

        first = errors(1)
        self.assertEqual(first, errors(1))
        self.assertNotEqual(first, errors(2))
        rms = math.sqrt(sum(e * e for e in first) / len(first))
        self.assertTrue(0.8 < rms < 2.4, rms)


class Refusals(unittest.TestCase):
    def test_setpoints_in_another_mode_are_ignored(self):
        switch = Switch()
        flight = airborne(switch)
        switch.now = dict(velocity=(5, 0, 0))
        flight.fleet.vehicles[0].pilot_mode("LOITER")
        flight.run_for(5)
        self.assertLess(flight.body().speed, 0.1)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.counts["ignored_in_other_mode"], 25)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.mode.name, "LOITER")

    def test_numbers_that_are_none_abort_the_autopilot(self):
        for bad in (math.nan, math.inf, -math.inf):
            switch = Switch()
            flight = airborne(switch)
            switch.now = dict(acceleration=(0.0, bad, 0.0))
            flight.run_for(1)
            (crash,) = flight.named("crash")
            self.assertIn("would have aborted", crash["reason"])
            heard = len(flight.controllers[0].frames)
            flight.run_for(5)
            self.assertEqual(len(flight.controllers[0].frames), heard, "an aborted autopilot is silent")

    def test_numbers_that_the_mask_leaves_out_do_no_harm(self):
        flight = airborne(lambda _: dict(velocity=(1, 0, 0), acceleration=(math.nan, 0, 0), mask=0x0DC7))
        flight.run_for(5)
        self.assertEqual(flight.named("crash"), [])
        self.assertGreater(flight.body().vn, 0.9)
