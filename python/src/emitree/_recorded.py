"""An emission whose rates are kept: a point is evaluated once, whatever renders it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._components import keys_of
from emitree._executor import Serial, Shared
from emitree._function import Floats, Function
from emitree._points import Points

if TYPE_CHECKING:
    from emitree._result import Rendering


class Recorded:
    """A function with the rates of all points at which it was evaluated.

    executor: whose workers evaluate it, as of `render`; None for this thread.
    """

    def __init__(self, function: Function, executor: Any = None) -> None:
        self._evaluator: Serial | Shared = (
            Serial(function) if executor is None else Shared(function, executor)
        )
        self._known: dict[bytes, float] = {}
        self._assumed: dict[bytes, float] = {}
        #: What renderings take as their emission.
        self.emission = self._as_emission(function.function)

    @property
    def evaluations(self) -> int:
        """At how many points the function was evaluated."""
        return len(self._known)

    def rates(self, points: Points) -> Floats:
        """The rates (n,), of points that are not known from the function."""
        return self._rates(points, {})

    def rendered(self, render: Callable[[Any, Any], Rendering]) -> Rendering:
        """Its rendering by a function of an emission and an executor."""
        return render(self.emission, None)

    @contextmanager
    def assuming(self, points: Points, rates: Floats) -> Iterator[None]:
        """For a time, the emission has these rates at points where it was not evaluated."""
        keys = keys_of(points.position, points.direction, points.energy)
        self._assumed = dict(zip(keys, rates.tolist(), strict=True))
        try:
            yield
        finally:
            self._assumed = {}

    def _rates(self, points: Points, assumed: dict[bytes, float]) -> Floats:
        keys = keys_of(points.position, points.direction, points.energy)
        new = {key: i for i, key in enumerate(keys) if key not in self._known}
        new = {key: number for key, number in new.items() if key not in assumed}
        if new:
            numbers = list(new.values())
            energy = None if points.energy is None else points.energy[numbers]
            found = np.empty(len(numbers))
            arguments = (points.position[numbers], points.direction[numbers], energy)
            for part, rates in self._evaluator.parts(*arguments):
                found[part] = rates
            self._known.update(zip(new, found.tolist(), strict=True))
        both = (self._known[key] if key in self._known else assumed[key] for key in keys)
        return np.fromiter(both, np.float64, len(keys))

    def _as_emission(self, function: Callable[..., Any]) -> Callable[..., Floats]:
        def emission(position: Floats, direction: Floats, energy: Floats | None = None) -> Floats:
            return self._rates(Points(position, direction, energy), self._assumed)

        return _named_as(function, emission)


class Passed:
    """An emission of any kind, whose evaluations are counted.

    executor: as of `render`.
    """

    def __init__(self, emission: Any, executor: Any) -> None:
        self._emission = emission
        self._executor = executor
        #: How often it was evaluated.
        self.evaluations = 0

    def rendered(self, render: Callable[[Any, Any], Rendering]) -> Rendering:
        """Its rendering by a function of an emission and an executor."""
        found = render(self._emission, self._executor)
        self.evaluations += found.evaluations
        return found


def _named_as(function: Callable[..., Any], other: Callable[..., Floats]) -> Callable[..., Floats]:
    """Another function with the name of a function, for messages."""
    return wraps(function)(other) if hasattr(function, "__qualname__") else other
