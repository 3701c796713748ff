"""Lock-step, pace, determinism, and the clocks that vehicles tell."""

import json
import unittest

from simlink.tests.support import LOCAL, Controller, Flight

WRAP = 1 << 32


def weave(controller: Controller) -> dict:
    """Flies with whatever it hears: differences would add up."""
    local = controller.last["LOCAL_POSITION_NED"]
    return dict(velocity=(3.0 - 0.05 * local.x, 2.0 - 0.05 * local.y + 0.5 * local.vx, 0.0))


class Lockstep(unittest.TestCase):
    def test_every_position_is_answered_before_time_goes_on(self):
        controllers = [Controller(weave) for _ in range(3)]
        flight = Flight(*controllers)
        flight.run_until(lambda: all(v.autopilot.is_streaming for v in flight.fleet.vehicles))
        flight.run_for(1)
        before = [vehicle.autopilot.counts["accepted"] for vehicle in flight.fleet.vehicles]
        wall = flight.hub.wall
        flight.run_for(60)
        for vehicle, count in zip(flight.fleet.vehicles, before, strict=True):
            self.assertEqual(vehicle.autopilot.counts["accepted"], count + 300)
        self.assertEqual(flight.hub.wall, wall, "while all stream, the wall clock does not matter")
        self.assertEqual(flight.fleet.lockstep_timeouts, 0)

    def test_one_who_falls_silent_is_waited_for_once(self):
        talks = [True]
        silent = Controller(lambda _: {} if talks[0] else None)
        flight = Flight(silent, Controller(weave), guided_timeout_s=30)
        flight.run_until(lambda: all(v.autopilot.is_streaming for v in flight.fleet.vehicles))
        talks[0] = False
        wall = flight.hub.wall
        flight.run_for(10)
        self.assertEqual([event["id"] for event in flight.named("lockstep_timeout")], [1])
        # Two seconds of waiting, then 20 times real time, for it may need its wall clock.
        self.assertAlmostEqual(flight.hub.wall - wall, 2.0 + 9.8 / 20, delta=0.1)
        talks[0] = True
        flight.run_for(1)
        talks[0] = False
        flight.run_for(5)
        self.assertEqual(len(flight.named("lockstep_timeout")), 2)

    def test_without_a_stream_time_runs_at_its_speed(self):
        for speed in (1, 20):
            flight = Flight(Controller(None, takes_off=False), speed=speed)
            flight.run_for(10)
            self.assertAlmostEqual(flight.hub.wall, 10 / speed, delta=0.3 / speed)

    def test_a_controller_that_has_gone_costs_one_wait(self):
        controller = Controller(weave)
        flight = Flight(controller, Controller(weave))
        flight.run_until(lambda: all(v.autopilot.is_streaming for v in flight.fleet.vehicles))
        controller.silent = True
        wall = flight.hub.wall
        flight.run_for(20)
        self.assertAlmostEqual(flight.hub.wall - wall, 2.0 + 20 / 20, delta=0.1)
        self.assertEqual(flight.fleet.lockstep_timeouts, 1)

    def test_without_lockstep_the_wall_clock_rules(self):
        flight = Flight(Controller(weave), lockstep=False, speed=2)
        flight.run_for(20)
        self.assertAlmostEqual(flight.hub.wall, 10.0, delta=0.2)


class Determinism(unittest.TestCase):
    def truth(self, seed: int) -> str:
        flight = Flight(
            *(Controller(weave) for _ in range(4)),
            seed=seed,
            gps_noise_m=0.8,
            wind=[3, 1],
            start_u=[[10 * i, 5] for i in range(4)],
            faults=[{"id": 2, "kind": "pose_frozen", "phase": "transit", "for_ms": 2000}],
        )
        flight.run_for(80)
        return json.dumps(flight.named("truth"))

    def test_the_same_seed_gives_the_same_truth(self):
        first = self.truth(5)
        self.assertGreater(len(json.loads(first)), 35)
        self.assertEqual(first, self.truth(5))
        self.assertNotEqual(first, self.truth(6))


class Clocks(unittest.TestCase):
    def test_the_boot_clock_wraps(self):
        controller = Controller(weave)
        flight = Flight(controller, boot_ms=WRAP - 20_000)
        flight.run_for(40)
        times = controller.seen[LOCAL]
        self.assertTrue(times[0] > WRAP - 20_000 and times[-1] == 20_000)
        for old, new in zip(times, times[1:], strict=False):
            self.assertEqual((new - old) % WRAP, 200)
        self.assertEqual(controller.last["SYSTEM_TIME"].time_boot_ms, 20_000)
        self.assertEqual(flight.named("crash", "failsafe", "timeout"), [])

    def test_the_time_of_day_is_told_once_it_is_known(self):
        controller = Controller(None, takes_off=False)
        flight = Flight(controller, boot_ms=7_000)
        flight.run_for(3)
        self.assertEqual(controller.last["SYSTEM_TIME"].time_unix_usec, 0)
        flight.run_for(17)
        message = controller.last["SYSTEM_TIME"]
        unix_ms = message.time_unix_usec // 1000
        self.assertEqual(unix_ms - 1_700_000_000_000, message.time_boot_ms - 7_000)

    def test_truth_is_told_at_each_step_from_the_epoch_on(self):
        flight = Flight(Controller(None), epoch_unix_ms=1_700_000_010_000, step_ms=1000)
        flight.run_for(15)
        truth = flight.named("truth")
        self.assertEqual([event["step"] for event in truth], [0, 1, 2, 3, 4, 5])
        self.assertEqual([event["t_ms"] for event in truth], [10_000 + 1000 * k for k in range(6)])

    def test_another_tick(self):
        controller = Controller(None, takes_off=False)
        flight = Flight(controller, rate_hz=10)
        flight.run_for(6)
        flight.hub.waiting.append((0, controller.pack(controller.command(511, LOCAL, 100_000))))
        flight.run_for(0.5)
        controller.seen.clear()
        flight.run_for(10)
        self.assertEqual(len(controller.seen[LOCAL]), 100)
