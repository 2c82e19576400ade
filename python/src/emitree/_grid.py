"""Data on a grid, from arrays or from a file: the table `[emission.grid]` of a scene."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _native, _units
from emitree._axes import (
    COORDINATES,
    Nodes,
    as_in_scenes,
    coordinates_of,
    given_nodes,
    in_one_unit,
    is_data_array,
    of_data_array,
)
from emitree._function import Floats
from emitree._native import SceneError
from emitree._real import real

if TYPE_CHECKING:
    from emitree._grid_function import GridFunction

#: Keys of the scene that are taken as they are.
_PLAIN = ("interpolation", "outside")
#: And those that only files need.
_OF_FILES = ("order", "format", "scale", "step")

#: Pairs: the name of a temporary file, and what it is called in messages and reports.
Aliases = list[tuple[str, str]]


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Emission rates at the nodes of a grid, from an array or from a file.

    values: an array of rates with the axes in the order of the coordinates, or an astropy quantity;
        or an xarray DataArray with dimensions of these names in any order, whose coordinates are
        the nodes unless keywords say otherwise (lat, latitude, lon, longitude, radius and
        colatitude are names too); or a Dataset, of which `variable` chooses an array.
    file: the name of a file (.npy, .npz, .fits, .h5, .nc, .vtk, .vti, .vtr), whose own axes are
        kept unless keywords say otherwise; variable: which of its arrays has the rates.
    coordinates: "cartesian" (x, y, z), "cylindrical" (rho, phi, z) or "spherical" (r, theta, phi);
        of arrays, those of the axes that are given.
    x, y, z, rho, r, theta, phi: the nodes of the axes, lengths in the length unit of the camera and
        angles in `angle_unit`: an array of numbers that all increase or all decrease, or
        (first, last) of equally spaced ones; of a file also the name of an array in it. theta is
        the colatitude, from the z axis; latitude, from the plane of x and y, may be given instead.
        phi that goes all round is closed.
    angle_unit: "deg" or "rad", where neither quantities nor attributes of coordinates have it.
    logarithmic: the names of axes that are interpolated in the logarithm of their coordinate.
    interpolation: "linear", "cubic", "monotone" or "nearest"; outside: "zero" or "error".
    order: of the axes in a file, as in "zyx" or "phi theta r"; format: of a file with another
        ending; scale: what its rates are multiplied with; step: which step of values with a fourth
        axis, such as time: its number, -1 being the last, or {"value": 12.5}, the step whose
        coordinate is nearest, with the name of the array of coordinates as "axis" if the
        dimensions have no names. (`isel` and `sel` choose a step of a DataArray.)

    It can be called as a function of (position, direction), with positions in the length unit of
    the nodes: wherever functions are taken, so are grids.

    >>> import emitree, numpy as np
    >>> ramp = np.arange(3.0)[:, None, None] + np.zeros((3, 2, 2))
    >>> grid = emitree.Grid(values=ramp, x=(0, 1), y=(0, 1), z=(0, 1))
    >>> emitree.render(grid, emitree.Canonical(), (1, 2)).image
    array([[0.5, 1.5]])
    >>> grid(np.array([[0.25, 0.5, 0.5], [0.25, 0.5, 2.0]]))
    array([0.5, 0. ])
    """

    values: Any = None
    file: str | os.PathLike[str] | None = None
    variable: str | None = None
    coordinates: str | None = None
    x: Any = None
    y: Any = None
    z: Any = None
    rho: Any = None
    r: Any = None
    theta: Any = None
    latitude: Any = None
    phi: Any = None
    angle_unit: str | None = None
    logarithmic: str | Iterable[str] | None = None
    interpolation: str | None = None
    outside: str | None = None
    order: str | None = None
    format: str | None = None
    scale: float | None = None
    step: int | Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        if (self.values is None) == (self.file is None):
            raise SceneError("expected one of `values`, an array, and `file`, the name of a file")
        if self.theta is not None and self.latitude is not None:
            raise SceneError("expected one of `theta` and `latitude`")
        if self.coordinates is not None and self.coordinates not in COORDINATES:
            kinds = ", ".join(map(repr, COORDINATES))
            raise SceneError(f"`coordinates` is {self.coordinates!r}: expected one of {kinds}")
        if self._file is None:
            for name in _OF_FILES:
                if getattr(self, name) is not None:
                    raise SceneError(f"`{name}` is for files: expected none with an array")
            if self.variable is not None and not _is_dataset(self.values):
                raise SceneError(
                    "`variable` is for files and Datasets: expected none with an array"
                )

    @property
    def _file(self) -> str | os.PathLike[str] | None:
        # Files were given as `values` before there was `file`.
        return self.values if isinstance(self.values, str | os.PathLike) else self.file

    @cached_property
    def _function(self) -> GridFunction:
        from emitree._grid_function import GridFunction

        return GridFunction(self, "the grid")

    def __call__(self, position: Any, direction: Any = None, energy: Any = None) -> Floats:
        """The rates (n,) at positions (n, 3): 0 outside, and the same in all directions."""
        return self._function(position)

    def in_length_unit(self, unit: str | None) -> GridFunction:
        """The grid as a function of positions in a unit, which nodes that are quantities need."""
        return self._function.in_length_unit(unit)

    def _given(self) -> dict[str, Any]:
        """The nodes of the keywords, latitudes as those of theta."""
        names = dict.fromkeys(axis for axes in COORDINATES.values() for axis in axes)
        nodes = {name: getattr(self, name) for name in names}
        if self.latitude is not None:
            nodes["theta"] = self.latitude
        return {name: values for name, values in nodes.items() if values is not None}

    def table(
        self, folder: str, length_unit: str | None, unit: str | None = None
    ) -> tuple[dict[str, Any], Aliases]:
        """The keys of a scene, for an array with a file that is written to `folder`.

        unit: of the rates, which a quantity is converted to.
        """
        given = self._given()
        values = _array_of(self.values, self.variable)
        kind = self.coordinates or coordinates_of(values, given)
        axes = COORDINATES[kind]
        for name in given:
            if name not in axes:
                raise SceneError(
                    f"`{name}` is given: expected the axes of {kind} coordinates, {', '.join(axes)}"
                )
        nodes: dict[str, Nodes] = {}
        aliases: Aliases = []
        table: dict[str, Any] = {}
        if self._file is not None:
            grid: dict[str, Any] = {"file": str(Path(self._file).absolute())}
            shape: tuple[int | None, ...] = (None, None, None)
            if self.variable is not None:
                grid["values"] = self.variable
        else:
            _check_memory(values)
            if is_data_array(values):
                values, nodes = of_data_array(values, kind, given, length_unit)
            if _units.is_quantity(values):
                table["unit"] = unit or _units.to_text(values.unit)
                values = _units.value_in(values, table["unit"], "values")
            values, shape = _cube(values, axes)
            file = str(Path(folder, "grid.npy"))
            np.save(file, values)
            grid = {"file": file, "order": " ".join(axes) if kind != "cartesian" else "xyz"}
            alias = f"array of shape {shape}"
            # As a message has it, and as the text of the scene.
            aliases = [(file, alias), (json.dumps(file)[1:-1], alias)]
        for name, of in given.items():
            is_latitude = name == "theta" and self.latitude is not None
            nodes[name] = given_nodes(name, of, length_unit, is_latitude)
        in_unit, angle_unit = in_one_unit(nodes, self.angle_unit)
        for name, count in zip(axes, shape, strict=True):
            if name in in_unit:
                key = "latitude" if nodes[name].is_latitude else name
                grid[key] = as_in_scenes(in_unit[name], count, key)
        if kind != "cartesian":
            grid["coordinates"] = kind
        if angle_unit is not None:
            grid["angle_unit"] = angle_unit
        if self.logarithmic is not None:
            chosen = self.logarithmic
            grid["logarithmic"] = [chosen] if isinstance(chosen, str) else list(chosen)
        for name in (*_PLAIN, *_OF_FILES):
            if getattr(self, name) is not None:
                grid[name] = _units.plain(getattr(self, name))
        return {"grid": grid} | table, aliases


