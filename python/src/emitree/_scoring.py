"""Fits to Poisson counts by Fisher scoring."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from emitree._cash import cash, counts_as
from emitree._forward import Forward
from emitree._function import Floats
from emitree._parameters import checked_parameters

#: A fit has ended where the next step is this share of a standard deviation in each parameter.
_SHARE = 0.1

#: Steps after which half of the former length is to be reached, near the end.
_PATIENCE = 4

#: The damping of the first step, relative to the information of each parameter, and the least one
#: after a step that was not taken.
_DAMPING = 1e-3

#: What the damping is multiplied with after a step that was not taken, and after one with which the
#: statistic has decreased by less than `_POOR` of what was expected, or more than `_GOOD`.
_REFUSED, _LESS, _MORE = 10.0, 3.0, 0.1
_POOR, _GOOD = 0.25, 0.75

#: The increase of the statistic, for each parameter, that errors of images may have made.
_JITTER = 0.25

#: The largest change of a parameter in one step, relative to its value: derivatives are not those
#: of parameters far off. As many standard deviations, if all others were known, are not far.
_LARGEST_CHANGE = 0.3
_NEAR = 10.0


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


def fit_counts(
    forward: Forward, counts: Any, start: Any, *, max_images: int = 40, share: float = _SHARE
) -> Fit:
    """The parameters with the least statistic of Cash (1979), by damped Fisher scoring.

    A step s solves (F + damping diag F) s = J (n - mu)/mu, with the information F = J (1/mu) J of
    the counts n, the expected ones mu and their derivatives J: the method of Levenberg (1944) and
    Marquardt (1963). The damping follows from how much of the expected decrease of the statistic
    there is. A step that increases the statistic, or at whose end an image has no derivatives, is
    tried again with more damping. The statistic may have jitter (see `Forward`): an increase by a
    quarter of the number p of parameters more than expected is none.
    The fit ends when the next step is shorter than `share` sqrt(p) standard deviations, or if steps
    shorter than sqrt(p) have not become shorter by a third in four: the images are not accurate
    enough for more. Then, and after `max_images`, the parameters are those with the least statistic
    so far.

    forward: from parameters to expected counts; counts: of the shape of the image, pixels that are
        NaN do not count; start: the first parameters (p,). A step changes none by more than 0.3 of
        its value or ten standard deviations, as they were if all others were known.
    max_images: the most images.
    share: a larger one, such as 0.5, ends a first fit with images to a loose tolerance, whose
        `theta` is the start of another one.

    Raises `ValueError` if the information is singular, if counts are negative or `share` is not
    positive, and what `forward` raises.

    >>> import emitree, numpy as np
    >>> def ball(height, width):
    ...     return lambda r, d: height * np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)
    >>> forward = emitree.Forward(ball, emitree.Canonical(), (8, 8), background=0.1, linear=[0])
    >>> counts = np.random.default_rng(1).poisson(forward((500.0, 0.3)))
    >>> fit = emitree.fit_counts(forward, counts, (450.0, 0.31))
    >>> fit.converged, bool((abs(fit.theta - (500, 0.3)) < 3 * fit.deviations).all())
    (True, True)
    """
    if not share > 0:
        raise ValueError(f"`share` is {share}: expected a positive number")
    theta = checked_parameters(start)
    expected = forward(theta)
    observed = counts_as(counts, expected.shape)
    statistic = cash(expected, observed)[0]
    jitter = _JITTER * len(theta)
    images, jacobians, damping = 1, 0, _DAMPING
    lengths: list[float] = []
    best: Fit | None = None
    while True:
        slopes = forward.jacobian(theta).reshape(len(theta), -1)
        jacobians += 1
        information, gradient = _information(slopes, expected.ravel(), observed.ravel())
        covariance = _inverse(information)
        # The square of the length of the undamped step, in standard deviations.
        length = float(gradient @ covariance @ gradient)
        is_short = length < share**2 * len(theta)
        here = Fit(theta, covariance, statistic, length**0.5, images, jacobians, is_short)
        if is_short or best is None or statistic < best.statistic:
            best = here
        # Near the end steps are as long as the errors of the images make them.
        lengths.append(length)
        is_jitter = length < len(theta) and length > 0.5 * min(lengths[:-_PATIENCE], default=np.inf)
        is_taken = False
        while not (is_short or is_jitter or is_taken) and images < max_images:
            step, damping = _limited_step(information, gradient, damping, theta)
            moved = forward.within_bounds(theta + step)
            found_expected = forward(moved)
            images += 1
            found = cash(found_expected, observed)[0]
            step = moved - theta
            predicted = float(2 * gradient @ step - step @ information @ step)
            decrease = statistic - found
            is_taken = decrease > -jitter and forward.has_derivatives(moved)
            if not is_taken:
                damping = _REFUSED * max(damping, _DAMPING)
                continue
            if decrease > _GOOD * predicted:
                damping *= _MORE
            elif decrease < _POOR * predicted:
                damping *= _LESS
            theta, expected, statistic = moved, found_expected, found
        if not is_taken:
            return replace(best, images=images, jacobians=jacobians)


def _limited_step(
    information: Floats, gradient: Floats, damping: float, theta: Floats
) -> tuple[Floats, float]:
    """The step (p,) of damped scoring that changes no parameter by too much, and its damping."""
    size = np.sqrt(np.diag(information))
    scaled = information / np.outer(size, size)
    limit = np.maximum(_LARGEST_CHANGE * abs(theta), _NEAR / size)
    while True:
        damped = scaled + damping * np.eye(len(size))
        step = np.asarray(np.linalg.solve(damped, gradient / size) / size)
        if (abs(step) <= limit).all():
            return step, damping
        damping = _LESS * max(damping, 0.1 * _DAMPING)


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
