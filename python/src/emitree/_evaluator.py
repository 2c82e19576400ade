"""What is called with each batch of points: a function, with workers and a cache."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import numpy as np

from emitree import _executor, _native, _options
from emitree._cache import Cache
from emitree._executor import Serial, Shared
from emitree._function import Floats, Function

#: The most points of one call of a function: few enough for their arrays to stay in a cache of the
#: processor, enough for the call to cost nothing.
BATCH_SIZE = 65536


def batch_size_of(given: int | None, function: Function | None) -> int | None:
    """The most points of a batch: those given, or by default those of a function."""
    given = _options.batch_size(given)
    return BATCH_SIZE if given is None and function is not None else given


def evaluator(
    stack: ExitStack,
    scene: _native.Scene,
    function: Function | None,
    executor: Any,
    cache: str | os.PathLike[str] | None,
) -> tuple[Callable[..., Floats] | None, Cache | None]:
    """What is called with each batch."""
    if function is None:
        for name, given in (("executor", executor), ("cache", cache)):
            if given is not None:
                raise TypeError(f"`{name}` is for functions: expected none with this emission")
        return None, None
    evaluate: Serial | Shared = Serial(function)
    if executor is not None:
        evaluate = Shared(function, _executor.checked(executor))
    if cache is not None:
        energies = scene.energies
        units = {
            "length_unit": scene.length_unit,
            "unit": function.unit,
            "energy_unit": energies[1] if energies else None,
        }
        opened = stack.enter_context(Cache(cache, units, function.name))
        return (lambda *batch: opened.rates(evaluate, *batch)), opened
    if executor is None:
        return function, None

    def shared(position: Floats, direction: Floats, energy: Floats | None) -> Floats:
        parts = list(evaluate.parts(position, direction, energy))
        rates = np.empty((len(position), *parts[0][1].shape[1:]))
        for part, of_part in parts:
            rates[part] = of_part
        return rates

    return shared, None
