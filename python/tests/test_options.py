"""Options that have no effect or make no sense are errors that name them."""

import time

import numpy as np
import pytest
from models import exact_peak, peak, spectral

import emitree

CUBE = emitree.Canonical()
ENERGY = {"min": 1, "max": 2, "bins": 2}


@pytest.mark.parametrize(("options", "name"), [
    (dict(lines=2), "lines"),
    (dict(steps=8), "steps"),
    (dict(threshold="1%"), "threshold"),
    (dict(order=3), "order"),
    (dict(method="los", base_level=3), "base_level"),
    (dict(method="los", minimize="time"), "minimize"),
    (dict(method="los", seeds=[((0.5, 0.5, 0.5), 0.1)]), "seeds"),
    (dict(method="paper", seeds=[((0.5, 0.5, 0.5), 0.1)]), "seeds"),
    (dict(method="paper", tolerance=0.1), "tolerance"),
    (dict(method="paper", steps=8), "steps"),
])  # fmt: skip
def test_options_that_a_method_does_not_use(options, name):
    method = options.get("method", "vol")
    message = f"`{name}` is given, and method `{method}` does not use it: expected none, or method"
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(peak, CUBE, (4, 4), **options)


@pytest.mark.parametrize("method", ["paper", "los"])
def test_intermediate_images_are_of_vol(method):
    message = f"`frame` or `progressive` is used, and method `{method}` has no intermediate images"
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(peak, CUBE, (4, 4), method=method, frame=print)
    with pytest.raises(emitree.SceneError, match=message):
        list(emitree.progressive(peak, CUBE, (4, 4), method=method))


@pytest.mark.parametrize(("options", "name"), [
    (dict(lines=4), "lines"),
    (dict(method="paper", smallest_feature=0.1), "smallest_feature"),
    (dict(method="los", threshold="1%"), "threshold"),
])  # fmt: skip
def test_a_session_refuses_options_that_its_method_does_not_use(options, name):
    method = options.get("method", "vol")
    message = f"`{name}` is given, and method `{method}` does not use it: expected none, or method"
    with pytest.raises(emitree.SceneError, match=message):
        emitree.Session(CUBE, (4, 4), **options)


def test_lines_of_spectra_are_for_vol():
    energy = emitree.Energies(1, 2, 2, lines=[1.5])
    emitree.render(spectral, CUBE, (2, 2), energy=energy)
    with pytest.raises(emitree.SceneError, match=r"`energy\.lines` is given, and method `los`"):
        emitree.render(spectral, CUBE, (2, 2), energy=energy, method="los")


def test_a_scene_file_keeps_what_another_method_needs(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'emission.expression = "x"\nprojection.type = "canonical"\n'
        'image = { width = 4, height = 4 }\nrender = { method = "los", lines = 2 }\n'
    )
    assert emitree.render(scene, method="vol").report["ignored"] == ["lines"]
    with pytest.raises(emitree.SceneError, match="`lines` is given, and method `vol`"):
        emitree.render(scene, method="vol", lines=3)
    with pytest.raises(emitree.SceneError, match="`lines` is given, and method `vol`"):
        emitree.render(scene, method="vol", changes={"render.lines": 3})


