"""How far vertices of found surfaces are from the places where g jumps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._surfaces import Surfaces

#: The bisections of all vertices: 3 % of the expected displacement is left.
_BISECTIONS = 7

#: Rates (n,) at positions (n, 3).
Rates = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Offsets:
    """The distances along their normals from vertices to the surface."""

    #: (n,), to the middle of the last interval, and the width of its half.
    offset: Floats
    uncertainty: Floats
    #: (n,), half way between the rates on both sides.
    threshold: Floats
    #: (n,), whether the rates on both sides differ by the jump; the offset is 0 elsewhere.
    is_found: NDArray[np.bool_]


def offsets_from(
    surfaces: Surfaces, rates: Rates, bisections: int, chosen: NDArray[np.intp] | None = None
) -> Offsets:
    """The offsets of vertices, of all or of chosen ones (n,), by bisections of each."""
    part = slice(None) if chosen is None else chosen
    position, normal = surfaces.position[part], surfaces.normal[part]
    size = float(np.linalg.norm(np.ptp(surfaces.position, axis=0)))
    # Of a normal distribution with this mean size hardly any are beyond four times as far.
    width = np.maximum(4.0 * surfaces.uncertainty[part], 1e-6 * size)
    above = rates(position + width[:, np.newaxis] * normal)
    below = rates(position - width[:, np.newaxis] * normal)
    is_found = (above - below) > 0.5 * surfaces.jump[part]
    threshold = 0.5 * (above + below)

    def is_above(offset: Floats) -> NDArray[np.bool_]:
        return np.asarray(rates(position + offset[:, np.newaxis] * normal) > threshold)

    offset = np.where(is_found, bisected(is_above, width, bisections), 0.0)
    left = np.where(is_found, width * 0.5**bisections, surfaces.uncertainty[part])
    return Offsets(offset, left, threshold, is_found)


def moved_onto(surfaces: Surfaces, rates: Rates) -> Surfaces:
    """The surfaces with vertices where the rates jump, by 9 evaluations of each.

    Patches of surfaces are as accurate as the image needs. In derivatives, in which limbs are
    bright, their errors are more: those of weakly determined combinations of parameters.
    """
    found = offsets_from(surfaces, rates, _BISECTIONS)
    position = surfaces.position + found.offset[:, np.newaxis] * surfaces.normal
    return replace(surfaces, position=position, uncertainty=found.uncertainty)


def bisected(
    is_above: Callable[[Floats], NDArray[np.bool_]], width: Floats, bisections: int
) -> Floats:
    """The places (n,) within -width to width from which on a condition holds."""
    low, high = -width, width
    for _ in range(bisections):
        middle = 0.5 * (low + high)
        above = is_above(middle)
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)
