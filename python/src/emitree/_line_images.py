"""Integrals along the lines of a family from what an image is made of, in which they are places.

The image is that of `render`. Products, image trees in the charts of bodies, and found surfaces
give the radiance along any line of sight of it, with an error: lines whose errors are too large,
as some beside limbs are, are to be integrated one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._cells import Integers
from emitree._function import Floats, Function
from emitree._line_families import FEWEST, Plane, planes
from emitree._lines import Lines
from emitree._sight import View

#: The part of the allowed error that is left to the image, and the largest tolerance of an image:
#: with looser ones, single pixels have larger errors than they should.
SHARE, LOOSEST = 0.9, 0.01
#: Lines of a family that are integrated one by one too, the fewest and the most, and the share of
#: the evaluations of the image that they may take.
_CHECKED, _CHECKED_SHARE = (4, 32), 0.1
#: In how many panels, as a share of those of other lines, and in how many those that contradict.
_PANELS = (0.5, 4.0)
#: What the largest difference of these is beyond both errors is added to all errors so many times.
_BEYOND = 2.0
#: Evaluations that such a line takes, at least.
_ALONE = 60
#: Evaluations that an image may take for each line: half of what it takes one by one.
_WORTH = 60
#: An image that has lines in a smaller share of its pixels has errors limited there alone.
_MASKED = 0.25
#: How far the ends of a line may be from those of the line of sight, relative to both.
_ENDS = 1e-9


#: Integrals and errors (n, k) of lines (n,) one by one, in a share of the panels of other lines,
#: and the number of evaluations.
Integrals = Callable[[Integers, float], tuple[Floats, Floats, int]]


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
    for plane in planes(lines):
        options = {"bounds": bounds, "occulters": occulters}
        plane = _best(plane, lines, parts, options)
        budget = min(most - found.evaluations, _WORTH * len(plane.line))
        if len(plane.line) < FEWEST or budget < _WORTH * FEWEST:
            continue
        before = found.evaluations
        _add(found, function, plane, options | {"seeds": seeds}, allowed, budget)
        affordable = _CHECKED_SHARE * (found.evaluations - before) / _ALONE
        _check(found, plane.line, int(np.clip(affordable, *_CHECKED)), integrals)
    return found


def _check(found: Shared, line: Integers, count: int, integrals: Integrals) -> None:
    """Compares some lines of a family with their integrals one by one.

    What the largest difference is beyond the estimated errors is added to the errors of all lines,
    so that an image which is wrong has no line within the tolerance.
    """
    # Multiples of the golden ratio are spread evenly, however the lines are ordered.
    spread = np.arange(1, count + 1) * (0.5 * (np.sqrt(5.0) - 1.0)) % 1.0
    some = line[np.floor(spread * len(line)).astype(np.int64)]
    some = some[found.is_known[some]]
    for share in _PANELS:
        # Lines that contradict are integrated anew: a few panels may miss what the image has.
        values, errors, evaluations = integrals(some, share)
        found.evaluations += evaluations
        apart = abs(values - found.values[some])
        beyond = np.maximum(apart - errors - found.errors[some], 0.0)
        contradicts = beyond.max(axis=1, initial=0.0) > 0.0
        some, beyond = some[contradicts], beyond[contradicts]
        if len(some) == 0:
            return
    found.errors[line] += _BEYOND * beyond.max(axis=0)


def _best(
    plane: Plane, lines: Lines, parts: tuple[Floats, Floats], options: dict[str, Any]
) -> Plane:
    """The plane with those of its lines that are lines of sight of the camera, with the same ends.

    If bounds end all of them, the depths of the camera are those of the bounds: other ones would be
    surfaces at which its view begins or ends.
    """
    own = plane.take(_agrees(plane, lines, parts, options))
    if options["bounds"] is None:
        return own
    free = replace(plane.camera, near=-np.inf if plane.is_parallel else 0.0, far=np.inf)
    free_plane = replace(plane, camera=free)
    of_bounds = free_plane.take(_agrees(free_plane, lines, parts, options))
    return of_bounds if len(of_bounds.line) >= len(own.line) else own


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
    from emitree._render import rendered_with_lines

    def rates(position: Floats, direction: Floats) -> Floats:
        return function(position, direction, None)

    near = _near_places(plane)
    given: dict[str, Any] = {**allowed, **options, "max_evaluations": budget}
    if np.count_nonzero(near) < _MASKED * near.size:
        given["mask"] = near.astype(np.float64)
    height, width = plane.shape
    places = plane.places / np.array([width, height])
    rendered = rendered_with_lines(rates, plane.camera, plane.shape, places, given)
    components = list(rendered) if isinstance(rendered, Components) else [rendered]
    for number, one in enumerate(components):
        of_lines = one._found.line_values()
        if of_lines is None or not one.converged:
            # Before its final verification an image has errors that nothing has checked.
            of_lines = np.zeros(len(places)), np.full(len(places), np.inf)
        found.values[plane.line, number], found.errors[plane.line, number] = of_lines
    found.evaluations += rendered.evaluations
    is_known = np.isfinite(found.errors[plane.line]).all(axis=1)
    found.is_known[plane.line] = is_known
    unknown = plane.line[~is_known]
    found.values[unknown], found.errors[unknown] = 0.0, 0.0


def _near_places(plane: Plane) -> NDArray[np.bool_]:
    """The pixels (height, width) that places are in, and those around them."""
    height, width = plane.shape
    near = np.zeros((height, width), dtype=bool)
    column, row = np.floor(plane.places).astype(np.int64).T
    near[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)] = True
    return np.asarray(_with_neighbours(near))


def _with_neighbours(near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels, and those beside them."""
    for axis in (0, 1):
        found = near.copy()
        ahead, back = [slice(None)] * 2, [slice(None)] * 2
        ahead[axis], back[axis] = slice(1, None), slice(None, -1)
        found[tuple(ahead)] |= near[tuple(back)]
        found[tuple(back)] |= near[tuple(ahead)]
        near = found
    return near
