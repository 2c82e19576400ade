"""Supports of functions: where a line of sight is inside of a box, a ball, an ellipsoid or a ring.

The parts of lines are intervals of their distance t from the origin. With a `growth` all shapes are
larger by radius + spread * t on all sides: a line that is within that distance of the given one is
inside of the shape at most there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from emitree._cells import Integers
from emitree._function import Floats
from emitree._sight import Lines

#: Starts and ends (...) of an interval of each line; those that end before they start are empty.
Interval = tuple[Floats, Floats]
#: How much larger shapes are: radii (...) [length], and spreads (...) [rad].
Growth = tuple[Floats, Floats]


class Supports(Protocol):
    """Shapes outside of which functions are 0."""

    def __len__(self) -> int:
        """The number of shapes."""

    @property
    def sizes(self) -> Floats:
        """The diameters (k,) [length]."""

    def inside(self, lines: Lines, which: Integers, growth: Growth | None = None) -> list[Interval]:
        """Where lines (...) are inside of shapes, by numbers that extend to (...)."""


def lengths(parts: list[Interval]) -> Floats:
    """The lengths (...) of all parts together."""
    total = np.zeros(parts[0][0].shape)
    for start, end in parts:
        with np.errstate(invalid="ignore"):
            total += np.where(end > start, end - start, 0.0)
    return total


@dataclass(frozen=True)
class Boxes:
    """Boxes along the axes x, y, z."""

    #: Corners (k, 3) [length].
    lower: Floats
    upper: Floats

    def __len__(self) -> int:
        return len(self.lower)

    @property
    def sizes(self) -> Floats:
        """The diameters (k,) [length]."""
        return np.asarray(np.sqrt(((self.upper - self.lower) ** 2).sum(axis=1)))

    def inside(self, lines: Lines, which: Integers, growth: Growth | None = None) -> list[Interval]:
        """Where lines (...) are inside of the boxes with the numbers (...)."""
        start, end = lines.near, lines.far
        for axis in range(3):
            slab = self.lower[:, axis][which], self.upper[:, axis][which]
            start, end = _within_slab(lines, axis, *slab, start, end, growth)
        return [(start, end)]


@dataclass(frozen=True)
class Balls:
    """Balls."""

    #: (k, 3) [length].
    centers: Floats
    #: (k,) [length].
    radii: Floats

    def __len__(self) -> int:
        return len(self.radii)

    @property
    def sizes(self) -> Floats:
        """The diameters (k,) [length]."""
        return 2.0 * self.radii

    def inside(self, lines: Lines, which: Integers, growth: Growth | None = None) -> list[Interval]:
        """Where lines (...) are inside of the balls with the numbers (...)."""
        offset = lines.origin - np.moveaxis(self.centers[which], -1, 0)
        along, square = (offset * lines.direction).sum(axis=0), (offset**2).sum(axis=0)
        start, end = _within(np.ones(1), along, square, self.radii[which], growth)
        return [(np.maximum(start, lines.near), np.minimum(end, lines.far))]


@dataclass(frozen=True)
class Ellipsoids:
    """Ellipsoids in any orientation."""

    #: (k, 3) [length].
    centers: Floats
    #: Unit vectors along the axes, each divided by its semi-axis: rows of (k, 3, 3) [1/length].
    axes: Floats

    def __len__(self) -> int:
        return len(self.centers)

    @property
    def sizes(self) -> Floats:
        """The diameters (k,) [length]."""
        return np.asarray(2.0 / np.linalg.norm(self.axes, axis=2).min(axis=1))

    def inside(self, lines: Lines, which: Integers, growth: Growth | None = None) -> list[Interval]:
        """Where lines (...) are inside of the ellipsoids with the numbers (...); no growth."""
        assert growth is None
        axes = self.axes[which]
        offset = lines.origin - np.moveaxis(self.centers[which], -1, 0)
        offset = np.einsum("...ij,j...->i...", axes, offset)
        direction = np.einsum("...ij,j...->i...", axes, lines.direction)
        square = (direction**2).sum(axis=0)
        # From the point that is nearest to the centre: seen from afar, differences would cancel.
        nearest = -(offset * direction).sum(axis=0) / square
        distance = ((offset + nearest * direction) ** 2).sum(axis=0)
        start, end = _within(square, np.zeros_like(square), distance, np.ones(1), None)
        return [(np.maximum(nearest + start, lines.near), np.minimum(nearest + end, lines.far))]


@dataclass(frozen=True)
class Rings:
    """Rings about the axis z with rectangular sections."""

    #: The least and the largest (R, z) of the sections, (k, 2) [length].
    lower: Floats
    upper: Floats

    def __len__(self) -> int:
        return len(self.lower)

    @property
    def sizes(self) -> Floats:
        """The diameters (k,) [length]."""
        height = self.upper[:, 1] - self.lower[:, 1]
        return np.hypot(2.0 * self.upper[:, 0], height)

    def inside(self, lines: Lines, which: Integers, growth: Growth | None = None) -> list[Interval]:
        """Where lines (...) are inside of the rings with the numbers (...): two parts."""
        inner, low = np.moveaxis(self.lower[which], -1, 0)
        outer, high = np.moveaxis(self.upper[which], -1, 0)
        start, end = _within_slab(lines, 2, low, high, lines.near, lines.far, growth)
        x, y, _ = lines.origin
        dx, dy, _ = lines.direction
        quadratic = dx**2 + dy**2, x * dx + y * dy, x**2 + y**2
        first, last = _within(*quadratic, outer, growth)
        start, end = np.maximum(start, first), np.minimum(end, last)
        hole_start, hole_end = _in_hole(*quadratic, inner, growth)
        # Without a hole both are beyond every end.
        return [(start, np.minimum(end, hole_start)), (np.maximum(start, hole_end), end)]


def _within_slab(
    lines: Lines,
    axis: int,
    low: Floats,
    high: Floats,
    start: Floats,
    end: Floats,
    growth: Growth | None,
) -> Interval:
    """The parts of intervals in which a coordinate is between two values."""
    origin, slope = lines.origin[axis], lines.direction[axis]
    if growth is None:
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (low - origin) / slope, (high - origin) / slope
        # A line in the plane of a face: 0/0.
        is_in = (low <= origin) & (origin <= high)
        is_parallel = slope == 0.0
        first = np.where(is_parallel, np.where(is_in, -np.inf, np.inf), first)
        second = np.where(is_parallel, np.inf, second)
        low_end, high_end = np.minimum(first, second), np.maximum(first, second)
        return np.maximum(start, low_end), np.minimum(end, high_end)
    radius, spread = growth
    start, end = _at_least(slope + spread, low - radius - origin, start, end)
    return _at_least(spread - slope, origin - high - radius, start, end)


def _at_least(slope: Floats, value: Floats, start: Floats, end: Floats) -> Interval:
    """The parts of intervals in which slope * t >= value."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = value / slope
    start = np.where(slope > 0.0, np.maximum(start, root), start)
    end = np.where(slope < 0.0, np.minimum(end, root), end)
    return start, np.where((slope == 0.0) & (value > 0.0), -np.inf, end)


