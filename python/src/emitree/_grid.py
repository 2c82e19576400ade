"""Data on a grid, from arrays or from a file: the table `[emission.grid]` of a scene."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from emitree import _units
from emitree._function import Floats
from emitree._native import SceneError

_AXES = "xyz"

#: Keys of the scene that are taken as they are.
_PLAIN = ("interpolation", "outside")
#: And those that only files need.
_OF_FILES = ("order", "format", "scale")

#: Pairs: the name of a temporary file, and what it is called in messages and reports.
Aliases = list[tuple[str, str]]


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Emission rates at the nodes of a grid, from an array or from a file.

    values: an array (nx, ny, nz) of rates, or an astropy quantity; or an xarray DataArray with the
        dimensions x, y and z in any order, whose coordinates are the nodes unless x, y, z say
        otherwise.
    file: the name of a file (.npy, .npz, .fits, .h5, .nc), whose own axes are kept unless x, y, z
        say otherwise; variable: which of its arrays has the rates.
    x, y, z: the nodes of the axes in the length unit of the camera: an array of ascending numbers,
        or (first, last) of equally spaced ones; of a file also the name of an array in it.
    interpolation: "linear" or "monotone"; outside: "zero" or "error".
    order: of the axes in a file, as in "zyx"; format: of a file with another ending; scale: what
        its rates are multiplied with.

    >>> import emitree, numpy as np
    >>> ramp = np.arange(3.0)[:, None, None] + np.zeros((3, 2, 2))
    >>> grid = emitree.Grid(values=ramp, x=(0, 1), y=(0, 1), z=(0, 1))
    >>> emitree.render(grid, emitree.Canonical(), (1, 2)).image
    array([[0.5, 1.5]])
    """

    values: Any = None
    file: str | os.PathLike[str] | None = None
    variable: str | None = None
    x: Any = None
    y: Any = None
    z: Any = None
    interpolation: str | None = None
    outside: str | None = None
    order: str | None = None
    format: str | None = None
    scale: float | None = None

    def __post_init__(self) -> None:
        if (self.values is None) == (self.file is None):
            raise SceneError("expected one of `values`, an array, and `file`, the name of a file")
        if self._file is None:
            for name in ("variable", *_OF_FILES):
                if getattr(self, name) is not None:
                    raise SceneError(f"`{name}` is for files: expected none with an array")

    @property
    def _file(self) -> str | os.PathLike[str] | None:
        # Files were given as `values` before there was `file`.
        return self.values if isinstance(self.values, str | os.PathLike) else self.file

    def table(
        self, folder: str, length_unit: str | None, unit: str | None = None
    ) -> tuple[dict[str, Any], Aliases]:
        """The keys of a scene, for an array with a file that is written to `folder`.

        unit: of the rates, which a quantity is converted to.
        """
        own: dict[str, Floats] = {}
        aliases: Aliases = []
        table: dict[str, Any] = {}
        if self._file is not None:
            grid: dict[str, Any] = {"file": str(Path(self._file).absolute())}
            shape: tuple[int | None, ...] = (None, None, None)
            if self.variable is not None:
                grid["values"] = self.variable
        else:
            values, own = _of_data_array(self.values, length_unit)
            if _units.is_quantity(values):
                table["unit"] = unit or _units.to_text(values.unit)
                values = _units.value_in(values, table["unit"], "values")
            values, shape = _cube(values)
            file = str(Path(folder, "grid.npy"))
            np.save(file, values)
            grid = {"file": file, "order": _AXES}
            alias = f"array of shape {shape}"
            # As a message has it, and as the text of the scene.
            aliases = [(file, alias), (json.dumps(file)[1:-1], alias)]
        for name, count in zip(_AXES, shape, strict=True):
            nodes = getattr(self, name)
            nodes = own.get(name) if nodes is None else nodes
            if nodes is not None:
                grid[name] = _nodes(nodes, count, length_unit, name)
        for name in (*_PLAIN, *_OF_FILES):
            if getattr(self, name) is not None:
                grid[name] = _units.plain(getattr(self, name))
        return {"grid": grid} | table, aliases


def _cube(values: Any) -> tuple[Floats, tuple[int, ...]]:
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise SceneError("some `values` are masked: expected a number at each node")
    try:
        found = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError(
            f"`values` is {type(values).__name__}: expected an array (nx, ny, nz) of numbers"
        ) from None
    if np.ndim(values) != 3:
        raise SceneError(f"`values` has the shape {np.shape(values)}: expected (nx, ny, nz)")
    return found, found.shape


def _nodes(nodes: Any, count: int | None, length_unit: str | None, name: str) -> Any:
    """The nodes of an axis as a scene has them."""
    if isinstance(nodes, str):
        if count is not None:
            raise SceneError(f"`{name}` is {nodes!r}: expected nodes, names are for files")
        return nodes
    found = np.asarray(_units.value_in(nodes, length_unit, name), dtype=np.float64)
    if found.shape == (2,) and count != 2:
        return {"min": float(found[0]), "max": float(found[1])}
    return found.tolist()


def _of_data_array(values: Any, length_unit: str | None) -> tuple[Any, dict[str, Floats]]:
    """The values of an xarray DataArray in the order x, y, z, and its coordinates."""
    if hasattr(values, "data_vars"):
        raise SceneError(
            f"`values` is a Dataset of {', '.join(map(str, values.data_vars))}: expected one of "
            "its arrays, dataset[name]"
        )
    if not (hasattr(values, "dims") and hasattr(values, "coords")):
        return values, {}
    dims = {str(dim).lower(): dim for dim in values.dims}
    if len(values.dims) != 3 or set(dims) != set(_AXES):
        raise SceneError(
            f"`values` is a DataArray with the dimensions {tuple(values.dims)}: expected x, y and "
            "z in any order (`rename` them), or an array (nx, ny, nz) without names"
        )
    ordered = values.transpose(*(dims[axis] for axis in _AXES))
    nodes: dict[str, Floats] = {}
    found = ordered.data if _units.is_quantity(ordered.data) else ordered.to_numpy()
    for number, axis in enumerate(_AXES):
        if dims[axis] not in ordered.coords:
            continue
        coordinate = ordered.coords[dims[axis]]
        places = _in_length_unit(coordinate, length_unit, axis)
        if len(places) > 1 and (np.diff(places) < 0).all():
            found, places = np.flip(found, number), places[::-1]
        nodes[axis] = places
    return found, nodes


def _in_length_unit(coordinate: Any, length_unit: str | None, axis: str) -> Floats:
    """The numbers of a coordinate; those with `units` are converted where the camera has a unit."""
    places = np.asarray(coordinate.to_numpy(), dtype=np.float64)
    unit = coordinate.attrs.get("units")
    if length_unit is None or unit in (None, "", "1", length_unit):
        return places
    try:
        return np.asarray(
            (places * _units.to_astropy(unit)).to_value(_units.to_astropy(length_unit))
        )
    except ValueError:
        raise SceneError(
            f"the coordinate `{axis}` of `values` is in {unit!r}: expected {length_unit!r}, or a "
            "length that converts to it"
        ) from None
