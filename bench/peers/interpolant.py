"""Means over pixels of polynomials that are known at the nodes of a grid."""

import numpy as np
from numpy.polynomial import chebyshev, legendre

from . import gauss


def _pixel_means(vander, degree: int, pixels: int) -> np.ndarray:
    """The exact means (pixels, degree + 1) of a basis of polynomials over equal pixels."""
    points, weight = gauss.panels(pixels, degree // 2 + 1)
    values = vander(2 * points - 1, degree)
    return pixels * (weight[:, None] * values).reshape(pixels, -1, degree + 1).sum(axis=1)


def from_gauss_nodes(count: int, pixels: int) -> np.ndarray:
    """The matrix (pixels, count) from values at Gauss nodes to pixels."""
    node, weight = gauss.nodes(count)
    # Coefficients by the rule itself, which is exact for these products.
    scale = 2 * np.arange(count) + 1
    coefficients = scale[:, None] * (legendre.legvander(2 * node - 1, count - 1).T * weight)
    return _pixel_means(legendre.legvander, count - 1, pixels) @ coefficients


def from_chebyshev_nodes(node: np.ndarray, pixels: int) -> np.ndarray:
    """The matrix (pixels, len(node)) from values at Chebyshev nodes in [0, 1] to pixels."""
    degree = len(node) - 1
    coefficients = np.linalg.inv(chebyshev.chebvander(2 * np.asarray(node) - 1, degree))
    return _pixel_means(chebyshev.chebvander, degree, pixels) @ coefficients
