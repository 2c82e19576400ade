"""Integrals over surfaces within the cones of pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._image_places import Covered, ImagePlaces
from emitree._sight import View
from emitree._surfaces import Surfaces

#: Parts of each side of a triangle: its parts are in the pixels of their centres.
_PARTS = 5


@dataclass(frozen=True)
class TriangleSums:
    """The integrals of functions on triangles, for each pixel divided by its solid angle."""

    #: The vertices (m, 3) of the triangles in view.
    corners: NDArray[np.int64]
    #: (parts, m), the pixel of each part and its weight: its solid angle, if seen face-on, over
    #: that of the pixel; for parallel lines of sight areas instead.
    pixel: NDArray[np.intp]
    weight: Floats
    #: The part of the image that the triangles cover.
    covered: Covered
    #: (height, width) in pixels.
    shape: tuple[int, int]

    @classmethod
    def of(
        cls, view: View, surfaces: Surfaces, places: ImagePlaces, part: Covered
    ) -> TriangleSums:
        """The triangles of surfaces, with the places of their vertices, in a view."""
        height, width = view.shape
        corners = surfaces.triangles[places.is_seen[surfaces.triangles].all(axis=1)]
        edges = surfaces.position[corners]
        across = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
        share = _centres()
        x, y = (share @ values[corners].T for values in (places.x, places.y))
        column = np.clip((x * width).astype(int), 0, width - 1)
        row = np.clip((y * height).astype(int), 0, height - 1)
        weight = 0.5 * np.linalg.norm(across, axis=1) / len(share)
        if not view.is_parallel:
            weight = weight / (share @ places.distance[corners].T) ** 2
        # The density changes little within a pixel: its mean is that in the centre.
        rows, columns = np.divmod(np.arange(height * width), width)
        density = view.lines_at((columns + 0.5) / width, (rows + 0.5) / height).density
        size = density / (height * width)
        pixel = row * width + column
        is_inside = part.is_inside(x, y) & (size > 0)[pixel]
        weight = np.where(is_inside, weight, 0.0) / np.where(size > 0, size, 1.0)[pixel]
        return cls(corners, pixel.ravel(), weight, part, view.shape)

    def image(self, values: Floats) -> Floats:
        """The integrals (height, width) of a function with values (vertices,), linear between."""
        height, width = self.shape
        parts = (_centres() @ values[self.corners].T * self.weight).ravel()
        sums = np.bincount(self.pixel, parts, minlength=height * width)
        return self.covered.extended(sums.reshape(height, width))


def _centres() -> Floats:
    """The weights (parts, 3) of the corners of a triangle at the centres of its equal parts."""
    found = []
    for i in range(_PARTS):
        for j in range(_PARTS - i):
            found.append((i + 1 / 3, j + 1 / 3))
            if i + j < _PARTS - 1:
                found.append((i + 2 / 3, j + 2 / 3))
    first, second = np.array(found).T / _PARTS
    return np.stack([1 - first - second, first, second], axis=1)
