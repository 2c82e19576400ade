"""Derivatives of an image whose emission jumps at surfaces that move with the parameters."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._displacements import Samples, change_of, samples_of
from emitree._function import Floats
from emitree._image_places import Covered, ImagePlaces, covered, image_places
from emitree._native import SceneError
from emitree._offsets import Rates, moved_onto
from emitree._pieces import Pieces, pieces_between
from emitree._point_rates import rates_at
from emitree._points import Points
from emitree._sight import View
from emitree._triangle_sums import TriangleSums

if TYPE_CHECKING:
    from emitree._result import Rendering
    from emitree._setup import Setup

#: Keywords of `render` that change the lines of sight.
_OF_VIEW = ("bounds", "occulters")

#: Keywords of `render` that change the unit of the image.
_OF_UNITS = ("unit", "image_unit", "quantity")


class MovingSurfaces:
    """The derivatives of an image by parameters that move the surfaces which a rendering found.

    By Reynolds' transport theorem the derivative of the integral over a pixel is that of the
    derivative of g, between the surfaces, and for each surface the jump times the speed of the
    surface along its normal.

    emission: that of the rendering, whose surfaces are made more accurate by it.
    """

    def __init__(self, rendering: Rendering, emission: Callable[..., Any]) -> None:
        surfaces, setup = rendering.surfaces, rendering._setup
        if surfaces is None or setup is None:
            raise ValueError("the rendering has no surfaces, or is a copy: expected the original")
        if setup.options.get("absorption") is not None:
            raise ValueError(
                "the image has a medium that absorbs: expected none, for derivatives by parameters "
                "that move surfaces"
            )
        of_view = {name: setup.options[name] for name in _OF_VIEW if name in setup.options}
        self._setup = setup
        self._view = View(setup.camera, setup.shape, **of_view)
        self._scale = _image_scale(self._view, setup)
        self._rates = self._along(emission)
        surfaces = moved_onto(surfaces, self._rates)
        self._surfaces = surfaces
        self._places: ImagePlaces = image_places(self._view, surfaces.position)
        self._covered: Covered = covered(surfaces.triangles, self._places)
        #: Points between the surfaces.
        self.pieces: Pieces = pieces_between(self._view, surfaces, self._places, self._covered)
        self._samples: Samples | None = None

    @property
    def least_jump(self) -> float:
        """The least jump of the rate at the surfaces."""
        return float(self._surfaces.jump.min())

    def rates(self, emission: Callable[..., Any], points: Points) -> Floats:
        """The rates (n,) of an emission at points."""
        return rates_at(emission, points, self._setup, self._setup.unit)

    def speed(
        self,
        changed: Callable[[float], Callable[..., Any]],
        first: float,
    ) -> tuple[Floats, float]:
        """The speed (vertices,) of the surfaces along their normals, and the change it is found by.

        changed: the emission where a parameter is changed by a number; first: the change that is
        tried first.
        """
        if self._samples is None:
            self._samples = samples_of(self._surfaces, self._rates)
        samples = self._samples
        change = change_of(samples, lambda by: self._along(changed(by)), first)
        offset, is_found = samples.displacements(self._along(changed(change)))
        return samples.at_vertices(np.where(is_found, offset / change, 0.0)), change

    def image(self, speed: Floats) -> Floats:
        """The part (height, width) of the surfaces in a derivative, for their speed (vertices,)."""
        return self._scale * self._of_triangles.image(-speed * self._surfaces.jump)

    def smooth(self, derivatives: Floats) -> Floats:
        """The parts (k, height, width) of the derivatives (n, k) of g at the points of `pieces`."""
        return self._scale * self.pieces.apply(derivatives)

    @cached_property
    def _of_triangles(self) -> TriangleSums:
        return TriangleSums.of(self._view, self._surfaces, self._places, self._covered)

    def _along(self, emission: Callable[..., Any]) -> Rates:
        """The rates of an emission as a function of positions, on their lines of sight."""

        def rates(position: Floats) -> Floats:
            points = Points(position, self._view.directions_at(position), None)
            return self.rates(emission, points)

        return rates


def _image_scale(view: View, setup: Setup) -> Floats | float:
    """What the integral of rates along lines of sight is multiplied with, for each pixel."""
    if not any(setup.options.get(name) is not None for name in _OF_UNITS):
        return 1.0
    from emitree._session import Session

    options = {
        name: setup.options[name] for name in (*_OF_VIEW, *_OF_UNITS) if name in setup.options
    }
    session = Session(setup.camera, setup.shape, method="los", steps=1, **options)
    while (points := session.ask()) is not None:
        session.tell(np.ones(len(points)))
    height, width = view.shape
    row, column = np.divmod(np.arange(height * width), width)
    lines = view.lines_at((column + 0.5) / width, (row + 0.5) / height)
    length = (lines.far - lines.near).reshape(height, width)
    if not np.isfinite(length).all():
        raise SceneError(
            "`far` is inf: expected a finite depth, for derivatives by parameters that move "
            "surfaces in units that are converted"
        )
    rendering = session.rendering()
    assert rendering is not None
    return np.divide(rendering.image, length, where=length > 0, out=np.zeros_like(length))
