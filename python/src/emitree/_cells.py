"""Cells: squares in pixels, and the places of lines of sight in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats

Integers = NDArray[np.int64]

#: The places of lines in a cell, x and y from -1 to 1: the nodes of Gauss's rule of 2 x 2, then the
#: centre and the corners. Corners are a little inside, as faces of a sky end at borders of pixels.
_GAUSS, _CORNER = 3**-0.5, 1 - 1e-7
PLACES = np.array(
    [[x, y] for y in (-_GAUSS, _GAUSS) for x in (-_GAUSS, _GAUSS)]
    + [[0.0, 0.0]]
    + [[x, y] for y in (-_CORNER, _CORNER) for x in (-_CORNER, _CORNER)]
)
#: Where the centre is in `PLACES`.
CENTRE = 4
#: Weights of `PLACES` in two rules that are exact up to degree 3: Gauss's, and one with the centre
#: and the corners. Their difference estimates the error of the first.
GAUSS = np.array([0.25] * 4 + [0.0] * 5)
CORNERS = np.array([0.0] * 4 + [2 / 3] + [1 / 12] * 4)
#: The finest cells are this many halvings of a pixel.
FINEST = 11


@dataclass(frozen=True)
class Cells:
    """Squares in pixels, each one of 4^level of its pixel."""

    #: Numbers (n,) of pixels, row by row.
    pixel: Integers
    #: (n,); 0 for the whole pixel.
    level: Integers
    #: (n,), from 0 to 2^level.
    row: Integers
    column: Integers

    @classmethod
    def whole(cls, pixel: Integers) -> Cells:
        """Whole pixels."""
        zero = np.zeros(len(pixel), dtype=np.int64)
        return cls(pixel, zero, zero, zero)

    def __getitem__(self, key: Any) -> Cells:
        """Some of the cells."""
        return Cells(self.pixel[key], self.level[key], self.row[key], self.column[key])

    def quarters(self) -> Cells:
        """The four quarters of each cell, (4 n,)."""
        row, column = np.array([[0, 0, 1, 1]]), np.array([[0, 1, 0, 1]])
        return Cells(
            np.repeat(self.pixel, 4),
            np.repeat(self.level + 1, 4),
            (2 * self.row[:, np.newaxis] + row).ravel(),
            (2 * self.column[:, np.newaxis] + column).ravel(),
        )

    def area(self) -> Floats:
        """The part (n,) of the pixel."""
        return np.asarray(0.25**self.level, dtype=np.float64)

    def distinct(self) -> tuple[Cells, Integers]:
        """Each different cell once, and the number (n,) among these of each."""
        assert FINEST < 12
        key = (self.pixel << 28) | (self.level << 24) | (self.row << 12) | self.column
        _, first, number = np.unique(key, return_index=True, return_inverse=True)
        return self[first], number