@pytest.mark.parametrize(("options", "message"), [
    (dict(executor=5), "`executor` is 5: expected a concurrent.futures.Executor"),
    (dict(batch_size=-1), "`batch_size` is -1: expected a number of points, 1 or more"),
    (dict(batch_size="many"), "`batch_size` is 'many': expected a number of points"),
    (dict(threads=10**9), "`threads` is 1000000000: expected a number of threads, 1 to 1024"),
    (dict(threads=1025), "`threads` is 1025: expected a number of threads, 1 to 1024"),
    (dict(threads=0), "`threads` is 0: expected a number of threads, 1 to 1024"),
    (dict(threads=2.5), "`threads` is 2.5: expected a number of threads"),
    (dict(max_evaluations=-1), "`render.max_evaluations` is -1"),
    (dict(tolerance=object()), "`render.tolerance`: <object"),
    (dict(instrument=3, energy=ENERGY), "`instrument` is 3: expected emitree.Instrument"),
    (dict(energy="abc"), "`energy` is 'abc': expected emitree.Energies, a dictionary"),
    (dict(energy=[1.0]), r"`energy` has the shape \(1,\): expected borders \(bins \+ 1,\)"),
    (dict(energy=[2.0, 1.0]), "`energy`: expected borders that are finite and ascend"),
    (dict(energy=[1.0, 2.0, 4.0, 7.0]), "in steps of 1 to 3 and ratios of 1.75 to 2: expected "
     "uniform steps or equal ratios"),
])  # fmt: skip
def test_what_makes_no_sense_is_named(options, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(peak, CUBE, (4, 4), **options)


def test_quantities_are_for_functions():
    with pytest.raises(emitree.SceneError, match="`quantities` is for functions"):
        emitree.render("x", CUBE, (4, 4), quantities=True)


def test_trees_take_no_more_threads():
    box = emitree.Box(min=(0, 0, 0), max=(1, 1, 1))
    with pytest.raises(emitree.SceneError, match="`threads` is 2000: expected"):
        emitree.build_tree("x", "never.fits", box, threads=2000)


def test_borders_of_energy_bins():
    linear = emitree.render(spectral, CUBE, (2, 2), energy=np.linspace(0.5, 2.5, 5))
    same = emitree.render(spectral, CUBE, (2, 2), energy={"min": 0.5, "max": 2.5, "bins": 4})
    assert np.array_equal(linear.image, same.image) and linear.report["energy"]["scale"] == "linear"
    borders = np.geomspace(0.1, 10, 7)
    ratios = emitree.render(spectral, CUBE, (2, 2), energy=borders)
    assert ratios.report["energy"]["scale"] == "log" and ratios.energy_unit == "keV"
    np.testing.assert_allclose(ratios.energies, borders, rtol=1e-12)
    single = emitree.Energies.from_edges(borders.astype(np.float32))
    assert (single.scale, single.bins) == ("log", 6)


def test_energies_of_other_kinds_are_the_same():
    from_class = emitree.render(spectral, CUBE, (2, 2), energy=emitree.Energies(1, 2, 2))
    from_table = emitree.render(spectral, CUBE, (2, 2), energy=ENERGY)
    assert np.array_equal(from_class.image, from_table.image)
    np.testing.assert_array_equal(from_class.energies, emitree.Energies(1, 2, 2).edges)


def test_a_limit_on_the_time():
    def slow(position, direction):
        time.sleep(0.02)
        return peak(position, direction)

    start = time.perf_counter()
    found = emitree.render(slow, CUBE, (64, 64), tolerance=1e-5, max_seconds=0.3, batch_size=200)
    assert 0.2 < time.perf_counter() - start < 3
    assert not found.converged and found.report["ending"] == "time"
    assert np.abs(found.image - exact_peak(64, 64)).max() < 0.5
    with pytest.raises(emitree.SceneError, match=r"`render\.max_seconds` is -1"):
        emitree.render(peak, CUBE, (4, 4), max_seconds=-1)


def test_limits_may_be_quantities():
    u = pytest.importorskip("astropy.units")
    found = emitree.render(peak, CUBE, (4, 4), max_seconds=2 * u.h)
    assert "max_seconds = 7200.0" in found.scene
    camera = emitree.Orthographic(
        position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), extent=(2, 2), near=8, far=10,
        length_unit="km",
    )  # fmt: skip
    found = emitree.render("exp(-r^2)", camera, (8, 8), smallest_feature=200 * u.m)
    assert 'smallest_feature = "200.0 m"' in found.scene
    with pytest.raises(
        emitree.SceneError, match=r"`max_seconds` is 1\.0 km: expected a number in s"
    ):
        emitree.render(peak, CUBE, (4, 4), max_seconds=1 * u.km)
    with pytest.raises(emitree.SceneError, match=r"`smallest_feature` is \[1\. 2\.\] m"):
        emitree.render(peak, camera, (4, 4), smallest_feature=[1, 2] * u.m)


def test_an_expression_is_rendered_in_the_shortest_time():
    formula = "exp(-20*((x - 0.4)^2 + (y - 0.6)^2 + (z - 0.5)^2))"
    in_time = emitree.render(formula, CUBE, (40, 40), minimize="time")
    fewest = emitree.render(formula, CUBE, (40, 40), minimize="evaluations")
    assert fewest.report["line_steps"] is None
    # The choice is one of measured time, on any machine.
    if in_time.report["line_steps"] is not None:
        assert in_time.report["line_steps"] >= 9
        assert in_time.report["evaluations"] > 60_000 > fewest.report["evaluations"]
    else:
        np.testing.assert_array_equal(in_time.image, fewest.image)
    assert in_time.converged
    assert np.abs(in_time.image - fewest.image).max() <= 0.02 * fewest.image.max()
    with pytest.raises(emitree.SceneError, match=r'`render\.minimize` is "speed"'):
        emitree.render(formula, CUBE, (4, 4), minimize="speed")


def test_the_smallest_feature_is_reported():
    found = emitree.render(peak, CUBE, (8, 8), smallest_feature=0.05)
    assert found.smallest_feature == found.report["smallest_feature"]
    assert "smallest_feature = 0.05" in found.scene
    lines = emitree.render(peak, CUBE, (8, 8), method="los")
    assert lines.smallest_feature is None
    with pytest.raises(emitree.SceneError, match="`smallest_feature` is given, and method `los`"):
        emitree.render(peak, CUBE, (8, 8), method="los", smallest_feature=0.05)
    with pytest.raises(emitree.SceneError, match=r"`render\.smallest_feature` is 2"):
        emitree.render(peak, CUBE, (8, 8), smallest_feature=2)
