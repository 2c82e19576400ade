"""Sweeps: many images, each from the plan of a neighbour."""

import numpy as np
import pytest
from models import counted, torus

import emitree

CUBE = emitree.Canonical()
CAMERA = emitree.Perspective(
    position=(6, -4, 5), target=(0, 0, 0), field_of_view=(35, 35), near=2, far=16
)
SHAPE = (48, 48)


def clouds(width, shift):
    """Two Gaussians: a sum of two products of functions of x, y and z."""

    def rate(position, direction):
        x, y, z = position.T
        first = np.exp(-((x - 0.4) ** 2 + (y - shift) ** 2 + (z - 0.5) ** 2) / width**2)
        return first + np.exp(-((x - 0.6) ** 2 + (y - 0.5) ** 2 + (z - 0.6) ** 2) / 0.04)

    return rate


def test_all_combinations():
    calls = []
    values = {"width": np.linspace(0.2, 0.22, 3), "shift": [0.4, 0.41]}
    sweep = emitree.sweep(counted(clouds, calls), values, CUBE, (12, 16))
    assert list(sweep.parameters) == ["width", "shift"]
    assert sweep.renderings.shape == (3, 2) and sweep.images.shape == (3, 2, 12, 16)
    assert sweep.evaluations == sum(calls) and sweep.converged
    for i, width in enumerate(values["width"]):
        for j, shift in enumerate(values["shift"]):
            finer = emitree.render(clouds(width, shift), CUBE, (12, 16), tolerance=1e-4).image
            assert abs(sweep.images[i, j] - finer).max() < 0.01 * finer.max()


def test_images_that_a_plan_serves_take_fewer_evaluations():
    values, camera = [0.3, 0.33, 0.36], CAMERA
    sweep = emitree.sweep(lambda tilt: torus(1.5, 0.3, 40, tilt), {"tilt": values}, camera, SHAPE)
    alone = [emitree.render(torus(1.5, 0.3, 40, tilt), camera, SHAPE) for tilt in values]
    assert sweep.converged
    assert sweep.evaluations < 0.75 * sum(rendering.evaluations for rendering in alone)
    for image, tilt in zip(sweep.images, values, strict=True):
        finer = emitree.render(torus(1.5, 0.3, 40, tilt), camera, SHAPE, tolerance=1e-4).image
        assert abs(image - finer).max() < 0.01 * finer.max()


def test_one_value_and_emissions_that_are_no_functions():
    sweep = emitree.sweep(
        lambda a: emitree.Expression("a * exp(-9*x*y)", {"a": a}), {"a": [2]}, CUBE, (4, 4)
    )
    alone = emitree.render("2 * exp(-9*x*y)", CUBE, (4, 4))
    np.testing.assert_array_equal(sweep.images[0], alone.image)
    assert sweep.evaluations == alone.evaluations


def test_images_without_a_plan_are_rendered_in_full():
    def ball(radius):
        return lambda r, d: np.where(np.linalg.norm(r - 0.5, axis=1) < radius, 2.0, 0.5)

    sweep = emitree.sweep(ball, {"radius": [0.3, 0.31]}, CUBE, (32, 32))
    for radius, rendering in zip((0.3, 0.31), sweep.renderings, strict=True):
        alone = emitree.render(ball(radius), CUBE, (32, 32))
        assert rendering.surfaces is not None
        np.testing.assert_array_equal(rendering.image, alone.image)


def test_what_is_wrong_is_named():
    for values, message in [
        ({}, "`parameters` has none: expected values by the names of parameters"),
        ({"width": []}, r"`parameters` has 'width' = \[\]: expected numbers \(values,\)"),
        ({"width": ["a"]}, r"`parameters` has 'width' = \['a'\]: expected numbers"),
        ({"width": [np.nan]}, "expected finite numbers"),
    ]:
        with pytest.raises(ValueError, match=message):
            emitree.sweep(clouds, values, CUBE, (4, 4))
