"""Counting how often the emission rate is evaluated."""

import numpy as np


class Counter:
    """A rate g(x, y, z) that counts its points: those of an array one by one."""

    def __init__(self, rate):
        self._rate = rate
        self.evaluations = 0

    def __call__(self, x, y, z):
        """The rates at points whose coordinates broadcast."""
        values = np.asarray(self._rate(*(np.asarray(t, dtype=float) for t in (x, y, z))))
        self.evaluations += values.size
        return values

    def at(self, points) -> np.ndarray:
        """The rates (n,) at points (n, 3)."""
        return self(*np.asarray(points).T)


class GridMemo:
    """A rate on the nodes of a grid that evaluates each node once, however often it is called."""

    def __init__(self, rate, axes):
        self._rate = rate
        self._axes = axes
        self._values = np.full([len(axis) for axis in axes], np.nan)

    def __call__(self, indices) -> np.ndarray:
        """The rates (n,) at nodes given by indices (n, 3)."""
        flat = np.ravel_multi_index(np.asarray(indices, dtype=int).T, self._values.shape)
        known = self._values.reshape(-1)
        new = np.unique(flat[np.isnan(known[flat])])
        if len(new):
            nodes = np.unravel_index(new, self._values.shape)
            points = (axis[node] for axis, node in zip(self._axes, nodes, strict=True))
            known[new] = self._rate(*points)
        return known[flat]


class PointMemo:
    """A rate of single points that evaluates each point once."""

    def __init__(self, rate):
        self._rate = rate
        self._known = {}

    def __call__(self, point) -> float:
        """The rate at one point (x, y, z)."""
        key = tuple(point)
        if key not in self._known:
            self._known[key] = float(self._rate(*key))
        return self._known[key]
