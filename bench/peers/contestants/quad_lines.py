"""QUADPACK along each line of a Gauss grid in the image plane, exact pixel means."""

import numpy as np

from .. import gauss, interpolant
from ..contestant import OTHERWISE, Contestant, Found


def _integrate(problem, lines, tolerance):
    from scipy.integrate import quad

    height, width = problem.shape
    node, _ = gauss.nodes(lines)
    bound = {"epsabs": tolerance * problem.scale, "epsrel": 0, "limit": 200}

    def line(x, y):
        # It warns where it gives up; what it has then found is still an image.
        return quad(lambda z: float(problem.rate(x, y, z)), 0, 1, full_output=1, **bound)[0]

    depths = np.array([[line(x, y) for x in node] for y in node])
    to_columns = interpolant.from_gauss_nodes(lines, width)
    to_rows = interpolant.from_gauss_nodes(lines, height)
    return Found(to_rows @ depths @ to_columns.T)


def _settings(*pairs):
    return [{"lines": lines, "tolerance": tolerance} for lines, tolerance in pairs]


SMOOTH = _settings(
    *((6, 0.1), (8, 0.1), (10, 0.05), (12, 0.02), (16, 1e-2), (20, 1e-3), (24, 1e-4)),
    *((28, 1e-4), (32, 1e-6), (40, 1e-8), (48, 1e-10)),
)
THIN = _settings(
    *((8, 0.1), (12, 0.1), (16, 0.05), (24, 0.02), (32, 1e-2), (40, 1e-2), (48, 1e-3)),
    *((56, 1e-3), (64, 1e-4), (96, 1e-6), (128, 1e-8)),
)
JUMP = _settings(
    *((2, 0.1), (3, 0.1), (4, 0.05), (5, 0.02), (6, 1e-2), (8, 1e-3), (10, 1e-4)),
    *((12, 1e-5), (14, 1e-5), (16, 1e-6), (20, 1e-8), (24, 1e-9)),
)
SURFACES = _settings((16, 0.05), (32, 0.02), (48, 0.02), (64, 0.02))

CONTESTANTS = [
    Contestant(
        name="quad on Gauss lines",
        distribution="scipy",
        about="`scipy.integrate.quad` (QUADPACK) along n x n Gauss lines of the whole image, "
        "exact pixel means of their interpolant",
        run=_integrate,
        settings={"eq8": SMOOTH, OTHERWISE: THIN, "shock": JUMP, "smile": SURFACES, "zodi": []},
        modules=("scipy.integrate",),
    )
]
