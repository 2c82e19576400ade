"""A grid as a function of positions: read and interpolated as a scene does it."""

from __future__ import annotations

import tempfile
from typing import Any

import numpy as np

from emitree import _native
from emitree._function import Floats
from emitree._grid import Grid
from emitree._native import SceneError
from emitree._scene import document


class GridFunction:
    """The values of a grid at positions in a length unit; `what` is what errors call it.

    >>> axes = {"x": (0, 1), "y": (0, 1), "z": (0, 1)}
    >>> grid = GridFunction(Grid(values=np.full((2, 2, 2), 3.0), **axes), "the grid")
    >>> grid(np.array([[0.5, 0.5, 0.5], [2.0, 0.5, 0.5]]))
    array([3., 0.])
    """

    def __init__(
        self, grid: Grid, what: str, unit: str | None = None, length_unit: str | None = None
    ) -> None:
        self.grid, self.what, self.unit, self.length_unit = grid, what, unit, length_unit
        self._scene: _native.Scene | None = None

    def __getstate__(self) -> dict[str, Any]:
        # A scene cannot be pickled: workers of an executor read their own.
        return self.__dict__ | {"_scene": None}

    def in_length_unit(self, unit: str | None) -> GridFunction:
        """The same as a function of positions in a unit."""
        return GridFunction(self.grid, self.what, self.unit, unit)

    @property
    def scene(self) -> _native.Scene:
        """A scene that has the grid as its emission."""
        if self._scene is None:
            self._scene = self._opened()
        return self._scene

    def _opened(self) -> _native.Scene:
        with tempfile.TemporaryDirectory(prefix="emitree-") as folder:
            try:
                table, aliases = self.grid.table(folder, self.length_unit, self.unit)
                # The unit is that of the numbers, and no unit of rates.
                table.pop("unit", None)
                projection = {"type": "canonical"}
                image = {"width": 1, "height": 1}
                text = document({"emission": table, "projection": projection, "image": image})
                return _native.Scene.parse("emitree", text, aliases)
            except SceneError as error:
                message = str(error).replace("`emission.grid`: ", "")
                raise SceneError(f"{self.what}: {message}") from None

    def values(self, position: Floats) -> Floats:
        """The values (n,); NaN outside of the grid."""
        try:
            return self.scene.grid_values(position)
        except _native.EmissionError as error:
            raise _native.EmissionError(f"{self.what}: {error}") from None

    def __call__(self, position: Any, direction: Any = None, energy: Any = None) -> Floats:
        """The rates (n,): 0 outside of the grid, and the same in all directions."""
        at = np.ascontiguousarray(position, dtype=np.float64)
        if at.ndim != 2 or at.shape[1] != 3:
            raise ValueError(f"`position` has the shape {at.shape}: expected (n, 3)")
        values = self.values(at)
        return np.where(np.isnan(values), 0.0, values)
