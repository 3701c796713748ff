"""From power-on into the air."""

import math
import unittest

from simlink.faults import Fault
from simlink.tests.support import GLOBAL, LOCAL, Controller, Flight


def hover(_: Controller) -> dict:
    return {}


class ArduPilot(unittest.TestCase):
    def setUp(self):
        self.controller = Controller(hover)
        self.flight = Flight(self.controller)

    def test_it_arms_takes_off_and_follows(self):
        self.flight.run_until(lambda: self.flight.fleet.vehicles[0].autopilot.is_streaming)
        order = [event["event"] for event in self.flight.named()]
        self.assertEqual(order, ["ekf_ready", "mode", "armed", "airborne"])
        self.flight.run_for(10)
        self.assertAlmostEqual(self.flight.body().up, 10.0, delta=0.6)
        heartbeat = self.controller.last["HEARTBEAT"]
        self.assertEqual((heartbeat.type, heartbeat.autopilot, heartbeat.custom_mode), (2, 3, 4))

    def test_before_the_ekf_is_ready_it_refuses_and_says_why(self):
        self.controller.takes_off = False
        self.flight.run_for(2)
        vehicle = self.flight.fleet.vehicles[0]
        for command, *parameters in ((400, 1), (176, 1, 4), (22, 0, 0, 0, 0, 0, 0, 10)):
            self.send(self.controller.command(command, *parameters))
        self.flight.run_for(0.4)
        self.assertEqual(self.controller.acks[-3:], [(400, 4), (176, 4), (22, 4)])
        self.assertIn("PreArm: Need Position Estimate", self.controller.texts)
        self.assertIn("Mode change to GUIDED failed: requires position", self.controller.texts)
        self.assertFalse(vehicle.autopilot.armed)

    def test_some_modes_do_not_arm(self):
        self.controller.takes_off = False
        self.flight.run_for(6)
        for mode, name in ((6, "RTL"), (9, "LAND"), (17, "BRAKE")):
            self.send(self.controller.command(176, 1, mode), self.controller.command(400, 1))
            self.flight.run_for(0.4)
            self.assertEqual(self.controller.acks[-1], (400, 4))
            self.assertEqual(self.controller.texts[-1], f"Arm: {name} mode not armable")

    def test_it_takes_off_only_in_guided_and_armed(self):
        self.controller.takes_off = False
        self.flight.run_for(6)
        self.send(self.controller.command(400, 1), self.controller.command(22, 0, 0, 0, 0, 0, 0, 10))
        self.flight.run_for(0.4)
        self.assertEqual(self.controller.acks[-2:], [(400, 0), (22, 4)])
        self.send(self.controller.command(176, 1, 4), self.controller.command(22, 0, 0, 0, 0, 0, 0, 10))
        self.flight.run_for(0.4)
        self.assertEqual(self.controller.acks[-2:], [(176, 0), (22, 0)])

    def test_a_second_takeoff_in_the_air_is_refused(self):
        self.flight.run_until(lambda: self.flight.fleet.vehicles[0].autopilot.is_streaming)
        for height in (10, 30):
            self.send(self.controller.command(22, 0, 0, 0, 0, 0, 0, height))
            self.flight.run_for(5)
            self.assertEqual(self.controller.acks[-1], (22, 4))
        self.assertAlmostEqual(self.flight.body().up, 10.0, delta=0.6)

    def test_armed_on_the_ground_it_disarms_by_itself(self):
        self.controller.takes_off = False
        self.flight.run_for(6)
        self.send(self.controller.command(400, 1))
        self.flight.run_for(9)
        self.assertTrue(self.flight.fleet.vehicles[0].autopilot.armed)
        self.flight.run_for(3)
        self.assertFalse(self.flight.fleet.vehicles[0].autopilot.armed)

    def test_it_sends_only_heartbeats_until_asked(self):
        self.controller.silent = True
        self.flight.run_for(10)
        self.assertEqual(set(self.controller.seen), {0})
        self.assertEqual(len(self.controller.seen[0]), 11)

    def test_after_a_reboot_it_sends_only_heartbeats_and_texts_until_asked(self):
        self.controller.takes_off = False
        self.flight.run_for(8)
        self.flight.fleet.vehicles[0].faults.add(Fault(1, "reboot", for_ms=2000))
        self.flight.run_for(3)
        self.controller.seen.clear()
        self.flight.run_for(10)
        self.assertIn(0, self.controller.seen)
        self.assertLessEqual(set(self.controller.seen), {0, 253})
        self.send(self.controller.command(511, GLOBAL, 200_000))
        self.flight.run_for(8)
        self.assertIn(GLOBAL, self.controller.seen)

    def test_intervals_are_honoured_per_message(self):
        self.controller.takes_off = False
        self.flight.run_for(5)
        self.send(self.controller.command(511, LOCAL, 1_000_000), self.controller.command(511, 2, -1))
        self.flight.run_for(1)
        self.controller.seen.clear()
        self.flight.run_for(10)
        counts = {message: len(times) for message, times in self.controller.seen.items()}
        self.assertEqual(counts, {0: 10, 1: 10, 24: 10, 193: 10, 49: 10, GLOBAL: 50, LOCAL: 10, 230: 10})

    def test_unknown_messages_and_commands_are_refused(self):
        self.controller.takes_off = False
        self.flight.run_for(1)
        self.send(self.controller.command(511, 9999, 200_000), self.controller.command(31_000))
        self.flight.run_for(0.4)
        self.assertEqual(self.controller.acks[-2:], [(511, 4), (31_000, 3)])

    def test_what_is_meant_for_another_system_is_passed_over(self):
        self.controller.takes_off = False
        self.flight.run_for(1)
        before = len(self.controller.acks)
        foreign = self.controller.command(400, 1)
        foreign.target_system = 77
        self.send(foreign)
        self.flight.run_for(1)
        self.assertEqual(len(self.controller.acks), before)

    def test_before_the_ekf_has_an_origin_nothing_is_said_of_it(self):
        self.controller.takes_off = False
        self.flight.run_for(4)
        self.assertTrue({LOCAL, 49}.isdisjoint(self.controller.seen))
        self.assertIn(GLOBAL, self.controller.seen)
        self.flight.run_for(3)
        self.assertTrue({LOCAL, 49} <= set(self.controller.seen))

    def test_the_position_pair_comes_last_and_with_one_time(self):
        self.flight.run_for(15)
        self.controller.frames.clear()
        self.flight.run_for(5)
        kinds = [int.from_bytes(frame[7:10], "little") for frame in self.controller.frames]
        self.assertEqual(kinds.count(LOCAL), 25)
        for at, kind in enumerate(kinds):
            if kind == LOCAL:
                self.assertEqual(kinds[at - 1], GLOBAL)
        pairs = len(self.controller.seen[LOCAL])
        self.assertEqual(self.controller.seen[LOCAL], self.controller.seen[GLOBAL][-pairs:])

    def send(self, *messages):
        self.flight.hub.waiting += [(0, self.controller.pack(message)) for message in messages]


