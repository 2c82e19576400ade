"""A curved shock: g falls by a factor of twenty at a surface, its image is smooth."""

import numpy as np

from . import gauss
from .scene import Scene

#: The depth of the brightest point, and the square of the radius of the core.
DEPTH = 0.3
CORE = 0.1
#: g behind the shock relative to g before it.
BEHIND = 0.05


def surface(x, y):
    """The depth of the shock, within the cube everywhere."""
    return 0.8 - 1.5 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)


def _smooth(x, y, z):
    return 1 / (CORE + (x - 0.5) ** 2 + (y - 0.5) ** 2 + (z - DEPTH) ** 2)


def rate(x, y, z):
    """The emission rate in the unit cube."""
    return np.where(z < surface(x, y), 1.0, BEHIND) * _smooth(x, y, z)


def _closed(x, y):
    """The integral along z, an arc tangent on each side."""
    root = np.sqrt(CORE + (x - 0.5) ** 2 + (y - 0.5) ** 2)
    near, shock, far = (np.arctan((z - DEPTH) / root) for z in (0.0, surface(x, y), 1.0))
    return (shock - near + BEHIND * (far - shock)) / root


def _split(x, y):
    """The integral along z by quadrature on each side."""
    z, weight = gauss.nodes(40)
    x, y = x[..., None], y[..., None]
    shock = surface(x, y)
    before = (shock * _smooth(x, y, shock * z)) @ weight
    behind = ((1 - shock) * _smooth(x, y, shock + (1 - shock) * z)) @ weight
    return before + BEHIND * behind


def exact(shape: tuple[int, int]) -> np.ndarray:
    """The image: closed along z, by quadrature over the pixels."""
    return gauss.mean_over_pixels(_closed, shape, 8)


def check(shape: tuple[int, int]) -> np.ndarray:
    """The image by quadrature along z as well, with other nodes in the pixels."""
    return gauss.mean_over_pixels(_split, shape, 5)


SCENE = Scene("shock", "a curved shock", rate, exact, check)
