"""The camera of `zodi` ends its lines on a sphere, and its exact image is that of ZodiPy's dust."""

import numpy as np

from . import harness, zodi, zodi_exact
from .contestants import CONTESTANTS
from .scene import relative_error


def test_lines_end_on_the_sphere():
    lines = zodi.CAMERA.lines((5, 7), 1)[:, :, 0, 0]
    ends = np.array(zodi.EARTH) + zodi.CAMERA.lengths(lines)[..., None] * lines
    np.testing.assert_allclose(np.linalg.norm(ends, axis=-1), zodi.JUPITER, rtol=1e-14)


def test_the_earth_is_where_zodipy_has_it():
    from astropy.time import Time
    from zodipy.bodies import get_earthpos_inst

    earth = get_earthpos_inst(Time(zodi.TIME), "builtin")
    np.testing.assert_allclose(earth, zodi.EARTH, atol=1e-8)


def test_lines_agree_with_many_steps_of_the_rate():
    lines = zodi.CAMERA.lines((3, 4), 1).reshape(-1, 3)
    length = zodi.CAMERA.lengths(lines)[:, None]
    s = length * (np.arange(20_000) + 0.5) / 20_000
    places = (start + s * lines[:, [axis]] for axis, start in enumerate(zodi.EARTH))
    many = length[:, 0] * zodi.rate(*places).mean(axis=1)
    way = {name: count for name, count in zodi_exact.WAYS["exact"].items() if name != "order"}
    np.testing.assert_allclose(zodi_exact.radiances(lines, **way), many, rtol=1e-6)


def test_the_exact_image_is_that_of_zodipy_with_many_points():
    exact, disagreement = zodi.SCENE.verified_image()
    assert disagreement < zodi.SCENE.agreement
    setting = {"points": 200, "across": 2}
    found = harness.measure(CONTESTANTS["ZodiPy"], zodi.SCENE, exact, setting)
    assert found.found, found.note
    # Its table of black bodies is off by 2e-4 where most of the light comes from.
    assert found.error < 1e-3


def test_emitree_gives_the_same_image():
    exact, _ = zodi.SCENE.verified_image()
    ours = CONTESTANTS["emitree"]
    problem = harness.Problem.of(zodi.SCENE, exact)
    found = ours.run(problem, tolerance=0.05)
    assert relative_error(found.image, exact) < 0.05
