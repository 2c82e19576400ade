"""Fits to Poisson counts by Fisher scoring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree._cash import cash, counts_as
from emitree._forward import Forward
from emitree._function import Floats
from emitree._parameters import checked_parameters

#: A fit has ended where the next step is this share of a standard deviation in each parameter.
_SHARE = 0.1

#: Steps after which half of the former length is to be reached, near the end.
_PATIENCE = 2

#: The damping of the first step, relative to the information of each parameter.
_DAMPING = 1e-3

#: By what a step is shortened if no surfaces are found at its end: they are not found at some
#: parameters, and are at others near them.
_SHORTER = 0.85

#: The largest change of a parameter in one step, relative to its first value: derivatives are not
#: those of parameters far off.
_LARGEST_CHANGE = 0.3


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters that were fitted to counts, with their errors."""

    #: The parameters (p,).
    theta: Floats
    #: Their covariance (p, p), the inverse of the Fisher information.
    covariance: Floats
    #: The statistic of Cash (1979) there.
    statistic: float
    #: The length of the step that would follow, in standard deviations: the root of s F s.
    distance: float
    #: How often the image was computed, and its derivatives.
    images: int
    jacobians: int
    #: Whether the next step would be short; False where the images did not allow that, or where
    #: there were as many images as are allowed.
    converged: bool

    @property
    def deviations(self) -> Floats:
        """The standard deviations (p,) of the parameters."""
        return np.sqrt(np.diag(self.covariance))


def fit_counts(forward: Forward, counts: Any, start: Any, *, max_images: int = 40) -> Fit:
    """The parameters with the least statistic of Cash (1979), by damped Fisher scoring.

    A step s solves (F + damping) s = J (n - mu)/mu, with the information F = J (1/mu) J of the
    counts n, the expected ones mu and their derivatives J. It is damped more where the statistic
    increases by more than the number p of parameters. Steps that are expected to decrease it by
    less than p are taken without a look at the statistic, which may have jitter (see `Forward`).
    Where an image has no derivatives, as its surfaces were not found, a step is shortened.
    The fit ends when the next step is shorter than 0.1 sqrt(p) standard deviations, or if such
    steps have not become shorter by a third in two: the images are not accurate enough for more.

    forward: from parameters to expected counts; counts: of the shape of the image, pixels that are
        NaN do not count; start: the first parameters (p,). A step changes none by more than 0.3 of
        its first value, unless that is 0.
    max_images: the most images.

    Raises `ValueError` if the information is singular, or if counts are negative, and what
    `forward` raises.

    >>> import emitree, numpy as np
    >>> def ball(height, width):
    ...     return lambda r, d: height * np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)
    >>> forward = emitree.Forward(ball, emitree.Canonical(), (8, 8), background=0.1, linear=[0])
    >>> counts = np.random.default_rng(1).poisson(forward((500.0, 0.3)))
    >>> fit = emitree.fit_counts(forward, counts, (450.0, 0.31))
    >>> fit.converged, bool((abs(fit.theta - (500, 0.3)) < 3 * fit.deviations).all())
    (True, True)
    """
    theta = checked_parameters(start)
    expected = forward(theta)
    observed = counts_as(counts, expected.shape)
    statistic = cash(expected, observed)[0]
    limit = np.where(theta == 0, np.inf, _LARGEST_CHANGE * abs(theta))
    images, jacobians, damping = 1, 0, _DAMPING
    decreases: list[float] = []
    while True:
        slopes = forward.jacobian(theta).reshape(len(theta), -1)
        jacobians += 1
        information, gradient = _information(slopes, expected.ravel(), observed.ravel())
        covariance = _inverse(information)
        decrease = float(gradient @ covariance @ gradient)
        is_short = decrease < _SHARE**2 * len(theta)
        # Near the end steps are as long as the errors of the images make them.
        decreases.append(decrease)
        is_jitter = decrease < len(theta) and decrease > 0.5 * min(
            decreases[:-_PATIENCE], default=np.inf
        )
        if is_short or is_jitter or images >= max_images:
            distance = decrease**0.5
            return Fit(theta, covariance, statistic, distance, images, jacobians, is_short)
        shorter, is_damped_more = 1.0, False
        while images < max_images:
            scale = np.sqrt(np.diag(information))
            damped = information + damping * np.diag(scale**2)
            step = np.linalg.solve(damped / np.outer(scale, scale), gradient / scale) / scale
            moved = forward.within_bounds(theta + shorter * np.clip(step, -limit, limit))
            expected = forward(moved)
            images += 1
            if not forward.has_derivatives(moved):
                shorter *= _SHORTER
                continue
            found = cash(expected, observed)[0]
            if decrease < len(theta) or found < statistic + len(theta):
                theta, statistic = moved, found
                # A damping that was needed is tried again with the next step.
                damping = damping if is_damped_more else 0.1 * damping
                break
            damping, is_damped_more = 10 * max(damping, _DAMPING), True
        else:
            expected = forward(theta)


def _information(slopes: Floats, expected: Floats, counts: Floats) -> tuple[Floats, Floats]:
    """The Fisher information (p, p), and the derivatives (p,) of half of -Cash."""
    seen = ~(np.isnan(expected) | np.isnan(counts)) & (expected > 0)
    slopes, mu = slopes[:, seen], expected[seen]
    return (slopes / mu) @ slopes.T, slopes @ ((counts[seen] - mu) / mu)


def _inverse(information: Floats) -> Floats:
    """The covariance, of parameters that all change the image."""
    size = np.sqrt(np.diag(information))
    if not (size > 0).all():
        number = int(np.flatnonzero(~(size > 0))[0])
        raise ValueError(f"the image does not depend on parameter {number}: expected others")
    relative = information / np.outer(size, size)
    if np.linalg.cond(relative) > 1e12:
        raise ValueError(
            "the parameters are degenerate in this image: their information is singular; expected "
            "fewer of them"
        )
    return np.asarray(np.linalg.inv(relative) / np.outer(size, size))
