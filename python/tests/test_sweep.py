"""Sweeps: many images, each from the plan of a neighbour."""

from dataclasses import replace

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


def evaluations_alone(model, name, values, **options):
    """The evaluations of the images of a sweep, each rendered in full."""
    renderings = [emitree.render(model(**{name: v}), CAMERA, SHAPE, **options) for v in values]
    return sum(rendering.evaluations for rendering in renderings)


def largest_error(sweep, model, name, values, **options):
    """The largest error of an image, relative to its largest pixel."""
    errors = []
    for image, value in zip(sweep.images, values, strict=True):
        finer = emitree.render(model(**{name: value}), CAMERA, SHAPE, tolerance=1e-4, **options)
        errors.append(abs(image - finer.image).max() / finer.image.max())
    return max(errors)


def torus_of(radius=1.5, width=0.3, height=40.0, tilt=0.3):
    return torus(radius, width, height, tilt)


SPHERE = emitree.Sphere(center=(0, 0, 0), radius=1)


@pytest.mark.parametrize(
    ("name", "values", "options", "most"),
    [
        ("tilt", np.linspace(0.25, 0.35, 11), {}, 1 / 3),
        ("radius", np.linspace(1.4, 1.6, 11), {}, 1 / 3),
        ("height", np.linspace(10, 50, 11), {}, 1 / 5),
        ("tilt", [0.3, 0.33, 0.36], {}, 1 / 2),
        # One plan does not serve all of these.
        ("radius", np.linspace(1, 2, 11), {}, 0.55),
        ("width", np.linspace(0.25, 0.35, 11), {}, 0.6),
    ],
)
def test_images_that_a_plan_serves_take_fewer_evaluations(name, values, options, most):
    calls = []
    sweep = emitree.sweep(counted(torus_of, calls), {name: values}, CAMERA, SHAPE, **options)
    assert sweep.converged and sweep.evaluations == sum(calls)
    assert sweep.evaluations < most * evaluations_alone(torus_of, name, values)
    assert largest_error(sweep, torus_of, name, values) < 0.01


def test_a_planet_in_view():
    values, options = np.linspace(1.4, 1.6, 11), {"occulters": [SPHERE], "tolerance": 0.03}
    sweep = emitree.sweep(torus_of, {"radius": values}, CAMERA, (8, 8), **options)
    some = [emitree.render(torus_of(value), CAMERA, (8, 8), **options) for value in values[::5]]
    assert sweep.converged
    # The eleven images take fewer evaluations than five of them in full.
    assert sweep.evaluations < 5 / 3 * sum(rendering.evaluations for rendering in some)
    for image, value in zip(sweep.images[::12], values[::12], strict=True):
        finer = emitree.render(
            torus_of(value), CAMERA, (8, 8), **(options | {"tolerance": 3e-3})
        ).image
        assert abs(image - finer).max() < 0.01 * finer.max()


def spiral(phase):
    """A torus with spiral arms: no sum of a few products, so that no plan serves another."""

    def rate(position, direction):
        x, y, z = position.T
        ring = np.hypot(x, y)
        arms = 1.1 + np.cos(2 * np.arctan2(y, x) - 6 * ring + phase)
        return np.exp(-((ring - 1.5) ** 2 + z**2) / 0.1) * arms

    return rate


def test_images_of_no_use_for_others_cost_a_tenth_more_at_most():
    phases = np.linspace(0, 1, 4)
    sweep = emitree.sweep(spiral, {"phase": phases}, CAMERA, SHAPE, tolerance=0.05)
    alone = [emitree.render(spiral(phase), CAMERA, SHAPE, tolerance=0.05) for phase in phases]
    for rendering, other in zip(sweep.renderings, alone, strict=True):
        np.testing.assert_array_equal(rendering.image, other.image)
    assert sweep.evaluations <= 1.1 * sum(rendering.evaluations for rendering in alone)
    # Plans that serve a part of their neighbours, of emissions that cost as much as their checks.
    shifts = np.linspace(0.3, 0.5, 11)
    sweep = emitree.sweep(lambda shift: clouds(0.15, shift), {"shift": shifts}, CUBE, SHAPE)
    alone = [emitree.render(clouds(0.15, shift), CUBE, SHAPE) for shift in shifts]
    assert sweep.converged
    assert sweep.evaluations <= 1.1 * sum(rendering.evaluations for rendering in alone)


