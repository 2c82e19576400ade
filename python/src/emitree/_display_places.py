"""Pictures of places in notebooks: where points are, along the axis in which they extend least."""

from __future__ import annotations

import base64
import html
import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats

#: The longer side of a picture [pixels], of which each is shown as 2 x 2.
_SIDE = 80

#: Readable on light and dark pages.
_COLOUR = (38, 125, 190)


def places_png(position: Floats) -> tuple[bytes, str]:
    """A PNG of the density of positions (n, 3), and the name of the axis along which it looks.

    Of the other two axes the first points to the right and the second up, at the same scale. The
    more opaque a pixel is, the more positions it has, on a logarithmic scale.

    >>> import numpy as np
    >>> png, axis = places_png(np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 0.1]]))
    >>> png[:4], axis
    (b'\\x89PNG', 'z')
    """
    finite = position[np.isfinite(position).all(axis=1)]
    low, high = (
        limit(finite, axis=0) if len(finite) else np.zeros(3) for limit in (np.min, np.max)
    )
    extent = high - low
    along = int(np.argmin(extent))
    axes = [axis for axis in range(3) if axis != along]
    largest = float(extent.max()) or 1.0
    columns, rows = (max(4, round(_SIDE * float(extent[axis]) / largest)) for axis in axes)
    # Places at one coordinate are in the middle.
    margin = np.where(extent > 0, 0.0, 0.5 * largest)
    ranges = [(low[axis] - margin[axis], high[axis] + margin[axis]) for axis in axes]
    counts, *_ = np.histogram2d(
        finite[:, axes[1]], finite[:, axes[0]], bins=(rows, columns), range=(ranges[1], ranges[0])
    )
    shown = np.log1p(counts) / max(np.log1p(counts.max(initial=0.0)), 1e-300)
    pixels = np.empty((rows, columns, 4), dtype=np.uint8)
    pixels[..., :3] = _COLOUR
    # What is there at all is to be seen.
    pixels[..., 3] = np.where(counts > 0, 55 + 200 * shown, 0)[::-1]
    return _png(pixels), "xyz"[along]


def places_html(position: Floats, rows: dict[str, str]) -> str:
    """A picture of positions beside a table; values of the table are HTML."""
    png, axis = places_png(position)
    image = base64.b64encode(png).decode()
    return (
        '<div style="display:flex;gap:1em;align-items:center">'
        f'<img alt="the positions, along {axis}" title="along {axis}" '
        f'style="width:{2 * png_width(png)}px;image-rendering:pixelated" '
        f'src="data:image/png;base64,{image}">{table_html(rows)}</div>'
    )


def png_width(png: bytes) -> int:
    """How many columns a PNG has."""
    return int.from_bytes(png[16:20], "big")


def table_html(rows: dict[str, str]) -> str:
    """A table of names and values, which are HTML."""
    cells = (f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in rows.items())
    return f"<table>{''.join(cells)}</table>"


def extent_html(position: Floats, unit: str) -> dict[str, str]:
    """The rows of a table with the range of each coordinate."""
    if len(position) == 0:
        return {}
    ends = zip("xyz", position.min(axis=0), position.max(axis=0), strict=True)
    return {name: span_html(low, high, unit) for name, low, high in ends}


def span_html(low: float, high: float, unit: str) -> str:
    """A range of values."""
    return f"{low:.4g} to {high:.4g} {html.escape(unit)}".rstrip()


def _png(pixels: NDArray[np.uint8]) -> bytes:
    """The bytes of a PNG file of pixels (rows, columns, 4), the highest row first: RGBA."""
    height, width, _ = pixels.shape

    def chunk(name: bytes, data: bytes) -> bytes:
        checked = name + data
        return struct.pack(">I", len(data)) + checked + struct.pack(">I", zlib.crc32(checked))

    # Eight bits, RGBA, not interlaced; each row begins with its filter, 0.
    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    rows = np.insert(pixels.reshape(height, 4 * width), 0, 0, axis=1).tobytes()
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(name, data) for name, data in chunks)
