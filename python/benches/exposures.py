"""Errors and evaluations of exposures, beside the mean of n images of cameras that do not move.

The exposures are the random ones of python/tests/passages.py, whose images are known from an
independent quadrature. The images at rest are at the middles of n equal times, each to half of the
tolerance; n is doubled until the largest error of the mean is within the tolerance, which takes
the exact image to know.

    python benches/exposures.py [FIRST LAST [TOLERANCE]]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

import emitree

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from passages import SIDE, passage

#: The most images of a bin.
MOST_IMAGES = 256
MOVES = ("still", "straight", "curve")


def largest_error(found, exact):
    """The largest |error| of a voxel over the largest |voxel|."""
    return float(abs(found.reshape(exact.shape) - exact).max() / abs(exact).max())


def snapshots(given, exact, tolerance):
    """How many images of each bin are enough, and their evaluations."""
    edges = np.linspace(*given.exposure.range_s, given.exposure.bins + 1)
    images = 1
    while images <= MOST_IMAGES:
        means, evaluations = [], 0
        for low, high in pairwise(edges):
            total = np.zeros((SIDE, SIDE))
            for time in low + (high - low) * (np.arange(images) + 0.5) / images:
                here = np.array([time])
                camera = replace(
                    given.camera, position=given.position(here)[0], target=given.target(here)[0]
                )

                def frozen(position, direction, time=time):
                    return given.emission(position, direction, np.full(len(position), time))

                found = emitree.render(frozen, camera, (SIDE, SIDE), tolerance=0.5 * tolerance)
                total += found.image / images
                evaluations += found.evaluations
            means.append(total)
        if largest_error(np.stack(means), exact) <= tolerance:
            return images, evaluations
        images *= 2
    return None, None


def main(first, last, tolerance):
    """Prints a line for each seed, and what they have in common."""
    print(f"tolerance {tolerance:g}; seeds {first} to {last - 1}; {SIDE} x {SIDE} pixels")
    print(
        "seed camera    bins  times  evaluations  error/tol  estimate/tol  outside  n  of n images"
    )
    ratios, gains, met, met_by_shots, outside, pixels = [], [], 0, 0, 0, 0
    for seed in range(first, last):
        given = passage(seed)
        exact = given.image()
        found = emitree.render(
            given.emission, given.camera, (SIDE, SIDE), exposure=given.exposure, tolerance=tolerance
        )
        error = largest_error(found.image, exact)
        beyond = int((abs(found.image.reshape(exact.shape) - exact)
                      > found.error.reshape(exact.shape)).sum())  # fmt: skip
        outside, pixels = outside + beyond, pixels + exact.size
        met += error <= tolerance and found.converged
        shots = emitree.render(
            given.emission,
            given.camera,
            (SIDE, SIDE),
            exposure=replace(given.exposure, snapshots=True),
            tolerance=tolerance,
        )
        of_shots = largest_error(shots.image, exact)
        met_by_shots += of_shots <= tolerance and shots.converged
        gains.append(shots.evaluations / found.evaluations)
        images, evaluations = snapshots(given, exact, tolerance)
        if images is not None:
            ratios.append(evaluations / found.evaluations)
        times = found.report["energies"]
        print(
            f"{seed:4} {MOVES[seed % 3]:8} {given.exposure.bins:5} {times:6} "
            f"{found.evaluations:12,} "
            f"{error / tolerance:10.3f} {found.estimated_error / tolerance:13.3f} {beyond:8} "
            f"| {shots.report['energies']:4} {shots.evaluations:10,} {of_shots / tolerance:10.3f} "
            f"| {images or '-':>3} {evaluations or '-':>8}",
            flush=True,
        )
    low, middle, high = np.quantile(ratios, [0, 0.5, 1])
    print(
        f"{met} of {last - first} within the tolerance and converged; {outside} of {pixels} voxels "
        f"beyond their errors; n images took {low:.2f} to {high:.2f} times as many "
        f"evaluations, median {middle:.2f}"
    )
    low, middle, high = np.quantile(gains, [0, 0.5, 1])
    print(
        f"{met_by_shots} of {last - first} with snapshots=True; they took {low:.2f} to {high:.2f} "
        f"times as many evaluations, median {middle:.2f}"
    )


if __name__ == "__main__":
    given = [float(text) for text in sys.argv[1:]]
    main(
        int(given[0]) if given else 0,
        int(given[1]) if given else 48,
        given[2] if given[2:] else 1e-2,
    )
