"""The file of a plan: NumPy's .npz with a name and a version."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _npz
from emitree._points import Points
from emitree._sparse import SparseMatrix

#: What the entry `format` of each file is.
FORMAT = "emitree plan"

#: The version of what is written; files of a higher one are refused.
VERSION = 1

#: The entries of a file; `energy` is there if the points have energies.
_ENTRIES = ("position", "direction", "data", "indices", "indptr", "seen", "unit")


@dataclass(frozen=True)
class Content:
    """What a file has: points, the matrix, and where there is an image."""

    points: Points
    matrix: SparseMatrix
    #: Whether each value of the image is a number, of the shape of the image.
    seen: NDArray[np.bool_]
    #: The unit of the rates.
    unit: str | None


def encoded(content: Content) -> bytes:
    """The bytes of a file."""
    points, matrix = content.points, content.matrix
    # Indices of 4 bytes, as far as they suffice.
    largest = max(matrix.shape[1], len(matrix.data))
    integer = np.int32 if largest < 2**31 else np.int64
    arrays: dict[str, Any] = {
        "position": points.position,
        "direction": points.direction,
        "data": matrix.data,
        "indices": matrix.indices.astype(integer),
        "indptr": matrix.indptr.astype(integer),
        "seen": content.seen,
        "unit": content.unit or "",
    }
    if points.energy is not None:
        arrays["energy"] = points.energy
    return _npz.encoded(FORMAT, VERSION, arrays)


def content(path: str | os.PathLike[str]) -> Content:
    """The content of a file; raises `ValueError` with its name if it is not that of a plan."""
    arrays = _npz.arrays_of(path, "a plan", FORMAT, VERSION, _ENTRIES)
    return _checked(os.fspath(path), arrays)


def _checked(name: str, arrays: dict[str, Any]) -> Content:
    """The arrays of a file, whose sizes agree."""
    points = Points(arrays["position"], arrays["direction"], arrays.get("energy"))
    seen, indptr, indices = arrays["seen"], arrays["indptr"], arrays["indices"]
    count = len(points)
    agree = (
        points.position.shape == points.direction.shape == (count, 3)
        and (points.energy is None or points.energy.shape == (count,))
        and indptr.shape == (seen.size + 1,)
        and indices.shape == arrays["data"].shape == (indptr[-1],)
        and bool(np.all(np.diff(indptr) >= 0))
        and (indices.size == 0 or (indices.min() >= 0 and indices.max() < count))
    )
    if not agree:
        raise ValueError(
            f"{name}: the arrays of the plan do not agree: expected weights of {seen.size} pixels "
            f"for {count} points"
        )
    matrix = SparseMatrix(arrays["data"], indices, indptr, (seen.size, count))
    return Content(points, matrix, seen.astype(bool), str(arrays["unit"]) or None)
