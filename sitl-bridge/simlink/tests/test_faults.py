"""Scripted faults as a node sees them."""

import math
import unittest

from simlink.faults import KINDS, Fault, FaultError
from simlink.tests.support import GLOBAL, LOCAL, Controller, Flight

HOVER_MS = 20_000


def fly(*faults: dict, seconds: float = 30.0, setpoint=lambda _: {}, **fields) -> tuple[Flight, Controller]:
    """Flies `seconds`; the vehicle hovers from 20 s at the latest."""
    controller = Controller(setpoint)
    flight = Flight(controller, faults=[{"id": 1, **fault} for fault in faults], **fields)
    flight.run_for(seconds)
    return flight, controller


class Position(unittest.TestCase):
    def test_gps_lost(self):
        flight, controller = fly({"kind": "gps_lost", "at_ms": HOVER_MS}, seconds=22)
        self.assertEqual(controller.last["GPS_RAW_INT"].fix_type, 1)
        self.assertFalse(controller.last["EKF_STATUS_REPORT"].flags & 16)
        flight.run_for(6)
        self.assertEqual(flight.named("failsafe")[0]["reason"], "EKF")
        self.assertEqual(flight.fleet.vehicles[0].autopilot.mode.name, "LAND")

    def test_gps_lost_for_a_moment(self):
        flight, controller = fly({"kind": "gps_lost", "at_ms": HOVER_MS, "for_ms": 3000})
        self.assertEqual(controller.last["GPS_RAW_INT"].fix_type, 3)
        self.assertTrue(controller.last["EKF_STATUS_REPORT"].flags & 16)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.mode.name, "GUIDED")

    def test_ekf_bad(self):
        _, controller = fly({"kind": "ekf_bad", "at_ms": HOVER_MS}, seconds=22)
        report = controller.last["EKF_STATUS_REPORT"]
        self.assertFalse(report.flags & 16)
        self.assertGreater(report.velocity_variance, 1.0)

    def test_pose_frozen(self):
        flight, controller = fly(
            {"kind": "pose_frozen", "at_ms": HOVER_MS}, setpoint=lambda _: dict(velocity=(3, 0, 0)), seconds=20.4
        )
        before = controller.last["LOCAL_POSITION_NED"], controller.last["GLOBAL_POSITION_INT"]
        flight.run_for(3)
        after = controller.last["LOCAL_POSITION_NED"], controller.last["GLOBAL_POSITION_INT"]
        for old, new in zip(before, after, strict=True):
            self.assertEqual(new.time_boot_ms - old.time_boot_ms, 3000)
        self.assertEqual([(m.x, m.y, m.vx) for m in (before[0],)], [(m.x, m.y, m.vx) for m in (after[0],)])
        self.assertEqual((before[1].lat, before[1].vx), (after[1].lat, after[1].vx))

    def test_pose_stale(self):
        flight, controller = fly({"kind": "pose_stale", "at_ms": HOVER_MS, "for_ms": 5000}, seconds=20.4)
        seen = len(controller.seen[LOCAL]), len(controller.seen[GLOBAL])
        heartbeats = len(controller.seen[0])
        flight.run_for(4)
        self.assertEqual((len(controller.seen[LOCAL]), len(controller.seen[GLOBAL])), seen)
        self.assertEqual(len(controller.seen[0]), heartbeats + 4)
        flight.run_for(2)
        self.assertGreater(len(controller.seen[LOCAL]), seen[0])

    def test_nan(self):
        _, controller = fly({"kind": "nan", "at_ms": HOVER_MS})
        local = controller.last["LOCAL_POSITION_NED"]
        self.assertTrue(math.isnan(local.x) and math.isinf(local.vx))
        self.assertTrue(abs(controller.last["GLOBAL_POSITION_INT"].lat) > 1e8)

    def test_teleport(self):
        flight, controller = fly({"kind": "teleport", "by_u": [0, 8], "at_ms": HOVER_MS}, seconds=20.2)
        self.assertAlmostEqual(controller.last["LOCAL_POSITION_NED"].x, 20.0, delta=0.1)
        self.assertAlmostEqual(flight.body().north, 20.0, delta=0.1)

    def test_teleport_in_ideal_flight(self):
        flight, _ = fly({"kind": "teleport", "by_u": [0, 8], "at_ms": HOVER_MS}, dynamics="ideal", start_u=[[50, 60]])
        self.assertEqual(flight.named("truth")[-1]["u"], [[50.0, 68.0]])


