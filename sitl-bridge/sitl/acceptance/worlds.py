"""Cases: whole worlds with twenty vehicles, beside simlink and the trainer."""

import json
import subprocess

from sitl.acceptance.bench import Bench
from sitl.acceptance.case import ARDUCOPTER, PX4, Case, Failure, expect

_LEAST_SHARE = 0.96


def _worlds(bench: Bench, uavs: int, worlds: int, least_share: float = 0.0) -> str:
    kind = "arducopter" if bench.autopilot == ARDUCOPTER else "px4"
    command = [str(bench.bridge), "swarm", "--sim", f"{kind}={bench.program}", "--json"]
    command += ["--count", str(uavs), "--worlds", str(worlds)]
    flown = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if flown.returncode != 0:
        raise Failure(flown.stderr[-400:])
    found = json.loads(flown.stdout)
    share, late = found["share_of_trainer"], found["late_decisions"] + found["missed_decisions"]
    simlink = found["simlink_coverage_mean"] / found["trainer_coverage_mean"]
    seen = f"{100 * share:.1f} % of the trainer's (simlink {100 * simlink:.1f} %), {late} late or missed"
    expect(late == 0, seen)
    expect(share >= least_share, seen)
    return seen


CASES = [
    Case(
        "20 UAVs, 3 worlds",
        "at least 96 % of the trainer's coverage, no decision late",
        lambda bench: _worlds(bench, 20, 3, _LEAST_SHARE),
        (ARDUCOPTER,),
    ),
    Case("4 UAVs, 1 world", "no decision late", lambda bench: _worlds(bench, 4, 1), (PX4,)),
]
