"""Functions of which an emission is a weighted sum: radial functions and voxels.

Where they are 0 is known, so that a response costs only what is not.
"""

from __future__ import annotations

import math
from typing import Any, Literal, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from emitree._cells import Integers
from emitree._function import Floats
from emitree._native import SceneError
from emitree._supports import Balls, Boxes, Rings, Supports


class Basis(Protocol):
    """k functions of the position, with values from 0 to 1, each 0 outside of its support."""

    def __len__(self) -> int:
        """The number of functions."""

    @property
    def supports(self) -> Supports:
        """Outside of these the functions are 0."""

    @property
    def feature(self) -> Floats:
        """The size (k,) of what is to be resolved [length]."""

    @property
    def is_constant(self) -> bool:
        """Whether the functions are 1 in their supports."""

    @property
    def edge(self) -> float:
        """The largest value at the border of a support, inside."""

    def values(self, position: Floats, which: Integers) -> Floats:
        """The values (...) of functions at positions (3, ...), inside the supports.

        which: their numbers, of a shape that extends to (...).
        """


class Dense:
    """All functions of a basis at given points."""

    #: Whether the functions are 1 in their supports.
    is_constant = False

    def __call__(self: Any, position: Floats, direction: Floats | None = None) -> Floats:
        """All functions (n, k) at positions (n, 3): an emission with k components."""
        position = np.asarray(position, dtype=float)
        count = len(self)
        found = np.zeros((len(position), count))
        for number in range(count):
            inside = self._is_inside(position, number)
            which = np.full(int(inside.sum()), number)
            found[inside, number] = self.values(position[inside].T, which)
        return found

    def emission(self: Any, coefficients: Any) -> Any:
        """The sum of all functions with coefficients (k,), as an emission for `render`."""
        weights = np.asarray(coefficients, dtype=float)
        if weights.shape != (len(self),):
            raise ValueError(
                f"`coefficients` has the shape {weights.shape}: expected ({len(self)},)"
            )

        def emission(position: Floats, direction: Floats) -> Floats:
            return cast(Floats, self(position) @ weights)

        return emission


class RadialFunctions(Dense):
    """Functions of the distance from a centre: in space, or in the section of a torus.

    centers: (k, 3), places x, y, z: balls; or (k, 2), places (R, z) in the section: rings about the
        axis z, R^2 = x^2 + y^2. In the length unit of the cameras.
    width: of all functions, or (k,), above 0. Of a Gaussian, the standard deviation; of a Wendland
        function, the distance beyond which it is 0.
    kind: with the distance q in widths, "gaussian": exp(-q^2 / 2) up to `cutoff`, 0 beyond; or
        "wendland": (1 - q)^4 (4 q + 1), twice continuously differentiable (H. Wendland 1995,
        doi:10.1007/BF02123482).
    cutoff: of Gaussians, in widths; at 4 a Gaussian is 3.4e-4 of its maximum.

    Raises `SceneError` if a shape or a number is not as described.

    >>> import emitree, numpy as np
    >>> basis = emitree.RadialFunctions([[2.0, 0.0], [2.5, 0.0]], 0.25)
    >>> basis(np.array([[0.0, 2.0, 0.0]])).round(4)
    array([[1.    , 0.1353]])
    """

    def __init__(
        self,
        centers: Any,
        width: Any,
        kind: Literal["gaussian", "wendland"] = "gaussian",
        *,
        cutoff: float = 4.0,
    ) -> None:
        self.centers = _places("centers", centers)
        widths = finite("width", width)
        if widths.ndim > 1 or (widths.ndim == 1 and len(widths) != len(self.centers)):
            raise SceneError(
                f"`width` has the shape {widths.shape}: expected a number, or ({len(self)},)"
            )
        if not (widths > 0.0).all():
            raise SceneError(f"`width` is {width}: expected lengths above 0")
        self.width = np.broadcast_to(widths, (len(self.centers),))
        if kind not in ("gaussian", "wendland"):
            raise SceneError(f'`kind` is {kind!r}: expected "gaussian" or "wendland"')
        if not (math.isfinite(cutoff) and cutoff > 0.0):
            raise SceneError(f"`cutoff` is {cutoff}: expected a number of widths above 0")
        self.kind, self.cutoff = kind, float(cutoff)
        self.supports: Supports
        reach = self.width * (cutoff if kind == "gaussian" else 1.0)
        if self.centers.shape[1] == 3:
            self.supports = Balls(self.centers, reach)
        else:
            half = reach[:, np.newaxis]
            self.supports = Rings(self.centers - half, self.centers + half)
        self._reach = reach

    def __len__(self) -> int:
        return len(self.centers)

    @property
    def feature(self) -> Floats:
        """The size (k,) of what is to be resolved [length]."""
        return self.width * (1.0 if self.kind == "gaussian" else 0.35)

    @property
    def edge(self) -> float:
        """The value at the border of a support, inside."""
        return math.exp(-0.5 * self.cutoff**2) if self.kind == "gaussian" else 0.0

    def values(self, position: Floats, which: Integers) -> Floats:
        """The values (...) of the functions with the numbers (...) at (3, ...)."""
        square = self._squares(position, which)
        if self.kind == "gaussian":
            return np.where(square <= self.cutoff**2, np.exp(-0.5 * square), 0.0)
        q = np.sqrt(square)
        # Two squares: a fourth power of NumPy takes five times as long.
        power = np.maximum(1.0 - q, 0.0) ** 2
        power *= power
        return cast(Floats, power * (4.0 * q + 1.0))

    def _squares(self, position: Floats, which: Integers) -> Floats:
        """Squared distances in widths."""
        centers = self.centers[which]
        if self.centers.shape[1] == 3:
            x, y, z = position
            square = (x - centers[..., 0]) ** 2 + (y - centers[..., 1]) ** 2
            square += (z - centers[..., 2]) ** 2
        else:
            radius, z = coordinates(position, 2)
            square = (radius - centers[..., 0]) ** 2 + (z - centers[..., 1]) ** 2
        return cast(Floats, square * (1.0 / self.width[which] ** 2))

    def _is_inside(self, position: Floats, number: int) -> NDArray[np.bool_]:
        which = np.full(len(position), number)
        scaled = self._squares(position.T, which) * self.width[number] ** 2
        return cast("NDArray[np.bool_]", scaled <= self._reach[number] ** 2)

    def __repr__(self) -> str:
        return f"<emitree {len(self)} radial functions, {self.kind}, in {_space(self.centers)}>"


