"""Sensitivity matrices of discs: means over the parts of pixels inside of the rim."""

import numpy as np
import pytest
from chords import means, of_gaussian

import emitree

pytest.importorskip("scipy.sparse")

#: Shapes whose pixels the rim crosses in all ways: corners cut off, slivers, one side, two, or all.
SHAPES = [(7, 7), (8, 8), (3, 5), (1, 1), (2, 2), (9, 1), (1, 6), (2, 11)]


def at_the_rim(camera, rng, count):
    """Gaussians about the directions of the rim."""
    origin, target = np.array(camera.position), np.array(camera.target)
    forward = (target - origin) / np.linalg.norm(target - origin)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    azimuth = rng.uniform(0, 2 * np.pi, (count, 1))
    angle = np.radians(camera.field_of_view / 2) * rng.uniform(0.9, 1.05, (count, 1))
    across = np.cos(azimuth) * right + np.sin(azimuth) * np.cross(right, forward)
    away = np.sin(angle) * across + np.cos(angle) * forward
    return origin + away * rng.uniform(1, 4, (count, 1)), rng.choice([0.2, 0.4, 0.8], count)


def check(camera, shape, rng, count, panels=24):
    """Columns of Gaussians at the rim are within tolerances of means by brute force."""
    centers, widths = at_the_rim(camera, rng, count)
    basis = emitree.RadialFunctions(centers, widths)
    functions = [of_gaussian(*one, basis.cutoff) for one in zip(centers, widths, strict=True)]
    truth, uncertainty = means(camera, shape, functions, panels=panels)
    is_outside = np.isnan(truth[0])
    truth = np.where(is_outside, 0.0, truth)
    largest = truth.max(axis=1)
    known = (largest > 1e-6 * largest.max()) & (uncertainty[:, 0] < 2e-3 * largest)
    assert known.sum() > count // 2
    for tolerance in (0.05, 0.01):
        found = emitree.sensitivity(basis, camera, shape, tolerance)
        assert found.converged and (found.in_image == ~is_outside).all()
        error = abs(found.matrix.toarray().T - truth) - uncertainty
        assert (error[known].max(axis=1) <= tolerance * largest[known]).all()


@pytest.mark.parametrize("mapping", ["equidistant", "equal_area"])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_columns_at_the_rim_of_a_disc(shape, mapping):
    rng = np.random.default_rng(7 * shape[0] + shape[1])
    for field_of_view in (25, 120, 230):
        camera = emitree.Fisheye(
            position=(0.2, -3, 0.4),
            target=(0.1, 0, 0.3),
            field_of_view=field_of_view,
            mapping=mapping,
            far=np.inf,
        )
        check(camera, shape, rng, 4)


@pytest.mark.parametrize("shape", [(5, 8), (1, 1), (4, 3)], ids=str)
def test_columns_at_the_ends_of_a_polar_image(shape):
    rng = np.random.default_rng(5)
    for field_of_view in (25, 190, 360):
        camera = emitree.Polar(
            position=(0.2, -3, 0.4), target=(0.1, 0, 0.3), field_of_view=field_of_view, far=np.inf
        )
        check(camera, shape, rng, 3)


@pytest.mark.parametrize("shape", [*SHAPES, (10, 10), (25, 25), (20, 50)], ids=str)
def test_pixels_outside_of_the_disc_are_those_of_render(shape):
    # The rim touches corners of pixels of 10 x 10, at (0.6, 0.8).
    camera = emitree.Fisheye(position=(0, -2, 1), target=(0, 0, 1), field_of_view=100, far=9)
    voxel = emitree.Voxels([[-1, 0, 0]], [[1, 1, 2]])
    found = emitree.sensitivity(voxel, camera, shape, tolerance=0.1)
    rendered = emitree.render("1", camera, shape, tolerance=0.1).image
    assert (np.isnan(found.image([1.0])) == np.isnan(rendered)).all()
    assert (found.in_image == ~np.isnan(rendered).ravel()).all()
    whole = emitree.sensitivity(emitree.Voxels([[-9, -9, -9]], [[9, 9, 9]]), camera, shape, 0.1)
    assert (whole.matrix.toarray()[:, 0] > 0).tolist() == found.in_image.tolist()
