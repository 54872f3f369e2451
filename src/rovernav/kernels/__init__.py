"""Every compiled kernel, in files that mirror the rooms: plain arrays in SI units, no objects."""

__all__: list[str] = []
