"""Families of lines: those through one point, and those that are parallel, as places in an image.

Lines of a family are lines of sight of a camera: their integrals are one function on its image
plane, which needs far fewer evaluations than each line by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from emitree._cameras import Equirectangular, Orthographic, Perspective
from emitree._cells import Integers
from emitree._function import Floats
from emitree._lines import Lines

#: The fewest lines of a family: fewer are cheaper one by one.
FEWEST = 100
#: How far lines may pass the point that they have in common, relative to their distance from it;
#: and by how much parallel directions may differ [rad].
_NEAR = 1e-10
#: Pairs of lines whose common point is tried.
_TRIALS = 64
#: The widest angle from the middle of a flat image to a line [rad].
_FLAT = np.radians(55.0)
#: Pixels beside the lines in an image.
MARGIN = 1
#: The fewest and the most pixels along the longer side of an image.
_SIDES = (64, 400)

#: The cameras of images.
ImageCamera: TypeAlias = Equirectangular | Orthographic | Perspective


@dataclass(frozen=True)
class Plane:
    """An image plane whose pixels are even, with the lines of a family as places on it.

    camera: that of the image.
    shape: (height, width) [pixels].
    line: the numbers (n,) of the lines.
    places: (n, 2), x and y [pixels] from the lower left corner.
    """

    camera: ImageCamera
    shape: tuple[int, int]
    line: Integers
    places: Floats

    @property
    def is_parallel(self) -> bool:
        """Whether the lines are parallel."""
        return isinstance(self.camera, Orthographic)

    def take(self, keep: NDArray[np.bool_]) -> Plane:
        """The same with some of its lines."""
        return replace(self, line=self.line[keep], places=self.places[keep])


def planes(lines: Lines) -> Iterator[Plane]:
    """The image planes of the families of lines, whatever the ends of the lines are."""
    left = np.flatnonzero(lines.lengths > 0.0)
    for line, viewpoint in _families(lines, left):
        made = _parallel(lines, line) if viewpoint is None else _central(lines, line, viewpoint)
        if made is not None:
            yield _imaged(lines, line, viewpoint, *made)


def _families(lines: Lines, left: Integers) -> Iterator[tuple[Integers, Floats | None]]:
    """The numbers of the lines of each family, and the point that they have in common."""
    same, number, count = np.unique(
        lines.positions[left], axis=0, return_inverse=True, return_counts=True
    )
    number = number.ravel()
    taken = np.zeros(len(left), dtype=bool)
    for which in np.flatnonzero(count >= FEWEST):
        is_in = number == which
        taken |= is_in
        yield left[is_in], same[which]
    left = left[~taken]
    left, families = _parallels(lines, left)
    for family in families:
        yield family, None
    yield from _crossing(lines, left)


def _parallels(lines: Lines, left: Integers) -> tuple[Integers, list[Integers]]:
    """Lines that are not parallel to many others, and families of those that are."""
    found = []
    for _ in range(_TRIALS):
        if len(left) < FEWEST:
            break
        # In the order in which they are given, neighbours are of one family.
        across = np.cross(lines.directions[left], lines.directions[left[0]])
        ahead = lines.directions[left] @ lines.directions[left[0]] > 0.0
        is_in = (np.linalg.norm(across, axis=1) < _NEAR) & ahead
        if np.count_nonzero(is_in) < FEWEST:
            break
        found.append(left[is_in])
        left = left[~is_in]
    return left, found


def _crossing(lines: Lines, left: Integers) -> Iterator[tuple[Integers, Floats]]:
    """Families of lines through a point that is not the position of all of them."""
    first = 0
    for _ in range(_TRIALS):
        if len(left) < FEWEST or first + 1 >= len(left):
            return
        point = _nearest_point(lines, left[[first, (first + len(left)) // 2]])
        near = _nearest_point(lines, left[[first, first + 1]])
        for candidate in (point, near):
            if candidate is None:
                continue
            line = left[_passes(lines, left, candidate)]
            if len(line) < FEWEST:
                continue
            exact = _nearest_point(lines, line)
            if exact is None or not _passes(lines, line, exact).all():
                exact = candidate
            yield line, exact
            left, first = np.setdiff1d(left, line), 0
            break
        else:
            first += max(1, len(left) // _TRIALS)


def _nearest_point(lines: Lines, line: Integers) -> Floats | None:
    """The point with the least sum of squared distances from lines; None of parallel ones."""
    direction, position = lines.directions[line], lines.positions[line]
    middle = position.mean(axis=0)
    across = np.eye(3) - direction[:, :, np.newaxis] * direction[:, np.newaxis, :]
    matrix = across.sum(axis=0)
    if np.linalg.eigvalsh(matrix)[0] < 1e-9 * len(line):
        return None
    right = np.einsum("nij,nj->i", across, position - middle)
    return np.asarray(middle + np.linalg.solve(matrix, right))


def _passes(lines: Lines, line: Integers, point: Floats) -> NDArray[np.bool_]:
    """Whether lines pass through a point."""
    towards = point - lines.positions[line]
    across = np.linalg.norm(np.cross(lines.directions[line], towards), axis=1)
    size = np.linalg.norm(towards, axis=1) + np.linalg.norm(lines.positions[line], axis=1)
    return np.asarray(across <= _NEAR * size)


def _central(lines: Lines, line: Integers, viewpoint: Floats) -> tuple[str, Floats, Floats] | None:
    """The plane of lines through a point: its kind, its axes in rows, and places (n, 2) on it."""
    direction = lines.directions[line]
    forward = _unit(direction.mean(axis=0))
    if forward is None or (direction @ forward).min() < np.cos(_FLAT):
        # Longitudes and latitudes about the plane that the lines are nearest to.
        axes = np.linalg.svd(direction - direction.mean(axis=0), full_matrices=False)[2]
        up = axes[2]
        middle = direction.mean(axis=0)
        middle = middle - (middle @ up) * up
        forward = _unit(middle)
        forward = axes[0] if forward is None else forward
        sight = np.stack([np.cross(forward, up), up, forward])
        right, above, ahead = (direction @ sight.T).T
        places = np.stack([np.arctan2(right, ahead), np.arcsin(np.clip(above, -1, 1))], axis=1)
        return "round", sight, places
    for _ in range(4):
        sight = _axes(direction, forward)
        right, up, ahead = (direction @ sight.T).T
        places = np.stack([right / ahead, up / ahead], axis=1)
        middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
        again = _unit(middle @ sight[:2] + sight[2])
        if again is None or np.abs(middle).max() < 1e-12:
            break
        forward = again
    return "flat", sight, places


def _parallel(lines: Lines, line: Integers) -> tuple[str, Floats, Floats]:
    """The plane of parallel lines, as `_central`."""
    forward = lines.directions[line[0]]
    position = lines.positions[line]
    sight = _axes(position - position.mean(axis=0), forward)
    return "parallel", sight, (position - position.mean(axis=0)) @ sight[:2].T


def _axes(vectors: Floats, forward: Floats) -> Floats:
    """Rows are right, along which vectors extend most across forward, up and forward."""
    across = vectors - (vectors @ forward)[:, np.newaxis] * forward
    across = across - across.mean(axis=0)
    longest = np.linalg.eigh(across.T @ across)[1][:, -1]
    right = _unit(longest - (longest @ forward) * forward)
    if right is None:
        right = _unit(np.cross(forward, np.eye(3)[np.argmin(abs(forward))]))
    assert right is not None
    # right x up = -forward
    return np.stack([right, np.cross(right, forward), forward])


def _unit(vector: Floats) -> Floats | None:
    length = float(np.linalg.norm(vector))
    return np.asarray(vector / length) if length > 1e-6 else None


def _imaged(
    lines: Lines,
    line: Integers,
    viewpoint: Floats | None,
    kind: str,
    sight: Floats,
    places: Floats,
) -> Plane:
    """The image plane around places on it."""
    low, high = places.min(axis=0), places.max(axis=0)
    middle = 0.5 * (low + high)
    if kind == "flat":
        # It is made for this: what is left is rounding.
        middle[:] = 0.0
    elif kind == "round":
        middle[1] = 0.0
    half = np.abs(places - middle).max(axis=0)
    longest = float(half.max())
    if longest <= 0.0:
        # One line, many times.
        longest = 1e-6 if viewpoint is not None else 1e-6 * (1.0 + abs(lines.positions).max())
    is_thin = half.min() < 0.05 * longest
    side = np.clip(len(line) if is_thin else np.sqrt(len(line)), *_SIDES)
    step = 2.0 * longest / side
    counts = 2 * (np.ceil(half / step).astype(int) + MARGIN)
    if kind == "round":
        # The whole circle is closed, and latitudes end at the poles.
        most = np.array([np.pi, 0.5 * np.pi]) / step
        counts = np.minimum(counts, 2 * np.maximum(np.floor(most).astype(int), MARGIN))
    extent = counts * step
    width, height = (int(count) for count in counts)
    steps = np.array([step, step])
    if kind == "round":
        whole = np.array([2.0 * np.pi, np.pi])
        is_closed = extent > whole - 2.0 * MARGIN * step
        extent = np.where(is_closed, whole, extent)
        steps = extent / counts
        middle[0] = 0.0 if is_closed[0] else middle[0]
        forward = np.sin(middle[0]) * sight[0] + np.cos(middle[0]) * sight[2]
        sight = np.stack([np.cross(forward, sight[1]), sight[1], forward])
        places = places - np.array([middle[0], 0.0])
        middle = np.zeros(2)
    camera = _camera(lines, line, viewpoint, kind, sight, middle, extent)
    on_image = (places - middle) / steps + 0.5 * counts
    return Plane(camera, (height, width), line, on_image)


def _camera(
    lines: Lines,
    line: Integers,
    viewpoint: Floats | None,
    kind: str,
    sight: Floats,
    middle: Floats,
    extent: Floats,
) -> ImageCamera:
    """The camera of a plane."""
    _, up, forward = sight
    position = lines.positions[line]
    if viewpoint is None:
        origin = position.mean(axis=0) + middle @ sight[:2]
        start = (position - origin) @ forward
        origin = origin + start.min() * forward
        start = start - start.min()
    else:
        origin = viewpoint
        start = ((position - origin) * lines.directions[line]).sum(axis=1)
        start = np.where(abs(start) < 1e-12 * (1.0 + np.linalg.norm(origin)), 0.0, start)
    near = max(float(start.min()), 0.0)
    far = float((start + lines.lengths[line]).max())
    reach = float(lines.scale[line[0]]) if not np.isfinite(far) else max(far, near + 1e-300)
    common: dict[str, Any] = {
        "position": origin.tolist(),
        "target": (origin + reach * forward).tolist(),
        "up": up.tolist(),
        "near": near,
        "far": far,
        "length_unit": lines.length_unit,
    }
    if kind == "parallel":
        return Orthographic(extent=extent.tolist(), **common)
    if kind == "round":
        angles = np.degrees(extent).tolist()
        return Equirectangular(field_of_view=angles, **common)
    angles = np.degrees(2.0 * np.arctan(0.5 * extent)).tolist()
    return Perspective(field_of_view=angles, **common)
