"""The fleet as a process: its configuration, its control lines, its sockets, its command line."""

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from simlink import config
from simlink.config import ConfigError
from simlink.tests.support import Controller, Flight

VEHICLE = {"id": 3, "port": 14_580}


class Configuration(unittest.TestCase):
    def test_little_is_needed(self):
        fleet = config.read({"vehicles": [VEHICLE]})
        self.assertEqual((fleet.vehicles[0].system, fleet.vehicles[0].dialect), (3, "ardupilot"))
        self.assertEqual((fleet.tick_ms, fleet.dynamics, fleet.lockstep, fleet.speed), (200, "point", True, 20.0))

    def test_everything_can_be_set(self):
        fleet = config.read(
            {
                "vehicles": [
                    {"id": 3, "system": 9, "host": "::1", "port": 1, "dialect": "px4", "lat": 1, "lon": 2, "alt": 3}
                ],
                "origin": {"lat": 47.4, "lon": 8.5, "alt": 400.0},
                "scale_m": 5,
                "step_ms": 1000,
                "map_side_u": 100,
                "epoch_unix_ms": 5,
                "rate_hz": 10,
                "dynamics": "ideal",
                "lockstep": False,
                "lockstep_timeout_s": 1,
                "speed": 3,
                "wind": [0, 0],
                "gps_noise_m": 0,
                "seed": 4,
                "battery": {"percent": 80, "minutes": 20},
                "start_u": [[1, 2]],
                "signing_key_file": "key",
                "faults": [{"id": 3, "kind": "nan"}],
                "guided_timeout_s": 0.8,
                "parameters": {"NAV_DLL_ACT": 2},
                "ekf_ready_s": 1,
                "boot_ms": 6,
                "unix_ms": 7,
            }
        )
        self.assertEqual(fleet.vehicles[0].start_u, (1.0, 2.0))
        self.assertEqual((fleet.battery.percent, fleet.unix_ms, fleet.ekf_ready_ms), (80, 7, 1000))

    def test_nonsense_is_refused_with_the_field(self):
        for fields, word in (
            ({"vehicles": []}, "no vehicles"),
            ({}, "vehicles"),
            ({"vehicles": [{"id": 1}]}, "port"),
            ({"vehicles": [{"id": 1, "port": 1, "sysid": 1}]}, "sysid"),
            ({"vehicles": [{"id": 255, "port": 1}]}, "1 to 254"),
            ({"vehicles": [VEHICLE, VEHICLE]}, "two vehicles"),
            ({"vehicles": [{"id": 1, "port": 70_000}]}, "port"),
            ({"vehicles": [{**VEHICLE, "dialect": "inav"}]}, "inav"),
            ({"vehicles": [VEHICLE], "dynamics": "warp"}, "warp"),
            ({"vehicles": [VEHICLE], "rate_hz": 7}, "rate_hz"),
            ({"vehicles": [VEHICLE], "rate_hz": True}, "rate_hz"),
            ({"vehicles": [VEHICLE], "speed": 0}, "speed"),
            ({"vehicles": [VEHICLE], "wind": [1]}, "wind"),
            ({"vehicles": [VEHICLE], "origin": {"lat": 100}}, "latitude"),
            ({"vehicles": [VEHICLE], "start_u": []}, "start_u"),
            ({"vehicles": [VEHICLE], "dynamics": "ideal", "wind": [1, 0]}, "wind"),
            ({"vehicles": [VEHICLE], "faults": [{"id": 4, "kind": "nan"}]}, "vehicle 4"),
            ({"vehicles": [VEHICLE], "colour": "red"}, "colour"),
            ([], "JSON object"),
        ):
            with self.assertRaisesRegex(ConfigError, word):
                config.read(fields)


class ControlLines(unittest.TestCase):
    def setUp(self):
        self.controller = Controller(lambda _: {})
        self.flight = Flight(self.controller)
        self.flight.run_until(lambda: self.flight.fleet.vehicles[0].autopilot.is_streaming)

    def say(self, command) -> None:
        line = command if isinstance(command, bytes) else json.dumps(command).encode()
        self.flight.hub.waiting.append((-1, line))
        self.flight.run_for(1)

    def test_a_fault(self):
        self.say({"fault": {"id": 1, "kind": "battery_low", "percent": 5}})
        self.flight.run_for(2)
        self.assertEqual(self.controller.last["SYS_STATUS"].battery_remaining, 5)

    def test_a_mode(self):
        self.say({"mode": {"id": 1, "name": "BRAKE"}})
        self.flight.run_for(2)
        self.assertEqual(self.controller.mode, 17)

    def test_stop(self):
        self.flight.hub.waiting.append((-1, b'{"stop": true}'))
        self.flight.until = lambda: False
        self.flight.fleet.stopped = False
        self.flight.fleet.run()
        self.assertEqual(self.flight.events[-1]["event"], "stats")

    def test_the_end_of_the_lines_is_the_end(self):
        self.flight.hub.waiting.append((-1, None))
        self.flight.until = lambda: False
        self.flight.fleet.stopped = False
        self.flight.fleet.run()
        self.assertTrue(self.flight.fleet.stopped)

    def test_nonsense_is_told_and_passed_over(self):
        for command in (
            b"{",
            b"[1]",
            {"fly": 1},
            {"mode": {"id": 9, "name": "LOITER"}},
            {"mode": {"id": 1, "name": "X"}},
            {"fault": {"id": 9, "kind": "nan"}},
            {"fault": 3},
            {"mode": 3},
            {"speed": "x"},
            {"a": 1, "b": 2},
        ):
            self.flight.events.clear()
            self.say(command)
            self.assertEqual(len(self.flight.named("error")), 1, command)


