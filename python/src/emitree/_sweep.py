"""Sweeps: the images of a model for many values of its parameters."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _progress
from emitree._cameras import Camera
from emitree._function import Floats
from emitree._plan import Plan
from emitree._render import render
from emitree._result import Rendering


@dataclass(frozen=True)
class Sweep:
    """The images of a model for all combinations of the values of its parameters."""

    #: The values (values,) of each parameter by its name, in the order of the axes.
    parameters: dict[str, NDArray[Any]]
    #: The renderings, an array of objects with one axis for each parameter.
    renderings: NDArray[Any]

    @cached_property
    def images(self) -> Floats:
        """All images: the axes of the parameters, then those of an image."""
        shape = self.renderings.shape
        images = np.array([rendering.image for rendering in self.renderings.ravel()])
        return images.reshape(shape + images.shape[1:])

    @property
    def evaluations(self) -> int:
        """How often the emission was evaluated for all images together."""
        return sum(rendering.evaluations for rendering in self.renderings.ravel())

    @property
    def converged(self) -> bool:
        """Whether all renderings met their stopping criterion."""
        return all(rendering.converged for rendering in self.renderings.ravel())


def sweep(
    model: Callable[..., Any],
    parameters: Mapping[str, Any],
    camera: Camera,
    shape: Sequence[int] | int,
    *,
    executor: Any = None,
    progress: _progress.Progress = False,
    **options: Any,
) -> Sweep:
    """The images of a model for all combinations of values of its parameters.

    The first image is rendered in full. Each of the others starts from the plan of the nearest one
    before, and is rendered in full where its points do not suffice; each has its own error estimate
    and meets the tolerance, or has not `converged`. Values are compared by their distance relative
    to the whole range of each parameter. Images of which no other can start, such as those of found
    surfaces and of image trees, are of no use for the next ones.

    model: model(**values) returns an emission, of any kind that `render` takes.
    parameters: the values (values,) of each parameter by its name; the last one changes first.
    camera, shape, executor, progress, options: as of `render`.

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
    if not values:
        raise ValueError("`parameters` has none: expected values by the names of parameters")
    renderings = np.empty(tuple(map(len, values.values())), dtype=object)
    done: list[tuple[Floats, Plan]] = []
    axes = list(values.values())
    for place in itertools.product(*map(range, renderings.shape)):
        of_place = [axis[number] for axis, number in zip(axes, place, strict=True)]
        named = zip(values, of_place, strict=True)
        emission = model(**{name: value.item() for name, value in named})
        at = np.array([_scaled(value, axis) for value, axis in zip(of_place, axes, strict=True)])
        near = _nearest(done, at)
        if near is None:
            found = render(emission, camera, shape, executor=executor, progress=progress, **options)
        else:
            found = near.refine(emission, executor=executor, progress=progress)
        renderings[place] = found
        plan = _plan_of(found)
        if plan is not None:
            done.append((at, plan))
    return Sweep(values, renderings)


def _plan_of(rendering: Rendering) -> Plan | None:
    """The plan of a rendering, if others may start from it."""
    try:
        plan = rendering.plan
    except ValueError:
        return None
    return plan if plan.is_of_products else None


def _checked(name: str, given: Any) -> NDArray[Any]:
    values = np.asarray(given)
    if values.ndim != 1 or len(values) == 0 or values.dtype.kind not in "fiu":
        raise ValueError(f"`parameters` has {name!r} = {given!r}: expected numbers (values,)")
    if not np.isfinite(values).all():
        raise ValueError(f"`parameters` has {name!r} = {given!r}: expected finite numbers")
    return values


def _scaled(value: Any, values: NDArray[Any]) -> float:
    """A value as a fraction of the range of all."""
    width = float(values.max()) - float(values.min())
    return (float(value) - float(values.min())) / width if width > 0 else 0.0


def _nearest(done: list[tuple[Floats, Plan]], at: Floats) -> Plan | None:
    """The nearest plan, of equally near ones the latest."""
    if not done:
        return None
    distances = [float(np.linalg.norm(place - at)) for place, _ in reversed(done)]
    return done[len(done) - 1 - int(np.argmin(distances))][1]
