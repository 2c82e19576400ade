"""Several fields, such as a density and a temperature, and one formula of them as an emission."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from emitree import _native, _units
from emitree._amr import AmrGrid
from emitree._axes import is_data_array
from emitree._cameras import Box, Sphere
from emitree._function import Floats, as_rates
from emitree._grid import Grid
from emitree._grid_function import GridFunction
from emitree._native import SceneError
from emitree._table import Table


class Fields:
    """Several fields and one formula of them as an emission: a function of positions.

    fields: the fields by the names that the formula has for them, each an `emitree.Grid`, a
        DataArray of xarray, an `AmrGrid`, what `from_pyvista` returns, `Particles`, or a function
        f(position) of positions (n, 3) that gives n numbers. There may be none.
    expression: the rate as a formula of the fields, of x, y, z, r, dx, dy, dz and E, of
        `constants`, and of `tables`, which are functions: see `emitree.Expression`.
    constants: the numbers that names stand for; tables: an `emitree.Table` by its name.
    units: for fields that are quantities, the units by their names in which the formula has them;
        by default their own.

    Each field is interpolated at the point as by itself. Outside of a `Grid` (unless its `outside`
    is "error"), of an `AmrGrid` and of a mesh the rate is 0, whatever the formula is: the data end
    there. Particles are 0 outside of all kernels, and functions what they are: a formula that
    divides by them may need `if(n > 0, ..., 0)`.

    >>> import emitree, numpy as np
    >>> axes = {"x": (-1, 1), "y": (-1, 1), "z": (-1, 1)}
    >>> n = emitree.Grid(values=np.full((3, 3, 3), 2.0), **axes)
    >>> cooling = emitree.Table([1.0, 3.0], {"T": [0.0, 1.0]})
    >>> glow = emitree.Fields(
    ...     {"n": n, "T": lambda position: position[:, 0] ** 2}, "n^2 * Lambda(T)",
    ...     tables={"Lambda": cooling},
    ... )
    >>> glow(np.array([[0.0, 0.5, 0.0], [0.5, 0, 0], [2, 0, 0]]))
    array([4., 6., 0.])
    >>> camera = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), extent=(1, 1))
    >>> image = emitree.render(glow, camera, (2, 2), tolerance=0.01).image
    >>> bool(abs(image - 4 * (2 + 2 * 2 / 3)).max() < 0.2)
    True
    """

    def __init__(
        self,
        fields: Mapping[str, Any],
        expression: str,
        constants: Mapping[str, float] | None = None,
        tables: Mapping[str, Table] | None = None,
        *,
        units: Mapping[str, Any] | None = None,
    ) -> None:
        if not isinstance(fields, Mapping):
            raise SceneError(
                f"`fields` is {type(fields).__name__}: expected a dictionary of fields by name"
            )
        self.expression = expression
        self.constants = {name: float(value) for name, value in (constants or {}).items()}
        self.tables = dict(tables or {})
        for name, table in self.tables.items():
            if not isinstance(table, Table):
                raise SceneError(
                    f"the table `{name}` is {type(table).__name__}: expected emitree.Table"
                )
        given = dict(units or {})
        for name in given:
            if name not in fields:
                expected = ", ".join(fields)
                raise SceneError(f"`units` has {name!r}: expected fields, {expected}")
        #: The unit of positions, a text; None for that of the camera.
        self.length_unit: str | None = None
        self._fields = {
            name: _field(name, field, _units.to_text(given.get(name)))
            for name, field in fields.items()
        }
        # What is wrong with the formula is said at once.
        self._parsed(self.constants, ())

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the fields."""
        return tuple(self._fields)

    @property
    def bounds(self) -> Box | Sphere | None:
        """What contains all points with a rate, of the first field that ends somewhere."""
        found = (field.bounds for field in self._fields.values())
        return next((bounds for bounds in found if bounds is not None), None)

    @property
    def edges(self) -> list[Sphere]:
        """Spheres within the bounds at which the data begin."""
        return [edge for field in self._fields.values() for edge in field.edges]

    def in_length_unit(self, unit: str | None) -> Fields:
        """The same fields as functions of positions in another unit."""
        if unit is None or self.length_unit == unit:
            return self
        other = copy.copy(self)
        other.length_unit = unit
        other._fields = {name: field.in_length_unit(unit) for name, field in self._fields.items()}
        return other

    def values(self, position: Any) -> dict[str, Floats]:
        """The values (n,) of each field at positions (n, 3); NaN outside of it."""
        positions = _positions(position)
        found = {}
        for name, field in self._fields.items():
            values, is_inside = field.at(positions)
            found[name] = values if is_inside is None else np.where(is_inside, values, np.nan)
        return found

    def model(self, names: Sequence[str] | None = None) -> FieldsModel:
        """The model whose parameters are some of the constants; by default all, in their order.

        It is a model for `jacobian`, `Forward` and `sweep`, with exact derivatives.
        """
        return FieldsModel(self, tuple(self.constants if names is None else names))

    def __call__(self, position: Any, direction: Any = None, energy: Any = None) -> Floats:
        """The rates (n,) at positions and directions (n, 3) and, of cubes, energies (n,)."""
        return self._evaluated(self._parsed(self.constants, ()), position, direction, energy)[0]

    def __repr__(self) -> str:
        return f"<emitree.Fields of {', '.join(self._fields)}: {self.expression!r}>"

    def _parsed(self, constants: Mapping[str, float], by: Sequence[str]) -> _native.Expression:
        tables = [(name, table._native) for name, table in self.tables.items()]
        return _native.Expression(
            self.expression, dict(constants), list(by), list(self._fields), tables
        )

    def _evaluated(
        self, parsed: _native.Expression, position: Any, direction: Any, energy: Any
    ) -> tuple[Floats, Floats]:
        """Rates (n,) and derivatives (n, p)."""
        positions = _positions(position)
        if direction is None:
            # Only formulas of dx, dy and dz depend on it.
            directions = np.zeros_like(positions)
        else:
            directions = np.asarray(direction, dtype=np.float64)
        energies = None if energy is None else np.asarray(energy, dtype=np.float64)
        columns, inside = [], np.ones(len(positions), dtype=bool)
        for field in self._fields.values():
            values, is_inside = field.at(positions)
            columns.append(values)
            if is_inside is not None:
                inside &= is_inside
        if inside.all():
            return parsed.rates_and_derivatives(positions, directions, energies, columns)
        # The formula is not evaluated where the data end.
        energies = None if energies is None else energies[inside]
        some, slopes = parsed.rates_and_derivatives(
            positions[inside], directions[inside], energies, [of[inside] for of in columns]
        )
        rates = np.zeros(len(positions))
        derivatives = np.zeros((len(positions), slopes.shape[1]))
        rates[inside], derivatives[inside] = some, slopes
        return rates, derivatives


