"""Places of points in an image: from world coordinates to those of the image plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._sight import Lines, View

#: Lines along each side of the image from which the search starts.
_STARTS = 17

#: Newton steps: from a start as near as these they end at rounding after four.
_STEPS = 5

#: The difference for derivatives of the map, in widths of the image.
_DIFFERENCE = 1e-6

#: How far beyond the borders of the image points are seen, in widths of it, and beyond the ends of
#: lines, in their lengths: vertices on a border are moved along the normal of their surface.
_BEYOND = 0.03

#: The place nearer to a border than which the first vertex is on it.
_ON_BORDER = 1e-6

#: The largest distance of a point from the line that is found, in distances from the origin.
_ACCURACY = 1e-7


@dataclass(frozen=True)
class ImagePlaces:
    """Where points (n, 3) are in an image."""

    #: (n,), (n,) from 0 to 1 within the image.
    x: Floats
    y: Floats
    #: (n,) along the line of sight from its origin [length].
    distance: Floats
    #: (n,) whether the point is in the image, and between the ends of its line of sight, or beside
    #: these by a small part of the image.
    is_seen: NDArray[np.bool_]


@dataclass(frozen=True)
class Covered:
    """The part of an image which surfaces cover: in some views they end before its borders."""

    #: Least and largest place, each (2,) of x and y.
    low: Floats
    high: Floats

    def is_inside(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        """Whether places are in the part."""
        inside = (x >= self.low[0]) & (x <= self.high[0])
        return np.asarray(inside & (y >= self.low[1]) & (y <= self.high[1]))

    def within(self, axis: int, places: Floats) -> Floats:
        """The places along an axis, and those outside of the part at its ends."""
        return np.clip(places, self.low[axis], self.high[axis])

    def extended(self, image: Floats) -> Floats:
        """An image (height, width) of what the part contains, continued to the borders.

        Pixels that are in the part by a third at least have the mean over that, and others are as
        the nearest of these.
        """
        for axis, array_axis in ((0, 1), (1, 0)):
            count = image.shape[array_axis]
            edges = self.within(axis, np.linspace(0, 1, count + 1))
            share = np.diff(edges) * count
            good = np.flatnonzero(share >= 1 / 3)
            if len(good) == 0:
                continue
            nearest = good[abs(np.arange(count)[:, np.newaxis] - good).argmin(axis=1)]
            scaled = 1 / share[nearest]
            image = image.take(nearest, axis=array_axis)
            image = image * (scaled if array_axis == 1 else scaled[:, np.newaxis])
        return image


def covered(triangles: NDArray[np.int64], places: ImagePlaces) -> Covered:
    """The part of an image that triangles cover.

    It is whole at borders at which they have vertices, or which they do not come near.
    """
    low, high = np.zeros(2), np.ones(2)
    for axis, values in enumerate((places.x, places.y)):
        of_corners = values[triangles]
        cell = float(np.percentile(np.ptp(of_corners, axis=1), 95)) if len(triangles) else 0.0
        low[axis] = cell if _ON_BORDER < values.min() < 1.5 * cell else 0.0
        high[axis] = 1 - cell if _ON_BORDER < 1 - values.max() < 1.5 * cell else 1.0
    return Covered(low, high)


def image_places(view: View, points: Floats) -> ImagePlaces:
    """The places of points (n, 3): those of the lines of sight that pass through them.

    The map from an image to its lines, of any camera, is inverted by Newton's method.
    """
    points = np.ascontiguousarray(points.T)
    x, y = _nearest(view, points)
    for _ in range(_STEPS):
        here = _offset(view.lines_at(x, y), points)
        by_x = (_offset(view.lines_at(x + _DIFFERENCE, y), points) - here) / _DIFFERENCE
        by_y = (_offset(view.lines_at(x, y + _DIFFERENCE), points) - here) / _DIFFERENCE
        xx, xy, yy = (by_x * by_x).sum(0), (by_x * by_y).sum(0), (by_y * by_y).sum(0)
        first, second = -(by_x * here).sum(0), -(by_y * here).sum(0)
        determinant = np.maximum(xx * yy - xy * xy, np.finfo(float).tiny)
        # Half the distance between starts at most: a step of a point outside may be of any size.
        limit = 0.5 / (_STARTS - 1)
        x = x + np.clip((yy * first - xy * second) / determinant, -limit, limit)
        y = y + np.clip((xx * second - xy * first) / determinant, -limit, limit)
    lines = view.lines_at(x, y)
    along = points - lines.origin
    distance = (along * lines.direction).sum(axis=0)
    off = np.linalg.norm(_offset(lines, points), axis=0)
    is_seen = (abs(x - 0.5) <= 0.5 + _BEYOND) & (abs(y - 0.5) <= 0.5 + _BEYOND)
    length = lines.far - lines.near
    beyond = _BEYOND * np.where(np.isfinite(length), length, abs(distance))
    is_seen &= (distance >= lines.near - beyond) & (distance <= lines.far + beyond)
    is_seen &= lines.density > 0
    is_seen &= off <= _ACCURACY * np.maximum(np.linalg.norm(along, axis=0), _ACCURACY)
    return ImagePlaces(x, y, distance, is_seen)


def _offset(lines: Lines, points: Floats) -> Floats:
    """The vectors (3, n) from lines to points, perpendicular to the lines."""
    along = points - lines.origin
    return along - (along * lines.direction).sum(axis=0) * lines.direction


def _nearest(view: View, points: Floats) -> tuple[Floats, Floats]:
    """The nearest of some lines all over the image to each point (3, n)."""
    side = np.linspace(0, 1, _STARTS)
    x, y = (values.ravel() for values in np.meshgrid(side, side))
    lines = view.lines_at(x, y)
    along = lines.direction.T @ points - (lines.origin * lines.direction).sum(axis=0)[:, None]
    squares = (points**2).sum(axis=0) - 2 * lines.origin.T @ points
    squares += (lines.origin**2).sum(axis=0)[:, None] - along**2
    if not view.is_parallel:
        squares[along < 0] = np.inf
    nearest = squares.argmin(axis=0)
    return x[nearest], y[nearest]
