"""What leaves the house: driven paths and routes as CSV and GeoJSON."""

from ._path import write_path_csv, write_path_geojson
from ._route import (
    write_profile_csv,
    write_route_csv,
    write_route_geojson,
    write_trip_geojson,
)

__all__ = [
    "write_path_csv",
    "write_path_geojson",
    "write_profile_csv",
    "write_route_csv",
    "write_route_geojson",
    "write_trip_geojson",
]
