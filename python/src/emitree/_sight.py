"""Lines of sight of a camera, and the cells of its pixels through which they go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._cameras import Camera, Canonical, Orthographic
from emitree._function import Floats
from emitree._scene import compose, length_unit_of

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
class Lines:
    """Lines of sight, with any shape (...) of arrays.

    All lines of a camera that is a point have their origin there. The points at a distance t of two
    lines are no farther apart than their origins, plus t times the difference of their directions.
    """

    #: (3, ...) [length].
    origin: Floats
    #: Unit vectors (3, ...) away from the observer.
    direction: Floats
    #: The ends (...) of what is in view, distances from the origin [length].
    near: Floats
    far: Floats
    #: dOmega/(dx dy) (...) [sr], or an area; 0 where there is no image.
    density: Floats

    def __getitem__(self, key: Any) -> Lines:
        """Some of the lines."""
        of_vectors = (slice(None), *(key if isinstance(key, tuple) else (key,)))
        return Lines(
            self.origin[of_vectors],
            self.direction[of_vectors],
            self.near[key],
            self.far[key],
            self.density[key],
        )

    def reshape(self, *shape: int) -> Lines:
        """The same lines in arrays of another shape."""
        return Lines(
            self.origin.reshape(3, *shape),
            self.direction.reshape(3, *shape),
            self.near.reshape(shape),
            self.far.reshape(shape),
            self.density.reshape(shape),
        )


@dataclass(frozen=True)
class Tubes:
    """Bundles of lines: a line in the middle, and how far the others are from it.

    At a distance t from the origins all lines are within radius + spread * t of the point of the
    middle line at t.
    """

    #: The lines in the middle, of shape (n,), with the nearest and farthest ends of the bundle.
    lines: Lines
    #: (n,) [length], and (n,) [rad].
    radius: Floats
    spread: Floats

    def __getitem__(self, key: Any) -> Tubes:
        """Some of the tubes."""
        return Tubes(self.lines[key], self.radius[key], self.spread[key])


class View:
    """The lines of sight of one camera."""

    def __init__(self, camera: Camera, shape: Sequence[int] | int, **options: Any) -> None:
        self.scene = compose("0", camera, shape, render={}, **options)
        #: (height, width) in pixels.
        self.shape = self.scene.shape
        shapes = [options["bounds"]] if options.get("bounds") is not None else []
        unit = length_unit_of(camera, [*shapes, *options.get("occulters", ())])
        is_parallel = isinstance(camera, Canonical | Orthographic)
        self._position = None if is_parallel else np.array(camera.table(unit)["position"], float)

    def __len__(self) -> int:
        """The number of pixels."""
        return self.shape[0] * self.shape[1]

    def lines_at(self, x: Floats, y: Floats) -> Lines:
        """The lines at places (n,), (n,) of the image plane, from 0 to 1."""
        point, direction, near, far, density = self.scene.lines(x, y)
        point, direction = np.ascontiguousarray(point.T), np.ascontiguousarray(direction.T)
        if self._position is None:
            shift = (point * direction).sum(axis=0)
            origin = point - shift * direction
        else:
            position = self._position[:, np.newaxis]
            shift = ((point - position) * direction).sum(axis=0)
            origin = np.broadcast_to(position, point.shape)
        return Lines(origin, direction, near + shift, far + shift, density)

    def lines_of(self, cells: Cells) -> Lines:
        """The lines (cells, places) of cells."""
        height, width = self.shape
        size = 0.5**cells.level
        row, column = np.divmod(cells.pixel, width)
        x, y = (cells.column + 0.5) * size + column, (cells.row + 0.5) * size + row
        half = 0.5 * size[:, np.newaxis]
        xs = (x[:, np.newaxis] + half * PLACES[:, 0]) / width
        ys = (y[:, np.newaxis] + half * PLACES[:, 1]) / height
        return self.lines_at(xs.ravel(), ys.ravel()).reshape(len(x), len(PLACES))


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


def tubes_of(lines: Lines) -> Tubes:
    """A tube for each of some cells, from their lines (cells, places)."""
    centre = lines[:, CENTRE]
    # Between the corners a border of a cell may be curved: a margin of a tenth.
    radius = 1.1 * _longest(lines.origin - centre.origin[..., np.newaxis])
    spread = 1.1 * _longest(lines.direction - centre.direction[..., np.newaxis])
    middle = Lines(
        centre.origin,
        centre.direction,
        lines.near.min(axis=1),
        lines.far.max(axis=1),
        lines.density.max(axis=1),
    )
    return Tubes(middle, radius, spread)


def union(tubes: Tubes) -> Tubes:
    """A tube (1,) around all of some tubes."""
    lines = tubes.lines
    middle = len(tubes.radius) // 2
    origin, direction = lines.origin[:, [middle]], lines.direction[:, [middle]]
    radius = np.linalg.norm(lines.origin - origin, axis=0) + tubes.radius
    spread = np.linalg.norm(lines.direction - direction, axis=0) + tubes.spread
    around = Lines(
        origin,
        direction,
        lines.near.min(keepdims=True),
        lines.far.max(keepdims=True),
        lines.density.max(keepdims=True),
    )
    return Tubes(around, radius.max(keepdims=True), spread.max(keepdims=True))


def _longest(vectors: Floats) -> Floats:
    """The longest of vectors (3, n, places), (n,)."""
    return np.asarray(np.sqrt((vectors**2).sum(axis=0).max(axis=1)))
