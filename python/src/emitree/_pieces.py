"""Pieces of lines of sight between surfaces, and the quadrature of smooth functions on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._image_places import Covered, ImagePlaces
from emitree._points import Points
from emitree._sight import View
from emitree._surfaces import Surfaces

#: The nodes of Gauss-Legendre quadrature on each piece.
_NODES = 5

#: The most lines of sight: the smooth part of a derivative is interpolated between them.
_MOST_LINES = 1500


@dataclass(frozen=True)
class Pieces:
    """Points on lines of sight, none of them at a surface, and the images of functions there."""

    #: The points (n,).
    points: Points
    #: (n,), the numbers of their lines and the weights of their rates [length].
    line: NDArray[np.intp]
    weight: Floats
    #: The places of the lines along the height and the width of the image.
    rows: Floats
    columns: Floats
    #: (height, width) in pixels.
    shape: tuple[int, int]

    def apply(self, rates: Floats) -> Floats:
        """The images (k, height, width) of rates (n, k)."""
        height, width = len(self.rows), len(self.columns)
        images = np.empty((rates.shape[1], *self.shape))
        rows, columns = _between(self.rows, self.shape[0]), _between(self.columns, self.shape[1])
        for image, column in zip(images, rates.T, strict=True):
            sums = np.bincount(self.line, self.weight * column, minlength=height * width)
            image[...] = rows @ sums.reshape(height, width) @ columns.T
        return images


def pieces_between(view: View, surfaces: Surfaces, places: ImagePlaces, part: Covered) -> Pieces:
    """The pieces of lines of sight all over an image, between the surfaces that they cross.

    places: those of the vertices; part: where they cover the image. Nodes are as far from the
    surfaces as these are uncertain.
    """
    height, width = view.shape
    coarser = max(1.0, (height * width / _MOST_LINES) ** 0.5)
    grid = (max(2, round(height / coarser)), max(2, round(width / coarser)))
    grid = (min(grid[0], height), min(grid[1], width))
    rows = part.within(1, (np.arange(grid[0]) + 0.5) / grid[0])
    columns = part.within(0, (np.arange(grid[1]) + 0.5) / grid[1])
    y, x = (values.ravel() for values in np.meshgrid(rows, columns, indexing="ij"))
    lines = view.lines_at(x, y)
    line, distance, margin = _crossings(surfaces, places, rows, columns)
    is_between = (distance > lines.near[line]) & (distance < lines.far[line])
    line, distance, margin = line[is_between], distance[is_between], margin[is_between]
    seen = np.flatnonzero((lines.density > 0) & (lines.far > lines.near))
    # All ends of pieces, line by line.
    number = np.concatenate([seen, line, seen])
    end = np.concatenate([lines.near[seen], distance, lines.far[seen]])
    margin = np.concatenate([np.zeros(len(seen)), margin, np.zeros(len(seen))])
    order = np.lexsort((end, number))
    number, end, margin = number[order], end[order], margin[order]
    is_piece = (number[:-1] == number[1:]) & (end[1:] > end[:-1])
    line, first, last = number[:-1][is_piece], end[:-1][is_piece], end[1:][is_piece]
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    node, weight = (1 + node) / 2, weight / 2
    length = last - first
    is_finite = np.isfinite(length)
    # Within the margins the function is taken as that at the nearest node.
    from_first = np.minimum(margin[:-1][is_piece], 0.2 * length)
    from_last = np.minimum(margin[1:][is_piece], 0.2 * length)
    with np.errstate(invalid="ignore"):
        inner = (
            first[:, None] + from_first[:, None] + (length - from_first - from_last)[:, None] * node
        )
    weights = length[:, None] * weight
    if not is_finite.all():
        scale = np.maximum(abs(first), np.finfo(float).tiny)[:, None]
        far = first[:, None] + from_first[:, None] + scale * node / (1 - node)
        inner = np.where(is_finite[:, None], inner, far)
        weights = np.where(is_finite[:, None], weights, scale * weight / (1 - node) ** 2)
    line = np.repeat(line, _NODES)
    direction = lines.direction[:, line]
    position = lines.origin[:, line] + inner.ravel() * direction
    points = Points(np.ascontiguousarray(position.T), np.ascontiguousarray(-direction.T), None)
    return Pieces(points, line, weights.ravel(), rows, columns, view.shape)


def _crossings(
    surfaces: Surfaces, places: ImagePlaces, rows_at: Floats, columns_at: Floats
) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Where lines cross triangles: the line, the distance, and how uncertain this is."""
    corners = surfaces.triangles[places.is_seen[surfaces.triangles].all(axis=1)]
    x, y = places.x[corners], places.y[corners]
    left, low = np.searchsorted(columns_at, x.min(axis=1)), np.searchsorted(rows_at, y.min(axis=1))
    columns = np.searchsorted(columns_at, x.max(axis=1), side="right") - left
    rows = np.searchsorted(rows_at, y.max(axis=1), side="right") - low
    counts = columns * rows
    triangle = np.repeat(np.arange(len(corners)), counts)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(counts) - counts, counts)
    row, column = np.divmod(number, np.maximum(columns[triangle], 1))
    row, column = row + low[triangle], column + left[triangle]
    x, y = x[triangle], y[triangle]
    (ax, bx, cx), (ay, by, cy) = (
        (x - columns_at[column, np.newaxis]).T,
        (y - rows_at[row, np.newaxis]).T,
    )
    # Areas opposite to each corner; of one sign if the line crosses the triangle.
    parts = np.stack([bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], axis=1)
    area = parts.sum(axis=1)
    crosses = ((parts >= 0).all(axis=1) & (area > 0)) | ((parts <= 0).all(axis=1) & (area < 0))
    vertices = corners[triangle[crosses]]
    share = parts[crosses] / area[crosses, None]
    distance = (share * places.distance[vertices]).sum(axis=1)
    # Twice the displacement that is expected, and along lines that are oblique more.
    margin = 4.0 * (share * surfaces.uncertainty[vertices]).sum(axis=1)
    return row[crosses] * len(columns_at) + column[crosses], distance, margin


def _between(places: Floats, pixels: int) -> Floats:
    """The matrix (pixels, places) of linear interpolation, and extrapolation to the borders."""
    at = (np.arange(pixels) + 0.5) / pixels
    if len(places) == 1:
        return np.ones((pixels, 1))
    low = np.clip(np.searchsorted(places, at, side="right") - 1, 0, len(places) - 2)
    share = (at - places[low]) / (places[low + 1] - places[low])
    matrix = np.zeros((pixels, len(places)))
    every = np.arange(pixels)
    matrix[every, low] = 1.0 - share
    matrix[every, low + 1] = share
    return matrix
