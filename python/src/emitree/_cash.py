"""The likelihood of Poisson counts: the statistic of Cash (1979)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats

#: Expected counts below which the logarithm is continued by its Taylor polynomial: far fewer than
#: any that are measured, and as many as make the statistic finite where an image is not positive.
LEAST_COUNTS = 1e-9


def cash(expected: Floats, counts: Floats) -> tuple[float, Floats]:
    """The statistic 2 sum(mu - n log(mu)), and its derivatives by the expected counts mu.

    expected, counts: mu and n, of the same shape. Where one of them is NaN neither the sum nor the
        derivative has a contribution.

    Below `LEAST_COUNTS` the logarithm is its quadratic Taylor polynomial there: the statistic is
    finite, and has a continuous second derivative.

    >>> statistic, slope = cash(np.array([2.0, np.nan]), np.array([3.0, 1.0]))
    >>> round(statistic, 6), slope
    (-0.158883, array([-1.,  0.]))
    """
    seen = _seen(expected, counts)
    mu, n = expected[seen], counts[seen]
    high = np.maximum(mu, LEAST_COUNTS)
    # The relative distance below the least counts; 0 above.
    below = (mu - high) / LEAST_COUNTS
    logarithm = np.log(high) + below - 0.5 * below**2
    slope = np.zeros(expected.shape)
    slope[seen] = 2.0 * (1.0 - n * (1.0 - below) / high)
    return float(2.0 * np.sum(mu - n * logarithm)), slope


def deviance_residuals(expected: Floats, counts: Floats) -> tuple[Floats, Floats]:
    """Signed roots of the deviance of each pixel, and their derivatives by the expected counts mu.

    expected, counts: mu and n, of the same shape. The sum of the squares is `cash` but for what
        depends on n alone. Where mu is below `LEAST_COUNTS` it counts as these, and where mu or n
        is NaN both results are 0.

    >>> residuals, slope = deviance_residuals(np.array([2.0, 3.0]), np.array([3.0, 3.0]))
    >>> residuals.round(6), slope.round(6)
    (array([-0.657868,  0.      ]), array([0.760031, 0.57735 ]))
    """
    seen = _seen(expected, counts)
    mu, n = np.maximum(expected[seen], LEAST_COUNTS), counts[seen]
    # The deviance in the relative excess e of counts, 2 mu ((1 + e) log(1 + e) - e), is e^2 mu for
    # small e, where the difference would cancel.
    excess = (n - mu) / mu
    size = 1.0 + excess
    exact = size * np.log(np.where(size > 0, size, 1.0)) - excess
    series = excess**2 * (1 / 2 - excess / 6 + excess**2 / 12 - excess**3 / 20 + excess**4 / 30)
    deviance = 2.0 * mu * np.where(abs(excess) < 1e-2, series, exact)
    roots = np.sign(mu - n) * np.sqrt(deviance)
    limit = 1.0 / np.sqrt(mu)
    slopes = np.where(roots == 0, limit, -excess / np.where(roots == 0, 1.0, roots))
    residuals, slope = np.zeros(expected.shape), np.zeros(expected.shape)
    residuals[seen] = roots
    slope[seen] = np.where(expected[seen] < LEAST_COUNTS, 0.0, slopes)
    return residuals, slope


def counts_as(counts: Any, shape: tuple[int, ...]) -> Floats:
    """Counts as an array of the shape of an image; raises `ValueError` if they are none."""
    observed = np.asarray(counts, dtype=np.float64)
    if observed.shape != shape:
        raise ValueError(f"the data have the shape {observed.shape}: expected {shape}")
    if (observed < 0).any():
        raise ValueError(f"the counts have {observed.min()}: expected 0 or more")
    return observed


def _seen(expected: Floats, counts: Floats) -> NDArray[np.bool_]:
    """Where both are numbers."""
    if counts.shape != expected.shape:
        raise ValueError(f"the counts have the shape {counts.shape}: expected {expected.shape}")
    return ~(np.isnan(expected) | np.isnan(counts))
