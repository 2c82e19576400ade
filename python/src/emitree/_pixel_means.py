"""Means of line integrals over pixels, with an error for each: cells of pixels are divided.

A cell has nine lines of sight. Its mean is that of Gauss's rule with four of them. The error is
estimated by the difference from another rule of the same degree, with the centre and the corners,
and by the residual of a quadratic polynomial that is fitted to all nine: one of them sees a kink or
a jump wherever it is. The error of a pixel is the sum over its cells, without cancellation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._along import summed
from emitree._cells import CORNERS, FINEST, GAUSS, PLACES, Cells, Integers
from emitree._function import Floats
from emitree._responses import Response
from emitree._sight import Lines, Tubes, View, tubes_of

#: Rows of pixels, and columns of a block of them, that are examined together.
_BLOCK = 8
#: Numbers of lines times columns that are integrated together.
_TOGETHER = 1 << 15
#: By how much the difference of the two rules is multiplied, and the residual of the polynomial:
#: then the error is at most the larger one for kinks, jumps and square roots along straight lines
#: through a cell (4500 random ones; with the difference alone 4 % have larger errors).
_OF_RULES, _OF_RESIDUAL = 1.5, 0.7


def _residuals() -> Floats:
    """A basis (3, places) of what no quadratic polynomial has at `PLACES`, orthonormal."""
    x, y = PLACES.T
    quadratics = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    return np.linalg.svd(quadratics)[0][:, quadratics.shape[1] :].T


_RESIDUALS = _residuals()
#: Of the error that a pixel may have, what each line may.
_OF_LINES = 0.2


@dataclass(frozen=True)
class Means:
    """Means over pixels, of pairs (n,) of a pixel and a function, or of all functions together."""

    #: Numbers (n,), row by row.
    pixel: Integers
    #: Numbers (n,) of functions; 0 if all are together.
    which: Integers
    #: (n, columns).
    value: Floats
    error: Floats
    #: How many integrals along a line, and evaluations of functions, it took.
    lines: int
    evaluations: int


@dataclass(frozen=True)
class _Sampled:
    """The lines (cells, places) of some cells."""

    lines: Lines
    tubes: Tubes
    #: Whether the density has a kink or a jump within a cell (cells,).
    has_kink: NDArray[np.bool_]


@dataclass(frozen=True)
class _OfCells:
    """What cells add to the integrals over their pixels, before the area."""

    #: Of density and response (cells, columns), and of the density (cells,).
    integral: Floats
    weight: Floats
    error: Floats
    lines: int
    evaluations: int


def strips(view: View) -> list[range]:
    """The rows of pixels that `first_means` takes together."""
    height = view.shape[0]
    return [range(top, min(top + _BLOCK, height)) for top in range(0, height, _BLOCK)]


def first_means(view: View, response: Response, rows: range) -> Means:
    """The means over the pixels of some rows, from nine lines each."""
    width = view.shape[1]
    pixel = np.arange(rows.start * width, rows.stop * width)
    cells = Cells.whole(pixel)
    lines = view.lines_of(cells)
    tubes = tubes_of(lines)
    seen = tubes.lines.density > 0.0
    column = pixel % width
    blocks = [
        np.flatnonzero((column >= left) & (column < left + _BLOCK) & seen)
        for left in range(0, width, _BLOCK)
    ]
    blocks = [block for block in blocks if len(block) > 0]
    if not blocks:
        nothing = np.zeros((0, response.columns))
        none = np.zeros(0, dtype=np.int64)
        return Means(none, none, nothing, nothing, 0, 0)
    number, which = response.candidates(tubes, blocks)
    sampled = _Sampled(lines, tubes, view.has_kink(cells))
    found = _of_cells(response, sampled, number, which)
    weight = found.weight[:, np.newaxis]
    return Means(
        pixel[number],
        which,
        _quotient(found.integral, weight),
        found.error / weight,
        found.lines,
        found.evaluations,
    )


def refined(
    view: View, response: Response, pixel: Integers, which: Integers, target: Floats
) -> Means:
    """The means over some pixels, with errors (n, columns) as far as cells can be divided."""
    count = len(pixel)
    value, error = np.zeros_like(target), np.full_like(target, np.inf)
    cells, item = Cells.whole(pixel), np.arange(count)
    columns = response.columns
    integral, weight, of_cells = np.zeros((0, columns)), np.zeros(0), np.zeros((0, columns))
    kept, kept_item = cells[:0], item[:0]
    lines = evaluations = 0
    while len(item) > 0:
        distinct, number = cells.distinct()
        lines_of = view.lines_of(distinct)
        sampled = _Sampled(lines_of, tubes_of(lines_of), view.has_kink(distinct))
        means = value[item] if len(kept_item) > 0 or cells.level.any() else None
        found = _of_cells(response, sampled, number, which[item], target[item], means)
        lines, evaluations = lines + found.lines, evaluations + found.evaluations
        cells, item = _joined(kept, cells), np.concatenate([kept_item, item])
        integral = np.concatenate([integral, found.integral])
        weight = np.concatenate([weight, found.weight])
        of_cells = np.concatenate([of_cells, found.error])
        area = cells.area()[:, np.newaxis]
        whole = summed(item, area * weight[:, np.newaxis], count)
        open_items = np.unique(item)
        share = _quotient(area * of_cells, whole[item])
        value[open_items] = _quotient(summed(item, area * integral, count), whole)[open_items]
        error[open_items] = summed(item, share, count)[open_items]
        is_open = ~np.all(error <= target, axis=1)
        numbers = np.bincount(item, minlength=count)[:, np.newaxis]
        is_split = np.any(share > (0.5 * target / np.maximum(numbers, 1))[item], axis=1)
        is_split &= is_open[item] & (cells.level < FINEST)
        # A pixel none of whose cells can be divided stays as it is.
        is_open &= np.bincount(item, is_split, minlength=count) > 0
        stays = is_open[item] & ~is_split
        kept, kept_item = cells[stays], item[stays]
        integral, weight, of_cells = integral[stays], weight[stays], of_cells[stays]
        cells, item = cells[is_split].quarters(), np.repeat(item[is_split], 4)
    return Means(pixel, which, value, error, lines, evaluations)


def _joined(cells: Cells, others: Cells) -> Cells:
    return Cells(
        np.concatenate([cells.pixel, others.pixel]),
        np.concatenate([cells.level, others.level]),
        np.concatenate([cells.row, others.row]),
        np.concatenate([cells.column, others.column]),
    )


def _of_cells(
    response: Response,
    sampled: _Sampled,
    number: Integers,
    which: Integers,
    target: Floats | None = None,
    means: Floats | None = None,
) -> _OfCells:
    """The integrals of functions (n,) over cells with the numbers (n,) among some cells.

    target: the errors (n, columns) that pixels may have; means: their means (n, columns) so far.
    """
    lines, tubes = sampled.lines, sampled.tubes
    count, columns = len(number), response.columns
    places = lines.near.shape[1]
    integral, error = np.empty((count, columns)), np.empty((count, columns))
    weight = np.empty(count)
    evaluations = 0
    together = max(1, _TOGETHER // (places * columns))
    for begin in range(0, count, together):
        some = slice(begin, begin + together)
        cells = number[some]
        of_lines = None if target is None else _OF_LINES * target[some]
        found = response.along(lines[cells], tubes[cells], which[some], of_lines)
        evaluations += found.evaluations
        density = lines.density[cells]
        weighted = density[..., np.newaxis] * found.value
        weight[some] = density @ GAUSS
        integral[some] = np.einsum("npc,p->nc", weighted, GAUSS)
        # A response that is the same in all of a pixel has no error, whatever the density is.
        own = _quotient(integral[some], weight[some, np.newaxis])
        mean = own if means is None else means[some]
        change = weighted - mean[:, np.newaxis] * density[..., np.newaxis]
        of_rules = abs(np.einsum("npc,p->nc", change, GAUSS - CORNERS))
        residual = np.sqrt((np.einsum("npc,rp->nrc", change, _RESIDUALS) ** 2).sum(axis=1))
        largest = density.max(axis=1)[:, np.newaxis]
        error[some] = np.maximum(_OF_RULES * of_rules, _OF_RESIDUAL * residual)
        # With a kink of the density any mean of the values may be the right one.
        kinked = np.flatnonzero(sampled.has_kink[cells])
        if len(kinked) > 0:
            farthest = abs(found.value[kinked] - mean[kinked, np.newaxis]).max(axis=1)
            error[some][kinked] = np.maximum(error[some][kinked], largest[kinked] * farthest)
        error[some] += largest * found.unseen
        error[some] += np.einsum("np,npc,p->nc", density, found.error, GAUSS)
    return _OfCells(integral, weight, error, count * places * columns, evaluations)


def _quotient(numerator: Floats, denominator: Floats) -> Floats:
    """A quotient, 0 where the denominator is 0."""
    known = denominator != 0.0
    return np.where(known, numerator / np.where(known, denominator, 1.0), 0.0)
