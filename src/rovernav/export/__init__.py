"""What leaves the house: driven paths, whole traces and routes as CSV and GeoJSON."""

from ._path import write_path_csv, write_path_geojson
from ._route import (
    write_profile_csv,
    write_route_csv,
    write_route_geojson,
    write_trip_geojson,
)
from ._trace import write_trace_csv

__all__ = [
    "write_path_csv",
    "write_path_geojson",
    "write_profile_csv",
    "write_route_csv",
    "write_route_geojson",
    "write_trace_csv",
    "write_trip_geojson",
]
