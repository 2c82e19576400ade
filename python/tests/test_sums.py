"""Sums over regions: `sums` of `render`, and `Rendering.sums`."""

import json
import pickle

import numpy as np
import pytest

import emitree

#: The exponent of `ball`.
STEEPNESS = 60


def ball(position, direction):
    return np.exp(-STEEPNESS * ((position - 0.5) ** 2).sum(axis=1))


def exact_image(pixels):
    """The image of `ball`, by Gauss-Legendre quadrature of each factor, exact to rounding."""
    nodes, weights = np.polynomial.legendre.leggauss(20)

    def means(cells):
        at = (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes) / cells
        return 0.5 * np.exp(-STEEPNESS * (at - 0.5) ** 2) @ weights

    along = means(pixels)
    return np.outer(along, along) * means(16).mean()


def test_sums_are_within_their_errors_and_tolerances():
    exact = exact_image(32)
    mask = np.zeros((32, 32))
    mask[8:20, 4:18] = 1
    sums = {
        "disc": {"circle": {"center": (16, 16), "radius": 9}, "tolerance": 1e-4},
        "mask": mask,
        "mean": {"mask": mask, "of": "mean", "tolerance": 1e-4},
    }
    found = emitree.render(ball, emitree.Canonical(), (32, 32), sums=sums, tolerance=1)
    assert found.converged and list(found.sums) == ["disc", "mask", "mean"]
    for name, value in {"mask": (exact * mask).sum(), "mean": exact[mask > 0].mean()}.items():
        error = abs(found.sums[name].value - value)
        assert error <= found.sums[name].error <= found.sums[name].allowed
    disc = found.sums["disc"]
    assert disc.error <= disc.allowed == pytest.approx(1e-4 * disc.value)
    assert disc.of == "sum" and disc.bands.shape == (0, 2)
    # The sum over the mask is that of the image.
    assert found.sums["mask"].value == pytest.approx((found.image * mask).sum())


def test_sums_are_in_reports_files_and_pickles(tmp_path):
    sums = {"on": {"box": {"min": (4, 4), "max": (28, 28)}}}
    found = emitree.render(ball, emitree.Canonical(), (32, 32), sums=sums)
    assert json.loads(json.dumps(found.report))["sums"]["on"]["value"] == found.sums["on"].value
    assert pickle.loads(pickle.dumps(found)).sums["on"].error == found.sums["on"].error
    fits = pytest.importorskip("astropy.io.fits")
    found.to_fits(tmp_path / "ball.fits")
    header = fits.getheader(tmp_path / "ball.fits")
    assert (header["SUM1"], header["SUMVAL1"]) == ("on", found.sums["on"].value)
    assert header["SUMERR1"] == found.sums["on"].error


def test_bands_of_a_cube_have_sums_too():
    def glow(position, direction, energy):
        return ball(position, direction) * np.exp(-energy)

    energy = {"min": 0.5, "max": 2.5, "bins": 4, "scale": "linear"}
    sums = {"on": {"box": {"min": (2, 2), "max": (14, 14)}, "tolerance": 2e-3}}
    found = emitree.render(glow, emitree.Canonical(), (16, 16), energy=energy, sums=sums)
    on = found.sums["on"]
    total = exact_image(16)[2:14, 2:14].sum() * (np.exp(-0.5) - np.exp(-2.5))
    assert found.converged and abs(on.value - total) <= on.error <= on.allowed
    assert on.bands.shape == (4, 2)
    assert on.bands[:, 0] @ np.full(4, 0.5) == pytest.approx(on.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sums": {"a": np.ones((3, 3))}}, "3 rows of 3 pixels"),
        ({"sums": {"a": {"circle": {"center": (1, 1)}}}}, "radius"),
        ({"sums": [1]}, "dictionary of regions"),
        ({"sums": {"a": {"of": "mean"}}}, "no region of its own"),
        ({"sums": {"a": np.ones((32, 32))}, "method": "los"}, "method `vol`"),
    ],
)
def test_what_can_not_be_is_refused(options, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(ball, emitree.Canonical(), (32, 32), **options)
