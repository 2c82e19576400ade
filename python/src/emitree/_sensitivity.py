"""Sensitivity matrices are made: pixels are divided until each column is within its tolerance."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from emitree import _options
from emitree._basis import RadialFunctions, Voxels
from emitree._cameras import Camera
from emitree._cells import Integers
from emitree._function import Floats, as_rates, name_of
from emitree._native import SceneError
from emitree._pixel_means import Means, first_means, refined, strips
from emitree._responses import OfBasis, OfFunction, Response
from emitree._sensitivity_matrix import Sensitivity, scipy_sparse
from emitree._setup import in_length_unit
from emitree._sight import View
from emitree._splines import BSplines

#: The largest entry of a column counts as at least this fraction of the largest of all: a function
#: at the border of a view may have entries of any size.
FLOOR = 1e-6
#: How often the largest entries, to which errors are relative, are determined again.
_ROUNDS = 12
#: Before an entry of a column is known, its scale is this fraction of the largest error.
_GUESS = 0.05
#: Pairs of a pixel and a function that are refined together.
_TOGETHER = 2048


@dataclass
class _Block:
    """The entries of some functions in one view."""

    view: View
    response: Response
    #: The numbers of the first pixel and of the first function in the matrix.
    row: int
    column: int
    pixel: Integers
    which: Integers
    value: Floats
    error: Floats

    def columns(self) -> Integers:
        """The columns (n, 1), or (1, k), of the values."""
        if self.response.columns == 1:
            return self.column + self.which[:, np.newaxis]
        return np.arange(self.column, self.column + self.response.columns)[np.newaxis]


#: Runs tasks, and gives their results in order.
Run = Callable[[Callable[[Any], Means], list[Any]], Iterator[Means]]


def sensitivity(
    basis: Any,
    cameras: Camera | Sequence[Camera],
    shape: Any,
    tolerance: float = 0.01,
    *,
    bounds: Any = None,
    occulters: Sequence[Any] = (),
    threads: int | None = None,
) -> Sensitivity:
    """The sensitivity matrix of some cameras to some functions: means over pixels, to a tolerance.

    basis: `RadialFunctions`, `Voxels` or `BSplines`; a function f(position, direction) -> rates,
        (n,) or (n, k) for k functions, as an emission of `render`; or a list of any of these, whose
        columns follow each other.
    cameras: a `Camera`, or a list of cameras with the same `length_unit`.
    shape: (height, width) of all images, or a list with one for each camera.
    tolerance: the largest error of an entry of a column, relative to the largest |entry| of the
        column over all cameras; above 0 and below 1.
    bounds, occulters: as of `render`: outside of the bounds all functions are 0, and opaque bodies
        hide what is behind them.
    threads: how many threads work, 1 to 1024; as many as there are processors by default. Functions
        are called in the calling thread. The matrix has the same bits for any number.

    Pixels are divided until the estimated error of each mean is within the tolerance. The place and
    the size of `RadialFunctions`, `Voxels` and `BSplines` are known, so that they are integrated
    only where they are not 0, and small ones are not missed. Other functions are integrated along
    all lines of sight, which have to be finite, by `far` or `bounds`. Their features are seen if
    they are no smaller than about half of a pixel and a fortieth of a line.

    Raises `SceneError` if an argument is wrong, `ImportError` without scipy, and any exception of a
    function.

    >>> import emitree, numpy as np
    >>> rings = emitree.Voxels.grid(np.linspace(2, 4, 5), np.linspace(-1, 1, 5))
    >>> cameras = [
    ...     emitree.Perspective(
    ...         position=position, target=(0, 2, 0), field_of_view=(50, 40), far=np.inf
    ...     )
    ...     for position in [(4.6, 0, 0.2), (-4.6, 0, -0.3)]
    ... ]
    >>> found = emitree.sensitivity(rings, cameras, (12, 16), tolerance=0.02)
    >>> found.matrix.shape, found.converged
    ((384, 16), True)
    >>> [image.shape for image in found.image(np.ones(16))]
    [(12, 16), (12, 16)]
    """
    sparse = scipy_sparse()
    if not (isinstance(tolerance, float | int) and 0.0 < tolerance < 1.0):
        raise SceneError(f"`tolerance` is {tolerance!r}: expected a number above 0 and below 1")
    views, shapes, is_one, unit = _views(cameras, shape, bounds, occulters)
    responses = _responses(basis, views)
    functions = sum(response.functions for response in responses)
    count = _options.threads(threads) or os.cpu_count() or 1
    lines = evaluations = 0
    blocks: list[_Block] = []
    with ThreadPoolExecutor(count) as pool:
        row = 0
        for view in views:
            column = 0
            for response in responses:
                task = partial(first_means, view, response)
                found = list(_run(pool, response)(task, strips(view)))
                lines += sum(means.lines for means in found)
                evaluations += sum(means.evaluations for means in found)
                blocks.append(_block(view, response, row, column, found))
                column += response.functions
            row += len(view)
        for _ in range(_ROUNDS):
            scale = _scales(blocks, functions, is_guessed=True)
            allowed = tolerance * scale
            open_blocks = [(block, _open(block, allowed)) for block in blocks]
            if not any(len(items) for _, items in open_blocks):
                break
            for block, items in open_blocks:
                for means in _refined(pool, block, items, allowed):
                    lines, evaluations = lines + means.lines, evaluations + means.evaluations
    parts = [_entries(block) for block in blocks]
    rows, columns, values = (np.concatenate(part) for part in zip(*parts, strict=True))
    pixels = sum(len(view) for view in views)
    matrix = sparse.csr_array((values, (rows, columns)), shape=(pixels, functions))
    return Sensitivity(
        matrix=matrix,
        error=_largest(blocks, functions, "error"),
        scale=_scales(blocks, functions, is_guessed=False),
        tolerance=float(tolerance),
        shapes=shapes,
        in_image=np.concatenate([view.has_image() for view in views]),
        unit=unit,
        lines=lines,
        evaluations=evaluations,
        _is_one_camera=is_one,
    )


def _views(
    cameras: Any, shape: Any, bounds: Any, occulters: Sequence[Any]
) -> tuple[list[View], tuple[tuple[int, int], ...], bool, str | None]:
    """The views of the cameras, their shapes, whether there is one camera alone, and their unit."""
    is_one = isinstance(cameras, Camera)
    given = [cameras] if is_one else list(cameras)
    if not given or not all(isinstance(camera, Camera) for camera in given):
        raise SceneError(f"`cameras` is {cameras!r}: expected a camera, or a list of cameras")
    is_several = np.ndim(shape) == 2
    sides = list(shape) if is_several else [shape] * len(given)
    if len(sides) != len(given):
        raise SceneError(f"`shape` has {len(sides)} shapes: expected one, or {len(given)}")
    views = [
        View(camera, of, bounds=bounds, occulters=occulters)
        for camera, of in zip(given, sides, strict=True)
    ]
    units = {view.scene.length_unit for view in views}
    if len(units) > 1:
        raise SceneError(f"the cameras have the length units {units}: expected the same for all")
    return views, tuple(view.shape for view in views), is_one, units.pop()


def _responses(basis: Any, views: list[View]) -> list[Response]:
    """The columns of a basis, or of a list."""
    if isinstance(basis, RadialFunctions | Voxels | BSplines):
        return [OfBasis(basis)]
    if callable(basis):
        return [_of_function(in_length_unit(basis, views[0].scene.length_unit), views)]
    if isinstance(basis, Sequence) and not isinstance(basis, str) and len(basis) > 0:
        return _merged([one for part in basis for one in _responses(part, views)])
    raise SceneError(
        f"`basis` is {basis!r}: expected RadialFunctions, Voxels, BSplines, a function "
        "f(position, direction), or a list of these"
    )


def _of_function(function: Callable[..., Any], views: list[View]) -> OfFunction:
    """A function, after one call that tells how many components it has."""
    for number, view in enumerate(views):
        lines = view.lines_at(np.array([0.5]), np.array([0.5]))
        if not (np.isfinite(lines.near) & np.isfinite(lines.far)).all():
            raise SceneError(
                f"the lines of sight of camera {number} are infinite: expected a finite `near` and "
                f"`far`, or `bounds`, for the function {name_of(function)}"
            )
    lines = views[0].lines_at(np.array([0.5]), np.array([0.5]))
    middle = lines.origin + 0.5 * (lines.near + lines.far) * lines.direction
    rates = as_rates(function(middle.T, -lines.direction.T), 1, None, takes_components=True)
    return OfFunction(function, rates.reshape(1, -1).shape[1])


def _merged(responses: list[Response]) -> list[Response]:
    """Neighbouring functions as one, so that they share their points."""
    merged: list[Response] = []
    together: list[OfFunction] = []
    for response in [*responses, None]:
        if isinstance(response, OfFunction):
            together.append(response)
            continue
        if together:
            count = sum(one.functions for one in together)
            merged.append(OfFunction(_Together([one.function for one in together]), count))
            together = []
        if response is not None:
            merged.append(response)
    return merged


@dataclass(frozen=True)
class _Together:
    """The rates of several functions as one with components."""

    functions: list[Callable[[Floats, Floats], Any]]

    def __call__(self, position: Floats, direction: Floats) -> Floats:
        """The rates (n, k) of all."""
        count = len(position)
        found = [
            as_rates(function(position, direction), count, None, takes_components=True)
            for function in self.functions
        ]
        return np.concatenate([rates.reshape(count, -1) for rates in found], axis=1)


def _run(pool: ThreadPoolExecutor, response: Response) -> Run:
    """Where tasks of a response run: functions of a user in this thread, all else in the pool."""
    return cast(Run, map if isinstance(response, OfFunction) else pool.map)


def _block(view: View, response: Response, row: int, column: int, means: Sequence[Means]) -> _Block:
    names = ("pixel", "which", "value", "error")
    arrays = [np.concatenate([getattr(one, name) for one in means]) for name in names]
    return _Block(view, response, row, column, *arrays)


def _largest(blocks: Sequence[_Block], functions: int, name: str) -> Floats:
    """The largest |value| or error (k,) of each column."""
    found = np.zeros(functions)
    for block in blocks:
        values = abs(getattr(block, name))
        np.maximum.at(found, np.broadcast_to(block.columns(), values.shape), values)
    return found


def _scales(blocks: Sequence[_Block], functions: int, is_guessed: bool) -> Floats:
    """What the errors (k,) of columns are relative to."""
    scale = _largest(blocks, functions, "value")
    if is_guessed:
        scale = np.where(scale > 0.0, scale, _GUESS * _largest(blocks, functions, "error"))
    return np.asarray(np.maximum(scale, FLOOR * scale.max(initial=0.0)))


def _open(block: _Block, allowed: Floats) -> NDArray[np.intp]:
    """The numbers of pairs whose error is larger than what is allowed in their columns (k,)."""
    return np.flatnonzero((block.error > allowed[block.columns()]).any(axis=1))


def _refined(
    pool: ThreadPoolExecutor, block: _Block, items: NDArray[np.intp], allowed: Floats
) -> Iterator[Means]:
    """Refines some pairs of a block."""
    together = max(1, _TOGETHER // block.response.columns)
    parts = np.array_split(items, max(1, math.ceil(len(items) / together)))
    columns = np.broadcast_to(block.columns(), block.value.shape)

    def task(part: NDArray[np.intp]) -> Means:
        targets = allowed[columns[part]]
        return refined(block.view, block.response, block.pixel[part], block.which[part], targets)

    for part, means in zip(parts, _run(pool, block.response)(task, parts), strict=True):
        block.value[part], block.error[part] = means.value, means.error
        yield means


def _entries(block: _Block) -> tuple[Integers, Integers, Floats]:
    """Rows, columns and values of a block, without zeros."""
    columns = np.broadcast_to(block.columns(), block.value.shape)
    rows = np.broadcast_to(block.row + block.pixel[:, np.newaxis], block.value.shape)
    kept = block.value != 0.0
    return rows[kept], columns[kept], block.value[kept]
