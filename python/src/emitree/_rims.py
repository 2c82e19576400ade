"""Pixels that the rim of a disc crosses: the part inside is stretched to a square.

The disc has radius 1 in coordinates p and q from -1 to 1 along the axes of the image. In the part
inside p is between two numbers, and q between the borders of the pixel or of the disc, which are
+-sqrt(1 - p^2). With p = sin(angle) they are +-cos(angle): smooth functions up to their ends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from emitree._cells import Cells, Integers
from emitree._function import Floats

#: Pixels that reach less than this into the disc only touch it.
_TOUCHES = 1e-12
#: Places are moved towards the middle by this fraction, so that rounding puts none beyond the rim.
_INWARDS = 1e-14


class Rim:
    """The rim of a disc that touches the borders of an image."""

    def __init__(self, shape: Sequence[int]) -> None:
        height, width = shape
        row, column = np.divmod(np.arange(height * width), width)
        sides, places = np.array([[2.0 / width], [2.0 / height]]), np.stack([column, row])
        lower, upper = sides * places - 1.0, sides * (places + 1) - 1.0
        nearest = (np.maximum(np.maximum(lower, -upper), 0.0) ** 2).sum(axis=0)
        farthest = (np.maximum(abs(lower), abs(upper)) ** 2).sum(axis=0)
        #: Whether pixels (pixels,) are inside, at least in part, and whether the rim crosses them.
        self.is_seen = nearest < 1.0 - _TOUCHES
        self.is_crossed = self.is_seen & (farthest > 1.0)
        #: The numbers (pixels,) of crossed pixels in the arrays below.
        self._number = np.cumsum(self.is_crossed) - 1
        lower, upper = lower[:, self.is_crossed], upper[:, self.is_crossed]
        middle = abs(lower + upper)
        # p is the axis along which the rim is flatter; q is mirrored so that most of it is above 0.
        self._is_x = middle[0] <= middle[1]
        (p_low, q_low), (p_high, q_high) = (
            np.where(self._is_x, ends, ends[::-1]) for ends in (lower, upper)
        )
        is_mirrored = q_low + q_high < 0.0
        self._sign = np.where(is_mirrored, -1.0, 1.0)
        self._low = np.where(is_mirrored, -q_high, q_low)
        self._high = np.where(is_mirrored, -q_low, q_high)
        self._area = sides.prod()
        widest = _half_chord(np.maximum(self._low, 0.0))
        first = np.arcsin(np.maximum(p_low, -widest))
        last = np.arcsin(np.minimum(p_high, widest))
        # Kinks are where the rim meets the upper border of q: there the end of q changes.
        kink = np.arcsin(_half_chord(self._high))
        has_first = (first < -kink) & (-kink < last) & (kink > 0.0)
        has_last = (first < kink) & (kink < last) & (kink > 0.0)
        #: Angles (n, 4) at places (n, 4) along the square, between which they are linear. Kinks are
        #: where cells are divided.
        one = np.where(has_first, -kink, np.where(has_last, kink, last))
        self._angles = np.stack([first, one, np.where(has_first & has_last, kink, last), last], 1)
        kinks = has_first.astype(np.int64) + has_last
        self._at = np.array([[0, 1, 1, 1], [0, 0.5, 1, 1], [0, 0.25, 0.75, 1]])[kinks]
        #: The level (pixels,) from which on cells have no kink.
        self._smooth_level = np.zeros(height * width, dtype=np.int64)
        self._smooth_level[self.is_crossed] = kinks

    def has_kink(self, cells: Cells) -> NDArray[np.bool_]:
        """Whether the map of cells (n,) to the part inside has a kink within them."""
        return np.asarray(cells.level < self._smooth_level[cells.pixel])

    def stretch(self, pixel: Integers, x: Floats, y: Floats, xs: Floats, ys: Floats) -> Floats:
        """Moves places of crossed pixels, and returns the area in the image by area in the square.

        pixel: numbers (n,); x, y: places (n, places) in the squares of these, from 0 to 1; xs, ys:
        places in the image, from 0 to 1, which are overwritten in pixels that the rim crosses.
        """
        area = np.ones_like(x)
        some = np.flatnonzero(self.is_crossed[pixel])
        number = self._number[pixel[some]]
        is_x = self._is_x[number, np.newaxis]
        along, across = np.where(is_x, x[some], y[some]), np.where(is_x, y[some], x[some])
        at, angles = self._at[number], self._angles[number]
        part = (along > at[:, [1]]).astype(np.int64) + (along > at[:, [2]])
        begin, end = np.take_along_axis(at, part, 1), np.take_along_axis(at, part + 1, 1)
        start, last = np.take_along_axis(angles, part, 1), np.take_along_axis(angles, part + 1, 1)
        slope = (last - start) / (end - begin)
        angle = start + (along - begin) * slope
        rim = np.cos(angle)
        low = np.maximum(self._low[number, np.newaxis], -rim)
        length = np.minimum(self._high[number, np.newaxis], rim) - low
        area[some] = slope * rim * length / self._area
        p, q = np.sin(angle), (low + length * across) * self._sign[number, np.newaxis]
        xs[some] = 0.5 + 0.5 * (1.0 - _INWARDS) * np.where(is_x, p, q)
        ys[some] = 0.5 + 0.5 * (1.0 - _INWARDS) * np.where(is_x, q, p)
        return area


def _half_chord(distance: Floats) -> Floats:
    """Half of a chord (n,) of the disc, at distances from its centre; 0 beyond the rim."""
    return np.asarray(np.sqrt(np.maximum(1.0 - distance**2, 0.0)))
