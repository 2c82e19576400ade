"""Derivatives of an image whose emission jumps at surfaces that move with the parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from emitree._displacements import Samples, change_of, samples_of
from emitree._function import Floats, as_rates
from emitree._image_places import Covered, ImagePlaces, covered, image_places
from emitree._pieces import Pieces, pieces_between
from emitree._points import Points
from emitree._sight import View
from emitree._surfaces import Surfaces

#: Parts of each side of a triangle: its parts are in the pixels of their centres.
_PARTS = 5


class MovingSurfaces:
    """The derivatives of an image by parameters that move the surfaces which a rendering found.

    By Reynolds' transport theorem the derivative of the integral over a pixel is that of the
    derivative of g, between the surfaces, and for each surface the jump times the speed of the
    surface along its normal.
    """

    def __init__(self, view: View, surfaces: Surfaces) -> None:
        self.view = view
        self.surfaces = surfaces
        self.places: ImagePlaces = image_places(view, surfaces.position)
        self.covered: Covered = covered(surfaces.triangles, self.places)
        self.pieces: Pieces = pieces_between(view, surfaces, self.places, self.covered)
        self._samples: Samples | None = None

    def rates_along(self, emission: Callable[..., Any]) -> Callable[[Floats], Floats]:
        """The rates of an emission as a function of positions, on their lines of sight."""

        def rates(position: Floats) -> Floats:
            return as_rates(emission(position, self._directions(position)), len(position), None)

        return rates

    def displacement(
        self,
        emission: Callable[..., Any],
        moved: Callable[[float], Callable[..., Any]],
        first: float,
    ) -> tuple[Floats, float]:
        """The speed (vertices,) of the surfaces along their normals, and the change it is found by.

        emission: that of the surfaces; moved: the emission where a parameter is changed; first: the
        change that is tried first.
        """
        if self._samples is None:
            self._samples = samples_of(self.surfaces, self.rates_along(emission))
        samples = self._samples
        change = change_of(samples, lambda by: self.rates_along(moved(by)), first)
        offset, is_found = samples.displacements(self.rates_along(moved(change)))
        return samples.at_vertices(np.where(is_found, offset / change, 0.0)), change

    def images(self, speeds: Floats) -> Floats:
        """The parts (k, height, width) of the surfaces in derivatives, for speeds (k, vertices)."""
        height, width = self.view.shape
        corners = self.surfaces.triangles[self.places.is_seen[self.surfaces.triangles].all(axis=1)]
        edges = self.surfaces.position[corners]
        area = 0.5 * np.linalg.norm(
            np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1
        )
        share = _centres()
        x, y = (share @ values[corners].T for values in (self.places.x, self.places.y))
        column = np.clip((x * width).astype(int), 0, width - 1)
        row = np.clip((y * height).astype(int), 0, height - 1)
        pixel = (row * width + column).ravel()
        across = np.where(self.covered.is_inside(x, y), area / len(share), 0.0)
        if not self.view.is_parallel:
            distance = share @ self.places.distance[corners].T
            across = across / distance**2
        # The solid angle of each pixel, or its area: the mean density is that in its centre.
        rows, columns = np.divmod(np.arange(height * width), width)
        lines = self.view.lines_at((columns + 0.5) / width, (rows + 0.5) / height)
        size = lines.density / (height * width)
        images = np.zeros((len(speeds), height, width))
        for number, speed in enumerate(speeds):
            # The larger rate is on the side of the normal: it loses what the surface passes.
            lost = share @ (-speed * self.surfaces.jump)[corners].T
            sums = np.bincount(pixel, (lost * across).ravel(), minlength=len(size))
            mean = np.divide(sums, size, out=np.zeros(len(size)), where=size > 0)
            images[number] = self.covered.extended(mean.reshape(height, width))
        return images

    def smooth(self, derivatives: Callable[[Points], Floats]) -> Floats:
        """The parts (k, height, width) of the derivatives (n, k) of g between the surfaces."""
        return self.pieces.apply(derivatives(self.pieces.points))

    def _directions(self, position: Floats) -> Floats:
        """Unit vectors (n, 3) from positions to the observer."""
        if self.view.is_parallel:
            direction = -self.view.lines_at(np.array([0.5]), np.array([0.5])).direction.T
            return np.repeat(direction, len(position), axis=0)
        away = self.view.observer - position
        return np.asarray(away / np.linalg.norm(away, axis=1, keepdims=True))


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
