"""What the autopilots do by themselves when nobody tells them anything."""

import unittest

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink.tests.support import Controller, Flight
from simlink.tests.test_setpoints import Switch, airborne


class SetpointTimeout(unittest.TestCase):
    def cruise(self, **fields) -> tuple[Flight, Switch]:
        switch = Switch()
        flight = airborne(switch, **fields)
        switch.now = dict(velocity=(5, 0, 0))
        flight.run_for(8)
        self.assertAlmostEqual(flight.body().vn, 5.0, delta=0.2)
        return flight, switch

    def silence(self, flight: Flight, switch: Switch) -> tuple[dict, dict]:
        switch.now = None
        flight.run_for(15)
        (timeout,), (stopped,) = flight.named("timeout"), flight.named("stopped")
        return timeout, stopped

    def test_three_seconds_by_default(self):
        timeout, stopped = self.silence(*self.cruise())
        self.assertEqual(timeout["silent_ms"], 3200)
        # 3 s at 5 m/s.
        self.assertAlmostEqual(timeout["flown_m"], 15.0, delta=0.5)
        self.assertTrue(20 < stopped["flown_m"] < 26, stopped)

    def test_it_can_be_set(self):
        for seconds in (0.6, 1.0):
            timeout, stopped = self.silence(*self.cruise(guided_timeout_s=seconds))
            self.assertLessEqual(timeout["silent_ms"], seconds * 1000 + 200)
            self.assertLess(stopped["flown_m"], 13)

    def test_it_can_be_set_over_mavlink(self):
        flight, switch = self.cruise()
        message = flight.controllers[0]
        request = mavlink.MAVLink_param_set_message(1, 1, b"GUID_TIMEOUT", 1.0, mavlink.MAV_PARAM_TYPE_REAL32)
        flight.hub.waiting.append((0, message.pack(request)))
        flight.run_for(0.4)
        self.assertEqual(message.last["PARAM_VALUE"].param_value, 1.0)
        timeout, _ = self.silence(flight, switch)
        self.assertEqual(timeout["silent_ms"], 1200)

    def test_an_acceleration_is_flown_on_until_the_timeout(self):
        flight, switch = self.cruise()
        switch.now = dict(velocity=(5, 0, 0), acceleration=(2.5, 0, 0))
        flight.run_for(0.4)
        _, stopped = self.silence(flight, switch)
        self.assertTrue(38 < stopped["flown_m"] < 60, stopped)

    def test_it_stays_in_guided_and_follows_again(self):
        flight, switch = self.cruise()
        self.silence(flight, switch)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.mode.name, "GUIDED")
        switch.now = dict(velocity=(2, 0, 0))
        flight.run_for(5)
        self.assertAlmostEqual(flight.body().vn, 2.0, delta=0.2)

    def test_px4_leaves_offboard_after_a_second(self):
        switch = Switch()
        flight = Flight(Controller(switch, dialect="px4"))
        flight.run_until(lambda: flight.fleet.vehicles[0].autopilot.mode.name == "OFFBOARD")
        switch.now = dict(velocity=(5, 0, 0))
        flight.run_for(8)
        timeout, stopped = self.silence(flight, switch)
        self.assertEqual(timeout["silent_ms"], 1200)
        self.assertLess(stopped["flown_m"], 16)
        self.assertEqual(flight.named("mode")[-1]["mode"], "POSCTL")

    def test_px4_changes_to_the_mode_it_is_told(self):
        for number, mode in ((3, "RTL"), (4, "LAND"), (5, "LOITER")):
            switch = Switch()
            flight = Flight(Controller(switch, dialect="px4"), parameters={"COM_OBL_RC_ACT": number})
            flight.run_until(lambda flight=flight: flight.fleet.vehicles[0].autopilot.mode.name == "OFFBOARD")
            switch.now = None
            flight.run_for(3)
            self.assertEqual(flight.named("mode")[-1]["mode"], mode)

    def test_in_ideal_flight_too(self):
        switch = Switch()
        flight = airborne(switch, dynamics="ideal", start_u=[[100, 20]])
        switch.now = dict(acceleration=(2.5, 0, 0))
        flight.run_for(10)
        timeout, stopped = self.silence(flight, switch)
        self.assertLessEqual(stopped["t_ms"] - timeout["t_ms"], 200)
        north = flight.body().north
        flight.run_for(10)
        self.assertEqual(flight.body().north, north)


