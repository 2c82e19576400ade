"""Lines of sight in equal steps, 1, 4 or 16 through each pixel: what most codes do."""

from functools import partial

import numpy as np

from ..contestant import OTHERWISE, Contestant, Found

STEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 512, 1024, 4096)
#: The most steps for all lines of a pixel together.
LONGEST = 4096


def _middles(count):
    return (np.arange(count) + 0.5) / count


def _march(problem, steps, across):
    height, width = problem.shape
    x, z = _middles(across * width), _middles(steps)
    image = np.empty(problem.shape)
    for row, y in enumerate(_middles(across * height).reshape(height, across)):
        lines = problem.rate(x[None, :, None], y[:, None, None], z).mean(axis=2)
        image[row] = lines.reshape(across, width, across).mean(axis=(0, 2))
    return Found(image)


CONTESTANTS = [
    Contestant(
        name=f"fixed step {across**2}",
        distribution="numpy",
        about=f"{across} x {across} lines of sight through each pixel, midpoint rule along z",
        run=partial(_march, across=across),
        settings={OTHERWISE: [{"steps": n} for n in STEPS if n * across**2 <= LONGEST]},
    )
    for across in (1, 2, 4)
]
