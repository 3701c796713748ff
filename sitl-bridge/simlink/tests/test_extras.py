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
