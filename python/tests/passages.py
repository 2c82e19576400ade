"""Random exposures by seed, with images by an independent quadrature whose error is known.

Gaussian blobs move, decay and oscillate while a camera is at rest, moves straight, or flies past on a
curve and turns. The integral of a Gaussian along a line of sight is a difference of erf; pixels and
times are integrated by the rule of Gauss, with two numbers of nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import erf

import emitree

#: Pixels along an edge.
SIDE = 16
#: From the camera to the middle of the blobs.
AHEAD = np.array([0.0, 0.0, 6.0])


@dataclass(frozen=True)
class Blob:
    """exp(-|r - c - v t|^2 / (2 s^2)) times a brightness that changes with time."""

    centre: np.ndarray
    velocity: np.ndarray
    sigma: float
    decay: float
    frequency: float

    def brightness(self, time):
        return np.exp(-self.decay * time) * (1 + 0.8 * np.sin(self.frequency * time))

    def rates(self, position, time):
        apart = position - self.centre - time[:, np.newaxis] * self.velocity
        return self.brightness(time) * np.exp(-0.5 * (apart**2).sum(axis=1) / self.sigma**2)

    def along(self, origin, direction, far, time):
        """Its integrals along lines (n, 3), (n, 3) from 0 to `far`, at times (n,)."""
        apart = origin - self.centre - time[:, np.newaxis] * self.velocity
        middle = -(apart * direction).sum(axis=1)
        across = (apart**2).sum(axis=1) - middle**2
        scale = np.sqrt(2) * self.sigma
        part = erf((far - middle) / scale) + erf(middle / scale)
        found = np.sqrt(np.pi / 2) * self.sigma * np.exp(-0.5 * across / self.sigma**2) * part
        return self.brightness(time) * found


@dataclass(frozen=True)
class Passage:
    """A random exposure: an emission, a camera and how it moves."""

    blobs: tuple[Blob, ...]
    camera: Any
    exposure: emitree.Exposure
    #: position(time (n,)) and target(time (n,)) of the camera, (n, 3).
    position: Any
    target: Any

    def emission(self, position, direction, time):
        return np.sum([blob.rates(position, time) for blob in self.blobs], axis=0)

    def image(self, nodes_of_pixels=4, nodes_of_times=64):
        """The cube (bins, height, width) by Gauss rules of so many nodes."""
        edges = np.linspace(*self.exposure.range_s, self.exposure.bins + 1)
        return np.stack(
            [
                self._mean(low, high, nodes_of_pixels, nodes_of_times)
                for low, high in pairwise(edges)
            ]
        )

    def at(self, time, nodes_of_pixels=4):
        """The image (height, width) at a time."""
        return self._mean(time, time, nodes_of_pixels, 1)

    def _mean(self, low, high, nodes_of_pixels, nodes_of_times):
        places, weights = np.polynomial.legendre.leggauss(nodes_of_pixels)
        inside = (np.arange(SIDE)[:, np.newaxis] + 0.5 + 0.5 * places).ravel() / SIDE
        of_place = np.tile(0.5 * weights, SIDE)
        x, y = (of.ravel() for of in np.meshgrid(2 * inside - 1, 2 * inside - 1))
        weight = np.outer(of_place, of_place)
        found = np.zeros((SIDE, SIDE))
        nodes, of_time = np.polynomial.legendre.leggauss(nodes_of_times)
        for node, share in zip(nodes, 0.5 * of_time, strict=True):
            time = 0.5 * (low + high) + 0.5 * (high - low) * node
            origin, direction, solid = self._lines(time, x, y)
            times = np.full(len(origin), time)
            lines = np.sum(
                [blob.along(origin, direction, self.camera.far, times) for blob in self.blobs],
                axis=0,
            )
            solid = solid.reshape(weight.shape) * weight
            values = lines.reshape(weight.shape) * solid
            found += share * _blocks(values) / _blocks(solid)
        return found

    def _lines(self, time, x, y):
        position, target = (of(np.array([time]))[0] for of in (self.position, self.target))
        forward = (target - position) / np.linalg.norm(target - position)
        right = np.cross(forward, self.camera.up)
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        if isinstance(self.camera, emitree.Orthographic):
            half = 0.5 * np.array(self.camera.extent)
            origin = position + np.outer(half[0] * x, right) + np.outer(half[1] * y, up)
            return origin, np.broadcast_to(forward, origin.shape), np.ones(len(x))
        half = np.tan(np.radians(0.5 * np.array(self.camera.field_of_view)))
        direction = forward + np.outer(half[0] * x, right) + np.outer(half[1] * y, up)
        length = np.linalg.norm(direction, axis=1)
        origin = np.broadcast_to(position, direction.shape)
        # The solid angle of a piece of the image plane falls as the cube of the distance.
        return origin, direction / length[:, np.newaxis], length**-3.0


def _blocks(values):
    size = len(values) // SIDE
    return values.reshape(SIDE, size, SIDE, size).sum(axis=(1, 3))


def passage(seed):
    """The exposure of a seed."""
    rng = np.random.default_rng([20261126, seed])
    stop = rng.uniform(1, 20)
    moves = ("still", "straight", "curve")[seed % 3]
    blobs = tuple(
        Blob(
            centre=rng.uniform(-1.5, 1.5, 3),
            velocity=rng.uniform(-1.5, 1.5, 3) / stop,
            sigma=float(rng.uniform(0.25, 0.8)),
            decay=float(rng.uniform(0, 2) / stop),
            frequency=float(rng.uniform(0, 6) / stop),
        )
        for _ in range(rng.integers(1, 4))
    )
    bins = int(rng.choice([1, 1, 4]))
    start = rng.normal(0, 0.3, 3) - AHEAD
    shift = rng.uniform(-1.5, 1.5, 3) * [1, 1, 0.3]
    up = (0, 1, 0)
    if seed % 2 and moves != "curve":
        camera = emitree.Orthographic(
            position=start, target=start + AHEAD, up=up, extent=(6, 6), far=12.0
        )
    else:
        camera = emitree.Perspective(
            position=start, target=start + AHEAD, up=up, field_of_view=(50, 50), far=12.0
        )

    def straight(time):
        share = 0.0 if moves == "still" else 1.0
        return start + np.outer(share * time / stop, shift)

    if moves == "still":
        exposure = emitree.Exposure(0, stop, bins=bins)
        return Passage(blobs, camera, exposure, straight, lambda time: straight(time) + AHEAD)
    if moves == "straight":
        exposure = emitree.Exposure(0, stop, bins=bins, velocity=shift / stop)
        return Passage(blobs, camera, exposure, straight, lambda time: straight(time) + AHEAD)
    angle, aim = rng.uniform(0.2, 0.8), rng.uniform(-0.5, 0.5, 3)

    def position(time):
        turned = angle * time / stop
        path = [6 * np.sin(turned), 0.5 * turned, -6 * np.cos(turned)]
        return np.stack(path, axis=-1) + straight(time) * 0.1

    def target(time):
        return np.outer(time / stop, aim)

    def observer(time):
        at = np.array([time])
        return position(at)[0], target(at)[0]

    exposure = emitree.Exposure(0, stop, bins=bins, observer=observer)
    return Passage(blobs, camera, exposure, position, target)
