"""Where a case runs."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Bench:
    """The programs, the case's own folder, and numbers that no other case has."""

    bridge: Path
    autopilot: str
    program: Path
    folder: Path
    instance: int
