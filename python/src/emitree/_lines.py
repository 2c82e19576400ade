"""Lines of sight that are given one by one, and detector elements that are sums of lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from emitree import _units
from emitree._cameras import Camera, Canonical, Healpix
from emitree._function import Floats
from emitree._native import SceneError
from emitree._sight import View
from emitree._sparse import SparseMatrix


class Lines:
    """Lines of sight: chords, fans, slits, limb scans, or anything else that is a list of rays.

    positions: (n, 3), where they begin, usually the observer; or (3,) for all.
    directions: (n, 3), vectors of any length but 0, away from the observer; or (3,) for all.
    lengths: (n,), how far each extends, 0 or more, or infinite; or a number for all.
    weights: (m, n), detector elements that are weighted sums of lines, such as apertures and pixels
        of finite size: an array, a sparse matrix of scipy or a `SparseMatrix`. Without weights each
        line is an element.
    groups: instead of weights, m lists of line numbers, from 0: each element is the mean of these.
    scale: of infinite lines, (n,) or a number for all: half of the samples are within three times
        this distance. By default that of the origin, or 1 if that is 0.
    length_unit: the unit of all lengths, such as "R_E"; needed if units are. Astropy quantities are
        converted to it.

    Arrays are attributes with the same names, `directions` of length 1, `weights` a `SparseMatrix`
    or None.

    Raises `SceneError` with the name of the argument, and the number of the line if there is one.

    >>> import emitree, numpy as np
    >>> angle = np.radians([-20, 0, 20])
    >>> fan = np.stack([np.cos(angle), np.sin(angle), np.zeros(3)], axis=1)
    >>> lines = emitree.Lines((-2, 0, 0), fan, 4.0)
    >>> lines
    <emitree.Lines: 3 lines>
    >>> emitree.Lines((-2, 0, 0), fan, 4.0, groups=[[0, 1], [1, 2]])
    <emitree.Lines: 3 lines in 2 sums>
    """

    def __init__(
        self,
        positions: Any,
        directions: Any,
        lengths: Any,
        weights: Any = None,
        *,
        groups: Any = None,
        scale: Any = None,
        length_unit: Any = None,
    ) -> None:
        unit = _units.to_text(length_unit)
        if unit is None:
            unit = _units.to_text(_units.first_unit([positions, lengths, scale]))
        #: The unit of lengths; None if it is not known.
        self.length_unit = unit
        given = {
            name: _numbers(name, _units.value_in(value, unit, name), expected, sides)
            for name, value, expected, sides in [
                ("positions", positions, "(n, 3) or (3,)", (3,)),
                ("directions", directions, "(n, 3) or (3,)", (3,)),
                ("lengths", lengths, "(n,), or a number", ()),
                ("scale", scale, "(n,), or a number", ()),
            ]
            if value is not None
        }
        count = _count(given)
        of = {
            name: np.array(np.broadcast_to(values, (count, *values.shape[1:])))
            for name, values in given.items()
        }
        #: (n, 3) [length].
        self.positions: Floats = of["positions"]
        _check("positions", self.positions, np.isfinite(self.positions).all(axis=1), "finite")
        length = np.linalg.norm(of["directions"], axis=1)
        is_good = np.isfinite(length) & (length > 0.0)
        _check("directions", of["directions"], is_good, "a vector of a finite length above 0")
        #: Unit vectors (n, 3), away from the observer.
        self.directions: Floats = of["directions"] / length[:, np.newaxis]
        #: (n,) [length].
        self.lengths: Floats = of["lengths"]
        _check("lengths", self.lengths, self.lengths >= 0.0, "0 or more, or inf")
        default = np.linalg.norm(self.positions, axis=1)
        #: Of infinite lines, (n,) [length].
        self.scale: Floats = of.get("scale", np.where(default > 0.0, default, 1.0))
        is_good = np.isfinite(self.scale) & (self.scale > 0.0)
        _check("scale", self.scale, is_good, "a finite length above 0")
        #: Whether these are the lines of a camera, of `camera.lines`.
        self.is_of_camera = False
        #: (m, n), or None.
        self.weights: SparseMatrix | None = None
        if groups is not None:
            if weights is not None:
                raise SceneError("`weights` and `groups` are given: expected one or the other")
            self.weights = _means(groups, count)
        elif weights is not None:
            self.weights = _matrix(weights, count)

    def __len__(self) -> int:
        """The number of lines."""
        return len(self.lengths)

    def __repr__(self) -> str:
        sums = "" if self.weights is None else f" in {self.weights.shape[0]} sums"
        unit = f" in {self.length_unit}" if self.length_unit else ""
        return f"<emitree.Lines{unit}: {len(self)} lines{sums}>"


def lines_of_camera(
    camera: Camera, shape: Sequence[int] | int, *, bounds: Any, occulters: Sequence[Any]
) -> Lines:
    """The lines of sight through the centres of the pixels of a camera."""
    view = View(camera, shape, bounds=bounds, occulters=occulters)
    height, width = view.shape
    row, column = np.divmod(np.arange(len(view)), width)
    lines = view.lines_at((column + 0.5) / width, (row + 0.5) / height)
    is_seen = view.has_image() & (lines.far > lines.near)
    near = np.where(is_seen, lines.near, 0.0)
    if not np.isfinite(near).all():
        raise SceneError("`near` is -inf: expected a finite depth, or `bounds`, for lines")
    length = np.where(is_seen, lines.far - near, 0.0)
    position = (lines.origin + near * lines.direction).T
    unit = view.scene.length_unit
    made = Lines(position, lines.direction.T, length, scale=_scale(camera, unit), length_unit=unit)
    made.is_of_camera = True
    return made


def _scale(camera: Camera, unit: str | None) -> float:
    """The scale of infinite lines of a camera."""
    if isinstance(camera, Canonical):
        return 1.0
    table = camera.table(unit)
    target = (0.0, 0.0, 0.0) if isinstance(camera, Healpix) else table["target"]
    distance = float(np.linalg.norm(np.subtract(table["position"], target)))
    return distance if distance > 0.0 else 1.0


def _numbers(name: str, value: Any, expected: str, sides: tuple[int, ...]) -> Floats:
    """An array (n, *sides), or (1, *sides) of a value for all lines."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError(
            f"`{name}` is {type(value).__name__}: expected an array {expected}"
        ) from None
    if array.shape == sides:
        array = array[np.newaxis]
    if array.ndim != 1 + len(sides) or array.shape[1:] != sides:
        raise SceneError(f"`{name}` has the shape {array.shape}: expected {expected}")
    return array


