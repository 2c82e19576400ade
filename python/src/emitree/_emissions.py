"""What glows, other than a function: the table `[emission]` of a scene."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from emitree import _units


@dataclass(frozen=True)
class Expression:
    """An emission rate as a formula of x, y, z, r, the emission direction dx, dy, dz, and E.

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

    def __repr__(self) -> str:
        given = "".join(f", {name}={value!r}" for name, value in self.parameters.items())
        return f"Model({self.name!r}{given})"


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Emission rates at the nodes of a grid, from an array or from a file.

    values: (nx, ny, nz) rates, or the name of a file (.npy, .npz, .fits, .h5, .nc), whose own
        axes are kept unless x, y, z say otherwise.
    x, y, z: the nodes of the axes in the length unit of the camera: an array of ascending numbers,
        or (first, last) of equally spaced ones.
    interpolation: "linear" or "monotone"; outside: "zero" or "error".
    """

    values: Any
    x: Any = None
    y: Any = None
    z: Any = None
    interpolation: str | None = None
    outside: str | None = None

    def table(self, folder: str, length_unit: str | None) -> dict[str, Any]:
        """The keys of a scene; an array is written to `folder` for it."""
        grid: dict[str, Any] = {}
        if isinstance(self.values, str | os.PathLike):
            grid["file"] = str(Path(self.values).absolute())
            shape: Sequence[int | None] = (None, None, None)
        else:
            values = np.ascontiguousarray(self.values, dtype=np.float64)
            shape = values.shape
            file = Path(folder, "grid.npy")
            np.save(file, values)
            grid |= {"file": str(file), "order": "xyz"}
        for name, count in zip("xyz", shape, strict=False):
            nodes = getattr(self, name)
            if nodes is None:
                continue
            nodes = np.asarray(_units.value_in(nodes, length_unit, name), dtype=np.float64)
            if nodes.shape == (2,) and count != 2:
                grid[name] = {"min": float(nodes[0]), "max": float(nodes[1])}
            else:
                grid[name] = nodes.tolist()
        for name in ("interpolation", "outside"):
            if getattr(self, name) is not None:
                grid[name] = getattr(self, name)
        return {"grid": grid}


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
