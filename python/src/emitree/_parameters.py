"""Checks of parameters, their bounds and ranges, and of data: an error names what was expected."""

from __future__ import annotations

from typing import Any

import numpy as np

from emitree._function import Floats


def checked_parameters(theta: Any) -> Floats:
    """Parameters (p,) as an array of finite numbers.

    >>> checked_parameters((1, 2))
    array([1., 2.])
    """
    parameters = np.array(theta, dtype=np.float64)
    if parameters.ndim != 1:
        raise ValueError(f"`theta` has the shape {parameters.shape}: expected (p,)")
    for number, value in enumerate(parameters):
        if not np.isfinite(value):
            raise ValueError(f"parameter {number} of `theta` is {value}: expected a finite number")
    return parameters


def checked_bounds(bounds: Any) -> Floats | None:
    """Bounds (p, 2), infinite where there is no limit."""
    if bounds is None:
        return None
    limits = []
    for number, pair in enumerate(bounds):
        if len(pair) != 2:
            raise ValueError(f"the bounds of parameter {number} are {pair}: expected (low, high)")
        low = -np.inf if pair[0] is None else float(pair[0])
        high = np.inf if pair[1] is None else float(pair[1])
        if not low < high:
            raise ValueError(f"the bounds of parameter {number} are {pair}: expected low < high")
        limits.append((low, high))
    return np.array(limits)


def checked_ranges(ranges: Any, bounds: Floats | None) -> Floats | None:
    """Ranges (p,), positive."""
    if ranges is None:
        return None
    found = np.array(ranges, dtype=np.float64)
    if found.ndim != 1 or not np.all(found > 0):
        raise ValueError(f"`ranges` are {ranges}: expected a positive number for each parameter")
    if bounds is not None and len(bounds) != len(found):
        raise ValueError(f"`ranges` are {len(found)}: expected {len(bounds)}, as many as `bounds`")
    return found


def default_ranges(theta: Floats, bounds: Floats | None, linear: tuple[int, ...]) -> Floats:
    """The sizes of parameters, or the widths of their bounds if these are less."""
    ranges = np.where(theta == 0, np.inf, abs(theta))
    if bounds is not None:
        ranges = np.minimum(ranges, bounds[:, 1] - bounds[:, 0])
    ranges[list(linear)] = 1.0
    for number, size in enumerate(ranges):
        if not np.isfinite(size):
            raise ValueError(
                f"parameter {number} is 0 at first, and has no bounds: expected `ranges`, over "
                "which each parameter changes the image"
            )
    return ranges


def checked_sigma(sigma: Any) -> Floats:
    """Standard deviations, positive."""
    deviation = np.asarray(sigma, dtype=np.float64)
    if not np.all(deviation > 0):
        raise ValueError(f"`sigma` has {deviation.min()}: expected positive numbers")
    return deviation


def checked_amount(name: str, amount: Any) -> Floats:
    """A number or an array of finite ones."""
    found = np.asarray(amount, dtype=np.float64)
    if not np.isfinite(found).all():
        raise ValueError(f"`{name}` is not finite: expected a number, or one for each pixel")
    return found
