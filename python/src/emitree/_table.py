"""Functions of one to three numbers from a table, such as an emissivity against temperature."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from emitree import _native, _units
from emitree._axes import is_data_array
from emitree._function import Floats
from emitree._native import SceneError
from emitree._real import real

#: What the values of an array are called.
_VALUES = "values"


class Table:
    """A function of one to three numbers from a table, for the formula of `Fields`.

    values: an array with an axis for each argument; or an xarray DataArray, whose coordinates are
        the nodes unless `axes` has them; of a file the name of its column or array.
    axes: the nodes of each argument by its name, in the order of the arguments: arrays of numbers
        that all increase or all decrease; of a file the names of its columns or arrays.
    file: instead, the name of a file: text (.csv, .ecsv, .txt, .dat), a FITS table or images
        (.fits), .npz, .h5 or .nc. By default the last column has the values, and all others are
        axes; of arrays, `values` has the values, and its dimensions have the names of the axes.
    logarithmic: the names of the axes, and of the values ("values" of an array), that are
        interpolated in their logarithm.
    outside: beyond the axes, "error" (wherever a rate depends on it), "zero", or "edge", the value
        of the nearest node.
    format, extension, scale: of files of another ending; the name of the extension of a FITS file;
        what values are multiplied with.

    It is linear along each axis, or linear in logarithms. Quantities are taken in their own units.

    >>> import emitree, numpy as np
    >>> cooling = emitree.Table(
    ...     [4e-22, 1e-22], {"T": [1e5, 1e7]}, logarithmic=["T", "values"], outside="edge"
    ... )
    >>> np.round(cooling([1e4, 1e6]) * 1e22, 12)
    array([4., 2.])
    """

    def __init__(
        self,
        values: Any = None,
        axes: Mapping[str, Any] | Iterable[str] | None = None,
        *,
        file: str | os.PathLike[str] | None = None,
        logarithmic: str | Iterable[str] = (),
        outside: str = "error",
        format: str | None = None,
        extension: str | None = None,
        scale: float = 1.0,
    ) -> None:
        names = [logarithmic] if isinstance(logarithmic, str) else list(logarithmic)
        if file is not None:
            self.name = f"Table(file={os.fspath(file)!r})"
            self._given: tuple[Any, ...] = (
                Path(file).absolute(),
                format,
                extension,
                _names(axes),
                _name(values),
                names,
                outside,
                float(scale),
            )
            self._native = _native.Table.read(*self._given)
            return
        for key, given in (("format", format), ("extension", extension)):
            if given is not None:
                raise SceneError(f"`{key}` is for files: expected none with an array")
        self.name = "Table"
        self._given = _of_array(values, axes, names, outside, float(scale))
        self._native = _native.Table(*self._given)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The names of the axes, in the order of the arguments."""
        return tuple(self._native.names)

    def nodes(self, argument: str) -> Floats:
        """The nodes along an axis, in increasing order."""
        if argument not in self.arguments:
            expected = ", ".join(self.arguments)
            raise SceneError(f"the argument is {argument!r}: expected one of {expected}")
        return self._native.nodes(self.arguments.index(argument))

    def __call__(self, *arguments: Any) -> Floats:
        """The values at numbers or arrays of numbers, one for each axis, broadcast.

        Raises `SceneError` if one is outside of the table, and `outside` is "error".
        """
        arrays = np.broadcast_arrays(*(np.asarray(of, dtype=np.float64) for of in arguments))
        shape = arrays[0].shape if arrays else ()
        found = self._native.values([np.ascontiguousarray(array).ravel() for array in arrays])
        return found.reshape(shape)

    def __repr__(self) -> str:
        ranges = (
            f"{name} from {nodes[0]:.6g} to {nodes[-1]:.6g}"
            for name, nodes in ((name, self.nodes(name)) for name in self.arguments)
        )
        return f"<emitree.{self.name}: {', '.join(ranges)}>"

    def __getstate__(self) -> dict[str, Any]:
        return {"name": self.name, "_given": self._given}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__dict__.update(state)
        kind = _native.Table if self.name == "Table" else _native.Table.read
        self._native = kind(*self._given)


def _names(axes: Any) -> list[str]:
    if axes is None:
        return []
    if isinstance(axes, Mapping):
        raise SceneError("`axes` has arrays: expected the names of columns or arrays of the file")
    return [axes] if isinstance(axes, str) else list(axes)


def _name(values: Any) -> str | None:
    if values is not None and not isinstance(values, str):
        raise SceneError("there are `values` and a `file`: expected one of them")
    return values


def _of_array(
    values: Any, axes: Any, logarithmic: list[str], outside: str, scale: float
) -> tuple[Any, ...]:
    """What the native table takes."""
    if values is None or isinstance(values, str):
        raise SceneError("expected `values`, an array, or `file`, the name of a file")
    name = _VALUES
    if is_data_array(values):
        name = str(values.name or _VALUES)
        if axes is None:
            missing = [str(dim) for dim in values.dims if dim not in values.coords]
            if missing:
                raise SceneError(
                    f"`values` has no coordinate for its dimension {missing[0]}: expected one "
                    "(`assign_coords`), or `axes`"
                )
            axes = {str(dim): values.coords[dim].to_numpy() for dim in values.dims}
        values = values.data if _units.is_quantity(values.data) else values.to_numpy()
    if not isinstance(axes, Mapping):
        raise SceneError("expected `axes`, the nodes of each argument by its name")
    known = [*axes, name, _VALUES]
    for other in logarithmic:
        if other not in known:
            expected = ", ".join(map(repr, dict.fromkeys(known)))
            raise SceneError(f"`logarithmic` has {other!r}: expected some of {expected}")
    nodes = {key: _numbers(of, f"the axis `{key}`") for key, of in axes.items()}
    for key, of in nodes.items():
        if of.ndim != 1:
            raise SceneError(f"the axis `{key}` has the shape {of.shape}: expected one axis")
    array = _numbers(values, "`values`") * scale
    expected_shape = tuple(len(of) for of in nodes.values())
    if array.shape != expected_shape:
        raise SceneError(
            f"`values` has the shape {array.shape}: expected {expected_shape}, the nodes of "
            f"{', '.join(nodes)}"
        )
    return (
        list(nodes),
        [of.tolist() for of in nodes.values()],
        array.ravel().tolist(),
        [key in logarithmic for key in nodes],
        name in logarithmic or _VALUES in logarithmic,
        outside,
    )


def _numbers(values: Any, name: str) -> Floats:
    return real(values.value if _units.is_quantity(values) else values, name, "numbers")
