"""Models whose evaluations are counted."""

from __future__ import annotations

from functools import wraps
from typing import Any, Protocol

from emitree._jacobian import ModelOf


class Counter(Protocol):
    """What has a number of evaluations."""

    evaluations: int


class Counting:
    """A model that adds its evaluations to those of a counter, such as a `Forward`."""

    def __init__(self, counter: Counter, model: ModelOf) -> None:
        self.counter = counter
        self.model = model
        derivative = getattr(model, "derivative", None)
        if callable(derivative):
            #: The exact derivatives of a model that has some, counted too.
            self.derivative = Counting(counter, derivative)
        #: Parameters of a published model with which surfaces move: see `PublishedModel`.
        if hasattr(model, "moves_jumps"):
            self.moves_jumps = model.moves_jumps
        #: The names of parameters, if the model has some.
        self.names = getattr(model, "names", ())

    def __call__(self, *theta: Any) -> Any:
        emission = self.model(*theta)
        if isinstance(emission, str) or not callable(emission):
            return emission

        @wraps(emission)
        def counted(position: Any, *others: Any) -> Any:
            self.counter.evaluations += len(position)
            return emission(position, *others)

        return counted
