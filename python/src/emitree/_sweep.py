"""Sweeps: the images of a model for many values of its parameters."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _progress
from emitree._cameras import Camera
from emitree._function import Floats
from emitree._sweep_order import Emissions, Images, swept


@dataclass(frozen=True)
class Sweep:
    """The images of a model for all combinations of the values of its parameters."""

    #: The values (values,) of each parameter by its name, in the order of the axes.
    parameters: dict[str, NDArray[Any]]
    #: The renderings, an array of objects with one axis for each parameter, and one for the cameras
    #: if there are several.
    renderings: NDArray[Any]
    #: How often the emission was evaluated for all images together. The evaluations of a rendering
    #: are those that it would take alone at the same points.
    evaluations: int

    @cached_property
    def images(self) -> Floats:
        """All images: the axes of the parameters, then those of an image."""
        shape = self.renderings.shape
        images = np.array([rendering.image for rendering in self.renderings.ravel()])
        return images.reshape(shape + images.shape[1:])

    @property
    def converged(self) -> bool:
        """Whether all renderings met their stopping criterion."""
        return all(rendering.converged for rendering in self.renderings.ravel())


def sweep(
    model: Callable[..., Any],
    parameters: Mapping[str, Any],
    camera: Camera | Sequence[Camera],
    shape: Sequence[int] | int,
    *,
    executor: Any = None,
    progress: _progress.Progress = False,
    **options: Any,
) -> Sweep:
    """The images of a model for all combinations of values of its parameters, and for all cameras.

    The image in the middle is rendered in full. For smooth emissions (products of functions of
    method "vol") its points, chosen to a quarter of the tolerance, serve the images around it as
    far as samples show that they do; then the next full rendering follows. Where the rates at these
    points are combinations of those of former values, as a sample shows, most are calculated. Each
    image has its own error estimate, from samples of its own emission, and meets the tolerance or
    has not `converged`. Sweeps whose images do not serve each other take at most about a tenth more
    evaluations than these renderings alone. Values are compared by their distance relative to the
    whole range of each parameter; their order does not matter.

    model: model(**values) returns an emission, of any kind that `render` takes.
    parameters: the values (values,) of each parameter by its name; the last one changes first.
    camera: as of `render`, or several: then the cameras are the last axis, and `parameters` may be
        none, {}. A point is evaluated once for cameras one after the other with the same
        `position`: views with charts, such as those with a planet or with ellipsoidal `bounds`,
        have most points in common then. Cameras that move have none.
    shape, executor, progress, options: as of `render`.

    Raises `ValueError` if a parameter has no values or some that are not finite numbers, and what
    `render` raises.

    >>> import emitree, numpy as np
    >>> def ball(width):
    ...     return lambda r, d: np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)
    >>> widths = [0.2, 0.21, 0.22]
    >>> sweep = emitree.sweep(ball, {"width": widths}, emitree.Canonical(), (16, 16))
    >>> sweep.images.shape, sweep.converged
    ((3, 16, 16), True)
    """
    values = {name: _checked(name, given) for name, given in parameters.items()}
    cameras = (camera,) if isinstance(camera, Camera) else tuple(camera)
    if not values and isinstance(camera, Camera):
        raise ValueError("`parameters` has none: expected values by the names of parameters")
    if not cameras:
        raise ValueError("`camera` is an empty sequence: expected a camera or several")
    axes = list(values.values())
    given = itertools.product(*(axis.tolist() for axis in axes))
    models = [partial(model, **dict(zip(values, of_place, strict=True))) for of_place in given]
    places = np.array(list(itertools.product(*map(_scaled, axes)))).reshape(len(models), len(axes))
    order = sorted(range(len(models)), key=lambda number: tuple(places[number]))
    renderings = np.empty((len(models), len(cameras)), dtype=object)
    evaluations = 0
    emissions = Emissions([models[number] for number in order])
    for column, (one, after) in enumerate(zip(cameras, [*cameras[1:], None], strict=True)):
        is_last = after is None or not _have_points_in_common(one, after)
        images = Images(one, shape, options, executor, progress)
        found, count = swept(emissions, places[order], images, is_last=is_last)
        renderings[order, column] = found
        evaluations += count
    shape_of_all = tuple(map(len, axes)) + (() if isinstance(camera, Camera) else (len(cameras),))
    return Sweep(values, renderings.reshape(shape_of_all), evaluations)


def _have_points_in_common(one: Camera, other: Camera) -> bool:
    """Whether renderings of two cameras may have the same points: if the observer is the same.

    The coordinates of charts depend on the observer and not on the pointing or the field.
    """
    # As texts of numbers: positions are tuples, arrays or quantities.
    first, second = [
        (list(map(str, camera.position)), camera.length_unit)
        if hasattr(camera, "position")
        else None
        for camera in (one, other)
    ]
    return first is not None and first == second


def _checked(name: str, given: Any) -> NDArray[Any]:
    values = np.asarray(given)
    if values.ndim != 1 or len(values) == 0 or values.dtype.kind not in "fiu":
        raise ValueError(f"`parameters` has {name!r} = {given!r}: expected numbers (values,)")
    if not np.isfinite(values).all():
        raise ValueError(f"`parameters` has {name!r} = {given!r}: expected finite numbers")
    return values


def _scaled(values: NDArray[Any]) -> Floats:
    """Values as fractions of the range of all."""
    least, width = float(values.min()), float(values.max()) - float(values.min())
    return (values - least) / width if width > 0 else np.zeros(len(values))
