"""Others on the port, and what real autopilots say that is easily misread."""

import unittest

from simlink import config
from simlink.extras import OTHER_SYSTEM
from simlink.faults import Fault
from simlink.tests.support import Controller, Flight


class Extras(unittest.TestCase):
    def test_they_send_heartbeats_of_their_own(self):
        controller = Controller(takes_off=False)
        flight = Flight(controller, extra=["vehicle", "camera", "companion"])
        senders = set()
        take = controller.take

        def listen(frame: bytes) -> list[bytes]:
            senders.add((frame[5], frame[6]))
            return take(frame)

        controller.take = listen
        flight.run_for(3)
        self.assertEqual(senders, {(1, 1), (OTHER_SYSTEM, 1), (1, 100), (1, 192)})

    def test_a_kind_that_is_not_known_is_refused(self):
        with self.assertRaisesRegex(config.ConfigError, "there is no extra 'boat'"):
            config.read({"vehicles": [{"id": 1, "port": 14_550}], "extra": ["boat"]})


class Batteries(unittest.TestCase):
    def told(self, **fields) -> dict[int, tuple[int, int]]:
        controller = Controller(takes_off=False, dialect="px4")
        flight = Flight(controller, **fields)
        heard = {}
        take = controller.take

        def listen(frame: bytes) -> list[bytes]:
            answers = take(frame)
            if status := controller.last.get("BATTERY_STATUS"):
                heard[status.id] = (status.battery_function, status.battery_remaining)
            return answers

        controller.take = listen
        flight.run_for(5)
        return heard

    def test_there_may_be_more_than_one(self):
        self.assertEqual(self.told(extra=["battery", "payload-battery"]), {0: (0, 100), 1: (2, 15), 2: (4, 5)})
        more = [{"id": 3, "function": "avionics", "percent": 40}]
        self.assertEqual(self.told(batteries=more), {0: (0, 100), 3: (3, 40)})

    def test_what_cannot_be_is_refused(self):
        for battery, word in (
            ({"id": 0, "percent": 5}, "1 to 255"),
            ({"id": 1, "percent": 101}, "0 to 100"),
            ({"id": 1, "percent": 5, "function": "toast"}, "there is no function 'toast'"),
        ):
            with self.assertRaisesRegex(config.ConfigError, word):
                config.read({"vehicles": [{"id": 1, "port": 14_550}], "batteries": [battery]})


class SharedPorts(unittest.TestCase):
    def test_every_vehicle_is_on_every_port(self):
        controllers = [Controller(lambda _: {}, vehicle=i, system=250 + i) for i in (1, 2, 3)]
        flight = Flight(*controllers, shared_ports=True)
        flight.run_until(lambda: all(vehicle.autopilot.is_streaming for vehicle in flight.fleet.vehicles))
        self.assertEqual([controller.others for controller in controllers], [{2, 3}, {1, 3}, {1, 2}])

    def test_whoever_takes_the_first_it_hears_commands_the_wrong_one(self):
        flight = Flight(Controller(takes_off=False), Controller(takes_off=False), shared_ports=True)
        flight.run_for(6)
        controller = flight.controllers[1]
        order = controller.command(400, 1)
        order.target_system = 1
        flight.hub.waiting.append((1, controller.pack(order)))
        flight.run_for(0.4)
        self.assertEqual([vehicle.autopilot.armed for vehicle in flight.fleet.vehicles], [True, False])


class AsSeen(unittest.TestCase):
    def test_px4_at_rest_reports_constant_position(self):
        controller = Controller(dialect="px4", takes_off=False)
        flight = Flight(controller)
        flight.run_for(10)
        self.assertEqual(controller.last["ESTIMATOR_STATUS"].flags, 1023)

    def test_px4_has_its_time_from_the_host(self):
        for dialect, factor in (("px4", 1), ("ardupilot", 5)):
            controller = Controller(dialect=dialect, takes_off=False)
            flight = Flight(controller, lockstep=False, speed=5.0)
            flight.run_for(10)
            first = controller.last["SYSTEM_TIME"]
            flight.run_for(50)
            last = controller.last["SYSTEM_TIME"]
            passed_ms = last.time_boot_ms - first.time_boot_ms
            unix_ms = (last.time_unix_usec - first.time_unix_usec) / 1000
            self.assertAlmostEqual(unix_ms * 5, passed_ms * factor, delta=1000)

    def test_a_clock_that_was_never_set_counts_from_1970(self):
        controller = Controller(takes_off=False)
        flight = Flight(controller)
        flight.fleet.vehicles[0].faults.add(Fault(1, "clock_unset"))
        flight.run_for(10)
        told = controller.last["SYSTEM_TIME"]
        self.assertEqual(told.time_unix_usec, told.time_boot_ms * 1000)
