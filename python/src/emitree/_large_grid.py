"""Data on a Cartesian grid that is larger than memory, read block by block."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from typing import Any

import numpy as np

from emitree import _native
from emitree._cameras import Box
from emitree._function import Floats
from emitree._grid import Grid
from emitree._native import SceneError
from emitree._real import real

#: Nodes beyond a block on each side that its interpolation needs: the slopes of `cubic` and
#: `monotone` at a node follow from the nodes beside it.
_MARGIN = {"linear": 0, "nearest": 0, "cubic": 2, "monotone": 2}
#: The share of the available memory that blocks take, unless `memory_bytes` is given; and the bytes
#: of a node, which the native grid has again.
_SHARE = 0.25
_BYTES_OF_NODE = 16

#: The numbers of a block along x, y and z.
Number = tuple[int, int, int]


class LargeGrid:
    """Emission rates at the nodes of a Cartesian grid that need not fit into memory: a function.

    values: (nx, ny, nz) rates with slices `values[a:b, c:d, e:f]`: a `numpy.memmap`, a dask array,
        a dataset of h5py or zarr, or the variable of a NetCDF file.
    x, y, z: the nodes of the axes, which all increase, in the length unit of the camera.
    interpolation: "linear", "cubic", "monotone" or "nearest", the same as of a `Grid`.
    block: cells along each side of a block, which is read as a whole when a point in it is asked
        for. Chunks of a file are best read by blocks of their size.
    memory_bytes: what the blocks that are kept take together; a quarter of the available memory if
        None. The block that was not used for longest is the first to be dropped.

    Outside of the nodes the rate is 0; `bounds`, their box, is taken by `render`.

    >>> import emitree, numpy as np
    >>> values = np.arange(27.0).reshape(3, 3, 3)
    >>> nodes = np.array([0.0, 1.0, 2.0])
    >>> grid = emitree.LargeGrid(values, x=nodes, y=nodes, z=nodes, block=1)
    >>> grid(np.array([[0.5, 1.0, 1.5], [3.0, 1.0, 1.0]]))
    array([9., 0.])
    """

    def __init__(
        self,
        values: Any,
        *,
        x: Any,
        y: Any,
        z: Any,
        interpolation: str = "linear",
        block: int = 64,
        memory_bytes: int | None = None,
    ) -> None:
        if interpolation not in _MARGIN:
            kinds = ", ".join(map(repr, _MARGIN))
            raise SceneError(f"`interpolation` is {interpolation!r}: expected one of {kinds}")
        if not (isinstance(block, int) and block > 0):
            raise SceneError(f"`block` is {block!r}: expected a number of cells above 0")
        self.values, self.interpolation, self.block = values, interpolation, block
        self._nodes = [_nodes(name, of) for name, of in (("x", x), ("y", y), ("z", z))]
        expected = tuple(len(nodes) for nodes in self._nodes)
        shape = tuple(getattr(values, "shape", ()))
        if shape != expected:
            raise SceneError(
                f"`values` has the shape {shape}: expected {expected}, the numbers of nodes"
            )
        self._most = self._blocks_within(memory_bytes)
        self._kept: OrderedDict[Number, Grid] = OrderedDict()
        self.bounds = Box(
            min=tuple(float(nodes[0]) for nodes in self._nodes),
            max=tuple(float(nodes[-1]) for nodes in self._nodes),
        )

    def _blocks_within(self, memory_bytes: int | None) -> int:
        """How many blocks are kept."""
        cells = self.block + 2 * _MARGIN[self.interpolation]
        of_block = _BYTES_OF_NODE
        for nodes in self._nodes:
            of_block *= min(cells + 1, len(nodes))
        available = _native.available_memory_bytes()
        if memory_bytes is None:
            memory_bytes = int(_SHARE * (available if available is not None else 1 << 32))
        if memory_bytes < of_block:
            raise SceneError(
                f"a block of {self.block} cells a side takes {of_block} bytes: expected at most "
                f"{memory_bytes}, the memory for blocks (a smaller `block` takes less)"
            )
        return memory_bytes // of_block

    def __getstate__(self) -> dict[str, Any]:
        # Workers of an executor read their own blocks.
        return self.__dict__ | {"_kept": OrderedDict()}

    def __repr__(self) -> str:
        shape = tuple(len(nodes) for nodes in self._nodes)
        return f"<emitree.LargeGrid of {shape} nodes, {self.interpolation}>"

    def __call__(self, position: Any, direction: Any = None, energy: Any = None) -> Floats:
        """The rates (n,) at positions (n, 3): 0 outside, and the same in all directions."""
        at = np.ascontiguousarray(position, dtype=np.float64)
        rates = np.zeros(len(at))
        for number, points in self._points_by_block(at):
            rates[points] = self._grid(number)(at[points])
        return rates

    def _points_by_block(self, at: Floats) -> Iterator[tuple[Number, Any]]:
        """The numbers of the blocks, in their order, with those of the points in each."""
        inside = np.ones(len(at), dtype=bool)
        numbers = np.empty((len(at), 3), dtype=np.intp)
        for axis, nodes in enumerate(self._nodes):
            along = at[:, axis]
            inside &= (along >= nodes[0]) & (along <= nodes[-1])
            cell = np.searchsorted(nodes, along, side="right") - 1
            numbers[:, axis] = np.clip(cell, 0, len(nodes) - 2) // self.block
        seen = np.flatnonzero(inside)
        blocks, of_point = np.unique(numbers[seen], axis=0, return_inverse=True)
        order = np.argsort(of_point.ravel(), kind="stable")
        ends = np.cumsum(np.bincount(of_point.ravel(), minlength=len(blocks)))
        for (i, j, k), points in zip(blocks, np.split(order, ends[:-1]), strict=True):
            yield (int(i), int(j), int(k)), seen[points]

    def _grid(self, number: Number) -> Grid:
        """The grid of a block, which is read unless it has been kept."""
        if number not in self._kept:
            parts = [self._part(of, nodes) for of, nodes in zip(number, self._nodes, strict=True)]
            values = np.asarray(self.values[tuple(parts)])
            x, y, z = (nodes[part] for nodes, part in zip(self._nodes, parts, strict=True))
            if len(self._kept) >= self._most:
                self._kept.popitem(last=False)
            self._kept[number] = Grid(
                values=values, x=x, y=y, z=z, interpolation=self.interpolation
            )
        self._kept.move_to_end(number)
        return self._kept[number]

    def _part(self, number: int, nodes: Floats) -> slice:
        """The nodes of a block along an axis, with those beside it."""
        margin = _MARGIN[self.interpolation]
        first, last = number * self.block, (number + 1) * self.block
        return slice(max(first - margin, 0), min(last + margin + 1, len(nodes)))


def _nodes(name: str, nodes: Any) -> Floats:
    found = real(nodes, f"`{name}`", "an array of numbers")
    if found.ndim != 1 or len(found) < 2 or not np.all(np.diff(found) > 0):
        raise SceneError(
            f"`{name}` has the shape {found.shape}: expected two or more nodes, all increasing"
        )
    return found
