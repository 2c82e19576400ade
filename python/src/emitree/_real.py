"""Arrays of real numbers, from what is given as such."""

from __future__ import annotations

from typing import Any

import numpy as np

from emitree._function import Floats
from emitree._native import SceneError


def real(values: Any, name: str, expected: str) -> Floats:
    """An array of 64-bit floats, of any array or list of numbers.

    name, expected: of messages.

    Raises `SceneError` of values that are masked, and of those that are no real numbers: complex
    ones, times and texts.

    >>> real([[1, 2], [3, 4]], "`values`", "numbers")
    array([[1., 2.],
           [3., 4.]])
    >>> real(np.ma.masked_equal([1, 2, 2], 2), "`values`", "numbers")
    Traceback (most recent call last):
    emitree.SceneError: `values` is masked at (1,) and 1 other place: expected numbers (`filled` \
makes numbers of them)
    """
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        places = np.argwhere(np.ma.getmaskarray(values))
        first, others = tuple(places[0].tolist()), len(places) - 1
        more = f" and {others} other place{'s' if others > 1 else ''}" if others else ""
        raise SceneError(
            f"{name} is masked at {first}{more}: expected {expected} (`filled` makes numbers of "
            "them)"
        )
    try:
        found = np.asarray(values)
        if found.dtype.kind == "O":
            found = found.astype(np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"{name} is {type(values).__name__}: expected {expected}") from None
    if found.dtype.kind not in "fiub":
        is_array = hasattr(values, "dtype")
        what = f"an array of {found.dtype}" if is_array else type(values).__name__
        raise SceneError(f"{name} is {what}: expected {expected}")
    return np.asarray(found, dtype=np.float64)
