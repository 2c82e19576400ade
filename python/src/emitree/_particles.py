"""Smoothed particles as an emission: sums of kernels about positions, as of SPH simulations."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from emitree import _libraries, _units
from emitree._cameras import Box
from emitree._function import Floats
from emitree._kernels import kernel_of
from emitree._native import SceneError
from emitree._real import real

#: Support radii in one tree differ at most by this factor: pairs beyond the support of their
#: particle are at most 1 - 1/_CLASS_RATIO^3 of those that are found.
_CLASS_RATIO = 1.2
#: How many pairs of points and particles are in memory at once, about.
_PAIRS = 2_000_000
#: The most seeds: each is in the text of the scene, which files keep.
_MOST_SEEDS = 500
#: One of so many successive points tells how many pairs all of them have.
_SAMPLED = 32


@dataclass(frozen=True)
class _Class:
    """Particles with support radii of about the same size."""

    tree: Any
    #: (n,) [length].
    support_radius: Floats
    #: Integrated emission times C / H^3, (n,).
    strength: Floats

    @property
    def largest(self) -> float:
        return float(self.support_radius.max())


class Particles:
    """Smoothed particles (SPH) as an emission: g(r) = sum of q_i W(|r - r_i|, H_i).

    W is a kernel with the integral 1 over space, and 0 from the support radius H_i on. q_i is the
    emission of the particle integrated over its volume: rate times volume. The emission is
    isotropic, and a function of (position, direction) for `render` and all else that takes one.

    position: (n, 3), in the length unit of the camera.
    emission: q (n,), or a number for all: rates times volume, in the unit of the rates times the
        camera's length unit cubed.
    rate: instead of `emission`, the rate per volume at each particle (n,), with the volumes of the
        particles as `volume` (n,), or as `mass` and `density` (n,), whose quotient is a volume in
        the length unit cubed: then g(r) = sum of (mass_i / density_i) rate_i W.
    smoothing_length: h (n,), or a number for all, after Monaghan and Lattanzio: the kernel ends at
        2 h, whichever kernel it is.
    support_radius: instead, H (n,): where the kernel ends. The smoothing lengths in files of Gadget
        and codes derived from it are such radii.
    kernel: "cubic_spline" (M4), "quartic_spline", "quintic_spline", "wendland_c2", "wendland_c4" or
        "wendland_c6".

    `bounds` is the box around all supports, and `seeds` are some of the particles: `render` uses
    both unless it is given others. A point costs a search in a k-d tree (scipy) for each class of
    particles whose support radii differ by up to 20 %.

    Raises `SceneError` if an array has another shape, or values that are not finite, or radii,
    volumes, masses or densities that are not above 0. Quantities of astropy are refused.

    Sources: Monaghan and Lattanzio (1985), Astron. Astrophys. 149, 135; Dehnen and Aly (2012),
    doi:10.1111/j.1365-2966.2012.21439.x, Table 1.

    >>> import emitree, numpy as np
    >>> particles = emitree.Particles(
    ...     [[0, 0, 0], [1, 0, 0]], rate=[1, 3], volume=0.5, smoothing_length=1
    ... )
    >>> len(particles), particles.emission
    (2, array([0.5, 1.5]))
    >>> camera = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), extent=(8, 8))
    >>> rendering = emitree.render(particles, camera, (32, 32), tolerance=0.01)
    >>> flux = rendering.image.sum() * (8 / 32) ** 2
    >>> bool(abs(flux - 2) < 0.01)
    True
    """

    def __init__(
        self,
        position: Any,
        *,
        emission: Any = None,
        rate: Any = None,
        volume: Any = None,
        mass: Any = None,
        density: Any = None,
        smoothing_length: Any = None,
        support_radius: Any = None,
        kernel: str = "cubic_spline",
    ) -> None:
        self._kernel = kernel_of(kernel)
        self._position = _positions(position)
        count = len(self._position)
        if (smoothing_length is None) == (support_radius is None):
            raise SceneError("expected one of `smoothing_length` and `support_radius`")
        if smoothing_length is not None:
            radius = 2.0 * _numbers("smoothing_length", smoothing_length, count, is_positive=True)
        else:
            radius = _numbers("support_radius", support_radius, count, is_positive=True)
        self._support_radius = radius
        self._emission = _integrated(emission, rate, volume, mass, density, count)
        with np.errstate(over="ignore", divide="ignore"):
            strength = self._emission * (self._kernel.normalisation / radius**3)
        bad = np.flatnonzero(~np.isfinite(strength))
        if len(bad):
            raise SceneError(
                f"particle {bad[0]} has the emission {self._emission[bad[0]]} and the support "
                f"radius {radius[bad[0]]}: expected a rate at its position that is finite"
            )
        for values in (self._position, self._emission, self._support_radius):
            values.flags.writeable = False
        self._classes = _classes(self._position, radius, strength)

    def __len__(self) -> int:
        """The number of particles."""
        return len(self._position)

    def __repr__(self) -> str:
        return f"Particles({len(self)} particles, kernel={self.kernel!r})"

    @property
    def position(self) -> Floats:
        """The positions (n, 3) [length]."""
        return self._position

    @property
    def emission(self) -> Floats:
        """The emissions integrated over the volumes of the particles (n,)."""
        return self._emission

    @property
    def support_radius(self) -> Floats:
        """The distances (n,) at which the kernels end [length]."""
        return self._support_radius

    @property
    def kernel(self) -> str:
        """The name of the kernel."""
        return self._kernel.name

    @property
    def standard_deviation(self) -> Floats:
        """The standard deviations (n,) of the kernels along one axis [length].

        For `smallest_feature` of `render`, if particles have few neighbours within their supports.
        """
        return self._support_radius * self._kernel.deviation

    @property
    def bounds(self) -> Box:
        """The box around the supports of all particles."""
        radius = self._support_radius[:, None]
        lower, upper = self._position - radius, self._position + radius
        return Box(min=tuple(lower.min(axis=0).tolist()), max=tuple(upper.max(axis=0).tolist()))

    @property
    def seeds(self) -> list[tuple[tuple[float, ...], float]]:
        """Pairs (position (3,), support radius) of some particles, at most 500, for `render`.

        They are spread over the particles of each size, so that a clump much smaller than the view
        is seen, even if all of it is in one pixel.
        """
        lower = self._position.min(axis=0)
        kind = np.floor(np.log2(self._support_radius / self._support_radius.min()))
        kind = np.minimum(kind, 64.0)
        factor = 1.0
        while True:
            # One of the particles of a size in each cube of some of their support radii.
            side = self._support_radius.min() * 2.0**kind * factor
            cube = np.column_stack([np.floor((self._position - lower) / side[:, None]), kind])
            _, chosen = np.unique(cube, axis=0, return_index=True)
            if len(chosen) <= _MOST_SEEDS:
                break
            factor *= 2.0
        return [
            (tuple(self._position[at].tolist()), float(self._support_radius[at])) for at in chosen
        ]

    def __call__(self, position: Any, direction: Any = None, energy: Any = None) -> Floats:
        """The rates (n,) at positions (n, 3), in all directions and at all energies."""
        points = np.asarray(position, dtype=np.float64)
        cKDTree = _libraries.scipy("spatial").cKDTree
        rates = np.zeros(len(points))
        for start, end in self._parts(points):
            tree = cKDTree(points[start:end])
            for of_class in self._classes:
                rates[start:end] += self._sums(of_class, tree)
        return rates

    def _parts(self, points: Floats) -> list[tuple[int, int]]:
        """Ranges of points with about `_PAIRS` pairs each."""
        count = len(points)
        if count * len(self) <= _PAIRS:
            return [(0, count)] if count else []
        # Successive points of a rendering are neighbours: one tells about the others.
        sample = points[::_SAMPLED]
        pairs = np.zeros(len(sample))
        for of_class in self._classes:
            pairs += of_class.tree.query_ball_point(sample, of_class.largest, return_length=True)
        part = np.floor(np.cumsum(pairs) * (_SAMPLED / _PAIRS))
        starts = [0, *((np.flatnonzero(np.diff(part)) + 1) * _SAMPLED).tolist(), count]
        return list(pairwise(starts))

    def _sums(self, of_class: _Class, tree: Any) -> Floats:
        """The sums over the particles of a class, at the points of a tree."""
        pairs = tree.sparse_distance_matrix(
            of_class.tree, of_class.largest, output_type="coo_matrix"
        ).tocsr()
        # The sum at a point does not depend on other points: particles have one order.
        pairs.sort_indices()
        pairs.data = self._kernel.shape(pairs.data / of_class.support_radius[pairs.indices])
        return np.asarray(pairs @ of_class.strength)


def _classes(position: Floats, radius: Floats, strength: Floats) -> list[_Class]:
    """Trees of particles with about the same support radius, the smallest first."""
    spatial = _libraries.scipy("spatial")
    numbers = np.floor(np.log(radius / radius.min()) / np.log(_CLASS_RATIO)).astype(np.int64)
    order = np.argsort(numbers, kind="stable")
    starts = np.flatnonzero(np.diff(numbers[order])) + 1
    return [
        _Class(spatial.cKDTree(position[part]), radius[part], strength[part])
        for part in np.split(order, starts)
    ]


def _integrated(
    emission: Any, rate: Any, volume: Any, mass: Any, density: Any, count: int
) -> Floats:
    """The emissions integrated over the volumes of the particles."""
    if (emission is None) == (rate is None):
        raise SceneError(
            "expected one of `emission`, integrated over the volume of each particle, and `rate`, "
            "per volume"
        )
    sizes = {"volume": volume, "mass": mass, "density": density}
    given = [name for name, values in sizes.items() if values is not None]
    if emission is not None:
        if given:
            raise SceneError(
                f"`{given[0]}` is for a `rate` per volume: expected none with `emission`, which is "
                "integrated over the volume"
            )
        return _numbers("emission", emission, count)
    if given not in (["volume"], ["mass", "density"]):
        has = " and ".join(f"`{name}`" for name in given) or "none of them"
        raise SceneError(f"`rate` has {has} beside it: expected `volume`, or `mass` and `density`")
    values = [_numbers(name, sizes[name], count, is_positive=True) for name in given]
    of_particle = values[0] if len(values) == 1 else values[0] / values[1]
    return np.asarray(_numbers("rate", rate, count) * of_particle)


def _floats(name: str, values: Any, expected: str) -> Floats:
    if _units.is_quantity(values):
        raise SceneError(
            f"`{name}` is a quantity in {values.unit}: expected numbers, as of `.to_value(unit)`, "
            "with lengths in the length unit of the camera"
        )
    return np.array(real(values, f"`{name}`", f"{expected} of numbers"))


def _positions(values: Any) -> Floats:
    expected = "an array (n, 3)"
    found = _floats("position", values, expected)
    if found.ndim != 2 or found.shape[1] != 3 or len(found) == 0:
        raise SceneError(f"`position` has the shape {found.shape}: expected (n, 3), n at least 1")
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(bad):
        raise SceneError(
            f"`position` of particle {bad[0]} is {found[bad[0]].tolist()}: expected finite numbers"
        )
    return found


def _numbers(name: str, values: Any, count: int, is_positive: bool = False) -> Floats:
    """One number for each particle; a single number is that of all."""
    found = _floats(name, values, f"a number or an array ({count},)")
    if found.shape not in ((), (count,)):
        raise SceneError(
            f"`{name}` has the shape {found.shape}: expected ({count},), as many as `position`, or "
            "one number"
        )
    found = np.broadcast_to(found, (count,)).copy()
    is_bad = ~np.isfinite(found) | (found <= 0.0 if is_positive else False)
    bad = np.flatnonzero(is_bad)
    if len(bad):
        what = "a finite number above 0" if is_positive else "a finite number"
        raise SceneError(f"`{name}` of particle {bad[0]} is {found[bad[0]]}: expected {what}")
    return found
