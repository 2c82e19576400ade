"""Values beyond the borders of blocks, for the interpolation up to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from emitree._amr_lattice import Integers, Lattice, Place
from emitree._function import Floats
from emitree._native import SceneError


def painted(lattice: Lattice, places: Sequence[Place], layers: int = 1) -> list[Floats]:
    """The values of all blocks with layers of cells around each; all tiles are painted.

    Cells of a block that lie entirely under a finer block have the mean of its cells. A cell of the
    layer has, in this order: the value of a block of the same level; the interpolant of the finest
    coarser block, at its centre; the mean of finer cells; outside of all blocks, the value of the
    nearest cell of the block. One beyond the box around all blocks has what the nearest place for
    a cell within the box would have.
    """
    levels = _levels(lattice)
    parents: dict[int, list[int]] = {}
    overlapped: dict[int, list[int]] = {}
    for blocks in levels:
        for block in blocks:
            below = np.unique(lattice.tiles[lattice.region(block)])
            parents[block] = below[below >= 0].tolist()
        for block in blocks:
            overlapped[block] = _paint(lattice, places, block)
    values = [place.values.copy() for place in places]
    for blocks in reversed(levels):
        for block in blocks:
            for other in overlapped[block]:
                ours, theirs, _ = _common(lattice, block, other)
                values[other][theirs] = values[block][ours]
            for parent in parents[block]:
                _restrict(lattice, values, block, parent)
    padded = [np.pad(of, layers, mode="edge") for of in values]
    # Without the finer levels, which would hide the blocks of the same level.
    so_far = replace(lattice, tiles=np.full_like(lattice.tiles, -1))
    for blocks in levels:
        for block in blocks:
            so_far.tiles[so_far.region(block)] = block
        for block in blocks:
            _fill(lattice, so_far, values, padded, block, layers)
    return padded


def nodal(lattice: Lattice, places: Sequence[Place]) -> list[Floats]:
    """The values of blocks with values at nodes, which need no layers; all tiles are painted."""
    for blocks in _levels(lattice):
        for block in blocks:
            _paint(lattice, places, block)
    return [place.values for place in places]


def _levels(lattice: Lattice) -> list[list[int]]:
    """The blocks of each level, from the coarsest."""
    return [np.flatnonzero(lattice.level == level).tolist() for level in np.unique(lattice.level)]


def _paint(lattice: Lattice, places: Sequence[Place], block: int) -> list[int]:
    """Enters a block into the tiles, and finds others of its level that are hidden by it.

    One with other values is an error.
    """
    region = lattice.region(block)
    below: list[int] = np.unique(lattice.tiles[region]).tolist()
    level = lattice.level[block]
    overlapped = [other for other in below if other >= 0 and lattice.level[other] == level]
    for other in overlapped:
        ours, theirs, low = _common(lattice, block, other)
        is_of_nodes = places[block].is_of_nodes
        if is_of_nodes:
            ours, theirs = (
                tuple(slice(of.start, of.stop + 1) for of in cells) for cells in (ours, theirs)
            )
        mine, others = places[block].values[ours], places[other].values[theirs]
        if not np.array_equal(mine, others):
            at = np.unravel_index(int(np.argmax(mine != others)), mine.shape)
            inner = 0.0 if is_of_nodes else 0.5
            where = lattice.origin + (low + (np.array(at) + inner) * lattice.ratio[block]) * (
                lattice.width
            )
            place = ", ".join(f"{coordinate:.6g}" for coordinate in where)
            raise SceneError(
                f"block {block} and block {other} of level {level} overlap, and "
                f"have {mine[at]:.6g} and {others[at]:.6g} at ({place}): expected the same value"
            )
    lattice.tiles[region] = block
    return overlapped


def _common(
    lattice: Lattice, block: int, other: int
) -> tuple[tuple[slice, ...], tuple[slice, ...], Integers]:
    """The cells that two blocks of a level share, of each block; and their least corner."""
    low = np.maximum(lattice.lower[block], lattice.lower[other])
    high = np.minimum(lattice.upper[block], lattice.upper[other])
    first, second = (
        tuple(
            slice(int(start), int(end))
            for start, end in zip(
                (low - lattice.lower[of]) // lattice.ratio[of],
                (high - lattice.lower[of]) // lattice.ratio[of],
                strict=True,
            )
        )
        for of in (block, other)
    )
    return first, second, low


def _restrict(lattice: Lattice, values: list[Floats], fine: int, coarse: int) -> None:
    """Means of a fine block in the cells of a coarser one that lie entirely under it."""
    ratio = lattice.ratio[coarse]
    # Cells of the coarse block.
    low = np.maximum(lattice.lower[fine], lattice.lower[coarse]) - lattice.lower[coarse]
    high = np.minimum(lattice.upper[fine], lattice.upper[coarse]) - lattice.lower[coarse]
    low, high = -(-low // ratio), high // ratio
    if (high <= low).any():
        return
    # The same in cells of the fine one.
    per_cell = ratio // lattice.ratio[fine]
    shift = (lattice.lower[coarse] - lattice.lower[fine]) // lattice.ratio[fine]
    start = shift + low * per_cell
    count = high - low
    part = values[fine][
        tuple(slice(int(a), int(a + n)) for a, n in zip(start, count * per_cell, strict=True))
    ]
    (nx, ny, nz), (rx, ry, rz) = count, per_cell
    means = part.reshape(nx, rx, ny, ry, nz, rz).mean(axis=(1, 3, 5))
    values[coarse][tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))] = means


def quadratic(padded: Floats) -> Floats:
    """The coefficients of a quadratic spline, with one layer, from values with two layers.

    Less an eighth of the second difference along each axis, a spline of the values reproduces
    quadratic functions: C. de Boor and G. J. Fix 1973, doi:10.1016/0021-9045(73)90029-4.
    """
    found = padded
    for axis in range(3):
        along = np.moveaxis(found, axis, 0)
        found = np.moveaxis(along[1:-1] - (along[2:] - 2 * along[1:-1] + along[:-2]) / 8, 0, axis)
    return found


def _fill(
    lattice: Lattice,
    so_far: Lattice,
    values: list[Floats],
    padded: list[Floats],
    block: int,
    layers: int,
) -> None:
    """Fills the layers around a block; all coarser blocks have theirs.

    so_far: the lattice with the tiles of this level and of the coarser ones.
    """
    is_layer = np.ones(padded[block].shape, dtype=bool)
    is_layer[(slice(layers, -layers),) * 3] = False
    at = np.nonzero(is_layer)
    ratio = lattice.ratio[block]
    # Beyond the box, the layer is that of the cells at its faces.
    centres = [
        np.clip(low + (of - layers + 0.5) * edge, edge / 2, count - edge / 2)
        for of, low, edge, count in zip(at, lattice.lower[block], ratio, lattice.count, strict=True)
    ]
    layer = padded[block][at]
    owners = so_far.block_at(centres)
    for owner in np.unique(owners[owners >= 0]):
        chosen = owners == owner
        points = [of[chosen] for of in centres]
        if lattice.level[owner] == lattice.level[block]:
            layer[chosen] = _nearest(lattice, values, owner, points)
        else:
            layer[chosen] = _linear(lattice, padded, owner, points, layers)
    beyond = owners < 0
    points = [of[beyond] for of in centres]
    layer[beyond] = _means(lattice, values, block, points, layer[beyond])
    padded[block][at] = layer


def _means(
    lattice: Lattice, values: list[Floats], block: int, centres: list[Floats], others: Floats
) -> Floats:
    """Means of finer cells over cells of a block's size; where there are none, other values."""
    finer = lattice.ratio[lattice.level > lattice.level[block]]
    if len(finer) == 0:
        return others
    ratio = lattice.ratio[block]
    parts = ratio // finer.max(axis=0)
    total, count = np.zeros(len(others)), np.zeros(len(others))
    for part in np.ndindex(*(int(of) for of in parts)):
        shift = ((np.array(part) + 0.5) / parts - 0.5) * ratio
        points = [of + by for of, by in zip(centres, shift, strict=True)]
        owners = lattice.block_at(points)
        for owner in np.unique(owners[owners >= 0]):
            chosen = owners == owner
            total[chosen] += _nearest(lattice, values, int(owner), [of[chosen] for of in points])
            count[chosen] += 1
    return np.where(count > 0, total / np.maximum(count, 1), others)


def _nearest(lattice: Lattice, values: list[Floats], block: int, points: list[Floats]) -> Floats:
    """The values of a block's cells at points in it, which are in smallest cells."""
    at = tuple(
        ((of - low) // ratio).astype(np.int64)
        for of, low, ratio in zip(points, lattice.lower[block], lattice.ratio[block], strict=True)
    )
    return np.asarray(values[block][at])


def _linear(
    lattice: Lattice, padded: list[Floats], block: int, points: list[Floats], layers: int
) -> Floats:
    """The trilinear interpolant of a block with its layers, at points in it."""
    of = padded[block]
    where = [
        (point - low) / ratio + (layers - 0.5)
        for point, low, ratio in zip(
            points, lattice.lower[block], lattice.ratio[block], strict=True
        )
    ]
    first = [np.floor(t).astype(np.int64) for t in where]
    weights = [t - i for t, i in zip(where, first, strict=True)]
    total = np.zeros(len(points[0]))
    for corner in np.ndindex(2, 2, 2):
        weight = np.ones(len(total))
        for w, c in zip(weights, corner, strict=True):
            weight *= w if c else 1 - w
        total += weight * of[tuple(i + c for i, c in zip(first, corner, strict=True))]
    return total