class Process(unittest.TestCase):
    """The real thing: a child process and UDP. It waits for events and never by the clock: computers can be busy."""

    def setUp(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.addCleanup(self.socket.close)

    def start(self, *arguments: str) -> subprocess.Popen:
        child = subprocess.Popen(
            [sys.executable, "-m", "simlink", *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.addCleanup(child.kill)
        return child

    def fleet(self, **fields) -> str:
        port = self.socket.getsockname()[1]
        return json.dumps({"vehicles": [{"id": 3, "port": port}], **fields}) + "\n"

    def event(self, child: subprocess.Popen, name: str) -> dict:
        for line in child.stdout:
            event = json.loads(line)
            if event["event"] == name:
                return event
        self.fail(f"no event {name}")

    def test_a_flight_over_udp(self):
        child = self.start()
        child.stdin.write(self.fleet(speed=200) + '{"speed": 100}\n')
        child.stdin.flush()
        self.event(child, "ready")
        controller = Controller(lambda _: dict(velocity=(2, 0, 0)))
        while not (position := controller.last.get("LOCAL_POSITION_NED")) or position.vx < 1.9:
            frame, sender = self.socket.recvfrom(2048)
            for answer in controller.take(frame):
                self.socket.sendto(answer, sender)
        self.event(child, "airborne")
        child.stdin.write('{"stop": true}\n')
        child.stdin.flush()
        stats = self.event(child, "stats")
        self.assertEqual(child.wait(), 0)
        self.assertGreater(stats["vehicles"][0]["setpoints"]["accepted"], 5)
        self.assertEqual(stats["vehicles"][0]["damaged"], 0)

    def test_closing_stdin_ends_it(self):
        child = self.start()
        child.stdin.write(self.fleet())
        child.stdin.close()
        self.assertEqual(child.wait(), 0)

    def test_it_ends_when_nobody_reads_its_events(self):
        child = self.start()
        child.stdin.write(self.fleet(speed=1000, step_ms=200))
        child.stdin.flush()
        child.stdout.readline()
        child.stdout.close()
        self.assertEqual(child.wait(), 0)
        self.assertEqual(child.stderr.read(), "")

    def test_what_cannot_be_is_told_and_ends_with_2(self):
        for line, word in (
            ("{}\n", "vehicles"),
            ("fleet\n", "no JSON"),
            ("", "no JSON"),
            (self.fleet(signing_key_file="/no/key"), "signing key"),
        ):
            child = self.start()
            _, err = child.communicate(line)
            self.assertEqual(child.returncode, 2)
            self.assertRegex(err, word)
            self.assertNotIn("Traceback", err)

    def test_by_hand(self):
        port = self.socket.getsockname()[1]
        child = self.start("--port", str(port), "--speed", "20", "--json", "--fault", '{"id": 1, "kind": "pose_stale"}')
        self.event(child, "ready")
        frame = self.socket.recv(2048)
        self.assertEqual(frame[7], 0, "a heartbeat")
        self.event(child, "fault")
        child.send_signal(signal.SIGINT)
        _, err = child.communicate()
        self.assertEqual(child.returncode, 0)
        self.assertIn(f"127.0.0.1:{port}", err)
        self.assertNotIn("Traceback", err)

    def test_a_signed_link(self):
        key = Path(self.enterContext(tempfile.TemporaryDirectory())) / "key"
        key.write_text("7f" * 32)
        os.chmod(key, 0o600)
        child = self.start()
        child.stdin.write(self.fleet(signing_key_file=str(key)))
        child.stdin.flush()
        frame, sender = self.socket.recvfrom(2048)
        self.assertEqual(frame[2], 1, "signed")
        controller = Controller(None)
        self.socket.sendto(controller.pack(controller.command(511, 33, 200_000)), sender)
        unsigned_answers = [f for f in self.drain() if f[7] == 77]
        self.assertEqual(unsigned_answers, [], "an unsigned command is not answered")
        child.stdin.write('{"stop": true}\n')
        child.stdin.flush()
        self.assertEqual(self.event(child, "stats")["vehicles"][0]["unauthentic"], 1)

    def drain(self) -> list[bytes]:
        """The next four datagrams: four seconds of the vehicle's time."""
        return [self.socket.recv(2048) for _ in range(4)]
