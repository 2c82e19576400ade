"""The time of a sensitivity matrix: three cameras of 24 x 32 pixels in a torus, 197 functions.

    python benches/sensitivity.py

Functions of known support are integrated where they are not 0; those of an array (n, k) along all
lines of sight. The matrices of the same functions have to agree within their tolerances.
"""

import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import emitree

TOLERANCE = 0.01
#: The limit for each kind of functions on two cores [s], that is, of the time of two processors.
LIMIT_S = 10.0
SHAPE = (24, 32)
#: The section of the torus: its major and minor radius, and the distance of functions.
MAJOR, MINOR = 3.0, 1.0
SPACING = MINOR / 8


def cameras() -> list[emitree.Perspective]:
    """Three cameras in the vessel, along the torus; lines end at the far wall."""
    places = [
        ((4.6, 0.0, 0.2), (0.0, 3.0, 0.0)),
        ((-2.3, 4.0, 0.4), (-2.6, -1.5, 0.0)),
        ((-2.3, -4.0, -0.3), (2.6, -1.5, 0.0)),
    ]
    return [
        emitree.Perspective(position=position, target=target, field_of_view=(60, 50), far=9)
        for position, target in places
    ]


def lattice() -> Any:
    """Places (197, 2) in the section, in units of their distance."""
    return np.array([(i, j) for i in range(-8, 9) for j in range(-8, 9) if i**2 + j**2 <= 64])


def bases() -> dict[str, Any]:
    """The functions, by name."""
    centers = [MAJOR, 0] + SPACING * lattice()
    gaussians = emitree.RadialFunctions(centers, SPACING)
    half = 0.5 * SPACING
    return {
        "Gaussians": gaussians,
        "Wendland": emitree.RadialFunctions(centers, 2.5 * SPACING, "wendland"),
        "rings": emitree.Voxels(centers - half, centers + half),
        "B-splines": splines(),
        "Gaussians, (n, k)": unknown(centers),
    }


def splines() -> emitree.BSplines:
    """14 x 14 cubic B-splines."""
    knots = np.linspace(-MINOR, MINOR, 18)
    return emitree.BSplines([MAJOR + knots, knots])


def unknown(centers: Any) -> Callable[[Any, Any], Any]:
    """The Gaussians as a function of which nothing is known: products of those of R and z."""
    R, z = np.unique(centers[:, 0]), np.unique(centers[:, 1])
    number_R, number_z = np.searchsorted(R, centers[:, 0]), np.searchsorted(z, centers[:, 1])

    def rates(position: Any, direction: Any) -> Any:
        distance = np.hypot(position[:, 0], position[:, 1])[:, np.newaxis] - R
        height = position[:, 2:] - z
        along_R = np.exp(-((distance / SPACING) ** 2) / 2)
        along_z = np.exp(-((height / SPACING) ** 2) / 2)
        return along_R.take(number_R, axis=1) * along_z.take(number_z, axis=1)

    return rates


def main() -> None:
    """Measures, prints and checks."""
    print(f"{os.cpu_count()} cores, tolerance {TOLERANCE}")
    print("functions              s  s (CPU)    entries      lines   evaluations")
    found, of_processors = {}, {}
    for name, basis in bases().items():
        start, before = time.perf_counter(), time.process_time()
        found[name] = one = emitree.sensitivity(basis, cameras(), SHAPE, TOLERANCE)
        time_s, of_processors[name] = time.perf_counter() - start, time.process_time() - before
        assert one.converged, name
        print(
            f"{name:18} {time_s:5.2f} {of_processors[name]:8.2f} {one.matrix.nnz:10,} "
            f"{one.lines:10,} {one.evaluations:13,}"
        )
    # The Gaussians of known support end at `cutoff`.
    difference = abs(found["Gaussians"].matrix - found["Gaussians, (n, k)"].matrix).max(axis=0)
    largest = (difference.toarray() / found["Gaussians"].scale).max()
    print(f"largest difference of the Gaussians: {largest:.4f} of the largest entry of a column")
    assert largest < 2.2 * TOLERANCE
    for name, time_s in of_processors.items():
        limit = 2 * LIMIT_S
        assert time_s < limit, f"{name}: {time_s:.1f} s of processors: expected below {limit} s"


if __name__ == "__main__":
    main()
