"""Integrals along the lines of a family from an image in which they are places.

The image is that of `render`, and its pixels are means. The value at a place is that of a
polynomial with the same means over the pixels around it. Its error is the largest of these pixels,
and a multiple of the difference to a polynomial of lower degree anywhere around it, which is large
beside jumps: lines there are to be integrated one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._cells import Integers
from emitree._function import Floats, Function
from emitree._line_families import FEWEST, Plane, planes
from emitree._lines import Lines
from emitree._sight import View

#: Pixels along each axis of the two polynomials, of the degrees 6 and 4.
_MANY, _FEW = 7, 5
#: Places in a pixel, along each axis, at which the difference of both is taken.
_PLACES = (np.arange(3) + 0.5) / 3.0
#: How many pixels on each side of a place are searched for differences, and for errors of pixels.
_REACH = 2
#: The error of the first polynomial is at most this times the largest difference around it: of 900
#: images of jumps, kinks and square roots along lines and circles it was up to 41 times.
_OF_DIFFERENCE = 41.0
#: The nodes of Gauss's rule on a pixel.
_GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
#: The part of the allowed error that is left to the image, and the largest tolerance of an image:
#: with looser ones, single pixels have larger errors than they should.
SHARE, LOOSEST = 0.8, 0.01
#: Lines of a family that are integrated one by one too: an image that differs from these more than
#: both errors say is not taken.
_CHECKED = 16
#: Evaluations that an image may take for each line: half of what it takes one by one.
_WORTH = 60
#: How far the ends of a line may be from those of the line of sight, relative to both.
_ENDS = 1e-9


def _cell_weights(count: int) -> Floats:
    """Coefficients (count, count) of the weights of means over cells 0 to 1, 1 to 2 and so on.

    The value at u of the polynomial with these means is the sum over cells of mean times weight,
    and row k has the coefficients of the weight of cell k, that of the highest power of u first. It
    is the derivative of the polynomial through the integrals from 0 to each border.
    """
    slopes = []
    for border in range(count + 1):
        others = [float(other) for other in range(count + 1) if other != border]
        basis = np.poly(others) / np.prod([border - other for other in others])
        slopes.append(np.polyder(basis))
    return np.array([np.sum(slopes[cell + 1 :], axis=0) for cell in range(count)])


_WEIGHTS = {count: _cell_weights(count) for count in (_MANY, _FEW)}


def _along(at: Floats, pixels: int, count: int) -> tuple[Integers, Floats]:
    """The first of `count` pixels around places (n,) on an axis, and their weights (n, count)."""
    cell = np.floor(at).astype(np.int64)
    first = np.clip(cell - count // 2, 0, pixels - count)
    inside = at - first
    powers = inside[:, np.newaxis] ** np.arange(count - 1, -1, -1)
    return first, powers @ _WEIGHTS[count].T


def values_at(image: Floats, error: Floats, plane: Plane, places: Floats) -> tuple[Floats, Floats]:
    """Values and errors (n,) at places (n, 2) of an image (height, width) with its error."""
    height, width = plane.shape
    rows, columns = np.indices(plane.shape)
    corner = np.stack([columns, rows], axis=-1).astype(np.float64)
    nodes = [plane.density(corner + np.array([x, y])) for x in _GAUSS for y in _GAUSS]
    # Pixels are means weighted with the solid angle.
    of_pixel = np.mean(nodes, axis=0)
    image, error = image * of_pixel, error * of_pixel
    first_column, of_columns = _along(places[:, 0], width, _MANY)
    first_row, of_rows = _along(places[:, 1], height, _MANY)
    each = np.arange(_MANY)
    row = first_row[:, np.newaxis, np.newaxis] + each[:, np.newaxis]
    column = first_column[:, np.newaxis, np.newaxis] + each
    value = np.einsum("nij,ni,nj->n", image[row, column], of_rows, of_columns)
    bound = largest_around(error, _REACH) + _OF_DIFFERENCE * largest_around(
        _difference(image), _REACH
    )
    inside = np.floor(places).astype(np.int64)
    column, row = (np.clip(inside[:, axis], 0, (width, height)[axis] - 1) for axis in (0, 1))
    density = plane.density(places)
    return value / density, bound[row, column] / density


def _difference(image: Floats) -> Floats:
    """The largest difference of the two polynomials in each pixel (height, width)."""
    height, width = image.shape
    many, few = (
        _sampled(height, count) @ image @ _sampled(width, count).T for count in (_MANY, _FEW)
    )
    sides = len(_PLACES)
    apart = abs(many - few).reshape(height, sides, width, sides)
    return np.asarray(apart.max(axis=(1, 3)))


def _sampled(pixels: int, count: int) -> Any:
    """The matrix from pixels to values at all places along an axis."""
    from scipy.sparse import csr_array

    places = (np.arange(pixels)[:, np.newaxis] + _PLACES).ravel()
    first, weights = _along(places, pixels, count)
    column = first[:, np.newaxis] + np.arange(count)
    starts = count * np.arange(len(places) + 1)
    return csr_array((weights.ravel(), column.ravel(), starts), shape=(len(places), pixels))


def largest_around(values: Any, reach: int) -> Any:
    """For each pixel (height, width) the largest of those up to `reach` rows and columns away."""
    found = values.copy()
    for axis in (0, 1):
        before = found.copy()
        for step in range(1, reach + 1):
            ahead, back = [slice(None)] * 2, [slice(None)] * 2
            ahead[axis], back[axis] = slice(step, None), slice(None, -step)
            for to, of in ((back, ahead), (ahead, back)):
                part = found[tuple(to)]
                np.maximum(part, before[tuple(of)], out=part)
    return found


#: Integrals and errors (n, k) of lines (n,) one by one, and the number of evaluations.
Integrals = Callable[[Integers], tuple[Floats, Floats, int]]


@dataclass
class Shared:
    """What images tell of lines."""

    #: Whether each line (n,) has a value.
    is_known: NDArray[np.bool_]
    #: Values and errors (n, k), 0 where there are none.
    values: Floats
    errors: Floats
    evaluations: int


def none_shared(count: int, columns: int) -> Shared:
    """Nothing is known of `count` lines with `columns` components."""
    zeros = np.zeros((count, columns))
    return Shared(np.zeros(count, dtype=bool), zeros, zeros.copy(), 0)


def shared_integrals(
    function: Function,
    lines: Lines,
    parts: tuple[Floats, Floats],
    columns: int,
    *,
    bounds: Any,
    occulters: Sequence[Any],
    seeds: Sequence[Any],
    allowed: dict[str, float],
    integrals: Integrals,
    most: int,
) -> Shared:
    """The integrals along lines of families, by an image of each.

    parts: where lines begin and end (n,) inside of the bounds and before opaque bodies.
    columns: the number k of components.
    allowed: `tolerance`, or `rtol` and `atol`, of images.
    integrals: integrates lines one by one, for comparison.
    most: how often the function may be evaluated.
    """
    found = none_shared(len(lines), columns)
    if len(lines) < FEWEST:
        return found
    for plane in planes(lines, min(allowed.values())):
        options = {"bounds": bounds, "occulters": occulters}
        plane = plane.take(_agrees(plane, lines, parts, options))
        budget = min(most - found.evaluations, _WORTH * len(plane.line))
        if len(plane.line) < FEWEST or budget < _WORTH * FEWEST:
            continue
        _add(found, function, plane, options | {"seeds": seeds}, allowed, budget)
        _check(found, plane.line, integrals)
    return found


def _check(found: Shared, line: Integers, integrals: Integrals) -> None:
    """Compares some lines of a family with their integrals one by one."""
    # Multiples of the golden ratio are spread evenly, however the lines are ordered.
    spread = np.arange(1, _CHECKED + 1) * (0.5 * (np.sqrt(5.0) - 1.0)) % 1.0
    some = line[np.floor(spread * len(line)).astype(np.int64)]
    values, errors, evaluations = integrals(some)
    found.evaluations += evaluations
    apart = abs(values - found.values[some])
    found.is_known[line] = bool(np.all(apart <= errors + found.errors[some]))


def _agrees(
    plane: Plane, lines: Lines, parts: tuple[Floats, Floats], options: dict[str, Any]
) -> NDArray[np.bool_]:
    """Whether lines are lines of sight of the camera, with the same ends."""
    view = View(plane.camera, plane.shape, **options)
    height, width = plane.shape
    sight = view.lines_at(plane.places[:, 0] / width, plane.places[:, 1] / height)
    position, direction = lines.positions[plane.line], lines.directions[plane.line]
    # Distances from the origin of the line of sight.
    start = ((position - sight.origin.T) * direction).sum(axis=1)
    near, far = (start + of[plane.line] for of in parts)
    is_in_view = far > near
    size = abs(near) + np.where(np.isfinite(far), abs(far), 0.0) + np.linalg.norm(position, axis=1)
    apart = np.linalg.norm(sight.origin.T + start[:, np.newaxis] * direction - position, axis=1)
    with np.errstate(invalid="ignore"):
        same_far = (far == sight.far) | (abs(far - sight.far) <= _ENDS * size)
    return np.asarray(
        is_in_view
        & same_far
        & (abs(near - sight.near) <= _ENDS * size)
        & (np.linalg.norm(sight.direction.T - direction, axis=1) < _ENDS)
        & (apart <= _ENDS * size)
    )


def _add(
    found: Shared,
    function: Function,
    plane: Plane,
    options: dict[str, Any],
    allowed: dict[str, float],
    budget: int,
) -> None:
    """Renders the image of a family, and adds the values at the places of its lines."""
    from emitree._components import Components
    from emitree._render import render

    def rates(position: Floats, direction: Floats) -> Floats:
        return function(position, direction, None)

    near = _near_places(plane)
    given: dict[str, Any] = {**allowed, **options}
    rendered = render(
        rates,
        plane.camera,
        plane.shape,
        mask=near.astype(np.float64) if not near.all() else None,
        max_evaluations=budget,
        **given,
    )
    components = list(rendered) if isinstance(rendered, Components) else [rendered]
    for number, one in enumerate(components):
        error = np.full(plane.shape, np.inf) if one.error is None else one.error
        values, errors = values_at(one.image, error, plane, plane.places)
        found.values[plane.line, number], found.errors[plane.line, number] = values, errors
    found.evaluations += rendered.evaluations


def _near_places(plane: Plane) -> NDArray[np.bool_]:
    """The pixels (height, width) that the values at places depend on."""
    height, width = plane.shape
    near = np.zeros((height, width), dtype=bool)
    column, row = np.floor(plane.places).astype(np.int64).T
    near[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)] = True
    return np.asarray(largest_around(near, _MANY // 2 + _REACH))
