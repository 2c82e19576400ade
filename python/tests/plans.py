"""Plans of all kinds, for the tests of gradients."""

from functools import cache

import numpy as np
from models import spectral, torus

import emitree

CAMERA = emitree.Perspective(
    position=(6, -4, 5), target=(0, 0, 0), field_of_view=(35, 35), near=2, far=16
)


def spiral(position, direction):
    """A torus with spiral arms: no sum of a few products of functions."""
    x, y, z = position.T
    ring = np.hypot(x, y)
    arms = 1.1 + np.cos(2 * np.arctan2(y, x) - 6 * ring)
    return np.exp(-((ring - 1.5) ** 2 + z**2) / 0.1) * arms


def halo(position, direction):
    """A Gaussian about the origin, with a slope."""
    return np.exp(-0.5 * (position**2).sum(axis=1)) * (1 + 0.2 * position[:, 0])


@cache
def plan_of(kind):
    """A plan of a kind."""
    gaussians, cube = torus(1.5, 0.3, 1.0, 0.3), emitree.Canonical()
    if kind == "products":
        return emitree.render(gaussians, CAMERA, (20, 24)).plan
    if kind == "planet":
        sphere = emitree.Sphere(center=(0, 0, 0), radius=1)
        return emitree.render(halo, CAMERA, (8, 8), occulters=[sphere], tolerance=0.1).plan
    if kind == "trees":
        return emitree.render(spiral, CAMERA, (12, 16), tolerance=0.1).plan
    if kind == "cells":
        return emitree.render("exp(-9*(x^2+y^2)) + z", cube, (8, 12), method="paper").plan
    if kind == "lines":
        fisheye = emitree.Fisheye(position=(0, 0, 0), target=(1, 0, 0), field_of_view=120, far=4)
        return emitree.render("exp(-r^2)", fisheye, (8, 8), method="los", lines=2, steps=6).plan
    assert kind == "bins"
    return emitree.render(spectral, cube, (6, 8), energy=emitree.Energies(1, 2, 3)).plan


#: Products, products in charts, image trees, cells, lines with pixels outside of a disc, and bins.
KINDS = ["products", "planet", "trees", "cells", "lines", "bins"]


def random_rates(plan, count=()):
    """Random rates at the points."""
    return np.random.default_rng(3).normal(size=(len(plan), *count))


def random_image(plan):
    """A random image; it has numbers also where the camera has no image."""
    return np.random.default_rng(4).normal(size=plan.shape)


def norm(plan, image):
    """The root of the sum of squares, where there is an image."""
    return np.linalg.norm(np.nan_to_num(image))