class Autopilot(unittest.TestCase):
    def test_clock_jump(self):
        flight, controller = fly({"kind": "clock_jump", "by_ms": 90_000, "at_ms": HOVER_MS})
        self.assertEqual(controller.last["LOCAL_POSITION_NED"].time_boot_ms, flight.fleet.t_ms + 90_000)

    def test_clock_jumps_back(self):
        flight, controller = fly({"kind": "clock_jump", "by_ms": -15_000, "at_ms": HOVER_MS})
        self.assertEqual(controller.last["LOCAL_POSITION_NED"].time_boot_ms, flight.fleet.t_ms - 15_000)

    def test_link_cut(self):
        flight, controller = fly({"kind": "link_cut", "at_ms": HOVER_MS, "for_ms": 4000}, seconds=20.2)
        frames = len(controller.frames)
        taken = flight.fleet.vehicles[0].endpoint.received
        flight.hub.waiting.append((0, controller.pack(controller.own_heartbeat())))
        flight.run_for(3)
        self.assertEqual(len(controller.frames), frames)
        self.assertEqual(flight.fleet.vehicles[0].endpoint.received, taken)
        flight.run_for(3)
        self.assertGreater(len(controller.frames), frames)
        self.assertEqual(len(flight.named("timeout")), 1)

    def test_reboot(self):
        flight, controller = fly({"kind": "reboot", "at_ms": HOVER_MS}, seconds=21)
        frames = len(controller.frames)
        controller.takes_off = False
        flight.run_for(4)
        self.assertEqual(len(flight.named("reboot")), 1)
        # Motors off in the air.
        self.assertIn("hit the ground", flight.named("crash")[0]["reason"])
        self.assertEqual(len(controller.frames), frames)

    def test_reboot_on_the_ground(self):
        controller = Controller(None, takes_off=False)
        flight = Flight(controller, faults=[{"id": 1, "kind": "reboot", "at_ms": 10_000, "for_ms": 1000}])
        flight.run_for(13)
        self.assertEqual(controller.last["HEARTBEAT"].system_status, 2)
        flight.run_for(7)
        self.assertEqual(controller.last["HEARTBEAT"].system_status, 3)
        # It has forgotten what it was asked for.
        self.assertLess(controller.seen[LOCAL][-1], 10_000)

    def test_pilot_mode(self):
        flight, controller = fly({"kind": "pilot_mode", "mode": "LOITER", "at_ms": HOVER_MS})
        self.assertEqual(controller.mode, 5)
        self.assertEqual(flight.named("mode")[-1]["why"], "pilot")

    def test_battery_low(self):
        _, controller = fly({"kind": "battery_low", "percent": 9, "at_ms": HOVER_MS})
        self.assertEqual(controller.last["SYS_STATUS"].battery_remaining, 9)
        self.assertIn("Battery 1 is low", controller.texts)

    def test_disarm_in_the_air(self):
        flight, _ = fly({"kind": "disarm", "at_ms": HOVER_MS})
        self.assertIn("hit the ground", flight.named("crash")[0]["reason"])


class Phases(unittest.TestCase):
    def begins(self, phase: str, setpoint) -> tuple[dict, Flight]:
        flight, _ = fly({"kind": "battery_low", "phase": phase, "after_ms": 400}, setpoint=setpoint, seconds=40)
        return flight.named("fault")[0], flight

    def test_takeoff(self):
        fault, flight = self.begins("takeoff", lambda _: {})
        airborne = flight.named("airborne")[0]
        armed = flight.named("armed")[0]
        self.assertTrue(armed["t_ms"] < fault["t_ms"] < airborne["t_ms"])

    def test_transit_and_hold(self):
        def late(controller: Controller) -> dict:
            moves = controller.last["LOCAL_POSITION_NED"].time_boot_ms > 30_000
            return dict(velocity=(3, 0, 0)) if moves else {}

        hold, flight = self.begins("hold", late)
        self.assertTrue(flight.named("airborne")[0]["t_ms"] < hold["t_ms"] < 30_000)
        transit, _ = self.begins("transit", late)
        self.assertTrue(30_000 < transit["t_ms"] < 33_000)


class Reading(unittest.TestCase):
    def test_every_kind_can_be_asked_for(self):
        needs = {"clock_jump": {"by_ms": 1}, "pilot_mode": {"mode": "RTL"}, "teleport": {"by_u": [1, 2]}}
        for kind in KINDS:
            self.assertEqual(Fault.read({"id": 1, "kind": kind, **needs.get(kind, {})}).kind, kind)

    def test_nonsense_is_refused_with_a_reason(self):
        for raw, word in (
            ({"id": 1, "kind": "gremlins"}, "gremlins"),
            ({"kind": "nan"}, "id"),
            ({"id": 1, "kind": "nan", "at": 3}, "`at`"),
            ({"id": 1, "kind": "nan", "at_ms": -1}, "at_ms"),
            ({"id": 1, "kind": "nan", "phase": "landing"}, "landing"),
            ({"id": 1, "kind": "clock_jump"}, "by_ms"),
            ({"id": 1, "kind": "teleport", "by_u": [1]}, "by_u"),
            ("nan", "nan"),
        ):
            with self.assertRaisesRegex(FaultError, word):
                Fault.read(raw)
