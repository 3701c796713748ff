"""Batteries besides the first, which SYS_STATUS tells of."""

from dataclasses import dataclass

FUNCTIONS = {"unknown": 0, "all": 1, "propulsion": 2, "avionics": 3, "payload": 4}
"""MAV_BATTERY_FUNCTION by its name."""


@dataclass(frozen=True)
class OtherBattery:
    """One more battery of a vehicle, of constant charge."""

    id: int
    function: str
    percent: float


EXTRAS = {
    "battery": OtherBattery(1, "propulsion", 15.0),
    "payload-battery": OtherBattery(2, "payload", 5.0),
}
"""What `--extra` gives every vehicle: a flight battery that is low, and one that no flight ends for."""
