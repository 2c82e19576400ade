"""Plans for a neighbourhood of parameters: one set of points for the centre and the ends.

The functions that are found for one emission may not contain those of its derivatives: a product of
Gaussians has one point, and the image there does not depend on their widths. The plan of the centre
is therefore compared with samples of the emissions at the ends. If it does not suffice, the plan is
that of a mixture of all of them, with weights of both signs, and is compared with each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from emitree._cameras import Camera
from emitree._function import Floats
from emitree._native import SceneError
from emitree._plan import Plan
from emitree._render import render
from emitree._result import Rendering

#: Of the mixtures one after the other, the tolerance relative to that of the plan, and the most
#: evaluations in those of the first emission. Products of a mixture take about as many; image
#: trees, which serve no better than those of the first emission, more than twice as many. The last
#: one is finer, as differences are a part of it only.
_MIXTURES = ((1.0, 1.5), (0.25, 3.0))
#: The tolerance of `render` by default.
_TOLERANCE = 0.01


def serves(plan: Plan, emissions: Iterable[Any]) -> bool:
    """Whether samples show that a plan serves all emissions to its tolerance.

    Only plans of products of functions are compared with samples; for others it is False.
    """
    return plan.is_of_products and all(_served(plan, emission) for emission in emissions)


def _served(plan: Plan, emission: Any) -> bool:
    try:
        return plan.render(emission).converged
    except SceneError:
        # The mesh has no products for some part of the view.
        return False


def plan_of_all(
    emissions: Sequence[Any],
    camera: Camera,
    shape: Sequence[int] | int,
    options: Mapping[str, Any],
) -> tuple[Plan, bool, Rendering]:
    """A plan for the first of some emissions that serves all of them, as far as one is found.

    Returns the plan, whether it serves them, and the rendering of the first emission. A plan that
    is not one of products is not compared: for the others it is as good as the same lines or cells
    are, and counts as one that serves them.
    """
    alone = render(emissions[0], camera, shape, **options)
    plan = alone.plan
    if not (alone.converged and plan.is_of_products):
        return plan, alone.converged, alone
    if serves(plan, emissions[1:]):
        return plan, True, alone
    given = options.get("max_evaluations")
    for weights, (finer, most) in zip(_weights(len(emissions)), _MIXTURES, strict=True):
        limit = int(most * alone.evaluations)
        changes: dict[str, Any] = finer_tolerance(options, finer)
        changes["max_evaluations"] = limit if given is None else min(limit, given)
        mixed = render(mixture(emissions, weights), camera, shape, **{**options, **changes})
        if mixed.converged and mixed.surfaces is None:
            plan_of_mixture = mixed.plan.with_options({name: options.get(name) for name in changes})
            if serves(plan_of_mixture, emissions):
                return plan_of_mixture, True, alone
    return plan, False, alone


def finer_tolerance(options: Mapping[str, Any], finer: float) -> dict[str, float]:
    """A finer tolerance, if it is the error of the largest pixel."""
    if finer == 1.0 or any(options.get(name) is not None for name in ("rtol", "atol")):
        return {}
    tolerance = options.get("tolerance")
    return {"tolerance": finer * (_TOLERANCE if tolerance is None else tolerance)}


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