def test_the_order_of_values_does_not_matter():
    values = np.linspace(1.45, 1.55, 5)
    first = emitree.sweep(torus_of, {"radius": values}, CAMERA, SHAPE)
    mixed = emitree.sweep(torus_of, {"radius": values[[3, 0, 4, 2, 1]]}, CAMERA, SHAPE)
    np.testing.assert_array_equal(mixed.images, first.images[[3, 0, 4, 2, 1]])
    assert mixed.evaluations == first.evaluations


def looking_at(x, field=35.0, position=(6, -4, 5)):
    return emitree.Perspective(
        position=position, target=(x, 0, 0), field_of_view=(field, field), near=2, far=16
    )


@pytest.mark.parametrize(
    ("options", "most"),
    [
        ({"bounds": emitree.Sphere(center=(0, 0, 0), radius=3)}, 0.3),
        ({"occulters": [SPHERE]}, 0.8),
        # The image plane moves with the camera, and all points with it.
        ({}, 1.0),
    ],
)
def test_cameras_of_one_observer(options, most):
    cameras = [looking_at(0.0), looking_at(0.1), looking_at(0.1, 34.0), looking_at(0.2)]
    calls = []
    sweep = emitree.sweep(counted(torus_of, calls), {}, cameras, (16, 16), **options)
    alone = [emitree.render(torus_of(), camera, (16, 16), **options) for camera in cameras]
    assert sweep.renderings.shape == (4,) and sweep.converged
    for rendering, other in zip(sweep.renderings, alone, strict=True):
        np.testing.assert_array_equal(rendering.image, other.image)
    assert sweep.evaluations == sum(calls)
    assert sweep.evaluations <= most * sum(rendering.evaluations for rendering in alone)


def test_positions_of_cameras_may_be_arrays():
    tuples = [looking_at(0.0), looking_at(0.1), looking_at(0.0, position=(6, -3, 5))]
    arrays = [replace(camera, position=np.array(camera.position)) for camera in tuples]
    options = {"bounds": emitree.Sphere(center=(0, 0, 0), radius=3)}
    expected = emitree.sweep(torus_of, {}, tuples, (16, 16), **options)
    found = emitree.sweep(torus_of, {}, arrays, (16, 16), **options)
    np.testing.assert_array_equal(found.images, expected.images)
    # The first two have one observer, whose points are evaluated once.
    assert found.evaluations == expected.evaluations
    assert found.evaluations < sum(rendering.evaluations for rendering in found.renderings)


def test_parameters_and_cameras():
    cameras, tilts = [looking_at(0.0), looking_at(0.0, position=(6, -3, 5))], [0.3, 0.32, 0.31]
    sweep = emitree.sweep(torus_of, {"tilt": tilts}, cameras, SHAPE)
    assert sweep.images.shape == (3, 2, *SHAPE)
    for column, camera in enumerate(cameras):
        single = emitree.sweep(torus_of, {"tilt": tilts}, camera, SHAPE)
        np.testing.assert_array_equal(sweep.images[:, column], single.images)
    with pytest.raises(ValueError, match="`camera` is an empty sequence: expected a camera"):
        emitree.sweep(torus_of, {"tilt": tilts}, [], SHAPE)


def test_workers_and_quantities():
    from concurrent.futures import ThreadPoolExecutor

    values = {"radius": [1.48, 1.5, 1.52]}
    alone = emitree.sweep(torus_of, values, CAMERA, SHAPE)
    with ThreadPoolExecutor(2) as executor:
        shared = emitree.sweep(torus_of, values, CAMERA, SHAPE, executor=executor)
    np.testing.assert_array_equal(shared.images, alone.images)
    assert shared.evaluations == alone.evaluations

    units = pytest.importorskip("astropy.units")
    camera = emitree.Canonical(length_unit="km")

    def of_width(width):
        def rate(position, direction):
            size = ((position.to_value("km") - 0.5) ** 2).sum(axis=1)
            return np.exp(-size / width**2) * units.Unit("cm-3 s-1 sr-1")

        return rate

    options = {"unit": "cm-3 s-1 sr-1", "quantities": True}
    sweep = emitree.sweep(of_width, {"width": [0.2, 0.21]}, camera, (8, 8), **options)
    assert sweep.converged
    for image, width in zip(sweep.images, (0.2, 0.21), strict=True):
        finer = emitree.render(of_width(width), camera, (8, 8), tolerance=1e-4, **options).image
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
