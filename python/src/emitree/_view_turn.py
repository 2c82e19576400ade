"""Cameras that are turned: around their target, or around their observer."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from emitree._cameras import Camera, Orthographic, Perspective
from emitree._function import Floats
from emitree._scene import length_unit_of

#: The smallest angle between the line of sight and the direction of up [deg].
_LEAST_ANGLE_DEG = 1.0

#: By how much a drag across the whole image turns a camera around its target [deg].
_AROUND_TARGET_DEG = 180.0


def can_turn(camera: Camera | None) -> bool:
    """Whether `turned` has a camera for this one.

    A cube and a whole sky have no direction; the coordinates of a WCS are those of one direction.
    """
    return camera is not None and hasattr(camera, "target") and camera.sky is None


def turned(camera: Camera, right: float, up: float) -> Camera:
    """The camera after a drag by fractions of the width and the height of the image.

    What is seen follows the drag. `Perspective` and `Orthographic` go around their target at the
    same distance, 180 degrees for the whole image; others stay and turn by their field of view.
    Right is around the direction of up, and no camera comes closer than 1 degree to that direction.

    >>> import emitree
    >>> camera = emitree.Orthographic(position=(3, 0, 0), target=(0, 0, 0), extent=(2, 2))
    >>> turned(camera, 0.5, 0).position
    (0.0, -3.0, 0.0)
    """
    unit = length_unit_of(camera, [])
    table = camera.table(unit)
    position, target = (np.array(table[key], dtype=np.float64) for key in ("position", "target"))
    axis = np.array(table.get("up", [0.0, 0.0, 1.0]), dtype=np.float64)
    axis /= np.linalg.norm(axis)
    changed: dict[str, Any] = {"length_unit": unit}
    if isinstance(camera, Perspective | Orthographic):
        angle_deg = _AROUND_TARGET_DEG
        place = target + _rotated(position - target, axis, -right * angle_deg, up * angle_deg)
        changed |= {"position": _tuple(place), "target": _tuple(target)}
    else:
        fields_deg = np.broadcast_to(np.asarray(table["field_of_view"], dtype=np.float64), (2,))
        away = _rotated(target - position, axis, right * fields_deg[0], up * fields_deg[1])
        changed |= {"position": _tuple(position), "target": _tuple(position + away)}
    return replace(camera, **changed)  # type: ignore[type-var]


def _rotated(vector: Floats, axis: Floats, around_deg: float, from_axis_deg: float) -> Floats:
    """A vector, rotated around an axis and then away from it."""
    along = vector @ axis
    across = vector - along * axis
    length, radius = np.linalg.norm(vector), np.linalg.norm(across)
    if radius <= 1e-12 * length:
        return vector
    first = across / radius
    second = np.cross(axis, first)
    around = np.radians(around_deg)
    limits = np.radians([_LEAST_ANGLE_DEG, 180.0 - _LEAST_ANGLE_DEG])
    # The angle changes towards a limit where the vector was beyond it, but is not set to it.
    before = np.arctan2(radius, along)
    polar = before + np.radians(from_axis_deg)
    polar = float(np.clip(polar, min(before, limits[0]), max(before, limits[1])))
    across = np.cos(around) * first + np.sin(around) * second
    return length * (np.sin(polar) * across + np.cos(polar) * axis)


def _tuple(values: Floats) -> tuple[float, ...]:
    # Rounding leaves 1e-16 of the length where there is nothing.
    rounded = np.where(np.abs(values) < 1e-15 * np.linalg.norm(values), 0.0, values)
    return tuple((rounded + 0.0).tolist())
