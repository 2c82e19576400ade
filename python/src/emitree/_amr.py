"""Data on nested blocks of cells, as of adaptive mesh refinement (AMR): a function of position."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from emitree import _units
from emitree._amr_ghosts import nodal, painted, quadratic
from emitree._amr_lattice import Lattice, Place, lattice_of
from emitree._cameras import Box
from emitree._function import Floats
from emitree._native import SceneError
from emitree._real import real

_INTERPOLATIONS = ("linear", "quadratic", "nearest")
#: What a block has values of, and the interpolations of each.
_VALUES_AT = {"cells": _INTERPOLATIONS, "nodes": ("linear", "nearest")}
#: Points at once: their arrays stay in the cache of a core.
_CHUNK = 8192


@dataclass(frozen=True, eq=False)
class Block:
    """A box of cells of one size.

    level: 0 or more, an integer; blocks of larger levels have smaller cells and replace those of
        smaller levels where they overlap.
    lower, upper: (3,), opposite corners of the box (borders of cells, not centres): lengths.
    values: (nx, ny, nz), the rate in each cell: numbers or an astropy quantity.
    values_at: "cells", or "nodes" of values at the corners of cells, (nx + 1, ny + 1, nz + 1) with
        those on all borders of the box.

    >>> import emitree, numpy as np
    >>> emitree.Block(0, (-1, -1, -1), (1, 1, 1), np.ones((4, 4, 4)))
    <emitree.Block of level 0, (4, 4, 4) cells from (-1, -1, -1) to (1, 1, 1)>
    >>> emitree.Block(0, (-1, -1, -1), (1, 1, 1), np.ones((4, 4, 4)), values_at="nodes")
    <emitree.Block of level 0, (4, 4, 4) nodes from (-1, -1, -1) to (1, 1, 1)>
    """

    level: int
    lower: Any
    upper: Any
    values: Any
    values_at: str = "cells"

    def __repr__(self) -> str:
        return (
            f"<emitree.Block of level {self.level}, {np.shape(self.values)} {self.values_at} from "
            f"{self.lower} to {self.upper}>"
        )


class AmrGrid:
    """Emission rates of nested blocks of cells: a function `grid(position, direction)`.

    blocks: `Block`s, all with values in cells or all with values at nodes. The cells of a level
        have one size, which is a whole multiple of that of the next finer level, along each axis;
        blocks are whole numbers of their cells away from the least corner of all. Blocks need not
        be nested properly, and may be leaves only.
    interpolation: "linear", trilinear between the centres of cells; "quadratic", a quadratic spline
        with continuous derivatives; or "nearest", the value of the cell. Outside of all blocks the
        rate is 0. Of values at nodes "linear", trilinear between the corners of a cell, or
        "nearest", the value of the nearest corner.
    length_unit: of corners that are quantities, that of the first one by default. Corners that are
        numbers are in the camera's length unit unless `length_unit` is given.
    unit: of the rates, that of the first values that are a quantity by default; `render` converts
        them to its own `unit`.

    The finest block that contains a point is interpolated. Up to half a cell from its border, a
    layer of cells around the block is used. Each of these has the value of the cell there if it is
    in a block of the same level; else the interpolant of the coarser block there, at its centre;
    else the mean of the finer cells there; else, outside of all blocks, the value of the nearest
    cell (beyond the box around all blocks, that of the cell at its face). Cells that lie entirely
    under a finer block have the mean of its cells, whatever values are given. So the rate is
    continuous within a level; at the border of two levels it jumps by a difference of second order
    in the size of the cells, and not at all if the data are linear. Where the blocks end, the rate
    falls to 0 from that of the last cells.

    Values at nodes need no layers: each cell has its own corners. The rate is continuous across
    blocks of one level with the same values at the nodes that they share; at the border of two
    levels it jumps by a difference of second order, and not at all if the data are linear.

    "quadratic" has an error of third order in the size of the cells, and images of it cost as few
    evaluations as those of a smooth function. It uses two layers of cells around blocks. Beside a
    jump of the data it overshoots by up to a fifth of it; rates of which none is negative stay so.
    At the centre of a cell it differs from the value by a term of fourth order.

    >>> import emitree, numpy as np
    >>> coarse = emitree.Block(0, (0, 0, 0), (4, 4, 4), np.ones((4, 4, 4)))
    >>> fine = emitree.Block(1, (1, 1, 1), (3, 3, 3), np.full((4, 4, 4), 2.0))
    >>> grid = emitree.AmrGrid([coarse, fine], interpolation="nearest")
    >>> grid(np.array([[0.5, 0.5, 0.5], [2, 2, 2], [5, 5, 5]]), None)
    array([1., 2., 0.])
    >>> camera = emitree.Orthographic(position=(9, 2, 2), target=(2, 2, 2), extent=(2, 2))
    >>> image = emitree.render(grid, camera, (4, 4), tolerance=0.01).image
    >>> bool(abs(image - 6).max() < 0.06)
    True
    """

    #: The unit of lengths, a text; None for that of the camera.
    length_unit: str | None
    #: The unit of the rates, a text, or None.
    unit: str | None
    interpolation: str

    def __init__(
        self,
        blocks: Sequence[Block],
        *,
        interpolation: str = "linear",
        length_unit: Any = None,
        unit: Any = None,
    ) -> None:
        blocks = list(blocks)
        if not blocks:
            raise SceneError("`blocks` is empty: expected at least one emitree.Block")
        if interpolation not in _INTERPOLATIONS:
            *first, last = map(repr, _INTERPOLATIONS)
            expected = f"{', '.join(first)} or {last}"
            raise SceneError(f"`interpolation` is {interpolation!r}: expected {expected}")
        for number, block in enumerate(blocks):
            if not isinstance(block, Block):
                raise SceneError(
                    f"block {number} is {type(block).__name__}: expected emitree.Block"
                )
        corners = [corner for block in blocks for corner in (block.lower, block.upper)]
        self.length_unit = _units.to_text(length_unit or _units.first_unit(corners))
        self.unit = _units.to_text(unit or _units.first_unit([block.values for block in blocks]))
        self.interpolation = interpolation
        self._is_of_nodes = _kind(blocks, interpolation) == "nodes"
        places = [self._place(number, block) for number, block in enumerate(blocks)]
        lattice = lattice_of(places)
        if self._is_of_nodes:
            layers = nodal(lattice, places)
        elif interpolation == "quadratic":
            layers = [quadratic(padded) for padded in painted(lattice, places, 2)]
        else:
            layers = painted(lattice, places)
        is_negative = any((place.values < 0).any() for place in places)
        self._least = -np.inf if is_negative else 0.0
        self._upper = np.max([place.upper for place in places], axis=0)
        self._blocks = len(places)
        self._set_tables(lattice, layers)

    def _place(self, number: int, block: Block) -> Place:
        name = f"block {number}"
        level = block.level
        if isinstance(level, bool) or not isinstance(level, int | np.integer) or level < 0:
            raise SceneError(f"`level` of {name} is {level!r}: expected an integer, 0 or more")
        lower = self._corner(block.lower, f"`lower` of {name}")
        upper = self._corner(block.upper, f"`upper` of {name}")
        for axis, low, high in zip("xyz", lower, upper, strict=True):
            if not low < high:
                raise SceneError(
                    f"`upper` of {name} is {high:.12g} along {axis}: expected more than `lower`, "
                    f"{low:.12g}"
                )
        values = _numbers(block.values, self.unit, f"`values` of {name}")
        least, kind = (2, "node") if self._is_of_nodes else (1, "cell")
        if values.ndim != 3 or min(values.shape) < least:
            more = ", 2 or more along each axis" if self._is_of_nodes else ""
            raise SceneError(
                f"`values` of {name} has the shape {values.shape}: expected (nx, ny, nz), a number "
                f"for each {kind}{more}"
            )
        if not np.isfinite(values).all():
            at = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
            place = f"in cell {at}" if kind == "cell" else f"at node {at}"
            raise SceneError(f"`values` of {name} is {values[at]} {place}: expected a number")
        return Place(int(level), lower, upper, values, self._is_of_nodes)

    def _corner(self, corner: Any, name: str) -> Floats:
        found = _numbers(corner, self.length_unit, name)
        if found.shape != (3,) or not np.isfinite(found).all():
            raise SceneError(f"{name} is {corner}: expected three finite lengths (x, y, z)")
        return found

    def _set_tables(self, lattice: Lattice, layers: list[Floats]) -> None:
        """Tables by tile and by block, from which a call takes all it needs."""
        self._lattice = lattice
        sizes = np.cumsum([0, 2, *(layer.size for layer in layers)])
        #: Two zeros, for points outside, and the blocks with their layers.
        self._values = np.concatenate([[0.0, 0.0], *(layer.ravel() for layer in layers)])
        shapes = np.array([layer.shape for layer in layers])
        ones = np.ones(len(layers))
        # Coordinates of a block's layered cells are `scale` q + `shift`, with q in smallest cells;
        # those of nodes have no layer and begin half a cell before centres.
        half = 0.5 if self.interpolation == "linear" else 1.0
        if self._is_of_nodes:
            half -= 0.5
        rows = [
            *(1 / lattice.ratio).T,
            *(half - lattice.lower / lattice.ratio).T,
            shapes[:, 1] * shapes[:, 2] * ones,
            shapes[:, 2] * ones,
            sizes[1:-1] * ones,
        ]
        # Points outside are in the first block, of zeros.
        self._of_block = np.array([np.concatenate([[0.0], row]) for row in rows])
        self._block_of_tile = np.concatenate([lattice.tiles.ravel() + 1, [0]]).astype(np.int32)

    @property
    def bounds(self) -> Box:
        """The box around all blocks, which `render` uses unless `bounds` is given."""
        low, high = self._lattice.origin, self._upper
        if self.length_unit is None:
            return Box(min=tuple(low.tolist()), max=tuple(high.tolist()))
        unit = _units.to_astropy(self.length_unit)
        return Box(min=tuple(low.tolist()) * unit, max=tuple(high.tolist()) * unit)

    def in_length_unit(self, unit: str | None) -> AmrGrid:
        """The same grid as a function of positions in another unit."""
        if unit is None or self.length_unit in (None, unit):
            return self
        here = _units.to_astropy(self.length_unit)
        try:
            factor = here.to(_units.to_astropy(unit))
        except ValueError:
            raise SceneError(
                f"the blocks have lengths in {self.length_unit}, and the camera in {unit}: "
                "expected units that convert to each other"
            ) from None
        other = copy.copy(self)
        lattice = self._lattice
        other.length_unit = unit
        other._lattice = replace(
            lattice, origin=lattice.origin * factor, width=lattice.width * factor
        )
        other._upper = self._upper * factor
        return other

    def __repr__(self) -> str:
        return f"<emitree.AmrGrid: {self._blocks} blocks, interpolation {self.interpolation!r}>"

    def __call__(self, position: Any, direction: Any = None) -> Any:
        """The rates (n,) at positions (n, 3); a quantity if the grid has a `unit`.

        position: numbers in `length_unit`, or a quantity; direction: without effect.
        """
        position = _numbers(position, self.length_unit, "position")
        rates = np.empty(len(position))
        for start in range(0, len(position), _CHUNK):
            part = slice(start, start + _CHUNK)
            rates[part] = self._rates(position[part])
        return rates if self.unit is None else rates << _units.to_astropy(self.unit)

    def is_inside(self, position: Any) -> Any:
        """Whether positions (n, 3) are in one of the blocks."""
        position = _numbers(position, self.length_unit, "position")
        found = np.empty(len(position), dtype=bool)
        for start in range(0, len(position), _CHUNK):
            part = slice(start, start + _CHUNK)
            found[part] = self._cells(position[part])[1] > 0
        return found

    def _cells(self, position: Floats) -> tuple[Floats, Any]:
        """Positions (3, n) in the smallest cells, and blocks (n,), from 1; 0 is outside."""
        lattice = self._lattice
        cells = position.T - lattice.origin[:, None]
        cells *= (1 / lattice.width)[:, None]
        np.clip(cells, -1, lattice.count[:, None], out=cells)
        tile = lattice.tile_of(0, cells[0])
        tile += lattice.tile_of(1, cells[1])
        tile += lattice.tile_of(2, cells[2])
        outside = ((cells < 0) | (cells >= lattice.count[:, None])).any(axis=0)
        tile[outside] = len(self._block_of_tile) - 1
        return cells, self._block_of_tile.take(tile, mode="clip").astype(np.intp)

    def _rates(self, position: Floats) -> Floats:
        cells, block = self._cells(position)
        of_block = self._of_block.take(block, axis=1, mode="clip")
        cells *= of_block[:3]
        cells += of_block[3:6]
        first = np.floor(cells)
        step_x, step_y, start = of_block[6:]
        at = first[0] * step_x
        at += first[1] * step_y
        at += first[2]
        at += start
        here = at.astype(np.intp)
        if self.interpolation == "nearest":
            return self._values.take(here, mode="clip")
        cells -= first
        if self.interpolation == "quadratic":
            return self._quadratic(here, step_x.astype(np.intp), step_y.astype(np.intp), cells)
        x, y, z = cells
        return self._linear(here, step_x.astype(np.intp), step_y.astype(np.intp), x, y, z)

    def _quadratic(self, at: Any, step_x: Any, step_y: Any, cells: Floats) -> Floats:
        """The quadratic spline in cells at `at`, at fractions of their edges."""
        last = cells**2 / 2
        first = last - cells + 0.5
        middle = 1 - first - last
        outside = step_x == 0
        # Their block has two zeros, and its neighbours are those of another one.
        at[outside] = 0

        def three(values: Sequence[Floats], axis: int) -> Floats:
            low, here, high = values
            low *= first[axis]
            here *= middle[axis]
            high *= last[axis]
            low += here
            low += high
            return low

        # Values before, at and after a place.
        shifted = [self._values[:-2], self._values[1:-1], self._values[2:]]

        def along_z(at: Any) -> Floats:
            return three([values.take(at - 1, mode="clip") for values in shifted], 2)

        def along_y(at: Any) -> Floats:
            return three([along_z(at + shift * step_y) for shift in (-1, 0, 1)], 1)

        found = three([along_y(at + shift * step_x) for shift in (-1, 0, 1)], 0)
        found[outside] = 0.0
        return np.maximum(found, self._least, out=found)

    def _linear(self, at: Any, step_x: Any, step_y: Any, x: Floats, y: Floats, z: Floats) -> Floats:
        """The trilinear interpolant in cells at `at`, at fractions of their edges."""
        values, beside = self._values[:-1], self._values[1:]

        def along_z(at: Any) -> Floats:
            low = values.take(at, mode="clip")
            high = beside.take(at, mode="clip")
            high -= low
            high *= z
            high += low
            return high

        def along_y(at: Any) -> Floats:
            low = along_z(at)
            high = along_z(at + step_y)
            high -= low
            high *= y
            high += low
            return high

        low = along_y(at)
        high = along_y(at + step_x)
        high -= low
        high *= x
        high += low
        return high


def _kind(blocks: Sequence[Block], interpolation: str) -> str:
    """What all blocks have values of, which the interpolation has to be for."""
    for number, block in enumerate(blocks):
        if block.values_at not in _VALUES_AT:
            raise SceneError(
                f"`values_at` of block {number} is {block.values_at!r}: expected 'cells' or 'nodes'"
            )
        if block.values_at != blocks[0].values_at:
            raise SceneError(
                f"block {number} has values at {block.values_at}, and block 0 at "
                f"{blocks[0].values_at}: expected the same of all blocks"
            )
    kind = blocks[0].values_at
    if interpolation not in _VALUES_AT[kind]:
        expected = " or ".join(map(repr, _VALUES_AT[kind]))
        raise SceneError(
            f"`interpolation` is {interpolation!r}: expected {expected} for values at {kind}"
        )
    return kind


def _numbers(values: Any, unit: str | None, name: str) -> Floats:
    """An array of 64-bit floats, of a quantity in `unit`."""
    return real(_units.value_in(values, unit, name.replace("`", "")), name, "numbers")