class Frames(unittest.TestCase):
    """Where the vehicles are, in the three frames of MAVLink."""

    def test_three_vehicles_have_three_origins_and_one_globe(self):
        controllers = [Controller(hover) for _ in range(3)]
        flight = Flight(*controllers, start_u=[[10, 20], [30, 20], [10, 60]])
        flight.run_for(30)
        for controller, (x, y) in zip(controllers, ((10, 20), (30, 20), (10, 60)), strict=True):
            local, globe = controller.last["LOCAL_POSITION_NED"], controller.last["GLOBAL_POSITION_INT"]
            self.assertAlmostEqual(local.x, 0.0, delta=0.05)
            self.assertAlmostEqual(local.y, 0.0, delta=0.05)
            plane = flight.fleet.vehicles[0].plane
            east, north = plane.metres(globe.lat / 1e7, globe.lon / 1e7)
            self.assertAlmostEqual(east, 2.5 * x, delta=0.05)
            self.assertAlmostEqual(north, 2.5 * y, delta=0.05)
            origin = controller.last["GPS_GLOBAL_ORIGIN"]
            east, north = plane.metres(origin.latitude / 1e7, origin.longitude / 1e7)
            self.assertAlmostEqual(east, 2.5 * x, delta=0.02)


class Px4(unittest.TestCase):
    def test_it_arms_takes_off_and_goes_offboard(self):
        controller = Controller(hover, dialect="px4")
        flight = Flight(controller)
        flight.run_until(lambda: flight.fleet.vehicles[0].autopilot.mode.name == "OFFBOARD")
        names = [event.get("mode") for event in flight.named("mode")]
        self.assertEqual(names, ["TAKEOFF", "LOITER", "OFFBOARD"])
        flight.run_for(5)
        heartbeat = controller.last["HEARTBEAT"]
        self.assertEqual((heartbeat.autopilot, heartbeat.custom_mode), (12, 6 << 16))
        self.assertAlmostEqual(flight.body().up, 10.0, delta=0.6)

    def test_offboard_needs_a_stream_first(self):
        controller = Controller(None, dialect="px4")
        flight = Flight(controller)
        flight.run_until(lambda: controller.airborne)
        flight.hub.waiting.append((0, controller.pack(controller.command(176, 1, 6))))
        flight.run_for(0.4)
        self.assertEqual(controller.acks[-1], (176, 1))
        self.assertIn("Mode change to OFFBOARD failed: no offboard signal", controller.texts)

    def test_a_stream_of_two_hertz_is_too_slow(self):
        controller = Controller(
            lambda c: {} if c.last["LOCAL_POSITION_NED"].time_boot_ms % 600 == 0 else None, dialect="px4"
        )
        flight = Flight(controller)
        flight.run_until(lambda: controller.airborne)
        flight.run_for(10)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.mode.name, "LOITER")

    def test_it_sends_positions_unasked_once_it_knows_them(self):
        controller = Controller(None, dialect="px4")
        controller.silent = True
        flight = Flight(controller)
        flight.run_for(4)
        self.assertFalse({LOCAL, GLOBAL} & set(controller.seen))
        flight.run_for(6)
        self.assertEqual((len(controller.seen[LOCAL]), len(controller.seen[GLOBAL])), (26, 26))

    def test_without_an_altitude_it_takes_off_to_a_parameter(self):
        controller = Controller(None, dialect="px4", takes_off=False)
        flight = Flight(controller)
        flight.run_for(6)
        nan = math.nan
        for command in (controller.command(400, 1), controller.command(22, nan, 0, 0, nan, nan, nan, nan)):
            flight.hub.waiting.append((0, controller.pack(command)))
        flight.run_for(8)
        self.assertAlmostEqual(flight.body().up, 2.5, delta=0.3)
