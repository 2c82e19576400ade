"""Records of evaluated points, each with a checksum of its own.

A record has 9 numbers, 64-bit floats: position, emission direction, energy (NaN if there is none),
rate, and the checksum of their bits. Zeros are no record, so that the tail of a file that the
system had no time to fill is known for what it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats

NDBool = NDArray[np.bool_]

COLUMNS = ["x", "y", "z", "dx", "dy", "dz", "energy", "rate", "checksum"]
#: What a point is known by: all columns before the rate.
KEY = 7
#: Bytes.
RECORD = 8 * len(COLUMNS)

#: An odd number with the bits of the golden ratio, 2^64 / phi: each bit of a word spreads over all
#: higher ones.
_PRIME = np.uint64(0x9E3779B97F4A7C15)
#: Any number but 0, whose checksum 0 would be.
_START = np.uint64(0x243F6A8885A308D3)
#: Bits that a 64-bit float keeps exactly.
_BITS = np.uint64(52)


def checksums(points: Floats) -> Floats:
    """The checksums (n,) of points (n, 8): whole numbers below 2^52.

    >>> bool(checksums(np.zeros((1, 8)))[0] > 0)
    True
    """
    words = np.ascontiguousarray(points, "<f8").view("<u8")
    found = np.full(len(words), _START, np.uint64)
    for column in words.T:
        found = (found ^ column) * _PRIME
        found ^= found >> np.uint64(29)
    return (found >> (np.uint64(64) - _BITS)).astype("<f8")


def encode(points: Floats) -> bytes:
    """Points (n, 8) as records."""
    return np.column_stack((points, checksums(points))).astype("<f8").tobytes()


def intact(records: Floats) -> NDBool:
    """Which records (n, 9) are as they were written, and have a rate that is a number."""
    rates = records[:, KEY]
    return (checksums(records[:, :-1]) == records[:, -1]) & np.isfinite(rates)


def keys(points: Floats) -> list[bytes]:
    """What points are known by: the bits of position, direction and energy."""
    return np.ascontiguousarray(points[:, :KEY]).view(f"V{8 * KEY}").ravel().tolist()
