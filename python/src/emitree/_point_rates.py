"""The rates of a function at points, in batches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._function import Floats
from emitree._points import Points

if TYPE_CHECKING:
    from emitree._setup import Setup


def rates_at(emission: Any, points: Points, setup: Setup | None, unit: str | None) -> Floats:
    """The rates (n,) of a function at points, in a unit, as of a rendering with a setup.

    Raises `TypeError` if the emission is no function, `ValueError` if it does not return n numbers,
    and any exception of the function.
    """
    from emitree._evaluator import BATCH_SIZE
    from emitree._setup import function_of

    if isinstance(emission, str) or not callable(emission):
        raise TypeError(f"the emission is {emission!r}: expected a function")
    function = function_of(emission, setup, unit)
    rates = np.empty(len(points))
    for start in range(0, len(points), BATCH_SIZE):
        part = slice(start, start + BATCH_SIZE)
        energy = None if points.energy is None else points.energy[part]
        rates[part] = function(points.position[part], points.direction[part], energy)
    return rates
