"""Emissions other than a function: the table `[emission]` of a scene."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


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
