"""Eq. (8) of Holmstroem's paper: waves and a peak, each a product of functions of x, y and z."""

import numpy as np
from scipy.special import erf

from . import gauss
from .scene import Scene

#: The alpha of the paper, for each axis.
STEEPNESS = 100.0 * np.array([1 / np.sqrt(2), np.sqrt(2), np.sqrt(3)])
CENTRE = np.array([np.sqrt(2) / 3, np.sqrt(7) / 5, np.sqrt(6) / 5])
WAVENUMBER = np.array([5.0, 7.0, 11.0])


def rate(x, y, z):
    """The emission rate in the unit cube."""
    waves, exponent = 0.1, 0.0
    for axis, t in enumerate((x, y, z)):
        waves = waves * np.sin(WAVENUMBER[axis] * t)
        exponent = exponent - STEEPNESS[axis] * (t - CENTRE[axis]) ** 2
    return waves**2 + np.exp(exponent)


def _means(axis: int, pixels: int) -> tuple[np.ndarray, np.ndarray]:
    """The means over equal pixels of the peak and of the squared wave along one axis."""
    border = np.linspace(0.0, 1.0, pixels + 1)
    root, wavenumber = np.sqrt(STEEPNESS[axis]), WAVENUMBER[axis]
    peak = np.sqrt(np.pi) / (2 * root) * erf(root * (border - CENTRE[axis]))
    wave = border / 2 - np.sin(2 * wavenumber * border) / (4 * wavenumber)
    return pixels * np.diff(peak), pixels * np.diff(wave)


def exact(shape: tuple[int, int]) -> np.ndarray:
    """The image in closed form: means of products are products of means."""
    height, width = shape
    peak_x, wave_x = _means(0, width)
    peak_y, wave_y = _means(1, height)
    (peak_z,), (wave_z,) = _means(2, 1)
    return peak_z * np.outer(peak_y, peak_x) + 0.01 * wave_z * np.outer(wave_y, wave_x)


def check(shape: tuple[int, int]) -> np.ndarray:
    """The image by quadrature of the rate, without the product form."""
    z, weight = gauss.panels(16, 10)
    line = lambda x, y: rate(x[..., None], y[..., None], z) @ weight  # noqa: E731
    return gauss.mean_over_pixels(line, shape, 6)


SCENE = Scene("eq8", "eq. (8) of the paper", rate, exact, check)