#: 64-bit floats in memory at once: the array, and the grid that is made of it.
_COPIES = 2


def _check_memory(values: Any) -> None:
    """Refuses an array that is not in memory yet, as of dask, and would not fit."""
    size, available = getattr(values, "size", 0), _native.available_memory_bytes()
    needed = 8 * _COPIES * size if isinstance(size, int) else 0
    if available is not None and needed > available:
        raise SceneError(
            f"`values` of shape {tuple(values.shape)} takes {needed} bytes of memory: expected at "
            f"most {available}, which are available (`isel` or `sel` chooses a part of a DataArray)"
        )


def _is_dataset(values: Any) -> bool:
    return hasattr(values, "data_vars")


def _array_of(values: Any, variable: str | None) -> Any:
    """The array of a Dataset that a variable names; what is no Dataset is the array."""
    if not _is_dataset(values):
        return values
    names = ", ".join(map(str, values.data_vars))
    if variable is None:
        raise SceneError(
            f"`values` is a Dataset of {names}: expected `variable`, the name of one of its arrays"
        )
    if variable not in values.data_vars:
        raise SceneError(f"`variable` is {variable!r}: expected one of {names}")
    return values[variable]


def _cube(values: Any, axes: tuple[str, ...]) -> tuple[Floats, tuple[int, ...]]:
    expected = f"({', '.join('n' + axis for axis in axes)})"
    found = real(values, "`values`", f"an array {expected} of numbers")
    if found.ndim != 3:
        raise SceneError(f"`values` has the shape {found.shape}: expected {expected}")
    return np.ascontiguousarray(found), found.shape
