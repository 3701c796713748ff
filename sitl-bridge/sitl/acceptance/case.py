"""What a case of the suite is."""

from collections.abc import Callable
from dataclasses import dataclass

from sitl.acceptance.bench import Bench

ARDUCOPTER, PX4 = "ArduCopter", "PX4"


class Failure(Exception):
    """Something was otherwise than documented; the words say what was seen."""


class NotRun(Exception):
    """A case cannot be run here; the words say what it lacks."""


@dataclass(frozen=True)
class Case:
    """One row of the table: what is done, and what must follow. `run` returns what was seen, or raises Failure."""

    name: str
    expected: str
    run: Callable[[Bench], str]
    autopilots: tuple[str, ...] = (ARDUCOPTER, PX4)


def expect(holds: bool, seen: str) -> None:
    """Raises Failure with what was seen unless it holds."""
    if not holds:
        raise Failure(seen)