class FieldsModel:
    """`Fields` as a model of some of its constants: see `Fields.model`."""

    def __init__(self, fields: Fields, names: tuple[str, ...]) -> None:
        self.fields = fields
        #: The constants that are the parameters.
        self.names = names
        fields._parsed(fields.constants, names)

    @property
    def theta(self) -> tuple[float, ...]:
        """The parameters of the fields themselves."""
        return tuple(self.fields.constants[name] for name in self.names)

    def __call__(self, *theta: float) -> Fields:
        """The emission."""
        other = copy.copy(self.fields)
        other.constants = self._constants(theta)
        return other

    def derivative(self, *theta: float) -> Callable[..., Floats]:
        """The derivatives of the rates, a function of the same that gives (n, p)."""
        parsed = self.fields._parsed(self._constants(theta), self.names)

        def derivatives(position: Any, direction: Any, energy: Any = None) -> Floats:
            return self.fields._evaluated(parsed, position, direction, energy)[1]

        return derivatives

    def _constants(self, theta: Sequence[float]) -> dict[str, float]:
        if len(theta) > len(self.names):
            raise TypeError(f"there are {len(theta)} parameters: expected {', '.join(self.names)}")
        values = zip(self.names, map(float, theta), strict=False)
        return self.fields.constants | dict(values)


