"""Plans for a neighbourhood of parameters: one set of points for the centre and the ends.

The functions that are found for one emission may not contain those of its derivatives: a product of
Gaussians has one point, and the image there does not depend on their widths. The plan of the centre
is therefore compared with samples of the emissions at the ends. If it does not suffice, the plan is
that of a mixture of all of them, with weights of both signs, and is compared with each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from emitree._cameras import Camera
from emitree._components import Components
from emitree._function import Floats
from emitree._native import SceneError
from emitree._plan import Plan
from emitree._render import render
from emitree._result import Rendering
from emitree._search import finer_tolerance, plan_of_products

#: Of the mixtures one after the other, the tolerance relative to that of the plan, and the most
#: evaluations in those of the first emission. The latter are finer as differences are a part of
#: them only: for derivatives of a torus a quarter suffices with some views and a tenth with others,
#: and products take 1.2 and 1.8 times the evaluations.
_MIXTURES = ((1.0, 1.3), (0.25, 1.5), (0.1, 2.5))


@dataclass(frozen=True)
class Neighbourhood:
    """A plan for several emissions."""

    plan: Plan
    #: Whether it serves all of them; of a plan that can't be compared, whether it has converged.
    suffices: bool
    #: The rendering of the first emission.
    first: Rendering
    #: The renderings of all emissions by the plan, if it suffices and was compared with them.
    checks: list[Rendering] | None = None

    def compared(self, emissions: Sequence[Any]) -> list[Rendering | None]:
        """The renderings of all emissions by the plan; None where it can't be compared."""
        if self.checks is not None:
            return [*self.checks]
        return [compared(self.plan, emission) for emission in emissions]


def serves(plan: Plan, emissions: Iterable[Any]) -> bool:
    """Whether samples show that a plan serves all emissions to its tolerance.

    Only plans of products of functions are compared with samples; for others it is False.
    """
    return checks_of(plan, emissions) is not None


def checks_of(plan: Plan, emissions: Iterable[Any]) -> list[Rendering] | None:
    """The renderings of emissions by a plan; None if it is not found to serve one of them."""
    checks = []
    for emission in emissions:
        found = compared(plan, emission)
        if found is None or not found.converged:
            return None
        checks.append(found)
    return checks


def compared(plan: Plan, emission: Any) -> Rendering | None:
    """The rendering of an emission by a plan, which samples compare with it; None if they can't."""
    if not plan.is_of_products:
        return None
    try:
        return plan.render(emission)
    except SceneError:
        # The mesh has no products for some part of the view.
        return None


def plan_of_all(
    emissions: Sequence[Any],
    camera: Camera,
    shape: Sequence[int] | int,
    options: Mapping[str, Any],
    alone: Rendering,
) -> Neighbourhood:
    """A plan for the first of some emissions that serves all of them, as far as one is found.

    A plan that is not one of products is not compared: for the others it is as good as the same
    lines or cells are, and counts as one that serves them. `alone` is the rendering of the first
    emission.
    """
    plan = alone.plan
    if not (alone.converged and plan.is_of_products):
        return Neighbourhood(plan, alone.converged, alone)
    checks = checks_of(plan, emissions[1:])
    if checks is not None:
        return Neighbourhood(plan, True, alone, [alone, *checks])
    given = options.get("max_evaluations")
    plain, differences = _weights(len(emissions))
    for weights, (finer, most) in zip((plain, differences, differences), _MIXTURES, strict=True):
        changes = finer_tolerance(options, finer)
        limit = int(most * alone.evaluations)
        mixed = plan_of_products(
            partial(plan.rates_at, mixture(emissions, weights)),
            camera,
            shape,
            {**options, **changes, "max_evaluations": None},
            limit if given is None else min(limit, given),
        )
        if mixed is not None:
            of_mixture = plan.with_points_of(mixed)
            checks = checks_of(of_mixture, emissions)
            if checks is not None:
                return Neighbourhood(of_mixture, True, alone, checks)
    return Neighbourhood(plan, False, alone)


def rendering_of_one(
    emission: Any, camera: Camera, shape: Sequence[int] | int, options: Mapping[str, Any]
) -> Rendering:
    """The rendering of an emission that is to be differentiated: it has one rate at each point."""
    found: Any = render(emission, camera, shape, **options)
    if isinstance(found, Components):
        raise ValueError(
            f"the model has {len(found)} rates at each point: expected one, as derivatives are "
            "those of one image"
        )
    return found  # type: ignore[no-any-return]


def _weights(count: int) -> tuple[list[float], list[float]]:
    """Weights of mixtures, of different sizes and signs, so that no symmetry cancels.

    In the second, differences of a few per cent are larger than the tolerance.

    >>> [[round(weight, 6) for weight in weights] for weights in _weights(3)]
    [[1.0, 1.0, -0.6], [1.3, 3.0, -3.3]]
    """
    numbers = range(count - 1)
    plain = [(1.0, -0.6, 0.7, -0.8)[number % 4] * (1.0 + 0.1 * (number // 4)) for number in numbers]
    differences = [(-1.0) ** number * 3.0 * (1.0 + 0.1 * (number % 7)) for number in numbers]
    return [1.0, *plain], [1.0 - sum(differences), *differences]


def mixture(emissions: Sequence[Any], weights: Sequence[float]) -> Any:
    """The weighted sum of some emissions.

    >>> import numpy as np
    >>> mixture([np.ones_like, np.zeros_like], [2.0, 3.0])(np.ones(2))
    array([2., 2.])
    """

    def mixed(*arguments: Any) -> Any:
        return sum(
            weight * emission(*arguments)
            for weight, emission in zip(weights, emissions, strict=True)
        )

    return mixed


def neighbourhood(
    emission: Callable[[Floats], Any], theta: Floats, distances: Floats, bounds: Floats | None
) -> list[Any]:
    """The emissions at the centre of a neighbourhood, and at an end for each distance but 0.

    emission: the emission at some parameters; theta: the centre (p,); distances: (p,) to the ends.
    bounds: least and largest parameters (p, 2): an end beyond them is on the other side.
    """
    found = [emission(theta)]
    for number, distance in enumerate(distances):
        if distance == 0:
            continue
        moved = theta.copy()
        moved[number] += distance
        if bounds is not None and moved[number] > bounds[number, 1]:
            moved[number] = max(theta[number] - distance, bounds[number, 0])
        found.append(emission(moved))
    return found
