"""Kernels of smoothed particles, whose integral over space is 1 and which are 0 beyond a radius.

A kernel of support radius H is W(r, H) = C / H^3 w(r / H) with w = 0 from 1 on. Sources: J. J.
Monaghan and J. C. Lattanzio (1985), Astron. Astrophys. 149, 135 (bibcode 1985A&A...149..135M) for
the cubic spline M4; W. Dehnen and H. Aly (2012), Mon. Not. R. Astron. Soc. 425, 1068, Table 1,
doi:10.1111/j.1365-2966.2012.21439.x for all, with the support radius as here; H. Wendland (1995),
Adv. Comput. Math. 4, 389, doi:10.1007/BF02123482 for the functions of Wendland.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from emitree._function import Floats
from emitree._native import SceneError


@dataclass(frozen=True)
class Kernel:
    """A kernel in three dimensions."""

    name: str
    #: w(x) for 0 <= x <= 1, where x is the distance by the support radius.
    shape: Callable[[Floats], Floats]
    #: C, with which the integral of C w(|x|) over the unit ball is 1.
    normalisation: float
    #: The standard deviation along one axis by the support radius.
    deviation: float

    def __reduce__(self) -> tuple[Callable[[str], Kernel], tuple[str]]:
        # By its name: workers of an executor get particles, and shapes are closures.
        return kernel_of, (self.name,)


def _spline(knots: tuple[tuple[float, float], ...], power: int) -> Callable[[Floats], Floats]:
    """The sum of factor * max(end - x, 0)^power over (end, factor)."""

    def shape(x: Floats) -> Floats:
        total = np.zeros_like(x)
        for end, factor in knots:
            total += factor * np.maximum(end - x, 0.0) ** power
        return total

    return shape


def _wendland(power: int, *coefficients: float) -> Callable[[Floats], Floats]:
    """(1 - x)^power times a polynomial, whose constant term is the first coefficient."""

    def shape(x: Floats) -> Floats:
        polynomial = np.full_like(x, coefficients[-1])
        for coefficient in coefficients[-2::-1]:
            polynomial *= x
            polynomial += coefficient
        return np.asarray(np.maximum(1.0 - x, 0.0) ** power * polynomial)

    return shape


#: Each kernel by its name; deviations are sigma / H, from H / h = H / (2 sigma) of the source.
KERNELS = {
    kernel.name: kernel
    for kernel in (
        Kernel(
            "cubic_spline",
            _spline(((1.0, 1.0), (1 / 2, -4.0)), 3),
            16 / np.pi,
            0.5 / 1.825742,
        ),
        Kernel(
            "quartic_spline",
            _spline(((1.0, 1.0), (3 / 5, -5.0), (1 / 5, 10.0)), 4),
            5**6 / (512 * np.pi),
            0.5 / 2.018932,
        ),
        Kernel(
            "quintic_spline",
            _spline(((1.0, 1.0), (2 / 3, -6.0), (1 / 3, 15.0)), 5),
            3**7 / (40 * np.pi),
            0.5 / 2.195775,
        ),
        Kernel("wendland_c2", _wendland(4, 1.0, 4.0), 21 / (2 * np.pi), 0.5 / 1.936492),
        Kernel(
            "wendland_c4",
            _wendland(6, 1.0, 6.0, 35 / 3),
            495 / (32 * np.pi),
            0.5 / 2.207940,
        ),
        Kernel(
            "wendland_c6",
            _wendland(8, 1.0, 8.0, 25.0, 32.0),
            1365 / (64 * np.pi),
            0.5 / 2.449490,
        ),
    )
}


def kernel_of(name: object) -> Kernel:
    """The kernel of a name.

    Raises `SceneError` for any other name.

    >>> bool(np.isclose(kernel_of("cubic_spline").normalisation, 16 / np.pi))
    True
    """
    kernel = KERNELS.get(name) if isinstance(name, str) else None
    if kernel is None:
        names = ", ".join(map(repr, KERNELS))
        raise SceneError(f"`kernel` is {name!r}: expected one of {names}")
    return kernel
