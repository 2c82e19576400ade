"""Errors that are allowed in values that are integrals along lines, or weighted sums of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree._function import Floats
from emitree._native import SceneError
from emitree._sparse import SparseMatrix

#: Before a value is known, the largest is this fraction of the largest error.
_GUESS = 1e-3


@dataclass(frozen=True)
class Allowance:
    """The errors that are allowed in values, which are lines or weighted sums of lines."""

    #: Relative to the largest |value|, or None.
    tolerance: float | None
    rtol: float
    atol: float
    weights: SparseMatrix | None

    @classmethod
    def of(cls, tolerance: Any, rtol: Any, atol: Any, weights: SparseMatrix | None) -> Allowance:
        """From options, checked."""
        if tolerance is not None and not (rtol is None and atol is None):
            raise SceneError(
                f"`tolerance` is {tolerance} beside `rtol` or `atol`: expected one or the other"
            )
        if rtol is None and atol is None:
            tolerance = 0.01 if tolerance is None else tolerance
        for name, value in (("tolerance", tolerance), ("rtol", rtol)):
            is_number = isinstance(value, float | int) and not isinstance(value, bool)
            if value is not None and not (is_number and 0.0 < value < 1.0):
                raise SceneError(f"`{name}` is {value!r}: expected a number above 0 and below 1")
        if atol is not None and not (isinstance(atol, float | int) and 0.0 < atol < np.inf):
            raise SceneError(f"`atol` is {atol!r}: expected a finite number above 0")
        return cls(tolerance, rtol or 0.0, atol or 0.0, weights)

    def of_image(self, share: float, loosest: float) -> dict[str, float]:
        """The options of `render` for an image with a share of the errors that are allowed.

        loosest: the largest `tolerance` and `rtol`.
        """
        if self.tolerance is not None:
            return {"tolerance": min(share * self.tolerance, loosest)}
        both = {"rtol": min(share * self.rtol, loosest), "atol": share * self.atol}
        return {name: value for name, value in both.items() if value > 0.0}

    def sums(self, values: Floats) -> Floats:
        """The values (m, k) of lines (n, k)."""
        return values if self.weights is None else _product(self.weights, values)

    def bounds(self, errors: Floats) -> Floats:
        """What the errors (m, k) of values are at most, from those of lines (n, k)."""
        return errors if self.weights is None else _product(_absolute(self.weights), errors)

    def of_values(self, values: Floats, errors: Floats, is_final: bool = False) -> Floats:
        """The errors (m, k) that are allowed in values, which have errors (m, k) so far.

        Until the end they are relative to what |value| is at least, which then hardly decreases.
        """
        least = abs(values) if is_final else np.maximum(abs(values) - errors, 0.0)
        if self.tolerance is None:
            return np.asarray(self.atol + self.rtol * least)
        largest = least.max(axis=0, initial=0.0)
        if not is_final:
            largest = np.maximum(largest, _GUESS * errors.max(axis=0, initial=0.0))
        return np.asarray(np.broadcast_to(self.tolerance * largest, values.shape))

    def of_lines(self, values: Floats, errors: Floats) -> Floats:
        """The errors (n, k) that are allowed along lines, so that those of all sums are."""
        if self.weights is None:
            return self.of_values(values, errors)
        allowed = self.of_values(self.sums(values), self.bounds(errors))
        size = _absolute(self.weights).times(np.ones(len(values)))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(size[:, np.newaxis] > 0.0, allowed / size[:, np.newaxis], np.inf)
        of_weight = np.repeat(np.arange(len(size)), np.diff(self.weights.indptr))
        has_weight = self.weights.data != 0.0
        found = np.full(values.shape, np.inf)
        np.minimum.at(found, self.weights.indices[has_weight], share[of_weight[has_weight]])
        return found


def _absolute(weights: SparseMatrix) -> SparseMatrix:
    return SparseMatrix(abs(weights.data), weights.indices, weights.indptr, weights.shape)


def _product(weights: SparseMatrix, values: Floats) -> Floats:
    """The product of a matrix and columns."""
    return np.stack([weights.times(column) for column in values.T], axis=1)
