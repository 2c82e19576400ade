"""A soft spherical shell, brighter towards large x: thin, smooth, separable in no way."""

import numpy as np

from . import gauss
from .scene import Scene

CENTRE = (0.5, 0.47, 0.52)
RADIUS = 0.35
#: The distance from the radius at which the rate has fallen to 1/e.
WIDTH = 0.03


def rate(x, y, z):
    """The emission rate in the unit cube."""
    square = (x - CENTRE[0]) ** 2 + (y - CENTRE[1]) ** 2 + (z - CENTRE[2]) ** 2
    return np.exp(-(((np.sqrt(square) - RADIUS) / WIDTH) ** 2)) * (1 + 0.5 * x)


def _image(shape: tuple[int, int], order: int, depth: tuple[int, int]) -> np.ndarray:
    z, weight = gauss.panels(*depth)
    line = lambda x, y: rate(x[..., None], y[..., None], z) @ weight  # noqa: E731
    return gauss.mean_over_pixels(line, shape, order)


def exact(shape: tuple[int, int]) -> np.ndarray:
    """The image by quadrature: there is no closed form."""
    return _image(shape, 7, (32, 12))


def check(shape: tuple[int, int]) -> np.ndarray:
    """The image by other nodes along all axes."""
    return _image(shape, 6, (25, 18))


SCENE = Scene("shell", "a thin shell", rate, exact, check)
