"""Emissions other than a function: the table `[emission]` of a scene."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _native


@dataclass(frozen=True)
class Expression:
    """An emission rate as a formula of x, y, z, r, the emission direction dx, dy, dz, and E; of the
    time t, in seconds, instead of E with an `exposure`.

    text: the formula; constants: the numbers that its names stand for.

    >>> import emitree
    >>> emitree.Expression("exp(-a * r^2)", constants={"a": 2.0}).table()
    {'expression': 'exp(-a * r^2)', 'constants': {'a': 2.0}}
    """

    text: str
    constants: Mapping[str, float] = field(default_factory=dict)

    def table(self) -> dict[str, Any]:
        """The keys of a scene."""
        table: dict[str, Any] = {"expression": self.text}
        if self.constants:
            table["constants"] = {name: float(value) for name, value in self.constants.items()}
        return table

    def model(self, names: Sequence[str] | None = None) -> ExpressionModel:
        """The model whose parameters are some of the constants; by default all, in their order.

        It is a model for `jacobian`, `Forward` and `sweep`, with exact derivatives.

        Raises `SceneError` if a name is not one of the constants, or if the formula is wrong.

        >>> import emitree, numpy as np
        >>> model = emitree.Expression("h * exp(-a * x^2)", {"a": 2.0, "h": 1.0}).model(["h"])
        >>> model(3.0)(np.zeros((1, 3)), np.zeros((1, 3)))
        array([3.])
        """
        return ExpressionModel(self, tuple(self.constants if names is None else names))


class ExpressionModel:
    """A formula as a model of some of its constants: see `Expression.model`."""

    def __init__(self, expression: Expression, names: tuple[str, ...]) -> None:
        self.expression = expression
        #: The constants that are the parameters.
        self.names = names
        self._native({})

    @property
    def theta(self) -> tuple[float, ...]:
        """The parameters of the expression itself."""
        return tuple(float(self.expression.constants[name]) for name in self.names)

    def __call__(self, *theta: float, **named: float) -> Callable[..., NDArray[np.float64]]:
        """The emission: a function of (position, direction[, energy])."""
        native = self._native(self._values(theta, named), ())

        def rates(position: Any, direction: Any, energy: Any = None) -> NDArray[np.float64]:
            return native.rates_and_derivatives(*_arrays(position, direction, energy))[0]

        return rates

    def derivative(self, *theta: float, **named: float) -> Callable[..., NDArray[np.float64]]:
        """The derivatives of the rates, a function of the same that gives (n, p).

        They are exact but for rounding. At a kink (`abs`, `min`, `max`, `if`) they are those of one
        side; `floor` and comparisons have the derivative 0, also where they jump.
        """
        native = self._native(self._values(theta, named))

        def derivatives(position: Any, direction: Any, energy: Any = None) -> NDArray[np.float64]:
            return native.rates_and_derivatives(*_arrays(position, direction, energy))[1]

        return derivatives

    def _values(self, theta: Sequence[float], named: Mapping[str, float]) -> dict[str, float]:
        if len(theta) + len(named) > len(self.names) or not set(named) <= set(self.names):
            given = [*map(str, theta), *named]
            raise TypeError(f"the parameters are {given}: expected {', '.join(self.names)}")
        return dict(zip(self.names, theta, strict=False)) | dict(named)

    def _native(
        self, values: Mapping[str, float], by: Sequence[str] | None = None
    ) -> _native.Expression:
        constants = {**self.expression.constants, **values}
        numbers = {name: float(value) for name, value in constants.items()}
        names = [*(self.names if by is None else by)]
        return _native.Expression(self.expression.text, numbers, names)


def _arrays(*arrays: Any) -> list[Any]:
    return [None if array is None else np.asarray(array, dtype=np.float64) for array in arrays]


class Model:
    """A published model by its name, with its parameters: `emitree models` lists them.

    >>> import emitree
    >>> emitree.Model("cmem", density=5.0)
    Model('cmem', density=5.0)
    """

    def __init__(self, name: str, **parameters: float) -> None:
        self.name = name
        self.parameters = parameters

    def table(self) -> dict[str, Any]:
        """The keys of a scene."""
        table: dict[str, Any] = {"model": self.name}
        if self.parameters:
            table["parameters"] = {name: float(v) for name, v in self.parameters.items()}
        return table

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Model):
            return NotImplemented
        return (self.name, self.parameters) == (other.name, other.parameters)

    def __hash__(self) -> int:
        return hash((self.name, tuple(sorted(self.parameters.items()))))

    def __repr__(self) -> str:
        given = "".join(f", {name}={value!r}" for name, value in self.parameters.items())
        return f"Model({self.name!r}{given})"


@dataclass(frozen=True)
class Tree:
    """A tree that `emitree.build_tree` or `emitree build` saved: the same rates in all directions.

    path: the file; report: what it took to build, if it was built here.
    """

    path: str | os.PathLike[str]
    report: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    def table(self) -> dict[str, Any]:
        """The keys of a scene."""
        return {"tree": str(Path(self.path).absolute())}
