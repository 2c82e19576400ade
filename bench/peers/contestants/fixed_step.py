"""Lines of sight in uniform steps, 1, 4 or 16 through each pixel: the method of most codes."""

from functools import partial

import numpy as np

from ..contestant import OTHERWISE, Contestant, Found

STEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 512, 1024, 4096)
#: The most steps for all lines of a pixel together.
LONGEST = 4096
#: Where lines are long and the image has folds, (lines across, steps).
OF_SMILE = {
    1: (80, 160, 800),
    2: (160, 400, 800, 1200, 1600),
    4: (160, 400, 800, 1600),
}
#: Where one line a pixel is nearly enough.
OF_ZODI = {1: (20, 50, 100, 200), 2: (50, 100, 200), 4: (50, 100)}
#: The most points of one call.
TOGETHER = 2**18


def _middles(count):
    return (np.arange(count) + 0.5) / count


def _march(problem, steps, across):
    height, width = problem.shape
    x, z = _middles(across * width), _middles(steps)
    image = np.empty(problem.shape)
    for row, y in enumerate(_middles(across * height).reshape(height, across)):
        parts = np.array_split(x, max(1, across * len(x) * steps // TOGETHER))
        lines = [problem.rate(part[:, None], y[:, None, None], z).mean(axis=2) for part in parts]
        lines = np.concatenate(lines, axis=1).reshape(across, width, across)
        image[row] = lines.mean(axis=(0, 2))
    return Found(image)


def _settings(counts):
    return [{"steps": steps} for steps in counts]


CONTESTANTS = [
    Contestant(
        name=f"fixed step {across**2}",
        distribution="numpy",
        about=f"{across} x {across} lines of sight through each pixel, midpoint rule along each",
        run=partial(_march, across=across),
        settings={
            OTHERWISE: _settings(n for n in STEPS if n * across**2 <= LONGEST),
            "smile": _settings(OF_SMILE[across]),
            "zodi": _settings(OF_ZODI[across]),
        },
        limit_s=60.0,
        for_users=True,
    )
    for across in OF_SMILE
]
