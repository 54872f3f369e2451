"""What leaves the house: driven paths as CSV and GeoJSON."""

from ._path import write_path_csv, write_path_geojson

__all__ = ["write_path_csv", "write_path_geojson"]
