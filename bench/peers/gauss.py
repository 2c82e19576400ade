"""Gauss-Legendre nodes on the unit interval, whole and in panels, and means over pixels."""

from collections.abc import Callable

import numpy as np
from scipy.special import roots_legendre


def nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of one rule on [0, 1]; the weights add up to 1."""
    node, weight = roots_legendre(count)
    return 0.5 * (node + 1), 0.5 * weight


def panels(count: int, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of `count` equal panels on [0, 1], each with a rule of `order` nodes."""
    node, weight = nodes(order)
    starts = np.arange(count)[:, None]
    return ((starts + node) / count).ravel(), np.tile(weight / count, count)


def mean_over_pixels(
    line: Callable[[np.ndarray, np.ndarray], np.ndarray], shape: tuple[int, int], order: int
) -> np.ndarray:
    """The means over pixels (height, width) of line(x, y), with order x order nodes in each.

    `line` is called with x (1, n) and y (m, 1), one row of pixels at a time.
    """
    height, width = shape
    x, _ = panels(width, order)
    y, _ = panels(height, order)
    _, weight = nodes(order)
    image = np.empty(shape)
    for row in range(height):
        values = line(x[None, :], y[row * order : (row + 1) * order, None])
        image[row] = (weight @ values).reshape(width, order) @ weight
    return image
