"""Functions of which an emission is a weighted sum: products of B-splines."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from emitree._basis import Dense, coordinates, finite, is_between, shapes
from emitree._cells import Integers
from emitree._function import Floats
from emitree._native import SceneError


class BSplines(Dense):
    """Products of B-splines along x, y and z, or along R and z.

    knots: ascending knots of each axis, as of `scipy.interpolate.BSpline`: n + degree + 1 knots for
        n functions; the last axis changes first. In the length unit of the cameras.
    degree: 1 or more, of all axes; 0 are `Voxels`.

    Raises `SceneError` if a number is not as described.

    >>> import emitree, numpy as np
    >>> basis = emitree.BSplines([np.arange(1.0, 8.0), np.arange(-3.0, 4.0)], degree=3)
    >>> basis.shape, basis(np.array([[4.0, 0.0, 0.0]])).max().round(4)
    ((3, 3), np.float64(0.4444))
    """

    def __init__(self, knots: Any, degree: int = 3) -> None:
        if len(knots) not in (2, 3):
            raise SceneError(f"`knots` has {len(knots)} axes: expected 2 (R, z) or 3")
        if not (isinstance(degree, int) and degree >= 1):
            raise SceneError(f"`degree` is {degree!r}: expected 1 or more (0: emitree.Voxels)")
        self.degree = degree
        self.knots = [_knots(f"knots[{axis}]", of, degree) for axis, of in enumerate(knots)]
        #: The numbers of functions along the axes.
        self.shape = tuple(len(of) - degree - 1 for of in self.knots)
        places = np.indices(self.shape).reshape(len(self.shape), -1)
        #: The knots (k, degree + 2) of each function along each axis.
        self._local = [
            np.lib.stride_tricks.sliding_window_view(of, degree + 2)[place]
            for of, place in zip(self.knots, places, strict=True)
        ]
        self._polynomials = [_polynomials(of) for of in self._local]
        lower = np.stack([of[:, 0] for of in self._local], axis=1)
        upper = np.stack([of[:, -1] for of in self._local], axis=1)
        self._lower, self._upper = lower, upper
        self.supports = shapes(lower, upper)

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def feature(self) -> Floats:
        """The size (k,) of what is to be resolved [length]."""
        return cast(Floats, (self._upper - self._lower).min(axis=1) / 6.0)

    @property
    def edge(self) -> float:
        """The largest value at the border of a support: 1 at knots of multiplicity degree + 1."""
        ends = [(of[:, 0] == of[:, -2]) | (of[:, 1] == of[:, -1]) for of in self._local]
        return 1.0 if any(of.any() for of in ends) else 0.0

    def values(self, position: Floats, which: Integers) -> Floats:
        """The values (...) of the functions with the numbers (...) at (3, ...)."""
        places = coordinates(position, len(self.shape))
        along_axes = zip(places, self._local, self._polynomials, strict=True)
        found = np.ones(1)
        for x, knots, polynomials in along_axes:
            found = found * _b_spline(x, which, knots, polynomials)
        return found

    def _is_inside(self, position: Floats, number: int) -> NDArray[np.bool_]:
        return is_between(position, self._lower[number], self._upper[number])

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.shape))
        return f"<emitree {shape} B-splines of degree {self.degree}>"


def _polynomials(knots: Floats) -> Floats:
    """B-splines (k,) by their knots (k, degree + 2), as polynomials between these.

    Of each of degree + 1 pieces, one after the other, the knot at its start and the coefficients of
    the powers of the distance from it: (degree + 2, k * (degree + 1)).

    The recursion of de Boor and Cox (C. de Boor, A Practical Guide to Splines, 2001, ch. IX, eq.
    15).
    """
    count, steps = knots.shape[0], knots.shape[1] - 1
    starts = knots[:, :steps]
    parts = [np.zeros((count, steps, steps)) for _ in range(steps)]
    for j, part in enumerate(parts):
        part[:, j, 0] = 1.0
    for degree in range(1, steps):
        for j in range(steps - degree):
            first, last = knots[:, [j]], knots[:, [j + degree + 1]]
            rising = _inverse(knots[:, [j + degree]] - first)
            falling = _inverse(last - knots[:, [j + 1]])
            parts[j] = _times(parts[j], rising, (starts - first) * rising) + _times(
                parts[j + 1], -falling, (last - starts) * falling
            )
    found = np.concatenate([starts[..., np.newaxis], parts[0]], axis=2)
    return np.ascontiguousarray(found.reshape(count * steps, -1).T)


def _times(coefficients: Floats, slope: Floats, value: Floats) -> Floats:
    """Polynomials (k, pieces, powers) times straight lines of given slopes and values at 0."""
    product = value[..., np.newaxis] * coefficients
    product[..., 1:] += slope[..., np.newaxis] * coefficients[..., :-1]
    return product


def _b_spline(x: Floats, which: Integers, knots: Floats, polynomials: Floats) -> Floats:
    """The B-splines with the numbers (...) at x (...), between the first and the last knot."""
    piece = which * (knots.shape[1] - 1)
    for inner in knots[:, 1:-1].T:
        piece = piece + (x >= inner[which])
    start, *coefficients = polynomials
    distance = x - start.take(piece)
    found = coefficients[-1].take(piece)
    for of_power in coefficients[-2::-1]:
        found *= distance
        found += of_power.take(piece)
    return found


def _inverse(length: Floats) -> Floats:
    """1 / length, 0 where that is 0."""
    return np.where(length > 0.0, 1.0 / np.where(length > 0.0, length, 1.0), 0.0)


def _knots(name: str, given: Any, degree: int) -> Floats:
    knots = finite(name, given)
    if knots.ndim != 1 or len(knots) < degree + 2 or not (np.diff(knots) >= 0.0).all():
        raise SceneError(
            f"`{name}` is {given!r}: expected {degree + 2} or more ascending numbers for degree "
            f"{degree}"
        )
    if not (knots[degree + 1 :] > knots[: -degree - 1]).all():
        raise SceneError(f"`{name}` has a knot more than {degree + 1} times: expected fewer")
    return knots
