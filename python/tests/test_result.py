"""What a rendering gives: files, coordinates, plots and a face in notebooks."""

import numpy as np
import pytest
from models import peak, spectral

import emitree

CAMERA = emitree.Equirectangular(
    position=(3, 0, 0), target=(0, 0, 0), field_of_view=(40, 20), near=0, far=6, length_unit="km"
)


def glow(position, direction):
    return np.exp(-(position**2).sum(axis=1)) * (2 + position[:, 1])


@pytest.fixture(scope="module")
def rendering():
    return emitree.render(glow, CAMERA, (10, 20), unit="ph cm-3 s-1 sr-1")


@pytest.fixture(scope="module")
def cube():
    energy = {"min": 1, "max": 3, "bins": 2, "unit": "keV"}
    return emitree.render(spectral, emitree.Canonical(), (4, 6), energy=energy)


@pytest.fixture(scope="module")
def sky():
    return emitree.render("exp(-r^2)", emitree.Healpix(position=(1, 0, 0), far=9), 4)


def test_the_report_has_the_keys_of_the_command(rendering):
    report = rendering.report
    assert report["evaluations"] == rendering.evaluations > 0
    assert report["converged"] is rendering.converged is True
    assert report["estimated_error"] == rendering.estimated_error < report["tolerance"] == 0.01
    assert report["image"]["quantity"] == "radiance" and report["image"]["unit"] == rendering.unit
    assert report["image"]["max"] == rendering.image.max()
    assert report["seconds"]["total"] >= report["seconds"]["emission"] > 0
    assert report["energy"] is None and report["energies"] is None and not report["overrides"]
    assert report["version"] == emitree.__version__
    assert 'type = "equirectangular"' in rendering.scene


def test_the_report_of_a_cube_has_its_bins(cube):
    bins = {"min": 1.0, "max": 3.0, "unit": "keV", "bins": 2, "scale": "linear"}
    assert cube.report["energy"] == bins and cube.report["energies"] > 0


def test_arrays_are_made_once(rendering):
    assert rendering.image is rendering.image and rendering.error is rendering.error


def test_irradiances_are_radiances_times_solid_angles(rendering):
    options = {"unit": "ph cm-3 s-1 sr-1", "quantity": "irradiance"}
    other = emitree.render(glow, CAMERA, (10, 20), **options)
    assert other.unit == "ph cm-2 s-1"
    latitude = np.radians(np.linspace(-10, 10, 11))
    solid_angle = np.diff(np.sin(latitude))[:, None] * np.radians(2.0)
    np.testing.assert_allclose(other.image, rendering.image * solid_angle, rtol=1e-9)


def test_fits(rendering, cube, sky, tmp_path):
    fits = pytest.importorskip("astropy.io.fits")
    rendering.to_fits(tmp_path / "image.fits")
    with pytest.raises(FileExistsError):
        rendering.to_fits(tmp_path / "image.fits")
    rendering.to_fits(tmp_path / "image.fits", overwrite=True)
    with fits.open(tmp_path / "image.fits", checksum=True) as file:
        assert np.array_equal(file[0].data, rendering.image)
        assert np.array_equal(file["ERROR"].data, rendering.error)
        assert file[0].header["BUNIT"] == rendering.unit
        assert file[0].header["NEVAL"] == rendering.evaluations
    assert np.array_equal(cube.to_fits()[0].data, cube.image)
    table = sky.to_fits()[1]
    assert table.header["NSIDE"] == 4 and len(table.data) == 12 * 4 * 4


def history(header):
    return "\n".join(str(line) for line in header["HISTORY"])


def test_fits_names_the_function(rendering):
    pytest.importorskip("astropy")
    header = rendering.to_fits()[0].header
    assert 'function = "test_result.glow"' in history(header)
    assert "expression" not in history(header)
    assert (header["SCENE"], header["BASELEVL"]) == ("emitree", rendering.report["base_level"])
    other = emitree.render(peak, emitree.Canonical(), (2, 2), method="paper")
    paper = other.to_fits()[0].header
    tree = other.tree
    assert (paper["ORDER"], paper["THRESHLD"]) == (tree["order"], tree["threshold"])
    assert "models.peak" in history(paper)


