"""Which parts of lines are inside of the bounds, and not behind opaque bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from emitree._cameras import Box, Ellipsoid, Sphere
from emitree._function import Floats
from emitree._lines import Lines
from emitree._native import SceneError
from emitree._sight import Lines as Sights
from emitree._supports import Boxes, Ellipsoids


def parts_of(lines: Lines, bounds: Any, occulters: Sequence[Any]) -> tuple[Floats, Floats]:
    """Where lines begin and end (n,) inside of the bounds and before opaque bodies."""
    near, far = np.zeros(len(lines)), lines.lengths.copy()
    sights = Sights(lines.positions.T, lines.directions.T, near, far, np.ones(len(lines)))
    which = np.zeros(len(lines), dtype=np.int64)
    if bounds is not None:
        (near, far), *_ = _support("bounds", bounds, lines.length_unit).inside(sights, which)
    for number, body in enumerate(occulters):
        name = f"occulters[{number}]"
        if isinstance(body, Box):
            raise SceneError(f"`{name}` is {body}: expected a Sphere or an Ellipsoid")
        (start, end), *_ = _support(name, body, lines.length_unit).inside(sights, which)
        is_hit = end > start
        inside = np.flatnonzero(is_hit & (start <= 0.0))
        if len(inside):
            raise SceneError(
                f"line {inside[0]} begins inside of `{name}`, at {lines.positions[inside[0]]}: "
                "expected positions outside of all bodies"
            )
        far = np.where(is_hit, np.minimum(far, start), far)
    return near, np.maximum(near, far)


def _support(name: str, shape: Any, unit: str | None) -> Boxes | Ellipsoids:
    """A shape as what lines are cut with."""
    if not isinstance(shape, Box | Ellipsoid | Sphere):
        raise SceneError(f"`{name}` is {shape!r}: expected a Sphere, an Ellipsoid or a Box")
    table = shape.table(unit)
    if isinstance(shape, Box):
        lower, upper = np.array([table["min"]], float), np.array([table["max"]], float)
        if not np.all(lower < upper):
            raise SceneError(f"`{name}` is {shape}: expected `min` below `max` on each axis")
        return Boxes(lower, upper)
    semi_axes = table["semi_axes"] if isinstance(shape, Ellipsoid) else [table["radius"]] * 3
    size = np.array(semi_axes, float)
    if size.shape != (3,) or not (np.isfinite(size) & (size > 0.0)).all():
        raise SceneError(f"`{name}` is {shape}: expected finite lengths above 0")
    third = np.array(table.get("pole", (0.0, 0.0, 1.0)), float)
    third /= np.linalg.norm(third)
    meridian = np.array(table.get("meridian", (1.0, 0.0, 0.0)), float)
    first = meridian - (meridian @ third) * third
    if not np.linalg.norm(first) > 1e-9 * np.linalg.norm(meridian):
        raise SceneError(f"`{name}` is {shape}: expected `meridian` across `pole`")
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(third, first), third]) / size[:, np.newaxis]
    return Ellipsoids(np.array([table["center"]], float), axes[np.newaxis])
