"""Flight modes, and what a vehicle does in each."""

from dataclasses import dataclass
from enum import Enum, auto


class Behaviour(Enum):
    """What the autopilot flies."""

    LEVEL = auto()
    """Level, at its altitude; nobody holds the position."""
    HOLD = auto()
    """Brakes, then holds the position."""
    GUIDED = auto()
    """Follows setpoints."""
    TAKEOFF = auto()
    """Climbs to an altitude, then changes to a mode that holds."""
    RETURN = auto()
    """Climbs, flies home, lands."""
    LAND = auto()
    """Descends where it is."""


@dataclass(frozen=True)
class Mode:
    """A flight mode of one autopilot."""

    name: str
    custom_mode: int
    behaviour: Behaviour
    needs_position: bool = True
    arms: bool = True
    """Whether the motors may be started in it."""


def by_name(modes: tuple[Mode, ...], name: str) -> Mode | None:
    """The mode of this name, if there is one."""
    return next((mode for mode in modes if mode.name == name), None)


def by_number(modes: tuple[Mode, ...], custom_mode: int) -> Mode | None:
    """The mode of this number in HEARTBEAT, if there is one."""
    return next((mode for mode in modes if mode.custom_mode == custom_mode), None)