def _roots(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats, Any]:
    """Where a t^2 + 2 b t + c = 0 for a > 0, in order, and whether there are two roots."""
    discriminant = b * b - a * c
    has_roots = (discriminant > 0.0) & (a > 0.0)
    q = -(b + np.copysign(np.sqrt(np.where(has_roots, discriminant, 0.0)), b))
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = q / a, c / q
    return np.minimum(one, other), np.maximum(one, other), has_roots


def _within(a: Floats, b: Floats, c: Floats, radius: Floats, growth: Growth | None) -> Interval:
    """Where a t^2 + 2 b t + c <= radius^2; nowhere or everywhere on lines along the axis, a = 0."""
    if growth is not None:
        radius = radius + growth[0]
        a, b = a - growth[1] ** 2, b - radius * growth[1]
    rest = c - radius**2
    first, last, has_roots = _roots(a, b, rest)
    # With a growth a <= 0 may be: the part is not bounded, and taken as everything.
    everywhere = (a <= 0.0) & ((rest <= 0.0) | (growth is not None))
    first = np.where(has_roots, first, np.where(everywhere, -np.inf, np.inf))
    return first, np.where(has_roots, last, np.where(everywhere, np.inf, -np.inf))


def _in_hole(a: Floats, b: Floats, c: Floats, radius: Floats, growth: Growth | None) -> Interval:
    """Where a t^2 + 2 b t + c < radius^2; beyond every line where there is no such part."""
    limit: Any = np.inf
    if growth is not None:
        radius = radius - growth[0]
        a, b = a - growth[1] ** 2, b + radius * growth[1]
        with np.errstate(divide="ignore", invalid="ignore"):
            limit = np.where(growth[1] > 0.0, radius / growth[1], np.inf)
    rest = c - radius**2
    first, last, has_roots = _roots(a, b, rest)
    if growth is None:
        along_axis = (a == 0.0) & (rest < 0.0)
        first, last = np.where(along_axis, -np.inf, first), np.where(along_axis, np.inf, last)
        has_roots = has_roots | along_axis
    last = np.minimum(last, limit)
    has_hole = has_roots & (radius > 0.0) & (last > first)
    return np.where(has_hole, first, np.inf), np.where(has_hole, last, np.inf)
