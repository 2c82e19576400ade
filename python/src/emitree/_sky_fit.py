"""The camera whose pixels are closest to those of a WCS, by least squares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree._function import Floats
from emitree._native import SceneError
from emitree._sky_planes import Plane

#: Where the pointing of most cameras is, as fractions of the image.
MIDDLE = np.array([0.5, 0.5])

#: How many corners along each axis are compared.
_CORNERS = 17


def directions_of(wcs: Any, to_model: Floats, places: Floats) -> Floats:
    """Unit vectors in the model (n, 3) of places (n, 2) in the image of a WCS [pixels].

    The lower left corner of the image is at (0, 0); NaN where the WCS has no direction.
    """
    # Pixel centres are at whole numbers: the lower left corner of an image is at -1/2.
    found = np.radians(wcs.all_pix2world(places - 0.5, 0))
    lon, lat = found[:, wcs.wcs.lng], found[:, wcs.wcs.lat]
    unit = [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]
    return np.asarray(np.stack(unit, axis=-1) @ to_model.T)


@dataclass(frozen=True)
class Pixels:
    """Corners of pixels over a whole image, and the directions that a WCS has for them.

    xy: (n, 2), from 0 to 1 over the image, right and up.
    sight: (n, 3), unit vectors in the model; NaN where the WCS has none.
    pixels: (n, 2, 3), by which a small change of a direction becomes pixels.
    axes: rows are right, up and forward in the middle of the image; mirrored images have none.
    directions: unit vectors in the model (n, 3) of places (n, 2) in the image [pixels].
    """

    xy: Floats
    sight: Floats
    pixels: Floats
    axes: Floats
    shape: tuple[int, int]
    directions: Callable[[Floats], Floats]

    @staticmethod
    def of(wcs: Any, shape: tuple[int, int], to_model: Floats) -> Pixels:
        height, width = shape
        sides = np.array([width, height], dtype=np.float64)

        def directions(places: Floats) -> Floats:
            return directions_of(wcs, to_model, places)

        x, y = (np.linspace(0.0, side, _CORNERS) for side in (width, height))
        places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        sight = directions(places)
        # Steps of half a pixel towards the middle do not leave the image.
        steps = np.where(places > 0.5 * sides, -0.5, 0.5)
        slopes = [
            (directions(places + steps[:, [axis]] * np.eye(2)[axis]) - sight) / steps[:, [axis]]
            for axis in (0, 1)
        ]
        jacobians = np.stack(slopes, axis=-1)
        known = np.isfinite(sight).all(axis=1) & np.isfinite(jacobians).all(axis=(1, 2))
        pixels = np.full((len(places), 2, 3), np.nan)
        pixels[known] = np.linalg.pinv(jacobians[known], rcond=1e-5)

        axes = axes_at(directions, 0.5 * sides)
        return Pixels(places / sides, sight, pixels, axes, shape, directions)


def axes_at(directions: Callable[[Floats], Floats], place: Floats) -> Floats:
    """Right, up and forward at a place in an image [pixels]."""
    around = directions(place + 0.5 * np.array([[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]]))
    if not np.isfinite(around).all():
        raise SceneError("`wcs` has no direction in the middle of the image: expected one")
    forward, right, up = around[0], around[2] - around[1], around[4] - around[3]
    if np.dot(np.cross(forward, up), right) <= 0:
        raise SceneError(
            "`wcs` is mirrored: expected an image as seen by an observer, with east to the "
            "left of north (or solar west to the right); a mirrored one is the mirror image of "
            "that, whose WCS has the other sign of CDELT1"
        )
    up = up - np.dot(up, forward) * forward
    up /= np.linalg.norm(up)
    return np.stack([np.cross(forward, up), up, forward])


@dataclass(frozen=True)
class Fit:
    """A camera of an image plane: axes in rows, half extents, the largest deviation [pixels].

    pointing: where it is, as fractions of the image.
    """

    plane: Plane
    axes: Floats
    half: Floats
    pointing: Floats
    off: float


def fit(plane: Plane, pixels: Pixels, pointing: Floats) -> Fit:
    """The camera with the smallest sum of squared distances, by Gauss and Newton."""
    known = np.isfinite(pixels.pixels).all(axis=(1, 2))
    centred = 2 * (pixels.xy[known] - pointing)
    seen, to_pixels = pixels.sight[known], pixels.pixels[known]

    def distances(axes: Floats, half: Floats) -> Floats:
        sight = plane.sight(*(centred * half).T) @ axes
        return np.einsum("nij,nj->ni", to_pixels, sight - seen)

    height, width = pixels.shape
    is_central = pointing is MIDDLE
    axes = pixels.axes if is_central else axes_at(pixels.directions, pointing * [width, height])
    middle = np.argmin(np.abs(centred).sum(axis=1))
    # No part of the image is farther from the pointing than the widest image with it in the middle.
    widest = np.array(plane.widest) / np.abs(2 * np.stack([pointing, 1 - pointing])).max(axis=0)
    # Half a pixel on the plane is half the angle of a pixel in the middle.
    right, up = (1 / np.linalg.norm(row) for row in to_pixels[middle])
    half = 0.5 * np.array([right * width, up * height])
    half = np.minimum(np.full(2, half.mean()) if plane.is_disc else half, widest)
    tiny = 1e-6
    for _ in range(12):
        start = distances(axes, half)
        changes = [_turned(axes, tiny * vector) for vector in np.eye(3)]
        columns = [distances(turned, half) - start for turned in changes]
        scales = [np.ones(2)] if plane.is_disc else list(np.eye(2))
        columns += [distances(axes, half * (1 + tiny * scale)) - start for scale in scales]
        slopes = np.stack([column.ravel() for column in columns], axis=1) / tiny
        step = np.linalg.lstsq(slopes, -start.ravel(), rcond=None)[0]
        axes = _turned(axes, step[:3])
        half = np.minimum(half * (1 + np.clip(step[3:], -0.5, 0.5)), widest)
        if np.abs(step).max() < 1e-15:
            break
    off = np.linalg.norm(distances(axes, half), axis=1).max()
    if not known.all() and not plane.is_disc:
        off = np.inf
    return Fit(plane, axes, half, pointing, float(off))


def _turned(axes: Floats, by: Any) -> Floats:
    """Axes turned about themselves by a small vector [rad]."""
    angle = float(np.linalg.norm(by))
    x, y, z = by
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # Rodrigues' formula.
    turn = np.eye(3) + np.sinc(angle / np.pi) * cross
    turn += 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * cross @ cross
    return turn @ axes