class Voxels(Dense):
    """Functions that are 1 inside of a box or a ring, and 0 outside.

    lower, upper: opposite corners: (k, 3), least and largest x, y, z: boxes along the axes; or
        (k, 2), least and largest (R, z): rings about the axis z with rectangular sections. In the
        length unit of the cameras.

    Raises `SceneError` if a shape or a number is not as described.

    >>> import emitree, numpy as np
    >>> rings = emitree.Voxels.grid(np.linspace(2, 4, 3), np.linspace(-1, 1, 5))
    >>> len(rings), rings.lower[1].tolist()
    (8, [2.0, -0.5])
    """

    is_constant = True

    def __init__(self, lower: Any, upper: Any) -> None:
        self.lower, self.upper = _places("lower", lower), _places("upper", upper)
        if self.lower.shape != self.upper.shape:
            raise SceneError(
                f"`lower` and `upper` have the shapes {self.lower.shape} and {self.upper.shape}: "
                "expected the same"
            )
        if not (self.lower < self.upper).all():
            number = int((self.lower >= self.upper).any(axis=1).argmax())
            raise SceneError(
                f"`lower` and `upper` number {number} are {self.lower[number].tolist()} and "
                f"{self.upper[number].tolist()}: expected lower < upper"
            )
        self.supports = shapes(self.lower, self.upper)

    @classmethod
    def grid(cls, *edges: Any, mask: Any = None) -> Voxels:
        """The cells of a grid, those of the last axis one after the other.

        edges: ascending borders of cells along x, y and z, or along R and z.
        mask: (cells of the first axis, ...), True for those that are wanted; all by default.
        """
        if len(edges) not in (2, 3):
            raise SceneError(f"there are edges of {len(edges)} axes: expected 2 (R, z) or 3")
        borders = [_ascending(f"edges[{axis}]", edge) for axis, edge in enumerate(edges)]
        shape = tuple(len(edge) - 1 for edge in borders)
        wanted = np.ones(shape, dtype=bool) if mask is None else np.asarray(mask)
        if wanted.shape != shape or wanted.dtype != bool:
            raise SceneError(
                f"`mask` has the shape {wanted.shape} and the type {wanted.dtype}: expected "
                f"{shape} and bool"
            )
        places = np.nonzero(wanted)
        pairs = list(zip(borders, places, strict=True))
        lower = np.stack([edge[place] for edge, place in pairs], axis=1)
        return cls(lower, np.stack([edge[place + 1] for edge, place in pairs], axis=1))

    def __len__(self) -> int:
        return len(self.lower)

    @property
    def feature(self) -> Floats:
        """The size (k,) of what is to be resolved [length]: the smallest edge."""
        return cast(Floats, (self.upper - self.lower).min(axis=1))

    @property
    def edge(self) -> float:
        """1: the value at the border of a support, inside."""
        return 1.0

    def values(self, position: Floats, which: Integers) -> Floats:
        """1 (...): the functions inside of their supports."""
        return np.ones(position.shape[1:])

    def _is_inside(self, position: Floats, number: int) -> NDArray[np.bool_]:
        return is_between(position, self.lower[number], self.upper[number])

    def __repr__(self) -> str:
        kind = "rings" if self.lower.shape[1] == 2 else "boxes"
        return f"<emitree {len(self)} voxels, {kind}>"


def coordinates(position: Floats, axes: int) -> list[Floats]:
    """x, y, z, or R and z, each (...), of positions (3, ...)."""
    x, y, z = position
    return [x, y, z] if axes == 3 else [np.sqrt(x * x + y * y), z]


def is_between(position: Floats, lower: Floats, upper: Floats) -> NDArray[np.bool_]:
    at = np.stack(coordinates(position.T, len(lower)), axis=1)
    return cast("NDArray[np.bool_]", ((lower <= at) & (at < upper)).all(axis=1))


def shapes(lower: Floats, upper: Floats) -> Supports:
    return Boxes(lower, upper) if lower.shape[1] == 3 else Rings(lower, upper)


def _space(places: Floats) -> str:
    return "space" if places.shape[1] == 3 else "the section of a torus"


def finite(name: str, given: Any) -> Floats:
    values = np.asarray(given)
    if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
        raise SceneError(f"`{name}` is {given!r}: expected finite numbers")
    return values.astype(float)


def _places(name: str, given: Any) -> Floats:
    places = finite(name, given)
    if places.ndim != 2 or places.shape[1] not in (2, 3) or len(places) == 0:
        raise SceneError(
            f"`{name}` has the shape {places.shape}: expected (k, 3) for x, y, z or (k, 2) for R, z"
        )
    return places


def _ascending(name: str, given: Any) -> Floats:
    values = finite(name, given)
    if values.ndim != 1 or len(values) < 2 or not (np.diff(values) > 0.0).all():
        raise SceneError(f"`{name}` is {given!r}: expected two or more ascending numbers")
    return values
