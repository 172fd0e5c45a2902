"""The boat's location on the Earth. Its plane lies on WGS 84 at an origin.

NMEA sentences and exercises' charts use it. A point's north and east are distances on a plane. It
is put on the ellipsoid at its distance and bearing from the origin, along the geodesic. So distance
and bearing from the origin are exact. Across that line the plane is too wide by one sixth of
(distance/radius)^2: 1 in 24 000 at 100 km. North on the plane is north at the origin; east of it
the meridians lean by the difference of longitude times the sine of the latitude.
"""

import math
import re
from dataclasses import dataclass
from typing import Final

# [deg] either way of latitude and longitude: at the poles north is no direction
ORIGIN_BOUNDS_DEG: Final = (80.0, 180.0)
DEGREES_PATTERN: Final = re.compile(r"\s*([+-]?[0-9]{1,3}(?:\.[0-9]*)?)\s*", re.ASCII)


@dataclass(frozen=True)
class Chart:
    """The plane with its origin at a latitude and longitude [deg]."""

    latitude: float
    longitude: float

    def position(self, north: float, east: float) -> tuple[float, float]:
        """Return latitude and longitude [deg] of a point [m] of the plane."""
        from geographiclib.geodesic import Geodesic  # noqa: PLC0415  few runs ask

        bearing, distance = math.degrees(math.atan2(east, north)), math.hypot(north, east)
        wanted = Geodesic.LATITUDE | Geodesic.LONGITUDE
        found = Geodesic.WGS84.Direct(self.latitude, self.longitude, bearing, distance, wanted)
        return found["lat2"], found["lon2"]


DEFAULT_CHART: Final = Chart(25.0, -45.0)  # mid-Atlantic: deep, and far from any coast


def chart_at(text: str) -> Chart:
    """Return the chart with its origin at ``LAT,LON`` [deg]; ValueError with the right form."""
    parts = [DEGREES_PATTERN.fullmatch(part) for part in text.split(",")]
    if len(parts) != 2 or None in parts:
        raise ValueError("say LAT,LON in degrees, south and west negative, such as 25.5,-45")
    latitude, longitude = (float(part[1]) for part in parts if part)
    for name, value, most in zip(
        ("latitude", "longitude"), (latitude, longitude), ORIGIN_BOUNDS_DEG, strict=True
    ):
        if abs(value) > most:
            raise ValueError(f"{name} {value:g} is not within {-most:g} and {most:g} degrees")
    return Chart(latitude, longitude)
