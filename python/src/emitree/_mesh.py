"""A mesh: the frozen quadrature of a session."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _native
from emitree._function import Floats, as_rates
from emitree._points import Points


@dataclass(frozen=True)
class SparseMatrix:
    """A sparse matrix in compressed rows: the arguments of `scipy.sparse.csr_array`.

    Row r has the weights data[indptr[r]:indptr[r + 1]] in the columns
    indices[indptr[r]:indptr[r + 1]]. With scipy it is
    `scipy.sparse.csr_array((matrix.data, matrix.indices, matrix.indptr), matrix.shape)`.
    """

    data: Floats
    indices: NDArray[np.int64]
    indptr: NDArray[np.int64]
    shape: tuple[int, int]


class Mesh:
    """The frozen quadrature of a session: points, and a linear map from rates there to an image.

    With the rates of its own emission `apply` returns the image of the rendering, to rounding. For
    another emission it is as good as the same points and weights are for that one, and it gives no
    error estimate. Of products (smooth emissions, method "vol") the points are pivots alone, and
    the other emission is taken to be in the span of the functions found, which hardly any is.

    >>> import emitree, numpy as np
    >>> session = emitree.Session(emitree.Canonical(), (16, 16), method="paper")
    >>> while points := session.ask():
    ...     session.tell(np.exp(-100 * ((points.position - 0.5) ** 2).sum(axis=1)))
    >>> mesh = session.mesh()
    >>> rates = np.exp(-90 * ((mesh.points.position - 0.5) ** 2).sum(axis=1))
    >>> mesh.apply(rates).shape
    (16, 16)
    """

    def __init__(self, native: _native.Mesh, unit: str | None) -> None:
        self._native = native
        self._unit = unit
        #: The points at which rates are needed; none is there twice.
        self.points = Points(*native.points())

    def __len__(self) -> int:
        return len(self._native)

    def apply(self, rates: Any) -> Floats:
        """The image or the cube, as `Rendering.image`, for rates (n,) at the `points` in `unit`."""
        values = self._native.apply(as_rates(rates, len(self), self._unit))
        return values if self._native.is_cube else values[0]

    @property
    def weights(self) -> SparseMatrix:
        """The weights of the rates in the values at nodes: lines of sight, cells or pivots."""
        return _matrix(self._native.weights())

    def matrix(self) -> SparseMatrix:
        """The whole map as one matrix, (pixels, points): times the rates it is the image, ravelled.

        It takes an image for each node, and is for small images. Rows of pixels without an image
        are empty; `apply` has NaN there.
        """
        return _matrix(self._native.matrix())


def _matrix(rows: Any) -> SparseMatrix:
    indptr, indices, data, shape = rows
    return SparseMatrix(data=data, indices=indices, indptr=indptr, shape=shape)