class HeartbeatsMissing(unittest.TestCase):
    def test_it_returns_even_while_setpoints_go_on(self):
        switch = Switch()
        flight = airborne(switch, parameters={"FS_GCS_ENABLE": 1})
        switch.now = dict(velocity=(5, 0, 0))
        flight.run_for(10)
        controller = flight.controllers[0]
        controller.heartbeats = False
        flight.run_for(7)
        (failsafe,) = flight.named("failsafe")
        self.assertEqual((failsafe["reason"], failsafe["mode"]), ("GCS", "RTL"))
        self.assertEqual(flight.named("mode")[-1]["mode"], "RTL")
        # Heartbeats come back; the mode does not.
        controller.heartbeats = True
        flight.run_for(5)
        self.assertIn("GCS Failsafe Cleared", controller.texts)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.mode.name, "RTL")

    def test_it_flies_home_and_lands(self):
        switch = Switch()
        flight = airborne(switch, parameters={"FS_GCS_ENABLE": 1})
        switch.now = dict(velocity=(5, -3, 0))
        flight.run_for(20)
        flight.controllers[0].heartbeats = False
        flight.controllers[0].takes_off = False
        flight.run_until(lambda: flight.named("landed"), 200)
        self.assertLess(abs(flight.body().east) + abs(flight.body().north), 2.0)
        self.assertFalse(flight.fleet.vehicles[0].autopilot.armed)
        self.assertEqual(flight.named("crash"), [])

    def test_ardupilot_counts_the_ground_station_s_id_alone(self):
        for system, kind in ((250, mavlink.MAV_TYPE_ONBOARD_CONTROLLER), (2, mavlink.MAV_TYPE_GCS)):
            controller = Controller(lambda _: {}, system=system, kind=kind)
            flight = Flight(controller, parameters={"FS_GCS_ENABLE": 1})
            flight.run_until(lambda flight=flight: flight.fleet.vehicles[0].autopilot.is_streaming)
            controller.heartbeats = False
            flight.run_for(20)
            self.assertEqual(flight.named("failsafe"), [])
        # Where it is told another, that one counts.
        controller = Controller(lambda _: {}, system=2)
        flight = Flight(controller, parameters={"FS_GCS_ENABLE": 1})
        flight.fleet.vehicles[0].autopilot.parameters["MAV_GCS_SYSID"] = 2.0
        flight.run_until(lambda: flight.fleet.vehicles[0].autopilot.is_streaming)
        controller.heartbeats = False
        flight.run_for(7)
        self.assertEqual(len(flight.named("failsafe")), 1)

    def test_px4_misses_no_onboard_controller(self):
        for kind, failsafes in ((mavlink.MAV_TYPE_ONBOARD_CONTROLLER, 0), (mavlink.MAV_TYPE_GCS, 1)):
            controller = Controller(lambda _: {}, dialect="px4", kind=kind)
            flight = Flight(controller)
            autopilot = flight.fleet.vehicles[0].autopilot
            flight.run_until(lambda autopilot=autopilot: autopilot.mode.name == "OFFBOARD")
            autopilot.parameters["NAV_DLL_ACT"] = 2.0
            controller.heartbeats = False
            flight.run_for(12)
            self.assertEqual(len(flight.named("failsafe")), failsafes, kind)

    def test_px4_with_that_failsafe_does_not_arm_without_a_ground_station(self):
        for kind, result in ((mavlink.MAV_TYPE_ONBOARD_CONTROLLER, 4), (mavlink.MAV_TYPE_GCS, 0)):
            controller = Controller(dialect="px4", takes_off=False, kind=kind)
            flight = Flight(controller)
            flight.fleet.vehicles[0].autopilot.parameters["NAV_DLL_ACT"] = 2.0
            flight.run_for(6)
            flight.hub.waiting.append((0, controller.pack(controller.command(400, 1))))
            flight.run_for(0.4)
            self.assertEqual(controller.acks[-1], (400, result))
            refused = "Preflight Fail: No connection to the GCS"
            self.assertEqual(refused in controller.texts, result != 0)

    def test_nobody_who_never_spoke_is_missed(self):
        controller = Controller(lambda _: {})
        controller.heartbeats = False
        flight = Flight(controller, parameters={"FS_GCS_ENABLE": 1})
        flight.run_for(40)
        self.assertTrue(flight.fleet.vehicles[0].autopilot.is_streaming)
        self.assertEqual(flight.named("failsafe"), [])
