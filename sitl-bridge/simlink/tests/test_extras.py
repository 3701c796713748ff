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


class AsSeen(unittest.TestCase):
    def test_px4_at_rest_reports_constant_position(self):
        controller = Controller(dialect="px4", takes_off=False)
        flight = Flight(controller)
        flight.run_for(10)
        self.assertEqual(controller.last["ESTIMATOR_STATUS"].flags, 1023)

    def test_a_clock_that_was_never_set_counts_from_1970(self):
        controller = Controller(takes_off=False)
        flight = Flight(controller)
        flight.fleet.vehicles[0].faults.add(Fault(1, "clock_unset"))
        flight.run_for(10)
        told = controller.last["SYSTEM_TIME"]
        self.assertEqual(told.time_unix_usec, told.time_boot_ms * 1000)
