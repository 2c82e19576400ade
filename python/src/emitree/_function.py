"""Functions as emissions: arrays in, rates out, whatever library made them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _units
from emitree._on_workers import OnWorkers

Floats = NDArray[np.float64]


class Function:
    """A function f(position, direction) or f(position, direction, energy), called with arrays.

    It gives n rates as 64-bit floats in `unit`, or (n, k) where it takes components. With
    `quantities` the function gets quantities in `length_unit` and `energy_unit`; else plain arrays.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        *,
        unit: str | None = None,
        length_unit: str | None = None,
        energy_unit: str | None = None,
        quantities: bool = False,
        takes_components: bool = False,
    ) -> None:
        self.function = function
        self.name = name_of(function)
        self.unit = unit
        self.takes_components = takes_components
        self.units = [length_unit, None, energy_unit] if quantities else [None] * 3

    def __call__(self, position: Floats, direction: Floats, energy: Floats | None) -> Floats:
        given = [values for values in (position, direction, energy) if values is not None]
        arguments = [
            values if unit is None else values << _units.to_astropy(unit)
            for values, unit in zip(given, self.units, strict=False)
        ]
        found = self.function(*arguments)
        return as_rates(found, len(position), self.unit, self.takes_components)


def name_of(function: Any) -> str:
    """What a function is called: module and qualified name; of other callables, those of the type.

    >>> name_of(np.linalg.norm), name_of(partial(name_of, 1))
    ('numpy.linalg.norm', 'partial of emitree._function.name_of')
    """
    if isinstance(function, partial):
        return f"partial of {name_of(function.func)}"
    if isinstance(function, OnWorkers):
        return f"on_workers of {name_of(function.factory)}"
    named = function if hasattr(function, "__qualname__") else type(function)
    module = getattr(named, "__module__", None) or "?"
    return f"{module}.{named.__qualname__}"


def _on_host(array: Any) -> Any:
    """An array of another library as one of NumPy: without a copy if it is in the memory of the
    host, by one if it is on another device. An array that is part of a gradient is left to its own
    conversion, which may raise an exception.
    """
    choices: tuple[dict[str, Any], ...] = ({}, {"device": "cpu", "copy": True})
    for options in choices:
        # TypeError: a library whose arrays have no copies by DLPack.
        with suppress(BufferError, RuntimeError, TypeError, ValueError):
            return np.from_dlpack(array, **options)
    return array


def as_rates(result: Any, count: int, unit: str | None, takes_components: bool = False) -> Floats:
    """What a function returned as `count` rates in `unit`, or as rows of k components.

    >>> as_rates([1, 2], 2, None)
    array([1., 2.])
    """
    if _units.is_quantity(result):
        if unit is None:
            raise ValueError(f"the rates have the unit {result.unit}: expected `unit` to be given")
        result = result.to_value(_units.to_astropy(unit))
    if isinstance(result, np.ma.MaskedArray) and np.ma.is_masked(result):
        raise ValueError("some rates are masked: expected a number for each point")
    if not isinstance(result, np.ndarray) and hasattr(result, "__dlpack__"):
        result = _on_host(result)
    rates = np.asarray(result)
    if rates.dtype.kind not in "fiub":
        raise TypeError(f"the rates are of type {rates.dtype}: expected real numbers")
    has_components = takes_components and rates.ndim == 2 and rates.shape[1] > 0
    if rates.shape[:1] != (count,) or (rates.ndim != 1 and not has_components):
        raise ValueError(f"the rates have the shape {rates.shape}: expected ({count},)")
    return np.ascontiguousarray(rates, dtype=np.float64)
