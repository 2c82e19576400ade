"""Sparse matrices in compressed rows, and their products without scipy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats


@dataclass(frozen=True)
class SparseMatrix:
    """A sparse matrix in compressed rows: the arguments of `scipy.sparse.csr_array`.

    Row r has the weights data[indptr[r]:indptr[r + 1]] in the columns
    indices[indptr[r]:indptr[r + 1]]. With scipy it is
    `scipy.sparse.csr_array((matrix.data, matrix.indices, matrix.indptr), matrix.shape)`.
    """

    data: Floats
    indices: NDArray[np.integer[Any]]
    indptr: NDArray[np.integer[Any]]
    shape: tuple[int, int]

    @cached_property
    def _rows(self) -> NDArray[np.integer[Any]]:
        """The row of each weight."""
        return np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))

    def times(self, values: Floats) -> Floats:
        """The product with a vector (columns,), a vector (rows,).

        >>> import numpy as np
        >>> matrix = SparseMatrix(np.array([2.0, 3.0]), np.array([1, 0]), np.array([0, 2]), (1, 2))
        >>> matrix.times(np.array([1.0, 10.0]))
        array([23.])
        """
        weighted = self.data * values[self.indices]
        return np.bincount(self._rows, weighted, minlength=self.shape[0]).astype(np.float64)

    def transpose_times(self, values: Floats) -> Floats:
        """The product of the transpose with a vector (rows,), a vector (columns,).

        >>> import numpy as np
        >>> matrix = SparseMatrix(np.array([2.0, 3.0]), np.array([1, 0]), np.array([0, 2]), (1, 2))
        >>> matrix.transpose_times(np.array([10.0]))
        array([30., 20.])
        """
        weighted = self.data * values[self._rows]
        return np.bincount(self.indices, weighted, minlength=self.shape[1]).astype(np.float64)

    @cached_property
    def _by_columns(self) -> tuple[NDArray[np.integer[Any]], NDArray[np.integer[Any]]]:
        """The weights in the order of their columns, and where each column begins."""
        order = np.argsort(self.indices, kind="stable")
        sizes = np.bincount(self.indices, minlength=self.shape[1])
        return order, np.concatenate(([0], np.cumsum(sizes)))

    def column(self, number: int) -> Floats:
        """A column (rows,).

        >>> import numpy as np
        >>> matrix = SparseMatrix(np.array([2.0, 3.0]), np.array([1, 0]), np.array([0, 2]), (1, 2))
        >>> matrix.column(1)
        array([2.])
        """
        order, begins = self._by_columns
        of_column = order[begins[number] : begins[number + 1]]
        found = np.zeros(self.shape[0])
        found[self._rows[of_column]] = self.data[of_column]
        return found


def compressed_rows(rows: Any) -> SparseMatrix:
    """The matrix of what the compiled part returns: (indptr, indices, data, shape)."""
    indptr, indices, data, shape = rows
    return SparseMatrix(data=data, indices=indices, indptr=indptr, shape=shape)
