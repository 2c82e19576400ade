"""Errors and evaluations of images of random distorted WCS, beside closed forms.

    python benches/distorted.py [FIRST LAST]

Needs astropy. Seeds are Gaussians and uniform balls seen with SIP, TPV, STG, SIN, AZP and AIT, at
tolerances from 10^-3 to 0.05; images are known from closed forms at many places in each pixel.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import emitree

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from test_sky_distorted import (
    DISTANCE,
    ball,
    camera_of,
    chord_of_ball,
    column_of_gaussian,
    distorted,
    exact,
    gaussian,
)

KINDS = ("SIP", "TPV", "STG", "SIN", "AZP", "AIT")
SHAPE = (24, 32)


def main(first: int, last: int) -> None:
    """Prints a line for each seed."""
    print("seed kind shape  tolerance  error/tol  estimate/tol  converged  beyond  evaluations  s")
    for seed in range(first, last):
        random = np.random.default_rng(seed)
        kind = KINDS[seed % 6]
        scale = 10 ** random.uniform(-2, -0.2) if kind in ("SIP", "TPV") else 1.5
        keys = {"PV2_1": random.uniform(1, 3)} if kind == "AZP" else {}
        roll = random.uniform(-180, 180)
        wcs = distorted(kind, shape=SHAPE, scale=scale, roll=roll, **keys)
        tolerance = 10 ** random.uniform(-3, -1.3)
        pixel = np.radians(scale) * DISTANCE
        at, size = random.normal(size=3) * pixel * 4, pixel * random.uniform(2, 8)
        is_ball = seed // 6 % 2 == 1
        # Depths at which the emission is; a Gaussian is seen to 7 standard deviations.
        reach = np.linalg.norm(at) + (1.5 if is_ball else 5.0) * size
        camera = camera_of(wcs, near=max(DISTANCE - reach, 1.0), far=DISTANCE + reach)
        place = at - np.array(camera.position)
        emission = ball(size, at) if is_ball else gaussian(size / 1.5, at)
        column = chord_of_ball(place, size) if is_ball else column_of_gaussian(place, size / 1.5)
        start = time.perf_counter()
        found = emitree.render(emission, camera, tolerance=tolerance)
        seconds = time.perf_counter() - start
        image = exact(wcs, SHAPE, column, 48 if is_ball else 16)
        error, largest = abs(found.image - image), np.nanmax(image)
        # The closed forms are known to this.
        beyond = int((error > found.error + 2e-4 * largest).sum())
        print(
            f"{seed:4} {kind} {'ball' if is_ball else 'gauss':5} {tolerance:10.4f} "
            f"{np.nanmax(error) / largest / tolerance:10.3f} "
            f"{found.estimated_error / tolerance:13.3f} {found.converged!s:>10} {beyond:7} "
            f"{found.evaluations:12,} {seconds:6.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:3] or ("0", "48")))
