"""Data of yt as an AMR grid."""

from __future__ import annotations

from typing import Any

import numpy as np

from emitree import _units
from emitree._amr import AmrGrid, Block
from emitree._function import Floats
from emitree._native import SceneError

#: The most cells of data that are sampled at one resolution: 1 GiB.
_MOST_CELLS = 2**27


def from_yt(
    dataset: Any,
    field: Any,
    *,
    unit: Any = None,
    length_unit: Any = None,
    max_level: int | None = None,
    interpolation: str = "linear",
) -> AmrGrid:
    """A field of a yt dataset as an `AmrGrid`; the rate is its value in each cell.

    Blocks are the grids of a patch-based dataset (uniform, or of AMR). An octree is sampled on one
    uniform grid (`covering_grid`) at `max_level`, which may need much memory.

    dataset: what `yt.load` returns, three-dimensional and in Cartesian coordinates.
    field: a name, or a pair such as ("gas", "density").
    unit: of the rates, a text or an astropy unit, which the field is converted to; a dimensionless
        field is in it already. By default the rates are numbers in the field's own unit.
    length_unit: of the corners; by default they are numbers in the dataset's `code_length`, which
        are taken to be in the camera's length unit.
    max_level: the finest level that is used; by default the finest that there is.
    interpolation: as of `AmrGrid`.

    Positions are those of the dataset. Periodic domains are not continued. Units are converted
    with astropy. Raises `SceneError` for other geometries and for units that do not convert.

    >>> import emitree, numpy as np
    >>> import yt  # doctest: +SKIP
    >>> dataset = yt.load_uniform_grid({"rate": np.ones((8, 8, 8))}, (8, 8, 8))  # doctest: +SKIP
    >>> emitree.from_yt(dataset, ("stream", "rate"))  # doctest: +SKIP
    <emitree.AmrGrid: 1 blocks, interpolation 'linear'>
    """
    geometry = str(getattr(dataset.geometry, "value", dataset.geometry))
    if geometry != "cartesian":
        raise SceneError(f"the dataset has {geometry} coordinates: expected Cartesian ones")
    if dataset.dimensionality != 3:
        raise SceneError(f"the dataset has {dataset.dimensionality} dimensions: expected 3")
    if max_level is not None and max_level < 0:
        raise SceneError(f"`max_level` is {max_level}: expected 0 or more")
    lengths = _units.to_text(length_unit)
    rates = _units.to_text(unit)
    index = dataset.index
    if hasattr(index, "grids"):
        chosen = [
            (int(grid.Level), grid.LeftEdge, grid.RightEdge, grid[field])
            for grid in index.grids
            if max_level is None or grid.Level <= max_level
        ]
    else:
        chosen = [_covering(dataset, field, max_level)]
    blocks = [
        Block(
            level,
            _lengths(left, lengths),
            _lengths(right, lengths),
            _rates(values, rates, field),
        )
        for level, left, right, values in chosen
    ]
    return AmrGrid(blocks, interpolation=interpolation, length_unit=lengths, unit=rates)


def _covering(dataset: Any, field: Any, max_level: int | None) -> tuple[int, Any, Any, Any]:
    """The whole domain at the resolution of a level."""
    finest = int(dataset.all_data()["index", "grid_level"].max())
    level = finest if max_level is None else min(max_level, finest)
    counts = np.asarray(dataset.domain_dimensions) * int(dataset.refine_by) ** level
    if np.prod(counts, dtype=float) > _MOST_CELLS:
        raise SceneError(
            f"level {level} of the dataset has {tuple(counts.tolist())} cells: expected at most "
            f"{_MOST_CELLS} in all; a smaller `max_level` has less"
        )
    left = dataset.domain_left_edge
    cover = dataset.covering_grid(level, left_edge=left, dims=counts)
    return 0, left, dataset.domain_right_edge, cover[field]


def _lengths(corner: Any, unit: str | None) -> Floats:
    if unit is None:
        return np.asarray(corner.to_value("code_length"), dtype=np.float64)
    import astropy.units as u

    try:
        factor = u.m.to(_units.to_astropy(unit))
    except u.UnitConversionError:
        raise SceneError(f"`length_unit` is {unit!r}: expected a unit of length") from None
    return np.asarray(corner.to_value("m"), dtype=np.float64) * factor


def _rates(values: Any, unit: str | None, field: Any) -> Floats:
    numbers = np.asarray(values.value, dtype=np.float64)
    if unit is None or values.units.is_dimensionless:
        return numbers
    import astropy.units as u

    own = (1.0 * values.in_base("cgs").uq).to_astropy().unit
    try:
        factor = own.to(_units.to_astropy(unit))
    except u.UnitConversionError:
        raise SceneError(
            f"the field {field} is in {values.units}, and `unit` is {unit!r}: expected one that it "
            "converts to"
        ) from None
    return np.asarray(values.in_base("cgs").value, dtype=np.float64) * factor