def test_fits_contains_the_changes(tmp_path):
    pytest.importorskip("astropy")
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'emission.expression = "x"\nprojection.type = "canonical"\n'
        "image = { width = 4, height = 4 }\n"
    )
    changed = emitree.render(scene, changes={"emission.expression": "2 * x"}, tolerance=0.1)
    told = history(changed.to_fits()[0].header)
    assert '# changed: emission.expression = "2 * x"' in told
    assert "# changed: render.tolerance = 0.1" in told and told in changed.scene.strip()


def test_a_scene_of_a_function_is_not_rendered_without_it(tmp_path, rendering):
    scene = tmp_path / "scene.toml"
    scene.write_text(rendering.scene)
    with pytest.raises(emitree.EmissionError, match=r"`test_result\.glow`, a function in Python"):
        emitree.render(scene)


def test_coordinates_are_those_of_the_camera(rendering, sky):
    pytest.importorskip("astropy")
    x, y = rendering.wcs.wcs_pix2world([[0, 0], [19, 9]], 0).T
    np.testing.assert_allclose((x + 180) % 360 - 180, [-19, 19], atol=1e-9)
    np.testing.assert_allclose(y, [-9, 9], atol=1e-9)
    assert sky.wcs is None


def test_xarray(rendering, cube, sky):
    pytest.importorskip("xarray")
    data = rendering.to_xarray()
    assert data.image.dims == ("y", "x") and data.image.attrs["units"] == rendering.unit
    np.testing.assert_allclose(data.x, np.arange(-19, 20, 2))
    assert float(data.image.sel(x=0.5, y=0.5, method="nearest")) == rendering.image[5, 10]
    assert cube.to_xarray().image.dims == ("energy", "y", "x")
    np.testing.assert_allclose(cube.to_xarray().energy, [1.5, 2.5])
    assert sky.to_xarray().image.dims == ("face_row", "column")


def test_only_linear_axes_are_angles():
    looking = {"position": (3, 0, 0), "target": (0, 0, 0), "near": 0, "far": 6}
    pinhole = emitree.Perspective(field_of_view=(90, 60), **looking)
    x, y = emitree.render("1", pinhole, (4, 4))._found.axes()
    assert x[0] == "x on the image plane (TAN)" and y[0] == "y on the image plane (TAN)"
    # tan 45 degrees = 1 at the edge, in degrees.
    np.testing.assert_allclose(x[2][-1] + 0.5 * np.diff(x[2])[0], np.degrees(1.0))
    disc = emitree.Fisheye(field_of_view=90, **looking)
    assert emitree.render("1", disc, (4, 4))._found.axes()[0][0] == "x on the image plane (ARC)"


def test_plots_have_units_and_point_up(rendering, cube, sky):
    plt = pytest.importorskip("matplotlib.pyplot")
    ax = rendering.plot(cmap="magma")
    (shown,) = ax.images
    assert shown.origin == "lower" and np.array_equal(shown.get_array(), rendering.image)
    np.testing.assert_allclose(shown.get_extent(), (-20, 20, -10, 10))
    assert ax.get_xlabel() == "longitude about the pointing [deg]"
    assert shown.colorbar.ax.get_ylabel() == "radiance [ph cm-2 s-1 sr-1]"
    figure, axes = plt.subplots(1, 2)
    assert cube.plot(axes[0]) is axes[0]
    assert np.array_equal(axes[0].images[0].get_array(), cube.flat_image)
    cube.plot(axes[1], bin=1)
    assert np.array_equal(axes[1].images[0].get_array(), cube.image[1])
    shown = sky.plot().images[0].get_array()
    assert shown.shape == (400, 800) and shown.mask[0, 0] and not shown.mask[200, 400]
    figure.canvas.draw()
    plt.close("all")


def test_a_face_in_notebooks(rendering, cube, sky):
    for each in (rendering, cube, sky):
        assert each._repr_png_().startswith(b"\x89PNG\r\n")
        assert "<img " in each._repr_html_() and "evaluations" in each._repr_html_()
    assert repr(rendering).startswith("<emitree.Rendering 10 x 20 in ph cm-2 s-1 sr-1: ")
    fixed = emitree.render(peak, emitree.Canonical(), (2, 2), method="los", steps=8)
    assert fixed.error is None and fixed.estimated_error is None
    assert "not estimated" in fixed._repr_html_() and "error" not in repr(fixed)
