"""Adaptive cubature in three dimensions: S. G. Johnson's library and SciPy's, by pixel or whole."""

import numpy as np

from ..contestant import OTHERWISE, Contestant, Found

#: S. G. Johnson's number of the norm "largest component".
L_INFINITY = 4


def _corners(shape):
    """The lowest x and y of all pixels, row by row, and the size of one."""
    height, width = shape
    y, x = np.divmod(np.arange(height * width), width)
    return x / width, y / height, 1 / width, 1 / height


def _by_pixel(problem, tolerance):
    from cubature import cubature

    x, y, width, height = _corners(problem.shape)
    area = width * height
    pixels = [
        cubature(
            problem.rate.at,
            ndim=3,
            fdim=1,
            xmin=np.array([left, low, 0.0]),
            xmax=np.array([left + width, low + height, 1.0]),
            abserr=tolerance * problem.scale * area,
            relerr=0,
            vectorized=True,
            maxEval=2_000_000,
        )[0][0]
        for left, low in zip(x, y, strict=True)
    ]
    return Found(np.reshape(pixels, problem.shape) / area)


def _all_pixels(problem):
    """All pixels at once, as a function (n, 3) -> (n, pixels) of a place in the pixel and z."""
    x, y, width, height = _corners(problem.shape)

    def rates(points):
        across, up, z = (points[:, [axis]] for axis in range(3))
        return problem.rate(x + width * across, y + height * up, z)

    return rates


def _together(problem, tolerance):
    from cubature import cubature

    pixels, _ = cubature(
        _all_pixels(problem),
        ndim=3,
        fdim=problem.shape[0] * problem.shape[1],
        xmin=np.zeros(3),
        xmax=np.ones(3),
        abserr=tolerance * problem.scale,
        relerr=0,
        norm=L_INFINITY,
        vectorized=True,
    )
    return Found(np.reshape(pixels, problem.shape))


def _together_by_scipy(problem, tolerance):
    from scipy.integrate import cubature

    found = cubature(
        _all_pixels(problem),
        np.zeros(3),
        np.ones(3),
        rule="genz-malik",
        rtol=0,
        atol=tolerance * problem.scale,
    )
    return Found(found.estimate.reshape(problem.shape), note=found.status)


def _settings(*tolerances):
    return [{"tolerance": tolerance} for tolerance in tolerances]


CONTESTANTS = [
    Contestant(
        name="cubature by pixel",
        distribution="cubature",
        about="hcubature of S. G. Johnson's library for the volume of each pixel",
        run=_by_pixel,
        settings={
            OTHERWISE: _settings(3, 1, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6),
            "smile": _settings(0.1, 0.01, 1e-3),
            "zodi": _settings(0.1, 0.01),
        },
        modules=("cubature",),
        for_users=True,
    ),
    Contestant(
        name="cubature all pixels",
        distribution="cubature",
        about="hcubature of a vector of all pixels, which share the subdivision",
        run=_together,
        settings={
            OTHERWISE: _settings(10, 1, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6),
            "smile": _settings(10, 1, 0.3, 0.1, 0.03),
            "zodi": [],
        },
        modules=("cubature",),
        patience=1,
    ),
    Contestant(
        name="SciPy cubature",
        distribution="scipy",
        about="`scipy.integrate.cubature`, Genz-Malik rule, of a vector of all pixels",
        run=_together_by_scipy,
        settings={
            OTHERWISE: _settings(10, 1, 0.3, 0.1, 0.01),
            "smile": _settings(10, 1, 0.3),
            "zodi": [],
        },
        modules=("scipy.integrate",),
        patience=1,
        for_users=True,
    ),
]
