"""Triangles divided between the rectangles of a lattice: areas and centroids of their parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats

#: Corners of a triangle that is clipped by a rectangle, at most.
_MOST_CORNERS = 7


@dataclass(frozen=True)
class Divided:
    """The parts of triangles in the rectangles of a lattice."""

    #: (n,), the numbers of the triangle, the column and the row.
    triangle: NDArray[np.intp]
    column: NDArray[np.intp]
    row: NDArray[np.intp]
    #: (n,), the part of the triangle's area.
    part: Floats
    #: (n, 3), the weights of the three corners in the centroid.
    centroid: Floats


def divided(x: Floats, y: Floats, columns: Floats, rows: Floats) -> Divided:
    """Triangles with corners (m, 3), (m, 3), divided by lines at increasing places of x and y.

    Parts outside of the first and last lines are left out. Each pair of a triangle and a rectangle
    that may overlap is a polygon, clipped by one side after the other (Sutherland and Hodgman
    1974, doi:10.1145/360767.360802).

    >>> found = divided(np.array([[0., 2., 0.]]), np.array([[0., 0., 2.]]), *2 * [np.arange(3.)])
    >>> found.column, found.row, found.part
    (array([0, 1, 0]), array([0, 0, 1]), array([0.5 , 0.25, 0.25]))
    """
    left, high_column = _range(x, columns)
    low, high_row = _range(y, rows)
    across, along = high_column - left, high_row - low
    counts = across * along
    triangle = np.repeat(np.arange(len(x)), counts)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(counts) - counts, counts)
    row, column = np.divmod(number, np.maximum(across[triangle], 1))
    row, column = row + low[triangle], column + left[triangle]
    corners = np.stack([x[triangle], y[triangle]], axis=2)
    polygons = np.zeros((len(triangle), _MOST_CORNERS, 2))
    polygons[:, :3] = corners
    length = np.full(len(triangle), 3)
    for axis, sign, limit in (
        (0, 1, columns[column]),
        (0, -1, columns[column + 1]),
        (1, 1, rows[row]),
        (1, -1, rows[row + 1]),
    ):
        polygons, length = _clipped(polygons, length, axis, sign, limit)
    area, centre = _area_and_centroid(polygons, length, corners[:, 0])
    whole = _area_and_centroid(corners, np.full(len(triangle), 3), corners[:, 0])[0]
    is_part = (area != 0) & (whole != 0)
    triangle, row, column = triangle[is_part], row[is_part], column[is_part]
    corners, centre = corners[is_part], centre[is_part]
    whole = whole[is_part]
    # The weights of corners are the areas opposite to them.
    to = corners - centre[:, np.newaxis]
    opposite = [(1, 2), (2, 0), (0, 1)]
    areas = [0.5 * _cross(to[:, i], to[:, j]) for i, j in opposite]
    centroid = np.stack(areas, axis=1) / whole[:, np.newaxis]
    return Divided(triangle, column, row, area[is_part] / whole, centroid)


def _range(values: Floats, lines: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first rectangle that each triangle (m, 3) may be in, and the one after the last."""
    last = len(lines) - 1
    first = np.clip(np.searchsorted(lines, values.min(axis=1), side="right") - 1, 0, last)
    end = np.clip(np.searchsorted(lines, values.max(axis=1), side="left"), 0, last)
    return first, np.maximum(end, first)


def _clipped(
    polygons: Floats, length: NDArray[np.intp], axis: int, sign: int, limit: Floats
) -> tuple[Floats, NDArray[np.intp]]:
    """Convex polygons (n, corners, 2) on one side of a line: sign * (corner - limit) >= 0."""
    found = np.zeros_like(polygons)
    count = np.zeros_like(length)
    every = np.arange(len(polygons))

    def append(chosen: NDArray[np.bool_], corner: Floats) -> None:
        found[every[chosen], count[chosen]] = corner[chosen]
        count[chosen] += 1

    height = sign * (polygons[:, :, axis] - limit[:, np.newaxis])
    for number in range(polygons.shape[1]):
        is_corner = number < length
        after = np.where(number + 1 < length, number + 1, 0)
        here, there = height[:, number], height[every, after]
        append(is_corner & (here >= 0), polygons[:, number])
        crosses = is_corner & ((here >= 0) != (there >= 0))
        share = np.where(crosses, here / np.where(crosses, here - there, 1.0), 0.0)
        between = polygons[:, number] + share[:, np.newaxis] * (
            polygons[every, after] - polygons[:, number]
        )
        append(crosses, between)
    return found, count


def _area_and_centroid(
    polygons: Floats, length: NDArray[np.intp], origin: Floats
) -> tuple[Floats, Floats]:
    """The signed areas (n,) of polygons and their centroids (n, 2); an origin (n, 2) near them."""
    away = polygons - origin[:, np.newaxis]
    every = np.arange(len(polygons))
    area, moment = np.zeros(len(polygons)), np.zeros((len(polygons), 2))
    for number in range(polygons.shape[1]):
        after = np.where(number + 1 < length, number + 1, 0)
        one, other = away[:, number], away[every, after]
        twice = np.where(number < length, _cross(one, other), 0.0)
        area += 0.5 * twice
        moment += (one + other) * (twice / 6.0)[:, np.newaxis]
    centre = moment / np.where(area != 0, area, 1.0)[:, np.newaxis]
    return area, origin + centre


def _cross(one: Floats, other: Floats) -> Floats:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
