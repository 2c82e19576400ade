"""The search for a plan of products, which ends where it takes too many evaluations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from emitree._cameras import Camera
from emitree._function import Floats
from emitree._plan import Plan
from emitree._points import Points
from emitree._session import SESSION_OPTIONS, Session

#: The tolerance of `render` by default.
_TOLERANCE = 0.01


def plan_of_products(
    rates: Callable[[Points], Floats],
    camera: Camera,
    shape: Sequence[int] | int,
    options: Mapping[str, Any],
    most: int,
) -> Plan | None:
    """The plan of products of an emission; None if there is none or it takes too many evaluations.

    A budget of the rendering, `max_evaluations`, would leave a quarter of it to the search for
    products, and the rest to image trees, which serve no other emission.

    rates: the rates (n,) of the emission at points.
    camera, shape, options: as of `render`.
    most: the most evaluations, exceeded by a batch at most.
    """
    known = {name: value for name, value in options.items() if name in SESSION_OPTIONS}
    session = Session(camera, shape, **known)
    evaluations = 0
    while points := session.ask():
        evaluations += len(points)
        if evaluations > most:
            return None
        session.tell(rates(points))
    found = session.rendering()
    if found is None or not found.converged or found.surfaces is not None:
        return None
    plan = session.mesh()
    return plan if plan.is_of_products else None


def finer_tolerance(options: Mapping[str, Any], finer: float) -> dict[str, float]:
    """A finer tolerance, if it is the error of the largest pixel.

    >>> finer_tolerance({"tolerance": 0.02}, 0.25), finer_tolerance({"rtol": 0.02}, 0.25)
    ({'tolerance': 0.005}, {})
    """
    if finer == 1.0 or any(options.get(name) is not None for name in ("rtol", "atol")):
        return {}
    tolerance = options.get("tolerance")
    return {"tolerance": finer * (_TOLERANCE if tolerance is None else tolerance)}
