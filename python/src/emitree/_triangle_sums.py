"""Integrals over surfaces within the cones of pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._clipping import divided
from emitree._function import Floats
from emitree._image_places import Covered, ImagePlaces
from emitree._sight import View
from emitree._surfaces import Surfaces


@dataclass(frozen=True)
class TriangleSums:
    """The integrals of functions on triangles, for each pixel divided by its solid angle."""

    #: (n, 3), the vertices of the triangle that a part is of, and their weights in its middle.
    corners: NDArray[np.int64]
    share: Floats
    #: (n,), the pixel of each part and its weight: its solid angle, if seen face-on, over that of
    #: the pixel; for parallel lines of sight areas instead.
    pixel: NDArray[np.intp]
    weight: Floats
    #: The part of the image that the triangles cover.
    covered: Covered
    #: (height, width) in pixels.
    shape: tuple[int, int]

    @classmethod
    def of(cls, view: View, surfaces: Surfaces, places: ImagePlaces, part: Covered) -> TriangleSums:
        """The triangles of surfaces, with the places of their vertices, in a view."""
        height, width = view.shape
        corners = surfaces.triangles[places.is_seen[surfaces.triangles].all(axis=1)]
        edges = surfaces.position[corners]
        across = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
        area = 0.5 * np.linalg.norm(across, axis=1)
        columns = part.within(0, np.linspace(0, 1, width + 1))
        rows = part.within(1, np.linspace(0, 1, height + 1))
        found = divided(places.x[corners], places.y[corners], columns, rows)
        corners = corners[found.triangle]
        weight = area[found.triangle] * found.part
        if not view.is_parallel:
            weight /= (found.centroid * places.distance[corners]).sum(axis=1) ** 2
        # The density changes little within a pixel: its mean is that in the centre.
        row, column = np.divmod(np.arange(height * width), width)
        density = view.lines_at((column + 0.5) / width, (row + 0.5) / height).density
        pixel = found.row * width + found.column
        size = (density / (height * width))[pixel]
        weight = np.where(size > 0, weight, 0.0) / np.where(size > 0, size, 1.0)
        return cls(corners, found.centroid, pixel, weight, part, view.shape)

    def image(self, values: Floats) -> Floats:
        """The integrals (height, width) of a function with values (vertices,), linear between."""
        height, width = self.shape
        parts = (self.share * values[self.corners]).sum(axis=1) * self.weight
        sums = np.bincount(self.pixel, parts, minlength=height * width)
        return self.covered.extended(np.asarray(sums, np.float64).reshape(height, width))
