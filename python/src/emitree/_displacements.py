"""How far surfaces at which g jumps move with parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._native import RenderError
from emitree._offsets import Rates, bisected, offsets_from
from emitree._surfaces import Surfaces

#: The most vertices at which displacements are found; those of the others are interpolated.
_MOST_VERTICES = 600

#: How many of these are tried before the others, to choose the change of a parameter.
_TRIED = 80

#: The reach of the search along a normal, in diagonals of the box around all surfaces: so short
#: that surfaces are planes and displacements proportional to changes, to about a per cent.
_REACH = 2e-3

#: Bisections: displacements are found to the reach divided by 2 to this power.
_BISECTIONS = 14

#: How often the first change is made four times as large: those of parameters near 0 are small.
_MOST_GROWTHS = 12

#: Neighbours of which a displacement is interpolated.
_NEIGHBOURS = 8


@dataclass(frozen=True)
class Samples:
    """Vertices of surfaces at which displacements are found, on the surface to rounding."""

    #: (n, 3), and unit vectors (n, 3) to the side with the larger rate.
    position: Floats
    normal: Floats
    #: (n,), half way between the rates on both sides.
    threshold: Floats
    #: The reach (scalar) of the search [length].
    reach: float
    #: Numbers (vertices, k) of the samples near each vertex, and their weights.
    neighbours: NDArray[np.intp]
    weights: Floats

    def at_vertices(self, values: Floats) -> Floats:
        """Values (vertices,) from those at the samples (n,)."""
        return np.asarray((self.weights * values[self.neighbours]).sum(axis=1))

    def is_above(
        self, rates: Rates, offset: Floats, chosen: slice | None = None
    ) -> NDArray[np.bool_]:
        """Whether the rates (n,) at distances along the normals are those of the larger side."""
        part = slice(None) if chosen is None else chosen
        position = self.position[part] + offset[part, np.newaxis] * self.normal[part]
        return np.asarray(rates(position) > self.threshold[part])

    def displacements(self, rates: Rates) -> tuple[Floats, NDArray[np.bool_]]:
        """The distances (n,) along normals to the surfaces of other rates, and where they are."""
        reach = np.full(len(self.position), self.reach)
        is_found = self.is_above(rates, reach) & ~self.is_above(rates, -reach)
        above = partial(self.is_above, rates)
        return bisected(above, reach, _BISECTIONS), is_found


def samples_of(surfaces: Surfaces, rates: Rates) -> Samples:
    """Some vertices all over the surfaces, moved onto them by bisection."""
    size = float(np.linalg.norm(np.ptp(surfaces.position, axis=0)))
    part = _parts(surfaces)
    chosen = _spread(surfaces.position, part, size)
    found = offsets_from(surfaces, rates, _BISECTIONS, chosen)
    chosen = chosen[found.is_found]
    position, normal = surfaces.position[chosen], surfaces.normal[chosen]
    position = position + found.offset[found.is_found, np.newaxis] * normal
    threshold = found.threshold[found.is_found]
    neighbours, weights = _interpolation(surfaces, part, chosen)
    return Samples(position, normal, threshold, _REACH * size, neighbours, weights)


def change_of(samples: Samples, moved: Callable[[float], Rates], first: float) -> float:
    """A change of a parameter that moves surfaces by half of the reach at most, and not much less.

    moved: the rates where the parameter is changed; first: the change that is tried first. Where
    nothing moves it is the largest one that is tried.
    """
    tried = slice(None, None, max(1, len(samples.position) // _TRIED))
    offset = np.full(len(samples.position), 0.5 * samples.reach)

    def is_within(change: float, share: float) -> bool:
        rates = moved(change)
        above = samples.is_above(rates, share * offset, tried)
        below = samples.is_above(rates, -share * offset, tried)
        return bool(np.mean(above & ~below) > 0.98)

    change = first
    while not is_within(change, 1.0) and abs(change) > 1e-6 * abs(first):
        change *= 0.25
    if change == first:
        for _ in range(_MOST_GROWTHS):
            if not _is_possible(is_within, change):
                break
            change *= 4.0
        while abs(change) > abs(first) and not _is_possible(is_within, change, 1.0):
            change *= 0.25
    return change


def _is_possible(
    is_within: Callable[[float, float], bool], change: float, share: float = 0.25
) -> bool:
    """Whether surfaces move by less than a share of the reach; False if there are no rates."""
    try:
        return is_within(change, share)
    except (ArithmeticError, ValueError, RuntimeWarning, RenderError):
        # A model may refuse parameters that are far from those given.
        return False


def _parts(surfaces: Surfaces) -> NDArray[np.intp]:
    """The number of the connected surface that each vertex belongs to: its least vertex."""
    part = np.arange(len(surfaces))
    corners = surfaces.triangles
    while True:
        least = part[corners].min(axis=1)
        found = part.copy()
        for corner in corners.T:
            np.minimum.at(found, corner, least)
        found = found[found]
        if np.array_equal(found, part):
            return part
        part = found


def _spread(position: Floats, part: NDArray[np.intp], size: float) -> NDArray[np.intp]:
    """Numbers of vertices, at most one for each surface and cube of a lattice."""
    origin, count, width = position.min(axis=0), 40, size / 40
    while True:
        cube = np.floor((position - origin) / width).astype(np.int64)
        key = ((part * 4096 + cube[:, 0]) * 4096 + cube[:, 1]) * 4096 + cube[:, 2]
        chosen = np.sort(np.unique(key, return_index=True)[1])
        if len(chosen) <= _MOST_VERTICES or count == 1:
            return chosen
        width *= 1.1


def _interpolation(
    surfaces: Surfaces, part: NDArray[np.intp], chosen: NDArray[np.intp]
) -> tuple[NDArray[np.intp], Floats]:
    """Neighbours (vertices, k) among the chosen vertices, and weights: moving least squares.

    Planes are fitted to the values of neighbours, with weights that fall with the distance.
    """
    count = min(_NEIGHBOURS, len(chosen))
    neighbours = np.empty((len(surfaces), count), dtype=np.intp)
    weights = np.empty((len(surfaces), count))
    for start in range(0, len(surfaces), 2048):
        rows = slice(start, start + 2048)
        position, others = surfaces.position[rows], surfaces.position[chosen]
        squares = (position**2).sum(axis=1)[:, np.newaxis] + (others**2).sum(axis=1)
        squares = np.maximum(squares - 2 * position @ others.T, 0.0)
        aligned = surfaces.normal[rows] @ surfaces.normal[chosen].T
        apart = (part[rows, np.newaxis] != part[chosen]) | (aligned < 0.3)
        # Another surface serves if there is nothing else, and only then.
        squares = np.where(apart, 1e6 * (squares + squares.max()), squares)
        near = np.argpartition(squares, count - 1, axis=1)[:, :count]
        squares = np.take_along_axis(squares, near, axis=1)
        scale = squares.max(axis=1, keepdims=True)
        nearness = 1.0 / (squares / scale + 1e-3) ** 2
        away = others[near] - position[:, np.newaxis]
        first, second = _tangents(surfaces.normal[rows])
        u = (away * first[:, np.newaxis]).sum(axis=2) / np.sqrt(scale)
        v = (away * second[:, np.newaxis]).sum(axis=2) / np.sqrt(scale)
        terms = np.stack([np.ones_like(u), u, v], axis=2)
        weighted = nearness[:, :, np.newaxis] * terms
        normal = np.einsum("nki,nkj->nij", terms, weighted)
        normal[:, 1, 1] += 1e-2 * normal[:, 0, 0]
        normal[:, 2, 2] += 1e-2 * normal[:, 0, 0]
        first_row = np.linalg.inv(normal)[:, 0]
        neighbours[rows] = near
        weights[rows] = np.einsum("ni,nki->nk", first_row, weighted)
    return neighbours, weights


def _tangents(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors (n, 3) perpendicular to each normal and to each other."""
    axis = np.eye(3)[abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normal, first)