class _Field(Protocol):
    """A field as `Fields` has it."""

    @property
    def bounds(self) -> Box | Sphere | None: ...

    @property
    def edges(self) -> list[Sphere]: ...

    def in_length_unit(self, unit: str) -> _Field: ...

    def at(self, position: Floats) -> tuple[Floats, Any]:
        """Values (n,), and whether points are inside; None if all are."""


def _field(name: str, field: Any, unit: str | None) -> _Field:
    if is_data_array(field):
        field = Grid(values=field)
    if isinstance(field, Grid):
        return _GridField(GridFunction(field, f"the field `{name}`", unit))
    if callable(field):
        return _FunctionField(name, field, unit)
    raise SceneError(
        f"the field `{name}` is {type(field).__name__}: expected an emitree.Grid or AmrGrid, an "
        "xarray.DataArray, or a function f(position)"
    )


class _GridField:
    """A grid, which a scene reads and interpolates."""

    def __init__(self, values: GridFunction) -> None:
        self.values = values

    def in_length_unit(self, unit: str) -> _GridField:
        return _GridField(self.values.in_length_unit(unit))

    @property
    def bounds(self) -> Box | Sphere | None:
        if self.values.grid.outside == "error":
            return None
        kind, ranges = self.values.scene.grid_ranges()
        (first, second, third) = ranges
        if kind == "spherical":
            return Sphere(center=(0.0, 0.0, 0.0), radius=first[1])
        if kind == "cylindrical":
            first = second = [-first[1], first[1]]
        low, high = zip(first, second, third, strict=True)
        return Box(min=low, max=high)

    @property
    def edges(self) -> list[Sphere]:
        kind, ranges = self.values.scene.grid_ranges()
        least = ranges[0][0]
        if kind != "spherical" or self.values.grid.outside == "error" or least <= 0.0:
            return []
        return [Sphere(center=(0.0, 0.0, 0.0), radius=least)]

    def at(self, position: Floats) -> tuple[Floats, Any]:
        values = self.values.values(position)
        is_inside = ~np.isnan(values)
        return (values, None) if is_inside.all() else (values, is_inside)


class _FunctionField:
    """A function of positions, such as an AMR grid."""

    def __init__(self, name: str, function: Callable[..., Any], unit: str | None) -> None:
        self.name, self.function, self.unit = name, function, unit

    def in_length_unit(self, unit: str) -> _FunctionField:
        if not isinstance(self.function, AmrGrid):
            return self
        return _FunctionField(self.name, self.function.in_length_unit(unit), self.unit)

    @property
    def bounds(self) -> Box | Sphere | None:
        has_end = hasattr(self.function, "is_inside")
        found = getattr(self.function, "bounds", None) if has_end else None
        return found if isinstance(found, Box | Sphere) else None

    @property
    def edges(self) -> list[Sphere]:
        return []

    def at(self, position: Floats) -> tuple[Floats, Any]:
        found = self.function(position)
        if _units.is_quantity(found):
            found = (
                found.value if self.unit is None else _units.value_in(found, self.unit, self.name)
            )
        try:
            values = as_rates(found, len(position), None)
        except (TypeError, ValueError) as error:
            message = str(error).replace("the rates", "the values")
            raise type(error)(f"the field `{self.name}`: {message}") from None
        is_inside = getattr(self.function, "is_inside", None)
        return values, None if is_inside is None else is_inside(position)


def _positions(position: Any) -> Floats:
    if _units.is_quantity(position):
        raise TypeError("the positions are a quantity: expected numbers")
    return np.ascontiguousarray(position, dtype=np.float64)
