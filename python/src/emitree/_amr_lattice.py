"""Blocks of several levels on the lattice of the smallest cells, and which is the finest where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._native import SceneError

Integers = NDArray[np.int64]

#: How far a border may be from the lattice of its level, in cells: that of rounded coordinates.
_DEVIATION = 1e-5
#: The most entries of the table of tiles: 1 GiB.
_MOST_TILES = 2**28
#: Axes with more cells are searched for borders: a table of cells would need much memory.
_MOST_CELLS = 2**22
_AXES = "xyz"


@dataclass(frozen=True)
class Place:
    """Where a block is and what it has, in plain numbers."""

    level: int
    lower: Floats
    upper: Floats
    #: Of cells, or of the nodes at their corners.
    values: Floats
    is_of_nodes: bool = False

    @property
    def cells(self) -> Integers:
        """The number of cells (3,) along each axis."""
        return np.array(self.values.shape, dtype=np.int64) - int(self.is_of_nodes)

    @property
    def width(self) -> Floats:
        """The edges of a cell."""
        return np.asarray((self.upper - self.lower) / self.cells)


@dataclass
class Lattice:
    """Blocks in cells of the smallest size.

    origin: the least corner (3,) of all blocks; width: edges of the smallest cells (3,).
    count: how many of them there are along each axis of the box around all blocks.
    ratio: (blocks, 3), edges of a block's cells; lower, upper: (blocks, 3), corners of the blocks;
    level: (blocks,).
    borders: of each axis, the sorted borders of all blocks, which divide the box into tiles.
    tiles: the finest block of each tile that has been painted so far; -1 where there is none.
    """

    origin: Floats
    width: Floats
    count: Integers
    ratio: Integers
    lower: Integers
    upper: Integers
    level: Integers
    borders: list[Integers]
    tiles: NDArray[np.int32]
    _stride: tuple[int, int, int] = field(init=False)
    _steps: list[Integers] = field(init=False)

    def __post_init__(self) -> None:
        _, ny, nz = self.tiles.shape
        self._stride = (ny * nz, nz, 1)
        self._steps = [
            _steps_of(borders, stride)
            for borders, stride in zip(self.borders, self._stride, strict=True)
        ]

    def region(self, block: int) -> tuple[slice, ...]:
        """The tiles of a block."""
        return tuple(
            slice(*np.searchsorted(borders, (low, high)))
            for borders, low, high in zip(
                self.borders, self.lower[block], self.upper[block], strict=True
            )
        )

    def tile_of(self, axis: int, cells: Floats) -> Integers:
        """What coordinates along an axis contribute to the number of a tile.

        cells: in smallest cells, no farther outside than integers reach; those outside are taken as
            in the first or the last cell.
        """
        steps = self._steps[axis]
        if len(steps) == 0:
            found = np.searchsorted(self.borders[axis][1:-1], cells, side="right")
            return np.asarray(found * self._stride[axis])
        return steps.take(cells.astype(np.int64), mode="clip")

    def block_at(self, cells: Sequence[Floats]) -> Integers:
        """The finest blocks at points (n,) a coordinate, in smallest cells; -1 outside of all."""
        inside = np.ones(len(cells[0]), dtype=bool)
        tiles = np.zeros(len(cells[0]), dtype=np.int64)
        for axis, of in enumerate(cells):
            inside &= (of >= 0) & (of < self.count[axis])
            tiles += self.tile_of(axis, of)
        found = self.tiles.ravel().take(tiles, mode="clip")
        return np.where(inside, found, -1).astype(np.int64)


def _steps_of(borders: Integers, stride: int) -> Integers:
    """For each smallest cell of an axis the number of its tile, times the stride of the axis.

    None for an axis that is searched.
    """
    if borders[-1] > _MOST_CELLS:
        return np.zeros(0, dtype=np.int64)
    return np.repeat(np.arange(len(borders) - 1) * stride, np.diff(borders))


def lattice_of(places: Sequence[Place]) -> Lattice:
    """The lattice of blocks, which have to be aligned; no tile is painted yet."""
    levels = sorted({place.level for place in places})
    first = {
        level: next(n for n, place in enumerate(places) if place.level == level) for level in levels
    }
    _check_widths(places, first)
    ratios = _ratios(places, levels, first)
    origin = np.min([place.lower for place in places], axis=0)
    width = places[first[levels[-1]]].width
    lower, upper = [], []
    for number, place in enumerate(places):
        ratio = ratios[place.level]
        cells = (place.lower - origin) / (width * ratio)
        nearest = np.rint(cells)
        # Rounded coordinates far from the origin are off by more than a fraction of a cell.
        rounding = 8 * np.finfo(float).eps * np.abs([place.lower, origin]).max(axis=0)
        off = np.abs(cells - nearest) > _DEVIATION + rounding / (width * ratio)
        if off.any():
            axis = int(np.argmax(off))
            raise SceneError(
                f"block {number} of level {place.level} begins at {_AXES[axis]} = "
                f"{place.lower[axis]:.12g}, {cells[axis]:.6g} cells from the least corner of all "
                f"blocks, {origin[axis]:.12g}: expected a whole number of its cells"
            )
        start = nearest.astype(np.int64) * ratio
        lower.append(start)
        upper.append(start + ratio * place.cells)
    ratio_of = np.array([ratios[place.level] for place in places])
    corners = np.array(lower), np.array(upper)
    borders = [np.unique(np.concatenate([of[:, axis] for of in corners])) for axis in range(3)]
    shape = tuple(len(of) - 1 for of in borders)
    if np.prod(shape, dtype=float) > _MOST_TILES:
        raise SceneError(
            f"the borders of the {len(places)} blocks divide their box into {shape} tiles: "
            f"expected at most {_MOST_TILES} in all; fewer levels, or larger blocks, have less"
        )
    return Lattice(
        origin=origin,
        width=width,
        count=np.array([of[-1] for of in borders]),
        ratio=ratio_of,
        lower=corners[0],
        upper=corners[1],
        level=np.array([place.level for place in places]),
        borders=borders,
        tiles=np.full(shape, -1, dtype=np.int32),
    )


def _check_widths(places: Sequence[Place], first: dict[int, int]) -> None:
    for number, place in enumerate(places):
        expected = places[first[place.level]].width
        if not np.allclose(place.width, expected, rtol=_DEVIATION, atol=0):
            raise SceneError(
                f"block {number} of level {place.level} has cells of {_text(place.width)}: "
                f"expected {_text(expected)}, as block {first[place.level]} of that level has"
            )


def _ratios(
    places: Sequence[Place], levels: list[int], first: dict[int, int]
) -> dict[int, Integers]:
    """The edges of each level's cells in those of the finest."""
    ratios = {levels[-1]: np.ones(3, dtype=np.int64)}
    for coarse, fine in zip(levels[-2::-1], levels[:0:-1], strict=True):
        quotient = places[first[coarse]].width / places[first[fine]].width
        nearest = np.rint(quotient)
        is_whole = (np.abs(quotient - nearest) <= _DEVIATION * quotient).all()
        if not is_whole or nearest.max() < 2:
            raise SceneError(
                f"block {first[fine]} of level {fine} has cells of "
                f"{_text(places[first[fine]].width)}, and block {first[coarse]} of level {coarse} "
                f"of {_text(places[first[coarse]].width)}: expected whole ratios, above 1 along an "
                "axis at least"
            )
        ratios[coarse] = ratios[fine] * nearest.astype(np.int64)
    return ratios


def _text(lengths: Floats) -> str:
    return f"({', '.join(f'{length:.6g}' for length in lengths)})"
