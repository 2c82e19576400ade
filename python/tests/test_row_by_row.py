"""Images and cubes that are written row by row: the values of a rendering, errors, no half file."""

import numpy as np
import pytest
from astropy.io import fits

import emitree


def glow(position, direction, energy):
    square = ((position - [0.4, 0.5, 0.6]) ** 2).sum(axis=1)
    other = ((position - [0.7, 0.3, 0.4]) ** 2).sum(axis=1)
    return np.exp(-30 * square - energy) + np.exp(-20 * other) / (1 + energy**2)


BINS = emitree.Energies(0.5, 4.0, 5, unit="keV")


@pytest.mark.parametrize("name", ["cube.fits", "cube.fits.gz"])
def test_a_cube_has_the_values_of_a_rendering(tmp_path, name):
    whole = emitree.render(glow, emitree.Canonical(), (24, 32), tolerance=1e-3, energy=BINS)
    options = {"tolerance": 1e-3, "energy": BINS}
    path = tmp_path / name
    report = emitree.render_to_fits(glow, emitree.Canonical(), (24, 32), path, **options)
    assert report["converged"]
    assert report["energies"] == whole.report["energies"]
    assert report["image"]["max"] == pytest.approx(whole.image.max(), rel=1e-12)
    with fits.open(path) as file:
        assert [table.name for table in file] == ["RADIANCE", "ERROR", "ENERGIES"]
        assert file[0].data.shape == (5, 24, 32)
        np.testing.assert_allclose(file[0].data, whole.image, rtol=1e-12)
        np.testing.assert_allclose(file["ERROR"].data, whole.error, rtol=1e-9)
        assert list(file["ENERGIES"].data["E_MIN"]) == pytest.approx(BINS.edges[:-1])
        assert file[0].header["CTYPE3"] == "ENER"


def test_a_large_cube_has_the_means_of_a_small_one(tmp_path):
    small = emitree.render(glow, emitree.Canonical(), (24, 32), tolerance=1e-2, energy=BINS)
    path = tmp_path / "cube.fits"
    report = emitree.render_to_fits(
        glow, emitree.Canonical(), (1000, 800), path, tolerance=1e-2, energy=BINS
    )
    assert report["evaluations"] < 2 * small.evaluations
    assert path.stat().st_size > 2 * 8 * 5 * 1000 * 800
    with fits.open(path) as file:
        mean = file[0].data.mean(axis=(1, 2))
    np.testing.assert_allclose(mean, small.image.mean(axis=(1, 2)), rtol=2e-2)


def test_a_view_with_a_planet_has_the_pixels_of_a_rendering(tmp_path):
    planet = emitree.Sphere(center=(0, 0, 0), radius=1)
    camera = emitree.Perspective(position=(7, 1, 0), target=(0, 0, 0), field_of_view=(30, 24))
    options = {
        "occulters": [planet],
        "tolerance": 1e-3,
        "bounds": emitree.Sphere(center=(0, 0, 0), radius=4),
    }

    def halo(position, direction):
        return np.exp(-np.linalg.norm(position, axis=1))

    whole = emitree.render(halo, camera, (120, 150), **options)
    path = tmp_path / "image.fits"
    report = emitree.render_to_fits(halo, camera, (120, 150), path, **options)
    assert report["converged"]
    assert report["evaluations"] <= whole.evaluations
    image = fits.getdata(path)
    # Both are within the tolerance.
    assert np.abs(image - whole.image).max() < 2e-3 * whole.image.max()
    with pytest.raises(emitree.RenderError, match="divides its view, and it is a cube"):
        emitree.render_to_fits(glow, camera, (12, 15), path, energy=BINS, **options, overwrite=True)


def test_files_that_are_there_stay(tmp_path):
    path = tmp_path / "image.fits"
    path.write_text("mine")
    with pytest.raises(FileExistsError, match=r"image\.fits"):
        emitree.render_to_fits("x", emitree.Canonical(), (8, 8), path)
    assert path.read_text() == "mine"
    report = emitree.render_to_fits("x", emitree.Canonical(), (8, 8), path, overwrite=True)
    assert report["image"]["height"] == 8


def test_a_failure_leaves_no_file(tmp_path):
    def fails(position, direction):
        raise KeyError("mine")

    def ball(position, direction):
        return np.where(np.linalg.norm(position - 0.5, axis=1) < 0.3, 2.0, 0.5)

    path = tmp_path / "image.fits"
    with pytest.raises(KeyError, match="mine"):
        emitree.render_to_fits(fails, emitree.Canonical(), (8, 8), path)
    with pytest.raises(emitree.RenderError, match="low-rank approximation"):
        emitree.render_to_fits(ball, emitree.Canonical(), (8, 8), path)
    with pytest.raises(TypeError, match="unknown option `tolerances`"):
        emitree.render_to_fits("x", emitree.Canonical(), (8, 8), path, tolerances=1)
    with pytest.raises(TypeError, match="unknown option `instrument`"):
        emitree.render_to_fits("x", emitree.Canonical(), (8, 8), path, instrument=None)
    with pytest.raises(TypeError, match="several emissions"):
        emitree.render_to_fits(["x", "y"], emitree.Canonical(), (8, 8), path)
    assert list(tmp_path.iterdir()) == []
