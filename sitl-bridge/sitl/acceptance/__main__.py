"""`python -m sitl.acceptance`: runs the suite against the named builds and prints a table."""

import argparse
import sys
import tempfile
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sitl import arducopter, px4
from sitl.acceptance import faults, flights, takeovers, worlds
from sitl.acceptance.bench import Bench
from sitl.acceptance.case import ARDUCOPTER, PX4, Case, Failure, NotRun
from sitl.process import SitlError

_SMALL = [*flights.CASES, *takeovers.CASES, *faults.CASES]
_INSTANCES = 4
"""Instance numbers of one case, so that no two vehicles have the same."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the suite; returns the exit status: 0 when all is as documented."""
    options = _parser().parse_args(arguments)
    try:
        builds = {}
        if options.arducopter:
            builds[ARDUCOPTER] = arducopter.program(options.arducopter)
        if options.px4:
            builds[PX4] = px4.folder(options.px4)
    except SitlError as error:
        print(f"sitl: {error}", file=sys.stderr)
        return 2
    chosen = [
        (autopilot, case)
        for autopilot in builds
        for case in [*_SMALL, *worlds.CASES]
        if autopilot in case.autopilots and (not options.only or any(word in case.name for word in options.only))
    ]
    folder = Path(tempfile.mkdtemp(prefix="covey-acceptance-"))
    rows = _run(chosen, builds, options.bridge.absolute(), folder, options.at_once)
    print("| autopilot | case | as documented | seen | |\n|---|---|---|---|---|")
    for autopilot, case in chosen:
        seen, verdict = rows[autopilot, case.name]
        print(f"| {autopilot} | {case.name} | {case.expected} | {seen} | {verdict} |")
    failed = sum(verdict == "FAILED" for _, verdict in rows.values())
    print(f"\n{len(rows)} cases, {failed} failed; files in {folder}")
    return 1 if failed else 0


def _run(
    chosen: list[tuple[str, Case]], builds: dict[str, Path], bridge: Path, folder: Path, at_once: int
) -> dict[tuple[str, str], tuple[str, str]]:
    rows: dict[tuple[str, str], tuple[str, str]] = {}
    lock = threading.Lock()

    def fly(number: int, autopilot: str, case: Case) -> None:
        place = folder / f"{number:02}-{autopilot}"
        place.mkdir()
        bench = Bench(bridge, autopilot, builds[autopilot], place, 40 + number * _INSTANCES)
        try:
            row = case.run(bench), "ok"
        except NotRun as lacking:
            row = str(lacking), "not run"
        except (Failure, SitlError) as failure:
            row = str(failure).replace("\n", " ").replace("|", "/"), "FAILED"
        with lock:
            rows[autopilot, case.name] = row
            print(f"{autopilot}, {case.name}: {row[1]} ({row[0]})", file=sys.stderr, flush=True)

    numbered = [(number, *pair) for number, pair in enumerate(chosen)]
    with ThreadPoolExecutor(at_once) as pool:
        for job in [pool.submit(fly, *one) for one in numbered if one[2] in _SMALL]:
            job.result()
    for one in numbered:  # whole worlds need the computer for themselves
        if one[2] not in _SMALL:
            fly(*one)
    return rows


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m sitl.acceptance", description=__doc__)
    parser.add_argument("--bridge", type=Path, required=True, help="the program sitl-bridge")
    parser.add_argument("--arducopter", metavar="PROGRAM", help="ArduPilot's Copter, built for SITL")
    parser.add_argument("--px4", metavar="FOLDER", help="PX4's build folder for SITL")
    parser.add_argument("--only", nargs="*", metavar="WORDS", help="only cases whose name has one of these")
    parser.add_argument("--at-once", type=int, default=8, help="cases that fly at the same time (8)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
