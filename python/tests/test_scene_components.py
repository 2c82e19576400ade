"""Scene files with several expressions."""

import math

import numpy as np
import pytest
from astropy.io import fits

import emitree

SCENE = """
[emission]
expressions = [
    "exp(-a*((x-0.5)^2 + (y-0.5)^2 + (z-0.5)^2))",
    "0.01*exp(-9*a*((x-0.5)^2 + (y-0.5)^2 + (z-0.5)^2))",
    "0*x",
]
components = ["wide", "narrow", "dark"]
constants = { a = 20.0 }
[projection]
type = "canonical"
[image]
width = 32
height = 24
"""


def exact(sharpness, shape):
    """The means over pixels of exp(-sharpness |r - 1/2|^2) along z."""
    root = math.sqrt(sharpness)

    def integral(low, high):
        ends = [math.erf(root * (end - 0.5)) for end in (low, high)]
        return math.sqrt(math.pi) / (2 * root) * (ends[1] - ends[0])

    rows, columns = (np.array([integral(i / n, (i + 1) / n) * n for i in range(n)]) for n in shape)
    return integral(0, 1) * np.outer(rows, columns)


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


def test_each_expression_has_an_image_to_its_own_tolerance(scene):
    found = emitree.render(scene, changes={"render.tolerance": 1e-3})
    assert isinstance(found, emitree.Components)
    assert found.names == ("wide", "narrow", "dark") and found.image.shape == (3, 24, 32)
    for name, expected in (("wide", exact(20, (24, 32))), ("narrow", exact(180, (24, 32)) / 100)):
        difference = abs(found[name].image - expected)
        assert difference.max() <= 1e-3 * expected.max()
        assert (difference <= found[name].error + 1e-14).all()
    assert (found["dark"].image == 0).all() and found.converged
    assert found.evaluations < sum(rendering.evaluations for rendering in found)
    again = emitree.render(scene, changes={"render.tolerance": 1e-3})
    assert again.evaluations == found.evaluations
    # Expressions in a list are the same emission, by calls.
    formulas = [
        emitree.Expression("exp(-a*((x-0.5)^2 + (y-0.5)^2 + (z-0.5)^2))", {"a": 20.0}),
        "0.01*exp(-9*20*((x-0.5)^2 + (y-0.5)^2 + (z-0.5)^2))",
    ]
    listed = emitree.render(formulas, emitree.Canonical(), (24, 32), tolerance=1e-3)
    np.testing.assert_allclose(listed.image, found.image[:2], rtol=1e-9, atol=1e-12)


def test_files_have_a_unit_for_each_component(scene, tmp_path):
    found = emitree.render(scene)
    path = tmp_path / "found.fits"
    found.to_fits(path)
    with fits.open(path, checksum=True) as hdus:
        names = ["WIDE", "NARROW", "DARK"]
        ends = ["", "_ERROR", "_EVALUATIONS"]
        assert [hdu.name for hdu in hdus] == [name + end for end in ends for name in names]
        for name in names:
            np.testing.assert_array_equal(hdus[name].data, found[name.lower()].image)
            np.testing.assert_array_equal(hdus[name + "_ERROR"].data, found[name.lower()].error)
        header = hdus[0].header
        assert header["NEVAL"] == found.evaluations and header["NCOMP"] == 3
        assert header["COMP2"] == "narrow" and header["NEVAL2"] == found[1].evaluations
        assert header["ESTER2"] == found[1].estimated_error
    with pytest.raises(FileExistsError):
        found.to_fits(path)
    found.to_fits(path, overwrite=True)


def test_components_of_a_function_have_files_too():
    def pair(position, direction):
        square = ((position - 0.5) ** 2).sum(axis=1)
        return np.stack([np.exp(-50 * square), np.exp(-30 * square)], axis=1)

    found = emitree.render(pair, emitree.Canonical(), (12, 16))
    hdus = found.to_fits()
    assert [hdu.name for hdu in hdus][:2] == ["COMPONENT_1", "COMPONENT_2"]
    np.testing.assert_array_equal(hdus[1].data, found[1].image)


def test_what_takes_one_rate_is_refused(scene):
    with pytest.raises(emitree.SceneError, match="the scene has several `expressions`"):
        emitree.render(scene, frame=print)
    with pytest.raises(TypeError, match="`executor` is for functions"):
        emitree.render(scene, executor=object())
    with pytest.raises(emitree.SceneError, match=r"`emission.components` has 1 name"):
        emitree.render(scene, changes={"emission.components": ["a"]})
    with pytest.raises(emitree.EmissionError):
        emitree.render(scene, changes={"emission.expressions": ["a", "a", "a/(x-x)"]})
