"""The map of a plan as a product of two matrices, small enough to be kept on a device.

Many columns of the matrix (pixels, points) are proportional to each other: those of the points of
one line of sight, and of a product of functions those of all depths z_k of one pair (x_i, y_j).
They are stored as one response, and each point has one number: how much its rate adds to which
response. A plan of 1,848 points for a torus has 154 responses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._sparse import SparseMatrix

#: Columns are proportional if they agree to this fraction of their largest value: rounding.
_ROUNDING = 1e-13
#: Columns are compared where two of their sums agree to this fraction.
_SIMILAR = 1e-9
#: From this fraction of numbers that are not 0 on, responses are a full matrix.
_DENSE = 0.1

_Integers = NDArray[np.int32]


@dataclass(frozen=True)
class Table:
    """A sparse matrix with as many weights in each row: a product of it is a gather and a sum.

    Shorter rows are filled with weights 0, so that no two threads ever add to the same number.
    """

    #: The columns of the weights (rows, weights of a row).
    columns: _Integers
    #: The weights (rows, weights of a row).
    weights: Floats


@dataclass(frozen=True)
class Factors:
    """The values of a plan's image, ravelled: responses @ (gathered @ rates)."""

    #: The sums of rates (responses, points).
    gathered: Table
    #: The image of each sum (pixels, responses).
    responses: Floats | Table


@dataclass(frozen=True)
class _Column:
    """The numbers of a column that are not 0, divided by the largest."""

    rows: _Integers
    values: Floats

    def equals(self, other: _Column) -> bool:
        if not np.array_equal(self.rows, other.rows):
            return False
        return bool(abs(self.values - other.values).max(initial=0.0) <= _ROUNDING)


def factors(
    column_of: Callable[[int], Floats], count: int, pixels: int, nodes: SparseMatrix | None = None
) -> Factors:
    """The factors of a matrix (pixels, points).

    column_of: its column for a point, NaN in pixels without an image. It is called once for each
        node, and for each point that several nodes use.
    count: the number of points; pixels: the number of values.
    nodes: the weights (nodes, points) of the rates in values at nodes, if the image depends on the
        rates by these alone: then all points of one node have proportional columns.

    >>> import numpy as np
    >>> matrix = np.array([[1.0, 2.0, 0.0], [3.0, 6.0, 0.0]])
    >>> found = factors(lambda point: matrix[:, point], 3, 2)
    >>> found.responses.round(3).tolist(), found.gathered.weights.tolist()
    ([[0.333], [1.0]], [[3.0, 6.0]])
    """
    first, relative = np.arange(count), np.ones(count)
    if nodes is not None:
        first, relative = _representatives(nodes)
    groups: list[_Column] = []
    sums = np.empty((count, 2))
    of_points, scales = np.full(count, -1), np.zeros(count)
    for point in np.unique(first).tolist():
        column, scale = _column(column_of(point))
        if column is None:
            continue
        similar = np.array([column.values.sum(), (column.values**2).sum()])
        known = sums[: len(groups)]
        near = (abs(known - similar) <= _SIMILAR * abs(similar)).all(axis=1)
        group = next((g for g in np.flatnonzero(near) if groups[g].equals(column)), len(groups))
        if group == len(groups):
            sums[group] = similar
            groups.append(column)
        of_points[point], scales[point] = group, scale
    of_points, scales = of_points[first], scales[first] * relative
    seen = np.flatnonzero(of_points >= 0)
    gathered = _table(of_points[seen], seen, scales[seen], len(groups))
    return Factors(gathered, _responses(groups, pixels))


def _representatives(weights: SparseMatrix) -> tuple[NDArray[np.int64], Floats]:
    """For each point one with a proportional column, and the ratio of the two."""
    count = weights.shape[1]
    first, relative = np.arange(count), np.ones(count)
    alone = np.bincount(weights.indices, minlength=count) == 1
    for low, high in zip(weights.indptr[:-1], weights.indptr[1:], strict=True):
        points, of_node = weights.indices[low:high], weights.data[low:high]
        usable = alone[points] & (of_node != 0)
        if usable.any():
            largest = int(np.argmax(np.where(usable, abs(of_node), 0.0)))
            first[points[usable]] = points[largest]
            relative[points[usable]] = of_node[usable] / of_node[largest]
    return first, relative


def _column(values: Floats) -> tuple[_Column | None, float]:
    """A column over its largest value, and this value; None if all are 0."""
    found = np.nan_to_num(values.ravel())
    rows = np.flatnonzero(found)
    if len(rows) == 0:
        return None, 0.0
    scale = float(found[np.argmax(abs(found))])
    return _Column(rows.astype(np.int32), found[rows] / scale), scale


def _responses(groups: list[_Column], pixels: int) -> Floats | Table:
    sizes = [len(column.rows) for column in groups]
    if sum(sizes) >= _DENSE * pixels * len(groups):
        full = np.zeros((pixels, len(groups)))
        for number, column in enumerate(groups):
            full[column.rows, number] = column.values
        return full
    rows = np.concatenate([column.rows for column in groups])
    values = np.concatenate([column.values for column in groups])
    return _table(rows, np.repeat(np.arange(len(groups)), sizes), values, pixels)


def _table(
    rows: NDArray[np.integer], columns: NDArray[np.integer], weights: Floats, count: int
) -> Table:
    """The table of `count` rows with some weights."""
    order = np.argsort(rows, kind="stable")
    rows, columns, weights = rows[order], columns[order], weights[order]
    sizes = np.bincount(rows, minlength=count)
    ends = np.cumsum(sizes)
    places = np.arange(len(rows)) - (ends - sizes)[rows]
    most = int(sizes.max(initial=0))
    found = Table(np.zeros((count, most), np.int32), np.zeros((count, most)))
    # A rate that is no number is to reach no other rows.
    used = np.flatnonzero(sizes)
    found.columns[used] = columns[(ends - sizes)[used]][:, np.newaxis]
    found.columns[rows, places] = columns
    found.weights[rows, places] = weights
    return found
