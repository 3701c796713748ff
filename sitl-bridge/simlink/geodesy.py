"""Between degrees and metres, on the plane that touches the globe at the origin.

The scale is ArduPilot's: one for all latitudes, shrunk by the cosine of the origin's
latitude towards the east.
"""

import math
from dataclasses import dataclass

METRES_PER_DEGREE = 111_318.84502145034
"""Along a meridian: 1e7 times ArduPilot's LOCATION_SCALING_FACTOR."""


@dataclass(frozen=True)
class Plane:
    """Metres east, north and up of one origin."""

    latitude: float
    longitude: float
    altitude_m: float

    @property
    def _metres_per_degree_east(self) -> float:
        return METRES_PER_DEGREE * max(math.cos(math.radians(self.latitude)), 0.01)

    def degrees(self, east_m: float, north_m: float) -> tuple[float, float]:
        """Latitude and longitude of a point."""
        return (
            self.latitude + north_m / METRES_PER_DEGREE,
            self.longitude + east_m / self._metres_per_degree_east,
        )

    def metres(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Metres east and north of a point."""
        return (
            (longitude - self.longitude) * self._metres_per_degree_east,
            (latitude - self.latitude) * METRES_PER_DEGREE,
        )


def deg_e7(degrees: float) -> int:
    """Degrees as MAVLink writes them."""
    return round(degrees * 1e7)
