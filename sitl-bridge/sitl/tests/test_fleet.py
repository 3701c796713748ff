"""A fleet of programs: how they are started, what is reported, how they end."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

from sitl import arducopter, px4
from sitl.process import SitlError
from sitl.tests.stand_in import UNIX_MS

ORIGIN = {"lat": 47.0, "lon": 8.0, "alt": 488.0}


class Fleets(unittest.TestCase):
    """Each test has a folder and, at most, one fleet."""

    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = Path(self._folder.name)
        self.program = self.folder / "program"
        self.program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m sitl.tests.stand_in "$@"\n')
        self.program.chmod(0o755)

    def start(self, **fields: Any) -> subprocess.Popen[str]:
        config = {
            "autopilot": "arducopter",
            "program": str(self.program),
            "folder": str(self.folder),
            "origin": ORIGIN,
            "scale_m": 2.5,
            "step_ms": 2000,
            "epoch_unix_ms": UNIX_MS + 1000,
            "vehicles": [{"id": i, "system": i + 1, "port": 9, "start_u": [40 * i, 60]} for i in range(2)],
            **fields,
        }
        pipe = subprocess.PIPE
        fleet = subprocess.Popen([sys.executable, "-m", "sitl"], stdin=pipe, stdout=pipe, stderr=pipe, text=True)
        self.addCleanup(self.end, fleet)
        fleet.stdin.write(json.dumps(config) + "\n")
        fleet.stdin.flush()
        return fleet

    def end(self, fleet: subprocess.Popen[str]) -> None:
        fleet.kill()
        fleet.communicate()

    def event(self, fleet: subprocess.Popen[str], kind: str) -> dict[str, Any]:
        for line in fleet.stdout:
            event = json.loads(line)
            if event["event"] == kind:
                return event
        self.fail(f"no {kind}; it says: {fleet.stderr.read()}")

    def test_true_positions_at_each_step(self) -> None:
        fleet = self.start()
        self.assertEqual(self.event(fleet, "ready")["vehicles"], 2)
        for step in range(3):
            truth = self.event(fleet, "truth")
            self.assertEqual(truth["step"], step)
            # 5 m/s are 2 u/s; step 0 begins a second after the samples do.
            north = 60 + 2 * (1 + 2 * step)
            for (x, y), start in zip(truth["u"], (0, 40), strict=True):
                self.assertAlmostEqual(x, start, delta=0.02)
                self.assertAlmostEqual(y, north, delta=0.02)

    def test_the_end_of_its_input_ends_all_programs(self) -> None:
        fleet = self.start()
        self.event(fleet, "truth")
        started = [int(pid) for pid in _children(fleet.pid)]
        self.assertEqual(len(started), 2)
        fleet.stdin.close()
        fleet.stdin = None
        self.assertEqual(fleet.wait(), 0)
        for pid in started:
            self.assertFalse(Path(f"/proc/{pid}").exists(), f"{pid} lives on")

    def test_programs_end_with_a_fleet_that_is_killed(self) -> None:
        fleet = self.start()
        self.event(fleet, "truth")
        started = _children(fleet.pid)
        self.assertEqual(len(started), 2)
        fleet.kill()
        fleet.communicate()
        for pid in started:
            while _is_running(pid):
                os.sched_yield()

    def test_a_command_that_is_none_is_told(self) -> None:
        fleet = self.start()
        fleet.stdin.write('{"fly": "higher"}\n')
        fleet.stdin.flush()
        self.assertIn("there is no command `fly`", self.event(fleet, "error")["text"])

    def test_a_program_that_ends_is_told_with_its_last_words(self) -> None:
        fleet = self.start(speed=13)
        said = fleet.stderr.read()
        self.assertEqual(fleet.wait(), 1)
        self.assertIn("ended with status 3", said)
        self.assertIn("the bearings are dry", said)

    def test_a_program_that_is_not_there(self) -> None:
        fleet = self.start(program="/nowhere/arducopter")
        _, said = fleet.communicate()
        self.assertEqual(fleet.returncode, 2)
        self.assertIn("/nowhere/arducopter: no such program; build ArduPilot's SITL", said)

    def test_each_vehicle_is_told_its_home_and_links(self) -> None:
        fleet = self.start(parameters={"GUID_TIMEOUT": 1})
        self.event(fleet, "truth")
        said = (self.folder / "uav-1" / "output.txt").read_text()
        self.assertIn("--sysid 2 --home 47.0013475,8.0013", said)
        self.assertIn("--serial0 udpclient:127.0.0.1:9 ", said)
        parameters = dict(line.split() for line in (self.folder / "uav-1" / "covey.parm").read_text().splitlines())
        self.assertEqual(parameters["GUID_TIMEOUT"], "1")
        self.assertEqual(parameters["FRAME_CLASS"], "1")


class Builds(unittest.TestCase):
    """What is named as a build."""

    def test_px4_wants_a_build_folder(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(SitlError, "no bin/px4 in there; build PX4's SITL"):
                px4.folder(folder)
            (Path(folder) / "bin").mkdir()
            (Path(folder) / "bin" / "px4").touch()
            self.assertEqual(px4.folder(folder), Path(folder))

    def test_a_program_is_found_in_the_path(self) -> None:
        self.assertTrue(arducopter.program("sh").is_absolute())


def _is_running(pid: str) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def _children(pid: int) -> list[str]:
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split() if os.path.exists(f"/proc/{pid}") else []
