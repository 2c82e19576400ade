"""What is called with each batch of points: a function, with workers and a cache."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _native, _options
from emitree._cache import Cache
from emitree._executor import Serial, Shared
from emitree._function import Floats, Function
from emitree._progress import Rising

#: The most points of one call of a function: few enough for their arrays to stay in a cache of the
#: processor, enough for the call to cost nothing.
BATCH_SIZE = 65536


def batch_size_of(given: int | None, function: Function | None) -> int | None:
    """The most points of a batch: those given, or by default those of a function."""
    given = _options.batch_size(given)
    return BATCH_SIZE if given is None and function is not None else given


@dataclass(frozen=True)
class Evaluator:
    """What is called with each batch, and what there is to report of it."""

    rates: Callable[..., Floats]
    shared: Shared | None
    cache: Cache | None

    @property
    def report(self) -> dict[str, Any]:
        """The tables `executor` and `cache` of a report, of those that were used."""
        tables = {"executor": self.shared, "cache": self.cache}
        return {name: of.report for name, of in tables.items() if of is not None}

    def progress(self, hook: Callable[[int], Any] | None) -> Callable[[int], Any] | None:
        """A hook that is called in the middle of batches too, where they are in parts."""
        if hook is None or self.shared is None:
            return hook
        self.shared.progress = Rising(hook)
        return self.shared.progress


def evaluator(
    stack: ExitStack,
    scene: _native.Scene,
    function: Function | None,
    executor: Any,
    cache: str | os.PathLike[str] | None,
) -> Evaluator | None:
    """What is called with each batch; None of an emission that is no function."""
    if function is None:
        for name, given in (("executor", executor), ("cache", cache)):
            if given is not None:
                raise TypeError(f"`{name}` is for functions: expected none with this emission")
        return None
    shared = None if executor is None else Shared(function, executor)
    evaluate = Serial(function) if shared is None else shared
    if cache is not None:
        energies = scene.energies
        units = {
            "length_unit": scene.length_unit,
            "unit": function.unit,
            "energy_unit": energies[1] if energies else None,
        }
        opened = stack.enter_context(Cache(cache, units, function.name))
        return Evaluator(lambda *batch: opened.rates(evaluate, *batch), shared, opened)
    if shared is None:
        return Evaluator(function, None, None)

    def in_parts(position: Floats, direction: Floats, energy: Floats | None) -> Floats:
        parts = list(evaluate.parts(position, direction, energy))
        rates = np.empty((len(position), *parts[0][1].shape[1:]))
        for part, of_part in parts:
            rates[part] = of_part
        return rates

    return Evaluator(in_parts, shared, None)
