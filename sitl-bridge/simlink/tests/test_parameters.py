"""Parameters: their defaults, how each dialect writes them, and how they are set."""

import struct
import unittest

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink import config
from simlink.tests.support import Controller, Flight


def told(flight: Flight, name: str) -> mavlink.MAVLink_message:
    """The answer to PARAM_REQUEST_READ."""
    controller = flight.controllers[0]
    request = mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), -1)
    flight.hub.waiting.append((0, controller.pack(request)))
    flight.run_for(0.4)
    answer = controller.last["PARAM_VALUE"]
    assert answer.param_id.rstrip("\0") == name, answer
    return answer


class Parameters(unittest.TestCase):
    def test_defaults_of_arducopter_are_floats(self):
        flight = Flight(Controller(takes_off=False))
        for name, value in (
            ("GUID_TIMEOUT", 3),
            ("FS_GCS_ENABLE", 0),
            ("MAV_GCS_SYSID", 255),
            ("RTL_ALT_M", 15),
            ("FENCE_ENABLE", 0),
        ):
            answer = told(flight, name)
            self.assertEqual((answer.param_value, answer.param_type), (value, mavlink.MAV_PARAM_TYPE_REAL32), name)

    def test_integers_of_px4_are_bytes(self):
        flight = Flight(Controller(dialect="px4", takes_off=False), parameters={"NAV_DLL_ACT": 2})
        for name, value in (("COM_OBL_RC_ACT", 0), ("NAV_DLL_ACT", 2), ("GF_ACTION", 2)):
            answer = told(flight, name)
            (number,) = struct.unpack("<i", struct.pack("<f", answer.param_value))
            self.assertEqual((number, answer.param_type), (value, mavlink.MAV_PARAM_TYPE_INT32), name)
        for name, value in (("COM_OF_LOSS_T", 1), ("RTL_RETURN_ALT", 30)):
            answer = told(flight, name)
            self.assertEqual((answer.param_value, answer.param_type), (value, mavlink.MAV_PARAM_TYPE_REAL32), name)

    def test_an_integer_of_px4_is_set_by_its_bytes(self):
        flight = Flight(Controller(dialect="px4", takes_off=False))
        (value,) = struct.unpack("<f", struct.pack("<i", 3))
        request = mavlink.MAVLink_param_set_message(1, 1, b"COM_OBL_RC_ACT", value, mavlink.MAV_PARAM_TYPE_INT32)
        flight.hub.waiting.append((0, flight.controllers[0].pack(request)))
        flight.run_for(0.4)
        self.assertEqual(flight.fleet.vehicles[0].autopilot.parameters["COM_OBL_RC_ACT"], 3.0)

    def test_a_vehicles_own_count_more(self):
        vehicles = [{"id": 1, "port": 14_550, "parameters": {"GUID_TIMEOUT": 2}}]
        flight = Flight(Controller(takes_off=False), vehicles=vehicles, parameters={"GUID_TIMEOUT": 1, "FENCE_ENABLE": 1})
        self.assertEqual(told(flight, "GUID_TIMEOUT").param_value, 2)
        self.assertEqual(told(flight, "FENCE_ENABLE").param_value, 1)

    def test_what_there_is_not_is_refused_and_not_answered(self):
        with self.assertRaisesRegex(config.ConfigError, "has no parameter 'RTL_ALTITUDE'"):
            Flight(Controller(), parameters={"RTL_ALTITUDE": 1})
        with self.assertRaisesRegex(config.ConfigError, "FENCE_ENABLE is a number"):
            Flight(Controller(), parameters={"FENCE_ENABLE": "yes"})
        flight = Flight(Controller(takes_off=False))
        with self.assertRaises(KeyError):
            told(flight, "RTL_ALTITUDE")
