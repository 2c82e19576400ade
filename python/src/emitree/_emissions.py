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


class ExactModel:
    """A model of some named parameters, whose derivatives are exact but for rounding.

    names: the parameters, in the order of theta.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        #: The names of the parameters.
        self.names = names
        self._native({})

    def _native(
        self, values: Mapping[str, float], by: Sequence[str] | None = None
    ) -> _native.Expression | _native.Model:
        """The emission with other values of parameters, to be differentiated by `by` or by all."""
        raise NotImplementedError

    def __call__(self, *theta: float, **named: float) -> Callable[..., NDArray[np.float64]]:
        """The emission: a function of (position, direction[, energy])."""
        return ExactRates(self, self._native(self._values(theta, named), ()))

    def in_length_unit(self, unit: str | None) -> Any:
        """The model as a function of positions in a unit: of a formula in any."""
        return self

    def derivative(self, *theta: float, **named: float) -> Callable[..., NDArray[np.float64]]:
        """The derivatives of the rates, a function of the same that gives (n, p).

        They are exact but for rounding. At a kink or a jump they are those of one side, also where
        it moves with a parameter.
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


class ExactRates:
    """The rates of a model with values of its parameters: a function."""

    def __init__(self, model: ExactModel, native: _native.Expression | _native.Model) -> None:
        self.model, self.native = model, native

    def __call__(self, position: Any, direction: Any, energy: Any = None) -> NDArray[np.float64]:
        """The rates (n,) at positions and directions (n, 3) and, of cubes, energies (n,)."""
        return self.native.rates_and_derivatives(*_arrays(position, direction, energy))[0]

    def in_length_unit(self, unit: str | None) -> ExactRates:
        """The same as a function of positions in a unit, which a published model may refuse."""
        self.model.in_length_unit(unit)
        return self


class ExpressionModel(ExactModel):
    """A formula as a model of some of its constants: see `Expression.model`."""

    def __init__(self, expression: Expression, names: tuple[str, ...]) -> None:
        self.expression = expression
        super().__init__(names)

    @property
    def theta(self) -> tuple[float, ...]:
        """The parameters of the expression itself."""
        return tuple(float(self.expression.constants[name]) for name in self.names)

    def _native(
        self, values: Mapping[str, float], by: Sequence[str] | None = None
    ) -> _native.Expression:
        numbers = _numbers({**self.expression.constants, **values})
        names = [*(self.names if by is None else by)]
        return _native.Expression(self.expression.text, numbers, names)


def _numbers(values: Mapping[str, float]) -> dict[str, float]:
    return {name: float(value) for name, value in values.items()}


def _arrays(*arrays: Any) -> list[Any]:
    return [None if array is None else np.asarray(array, dtype=np.float64) for array in arrays]


class Model:
    """A published model by its name, with its parameters: `emitree models` lists them.

    It can be called, with positions in the length unit of the model, as a function of
    (position, direction[, energy]): wherever functions are taken, so are models.

    >>> import emitree
    >>> emitree.Model("cmem", density=5.0)
    Model('cmem', density=5.0)
    >>> emitree.Model("power_law", exponent=3)(np.array([[0.0, 2.0, 0.0]]), np.zeros((1, 3)))
    array([0.125])
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

    @property
    def length_unit(self) -> str | None:
        """The unit of positions, a text; None if the model has none."""
        unit = self._native(()).length_unit
        return None if unit == "1" else unit

    def model(self, names: Sequence[str] | None = None) -> PublishedModel:
        """The model whose parameters are some of its own; by default those given, in their order.

        It is a model for `jacobian`, `Forward` and `sweep`, with exact derivatives. Defaults that
        follow from a parameter change with it.

        Raises `SceneError` if there is no such model or parameter, or if a value is refused.

        >>> import emitree
        >>> wind = emitree.Model("power_law", amplitude=2.0).model(["amplitude", "exponent"])
        >>> wind.theta
        (2.0, 2.0)
        >>> wind.derivative(2.0, 1.0)(np.array([[4.0, 0.0, 0.0]]), np.zeros((1, 3))).round(3)
        array([[ 0.25 , -0.693]])
        """
        return PublishedModel(self, tuple(self.parameters if names is None else names))

    def __call__(self, position: Any, direction: Any, energy: Any = None) -> NDArray[np.float64]:
        """The rates (n,) at positions and directions (n, 3) and, of cubes, energies (n,)."""
        arrays = _arrays(position, direction, energy)
        return self._native(()).rates_and_derivatives(*arrays)[0]

    def in_length_unit(self, unit: str | None) -> Model:
        """The model as a function of positions in a unit, which has to be its own, or none."""
        own = self.length_unit
        if unit is not None and own is not None and unit != own:
            raise _native.SceneError(
                f"the length unit of the camera is `{unit}`, and that of the model `{self.name}` "
                f"is `{own}`: expected the same where the model is a function, or none"
            )
        return self

    def _native(self, by: Sequence[str]) -> _native.Model:
        return _native.Model(self.name, _numbers(self.parameters), list(by))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Model):
            return NotImplemented
        return (self.name, self.parameters) == (other.name, other.parameters)

    def __hash__(self) -> int:
        return hash((self.name, tuple(sorted(self.parameters.items()))))

    def __repr__(self) -> str:
        given = "".join(f", {name}={value!r}" for name, value in self.parameters.items())
        return f"Model({self.name!r}{given})"


class PublishedModel(ExactModel):
    """A published model as a model of some of its parameters: see `Model.model`."""

    def __init__(self, published: Model, names: tuple[str, ...]) -> None:
        self.published = published
        super().__init__(names)

    @property
    def theta(self) -> tuple[float, ...]:
        """The parameters of the model itself, given or not."""
        values = dict(self._native({}, ()).parameters)
        return tuple(values[name] for name in self.names)

    @property
    def moves_jumps(self) -> tuple[str, ...]:
        """The parameters with which a surface moves at which the rate may jump.

        The derivative of an image by such a parameter has a part that `derivative` does not have:
        the jump times the speed of the surface.
        """
        return tuple(self._native({}).moves_jumps)

    def in_length_unit(self, unit: str | None) -> PublishedModel:
        """The model as a function of positions in a unit, which has to be its own, or none."""
        self.published.in_length_unit(unit)
        return self

    def _native(
        self, values: Mapping[str, float], by: Sequence[str] | None = None
    ) -> _native.Model:
        published = Model(self.published.name, **{**self.published.parameters, **values})
        return published._native(self.names if by is None else by)


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
