"""Small pictures for the page: an array of colours as PNG, without a plotting library."""

from __future__ import annotations

import base64
import struct
import zlib

from ..core import U8, ShapeError


def png(rgb: U8) -> bytes:
    """A PNG file of colours (h, w, 3), or (h, w, 4) with opacity, row 0 at the top.

    Raises:
        ShapeError: No such array of bytes.
    """
    if rgb.ndim != 3 or rgb.shape[2] not in (3, 4) or rgb.dtype != "uint8" or not rgb.size:
        raise ShapeError(f"a picture needs bytes (h, w, 3 or 4), got {rgb.dtype} {rgb.shape}")
    height, width, channels = rgb.shape
    lines = b"".join(b"\0" + row.tobytes() for row in rgb)  # filter 0 before each line
    kind = {3: 2, 4: 6}[channels]
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    return b"".join(
        (
            b"\x89PNG\r\n\x1a\n",
            _chunk(b"IHDR", head),
            _chunk(b"IDAT", zlib.compress(lines, 6)),
            _chunk(b"IEND", b""),
        )
    )


def data_uri(data: bytes, kind: str = "image/png") -> str:
    """The bytes as an address that an ``<img>`` shows without asking the server."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
