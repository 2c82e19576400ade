"""Lines of sight of a camera through cells of its pixels, and tubes around them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._cameras import Camera, Canonical, Fisheye, Orthographic
from emitree._cells import CENTRE, PLACES, Cells
from emitree._function import Floats
from emitree._rims import Rim
from emitree._scene import compose, length_unit_of


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
        #: Whether all lines of sight are parallel; otherwise they end at one observer.
        self.is_parallel = isinstance(camera, Canonical | Orthographic)
        #: The rim of the image, None where it is a rectangle.
        self.rim = Rim(self.shape) if isinstance(camera, Fisheye) else None
        self._position = (
            None if self.is_parallel else np.array(camera.table(unit)["position"], float)
        )

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

    def directions_at(self, position: Floats) -> Floats:
        """Unit vectors (n, 3) to the observer, from positions (n, 3)."""
        if self._position is None:
            middle = np.array([0.5])
            direction = -self.lines_at(middle, middle).direction.T
            return np.repeat(direction, len(position), axis=0)
        away = self._position - position
        return np.asarray(away / np.linalg.norm(away, axis=1, keepdims=True))

    def lines_of(self, cells: Cells) -> Lines:
        """The lines (cells, places) of cells; their densities are as of whole pixels."""
        height, width = self.shape
        size = 0.5 ** cells.level[:, np.newaxis]
        row, column = np.divmod(cells.pixel[:, np.newaxis], width)
        x = (cells.column[:, np.newaxis] + 0.5 + 0.5 * PLACES[:, 0]) * size
        y = (cells.row[:, np.newaxis] + 0.5 + 0.5 * PLACES[:, 1]) * size
        xs, ys = (x + column) / width, (y + row) / height
        areas = None if self.rim is None else self.rim.stretch(cells.pixel, x, y, xs, ys)
        lines = self.lines_at(xs.ravel(), ys.ravel()).reshape(*x.shape)
        return lines if areas is None else replace(lines, density=lines.density * areas)

    def has_kink(self, cells: Cells) -> NDArray[np.bool_]:
        """Whether the density of the lines of cells (n,) has a kink or a jump within them."""
        if self.rim is None:
            return np.zeros(len(cells.pixel), dtype=bool)
        return self.rim.has_kink(cells)

    def has_image(self) -> NDArray[np.bool_]:
        """Whether pixels (pixels,) are in the image, at least in part."""
        return np.ones(len(self), dtype=bool) if self.rim is None else self.rim.is_seen


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
