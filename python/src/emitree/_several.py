"""Several emissions at once, as one function that returns the rates of all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from emitree import _native
from emitree._emissions import Expression
from emitree._function import Floats


class Several:
    """The rates (n, k) of k emissions; `names` are theirs, if they have any.

    >>> import numpy as np
    >>> several = Several.of(["x", Expression("a * y", {"a": 2.0})])
    >>> several(np.array([[1.0, 3.0, 0.0]]), np.zeros((1, 3)))
    array([[1., 6.]])
    """

    def __init__(
        self, functions: Sequence[Callable[..., Any]], names: Sequence[str] | None
    ) -> None:
        self.functions = functions
        self.names = None if names is None else tuple(names)

    @staticmethod
    def of(emissions: Any) -> Several | None:
        """A list or a dictionary of emissions as one; None of anything else.

        Raises `SceneError` if there are none, or if one of them is no formula and no function.
        """
        if isinstance(emissions, Mapping):
            names, members = [str(name) for name in emissions], list(emissions.values())
        elif isinstance(emissions, list | tuple):
            names, members = None, list(emissions)
        else:
            return None
        if not members:
            raise _native.SceneError("the emission is empty: expected at least one")
        labels = range(len(members)) if names is None else names
        functions = [
            _function(member, label) for member, label in zip(members, labels, strict=True)
        ]
        return Several(functions, names)

    def __call__(self, *arrays: Floats) -> Floats:
        """The rates (n, k) at positions, directions and, of cubes, energies."""
        columns = [np.asarray(function(*arrays), dtype=np.float64) for function in self.functions]
        for number, column in enumerate(columns):
            if column.shape != (len(arrays[0]),):
                raise ValueError(
                    f"the rates of emission {number} have the shape {column.shape}: expected "
                    f"({len(arrays[0])},)"
                )
        return np.stack(columns, axis=1)


def _function(emission: Any, label: Any) -> Callable[..., Any]:
    if isinstance(emission, str):
        emission = Expression(emission)
    if isinstance(emission, Expression):
        return emission.model([])()
    if callable(emission):
        return emission
    raise _native.SceneError(
        f"emission {label!r} is {type(emission).__name__}: expected a formula, an `Expression`, a "
        "`Model`, a `Grid` or a function where there are several"
    )