def _count(given: dict[str, Floats]) -> int:
    """The number of lines."""
    counts = {name: len(values) for name, values in given.items() if len(values) != 1}
    if len(set(counts.values())) > 1:
        shown = ", ".join(f"`{name}` {count}" for name, count in counts.items())
        raise SceneError(f"the numbers of lines are different: {shown}; expected the same for all")
    return next(iter(counts.values()), 1)


def _check(name: str, values: Floats, is_good: Any, expected: str) -> None:
    wrong = np.flatnonzero(~is_good)
    if len(wrong):
        raise SceneError(f"`{name}[{wrong[0]}]` is {values[wrong[0]]}: expected {expected}")


def _matrix(weights: Any, count: int) -> SparseMatrix:
    """Weights (m, n) of sums of lines."""
    if isinstance(weights, SparseMatrix):
        matrix = weights
    elif hasattr(weights, "tocsr"):
        rows = weights.tocsr()
        data = np.asarray(rows.data, dtype=np.float64)
        matrix = SparseMatrix(data, rows.indices, rows.indptr, rows.shape)
    else:
        try:
            dense = np.asarray(weights, dtype=np.float64)
        except (TypeError, ValueError):
            raise SceneError(
                f"`weights` is {type(weights).__name__}: expected a matrix (m, {count}) of numbers"
            ) from None
        if dense.ndim != 2:
            raise SceneError(f"`weights` has the shape {dense.shape}: expected (m, {count})")
        row, column = np.nonzero(dense)
        starts = np.concatenate(([0], np.cumsum(np.bincount(row, minlength=len(dense)))))
        matrix = SparseMatrix(dense[row, column], column, starts, (len(dense), dense.shape[1]))
    if len(matrix.shape) != 2 or matrix.shape[1] != count:
        raise SceneError(f"`weights` has the shape {matrix.shape}: expected (m, {count})")
    if not np.isfinite(matrix.data).all():
        raise SceneError("`weights` has numbers that are not finite: expected finite ones")
    return matrix


def _means(groups: Any, count: int) -> SparseMatrix:
    """The means over groups of lines, by their numbers."""
    if not isinstance(groups, Sequence | np.ndarray) or isinstance(groups, str) or not len(groups):
        raise SceneError(f"`groups` is {groups!r}: expected a list of lists of line numbers")
    arrays = [np.asarray(group) for group in groups]
    for number, lines in enumerate(arrays):
        is_good = lines.ndim == 1 and len(lines) > 0 and lines.dtype.kind in "iu"
        if not is_good or lines.min() < 0 or lines.max() >= count:
            raise SceneError(
                f"`groups[{number}]` is {groups[number]}: expected numbers of lines, "
                f"0 to {count - 1}"
            )
    sizes = np.array([len(lines) for lines in arrays])
    starts = np.concatenate(([0], np.cumsum(sizes)))
    every = np.concatenate(arrays).astype(np.int64)
    return SparseMatrix(np.repeat(1.0 / sizes, sizes), every, starts, (len(arrays), count))
