"""Pixel means of line integrals by brute force, for tests: lines of sight and chords made by hand."""

import math

import numpy as np
from scipy.special import erf

import emitree


def places(shape, panels, is_disc):
    """Places (h, w, n) of lines in the image, from -1 to 1 along x and y, and weights (h, w, n).

    Each pixel has (4 panels)^2 lines: Gauss's rule with 4 nodes in each panel along both axes. Of a
    disc, those along x are in the part of the pixel that is inside at each y.
    """
    node, weight = np.polynomial.legendre.leggauss(4)
    place = ((np.arange(panels)[:, None] + 0.5 + 0.5 * node) / panels).ravel()
    weight = np.tile(weight, panels)
    height, width = shape
    y = ((np.arange(height)[:, None] + place) / height * 2 - 1)[:, None, :, None]
    left = (np.arange(width) / width * 2 - 1)[:, None, None]
    right, left = np.broadcast_arrays(left + 2 / width, left, y)[:2]
    if is_disc:
        half = np.sqrt(1 - y**2)
        left, right = np.maximum(left, -half), np.minimum(right, half)
    length = np.maximum(right - left, 0.0)
    x = left + length * place
    weights = length * (weight[:, None] * weight)
    count = len(weight) ** 2
    return [
        np.broadcast_to(of, weights.shape).reshape(height, width, count) for of in (x, y, weights)
    ]


def lines(camera, shape, panels):
    """The lines of a camera: its position, directions (h, w, n, 3) and weights (h, w, n).

    The weights are solid angles over that of the part of the pixel in the image; NaN without one.
    """
    origin, target = np.array(camera.position, float), np.array(camera.target, float)
    forward = (target - origin) / np.linalg.norm(target - origin)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    x, y, weights = places(shape, panels, isinstance(camera, emitree.Fisheye))
    if isinstance(camera, emitree.Perspective):
        half_x, half_y = np.tan(np.radians(np.array(camera.field_of_view) / 2))
        across, height, ahead = x * half_x, y * half_y, np.ones_like(x)
        density = (across**2 + height**2 + 1) ** -1.5
    else:
        half = np.radians(camera.field_of_view / 2)
        if not isinstance(camera, emitree.Fisheye):
            azimuth, angle = np.pi * (x + 1), half * (y + 1) / 2
            density = np.sin(angle)
        elif camera.mapping in (None, "equidistant"):
            azimuth, angle = np.arctan2(y, x), half * np.hypot(x, y)
            density = np.sinc(angle / np.pi)
        else:
            azimuth, density = np.arctan2(y, x), 1.0
            angle = 2 * np.arcsin(np.sin(half / 2) * np.minimum(np.hypot(x, y), 1.0))
        across, height = np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth)
        ahead = np.cos(angle)
    direction = across[..., None] * right + height[..., None] * up + ahead[..., None] * forward
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    weights = weights * density
    with np.errstate(invalid="ignore"):
        weights /= weights.sum(axis=2, keepdims=True)
    return origin, direction, weights


def means(camera, shape, functions, panels=20):
    """The means (functions, pixels) of integrals along lines, and the largest error (functions, 1)."""
    coarse, fine = (
        np.array([(of(origin, direction) * weights).sum(axis=2).ravel() for of in functions])
        for origin, direction, weights in (
            lines(camera, shape, n) for n in (panels * 2 // 3, panels)
        )
    )
    return fine, np.nanmax(abs(fine - coarse), axis=1, keepdims=True)


def in_box(lower, upper):
    """The lengths of lines in a box."""

    def length(origin, direction):
        with np.errstate(divide="ignore"):
            ends = [(lower - origin) / direction, (upper - origin) / direction]
        start = np.maximum(np.minimum(*ends).max(axis=-1), 0.0)
        return np.maximum(np.maximum(*ends).min(axis=-1) - start, 0.0)

    return length


def in_ring(lower, upper):
    """The lengths of lines in a ring: all crossings are sorted, and the middles between them tested."""

    def length(origin, direction):
        a = (direction[..., :2] ** 2).sum(axis=-1)
        b = direction[..., :2] @ origin[:2]
        with np.errstate(invalid="ignore", divide="ignore"):
            crossings = [(z - origin[2]) / direction[..., 2] for z in (lower[1], upper[1])]
            for radius in (lower[0], upper[0]):
                root = np.sqrt(b * b - a * (origin[:2] @ origin[:2] - radius**2))
                crossings += [(-b - root) / a, (-b + root) / a]
        t = np.stack([*crossings, np.zeros_like(a)], axis=-1)
        t = np.sort(np.where(np.isfinite(t) & (t > 0), t, 0.0), axis=-1)
        middle = origin + 0.5 * (t[..., 1:] + t[..., :-1])[..., None] * direction[..., None, :]
        r, z = np.hypot(middle[..., 0], middle[..., 1]), middle[..., 2]
        inside = (lower[0] < r) & (r < upper[0]) & (lower[1] < z) & (z < upper[1])
        return (np.diff(t, axis=-1) * inside).sum(axis=-1)

    return length


def in_ball(center, radius):
    """The lengths of lines in a ball."""

    def length(origin, direction):
        middle = direction @ (center - origin)
        square = ((center - origin) ** 2).sum() - middle**2
        half = np.sqrt(np.maximum(radius**2 - square, 0.0))
        return np.maximum(middle + half, 0.0) - np.maximum(middle - half, 0.0)

    return length


def of_gaussian(center, width, cutoff):
    """Integrals of exp(-distance^2 / (2 width^2)) within `cutoff` widths: an error function."""

    def integral(origin, direction):
        middle = direction @ (center - origin)
        square = ((center - origin) ** 2).sum() - middle**2
        half = np.sqrt(np.maximum((cutoff * width) ** 2 - square, 0.0))
        ends = [
            erf((np.maximum(middle + side * half, 0.0) - middle) / (width * math.sqrt(2)))
            for side in (-1, 1)
        ]
        peak = np.exp(-square / (2 * width**2)) * width * math.sqrt(math.pi / 2)
        return peak * (ends[1] - ends[0])

    return integral


def along(rate, near, far, panels):
    """Integrals of an emission along lines, by Gauss's rule with 4 nodes in each panel."""
    node, weight = np.polynomial.legendre.leggauss(4)
    half = 0.5 * (far - near) / panels
    distances = (near + half * (2 * np.arange(panels)[:, None] + 1 + node)).ravel()

    def integral(origin, direction):
        found = np.zeros(direction.shape[:-1])
        flat = direction.reshape(-1, 3)
        for distance, part in zip(distances, np.tile(half * weight, panels), strict=True):
            rates = rate(origin + distance * flat, -flat)
            found += part * rates.reshape(found.shape)
        return found

    return integral
