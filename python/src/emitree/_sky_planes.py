"""The image planes of cameras, as in the renderer: lines of sight of places in an image.

They serve to find the camera of a WCS and to measure how well it agrees; nothing is rendered here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from emitree._cameras import Camera, Equirectangular, Fisheye, Perspective
from emitree._function import Floats


def _tangent(right: Floats, up: Floats) -> Floats:
    sight = np.stack([right, up, np.ones_like(right)], axis=-1)
    return np.asarray(sight / np.linalg.norm(sight, axis=-1, keepdims=True))


def _plate_carree(right: Floats, up: Floats) -> Floats:
    return np.stack([np.cos(up) * np.sin(right), np.sin(up), np.cos(up) * np.cos(right)], axis=-1)


def _equidistant(right: Floats, up: Floats) -> Floats:
    angle = np.hypot(right, up)
    across = np.sinc(angle / np.pi)
    return np.stack([across * right, across * up, np.cos(angle)], axis=-1)


def _equal_area(right: Floats, up: Floats) -> Floats:
    # The radius is 2 sin(angle / 2): sin(angle) = radius cos(angle / 2).
    half = np.minimum(0.5 * np.hypot(right, up), 1.0)
    across = np.sqrt(1 - half**2)
    return np.stack([across * right, across * up, 1 - 2 * half**2], axis=-1)


@dataclass(frozen=True)
class Plane:
    """An image plane that pixels divide evenly.

    sight: unit vectors (right, up, forward) of places on the plane, for small angles in radians.
    widest: the largest half extents of an image on it; half extents of images.
    """

    code: str
    camera: type[Camera]
    sight: Callable[[Floats, Floats], Floats]
    widest: tuple[float, float]
    is_disc: bool = False


_TAN_89_DEG = float(np.tan(np.radians(89.0)))

#: By the code of the projection in FITS.
PLANES = {
    plane.code: plane
    for plane in (
        Plane("TAN", Perspective, _tangent, (_TAN_89_DEG, _TAN_89_DEG)),
        Plane("CAR", Equirectangular, _plate_carree, (np.pi, np.pi / 2)),
        Plane("ARC", Fisheye, _equidistant, (np.pi, np.pi), is_disc=True),
        Plane("ZEA", Fisheye, _equal_area, (2.0, 2.0), is_disc=True),
    )
}
