"""Exposures: pixels are means over times, observers move, light takes time."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from passages import passage
from scipy.special import erf

import emitree

CAMERA = emitree.Orthographic(
    position=(0, 0, 5), target=(0, 0, 0), up=(0, 1, 0), extent=(6, 6), far=10
)
SHAPE = (24, 24)


def blob(position, direction, time):
    """A Gaussian that moves with the velocity 1 along x."""
    x, y, z = position.T
    return np.exp(-((x - time) ** 2) - y**2 - z**2)


def means(low, high):
    """Means of exp(-u^2) between (n,) and (n,)."""
    return 0.5 * np.sqrt(np.pi) * (erf(high) - erf(low)) / (high - low)


def trail(start, stop, camera_velocity=-1.0):
    """The closed form: the blob over the camera's pixels, and the mean over the time."""
    edges = np.linspace(-3, 3, SHAPE[1] + 1)
    of_y = means(edges[:-1], edges[1:])
    depth = np.sqrt(np.pi) * erf(5)

    def twice(u):
        # The integral of the integral of exp(-u^2): u erf(u) sqrt(pi)/2 + exp(-u^2)/2.
        return 0.5 * np.sqrt(np.pi) * u * erf(u) + 0.5 * np.exp(-(u**2))

    low, high = edges[:-1], edges[1:]
    inner = [twice(high - t) - twice(low - t) for t in (start, stop)]
    of_x = (inner[0] - inner[1]) / ((high - low) * (stop - start))
    return depth * np.outer(of_y, of_x)


def error(found, exact):
    return abs(found - exact).max() / abs(exact).max()


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
@pytest.mark.parametrize(
    "emission", [blob, "exp(-(x - t)^2 - y^2 - z^2)"], ids=["function", "formula"]
)
def test_a_blob_that_moves_is_a_difference_of_erf(emission, tolerance):
    exposure = emitree.Exposure(0, 2)
    found = emitree.render(emission, CAMERA, SHAPE, exposure=exposure, tolerance=tolerance)
    assert found.converged and found.image.shape == SHAPE
    assert error(found.image, trail(0, 2)) < tolerance
    assert (abs(found.image - trail(0, 2)) <= found.error.max()).all()
    assert found.times.tolist() == [0, 2] and found.energies is None


def test_several_bins_are_a_cube_and_their_mean_the_image_of_all():
    exposure = emitree.Exposure(-1, 2, bins=3)
    found = emitree.render(blob, CAMERA, SHAPE, exposure=exposure, tolerance=1e-3)
    exact = np.stack([trail(t, t + 1) for t in (-1, 0, 1)])
    assert found.image.shape == (3, *SHAPE) and error(found.image, exact) < 1e-3
    assert error(found.flat_image, trail(-1, 2)) < 1e-3
    assert found.times.tolist() == [-1, 0, 1, 2]
    assert found.energies is None and found.energy_unit is None


@pytest.mark.parametrize(
    "moving",
    [
        {"velocity": (-1, 0, 0)},
        {"observer": lambda time: (-time, 0, 5)},
        {"observer": lambda time: ((-time, 0, 5), (-time, 0, 0))},
        {"observer": ([0, 1, 2], [(0, 0, 5), (-1, 0, 5), (-2, 0, 5)])},
    ],
    ids=["velocity", "position", "target", "arrays"],
)
@pytest.mark.parametrize("emission", ["exp(-x^2 - y^2 - z^2)", lambda p, d, t: blob(p, d, 0 * t)])
def test_a_camera_that_moves_past_a_blob_at_rest_sees_the_same(moving, emission):
    found = emitree.render(
        emission, CAMERA, SHAPE, exposure=emitree.Exposure(0, 2, **moving), tolerance=1e-3
    )
    assert found.converged and error(found.image, trail(0, 2)) < 1e-3
    assert found.report["time"]["observer_moves"]


def test_a_brightness_that_decays_is_its_mean():
    exposure = emitree.Exposure(1, 3)
    found = emitree.render(
        "exp(-x^2 - y^2 - z^2) * exp(-t)", CAMERA, SHAPE, exposure=exposure, tolerance=1e-4
    )
    still = emitree.render("exp(-x^2 - y^2 - z^2)", CAMERA, SHAPE, tolerance=1e-6)
    exact = still.image * (np.exp(-1) - np.exp(-3)) / 2
    assert error(found.image, exact) < 1e-4
    # The time is a factor: the image of one time is that of all others.
    assert (found.report["energies"], found.evaluations) == (1, 3325)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("tolerance", [1e-2])
def test_random_passages_are_those_of_an_independent_quadrature(seed, tolerance):
    given = passage(seed)
    exact = given.image()
    assert error(given.image(3, 48), exact) < 0.02 * tolerance
    found = emitree.render(
        given.emission, given.camera, exact.shape[1:], exposure=given.exposure, tolerance=tolerance
    )
    assert found.converged
    assert error(found.image.reshape(exact.shape), exact) < tolerance


def test_light_left_when_the_source_was_elsewhere():
    # A source at the depth s is seen where it was s/c ago.
    camera = replace(CAMERA, length_unit="km")
    c = 299_792.458

    def fast(position, direction, time):
        # A tenth of the speed of light along x.
        return blob(position, direction, 0.1 * c * time)

    still = {"tolerance": 5e-3, "exposure": emitree.Exposure(0, 20 / c)}
    delayed = emitree.Exposure(0, 20 / c, light_travel_time=True)
    found = emitree.render(fast, camera, (12, 12), **{**still, "exposure": delayed})

    def by_hand(position, direction, time):
        return fast(position, direction, time - (5 - position[:, 2]) / c)

    exact = emitree.render(by_hand, camera, (12, 12), **still)
    assert error(found.image, exact.image) < 1e-2
    at_once = emitree.render(fast, camera, (12, 12), **still)
    assert error(at_once.image, exact.image) > 0.05
    assert found.report["time"]["light_travel_time"]


def test_an_orbit_about_an_opaque_body_is_an_image_of_one_place():
    """The emission is symmetric about the axis of the orbit: nothing changes."""

    def corona(position, direction, time=None):
        return np.exp(-np.hypot(position[:, 0], position[:, 1]) - position[:, 2] ** 2)

    def orbit(time):
        return (6 * np.cos(time), 6 * np.sin(time), 0.0), (0.0, 0.0, 0.0)

    camera = emitree.Perspective(
        position=(6, 0, 0), target=(0, 0, 0), field_of_view=(50, 50), far=12
    )
    body = {"occulters": [emitree.Sphere(center=(0, 0, 0), radius=1)], "tolerance": 2e-2}
    moving = emitree.Exposure(0, 1, observer=orbit)
    found = emitree.render(corona, camera, (10, 10), exposure=moving, **body)
    still = emitree.render(corona, camera, (10, 10), **{**body, "tolerance": 2e-3})
    assert found.converged and error(found.image, still.image) < 2.2e-2


def test_snapshots_have_bodies_that_do_not_move_with_the_observer():
    formula = "exp(-(x - t)^2 - y^2 - z^2)"
    body = [emitree.Sphere(center=(0.5, 0, 0), radius=0.8)]
    moving = emitree.Exposure(0, 0.5, velocity=(-1, 0, 0))
    options = {"occulters": body, "tolerance": 0.1}
    with pytest.raises(emitree.SceneError, match=r"occulter.* 1 does not move with the observer"):
        emitree.render(formula, CAMERA, (4, 4), exposure=moving, **options)
    snapshots = replace(moving, snapshots=True)
    found = emitree.render(formula, CAMERA, (4, 4), exposure=snapshots, **options)
    assert found.converged and found.estimated_error <= 0.1
    # Independently: the mean of many images.
    times = (np.arange(12) + 0.5) / 24
    images = []
    for time in times:
        here = replace(CAMERA, position=(-time, 0, 5), target=(-time, 0, 0))
        frozen = emitree.Expression(formula, {"t": time})
        fine = {"occulters": body, "method": "los", "lines": 6, "tolerance": 1e-2}
        images.append(emitree.render(frozen, here, (4, 4), **fine).image)
    assert error(found.image, np.mean(images, axis=0)) < 0.11


@pytest.mark.parametrize("emission", [blob, "exp(-(x - t)^2 - y^2 - z^2)"])
def test_snapshots_are_the_same_mean(emission):
    exposure = emitree.Exposure(0, 2, bins=2, snapshots=True)
    found = emitree.render(emission, CAMERA, SHAPE, exposure=exposure, tolerance=1e-2)
    exact = np.stack([trail(0, 1), trail(1, 2)])
    assert found.converged and error(found.image, exact) < 1e-2
    assert (abs(found.image - exact) <= found.error.max()).all()
    assert found.times.tolist() == [0, 1, 2] and found.report["time"]["bins"] == 2
    assert error(found.flat_image, trail(0, 2)) < 1e-2


def test_files_have_the_times():
    astropy = pytest.importorskip("astropy.io.fits")
    exposure = emitree.Exposure(10, 16, bins=3)
    found = emitree.render("1 + t*x", CAMERA, (4, 6), exposure=exposure)
    with astropy.open(io.BytesIO(found._found.fits())) as file:
        header = file[0].header
        assert [header[key] for key in ("CTYPE3", "CUNIT3", "CRVAL3", "CDELT3", "CRPIX3")] == [
            "TIME",
            "s",
            11.0,
            2.0,
            1.0,
        ]
        assert (header["TSTART"], header["TSTOP"], header["TIMEUNIT"]) == (10, 16, "s")
        assert header["NTIME"] >= 1 and "NENERGY" not in header
        times = file["TIMES"].data
        assert times["T_START"].tolist() == [10, 12, 14] and times["T_STOP"].tolist() == [
            12,
            14,
            16,
        ]
    one = emitree.render("1 + t*x", CAMERA, (4, 6), exposure=emitree.Exposure(10, 16))
    with astropy.open(io.BytesIO(one._found.fits())) as file:
        assert file[0].data.shape == (4, 6) and file[0].header["TSTOP"] == 16
        assert "TIMES" not in [table.name for table in file]


def test_datasets_and_copies_have_the_times():
    import copy

    exposure = emitree.Exposure(0, 4, bins=2)
    found = emitree.render("1 + t*x", CAMERA, (4, 6), exposure=exposure)
    again = copy.copy(found)
    assert again.times.tolist() == [0, 2, 4] and (again.image == found.image).all()
    assert "light curve" in found._repr_html_()
    pytest.importorskip("xarray")
    dataset = found.to_xarray()
    assert dataset.image.dims == ("time", "y", "x")
    assert dataset.time.values.tolist() == [1, 3] and dataset.time.units == "s"


def test_quantities_are_converted():
    u = pytest.importorskip("astropy.units")
    camera = replace(CAMERA, length_unit="km")
    seconds = []

    def emission(position, direction, time):
        seconds.append(time.to_value("s").max())
        return blob(position.to_value("km"), None, time.to_value("s"))

    exposure = emitree.Exposure(0 * u.s, 2000 * u.ms)
    found = emitree.render(
        emission, camera, SHAPE, exposure=exposure, tolerance=1e-3, quantities=True
    )
    assert error(found.image, trail(0, 2)) < 1e-3 and max(seconds) <= 2
    moving = emitree.Exposure(0 * u.s, 2 * u.s, velocity=[-1000, 0, 0] * u.m / u.s)
    found = emitree.render("exp(-r^2)", camera, SHAPE, exposure=moving, tolerance=1e-3)
    assert error(found.image, trail(0, 2)) < 1e-3


def test_sessions_and_plans_give_points_where_they_are_seen():
    exposure = emitree.Exposure(0, 2, velocity=(-1, 0, 0))
    direct = emitree.render(blob, CAMERA, SHAPE, exposure=exposure, tolerance=1e-2)
    session = emitree.Session(CAMERA, SHAPE, exposure=exposure, tolerance=1e-2)
    while points := session.ask():
        session.tell(blob(points.position, points.direction, points.energy))
    assert (session.rendering().image == direct.image).all()
    plan = direct.plan
    rates = blob(plan.points.position, plan.points.direction, plan.points.energy)
    assert np.allclose(plan.apply(rates).reshape(SHAPE), direct.image, rtol=1e-9)


def test_absorption_moves_with_the_world():
    """Fog at rest before a blob at rest, seen by a camera that moves, and the reverse."""
    fog = "0.5 * exp(-x^2 - (z - 2)^2)"
    moving = emitree.Exposure(0, 1, velocity=(0.7, 0, 0))
    found = emitree.render(
        "exp(-r^2)", CAMERA, (8, 8), exposure=moving, absorption=fog, tolerance=1e-2
    )
    shifted = "0.5 * exp(-(x + 0.7*t)^2 - (z - 2)^2)"
    exact = emitree.render(
        "exp(-(x + 0.7*t)^2 - y^2 - z^2)", CAMERA, (8, 8), exposure=emitree.Exposure(0, 1),
        absorption=shifted, tolerance=1e-2,
    )  # fmt: skip
    assert error(found.image, exact.image) < 2e-2


WRONG = {
    "`exposure` is tuple: expected emitree.Exposure(start, stop), in seconds": (0, 1),
    "`time.stop` is 1: expected more than 2, the `start`": emitree.Exposure(2, 1),
    "`exposure.start` is 'now': expected a time in seconds": emitree.Exposure("now", 1),
    "has an `observer` and a `velocity`: expected one of them": emitree.Exposure(
        0, 1, observer=lambda t: (t, 0, 0), velocity=(1, 0, 0)
    ),
    "expected a position (3,), or a pair (position, target)": emitree.Exposure(
        0, 1, observer=lambda t: t
    ),
    "`exposure.observer` is not smooth": emitree.Exposure(
        0, 1, observer=lambda t: (float(t > 0.3), 0, 0)
    ),
    "`exposure.observer` positions have the shape (2,): expected (2, 3)": emitree.Exposure(
        0, 1, observer=([0, 1], [0, 1])
    ),
    "expected a function of the time, or (times, positions)": emitree.Exposure(0, 1, observer=[1]),
    "returns a target at some times alone": emitree.Exposure(
        0, 1, observer=lambda t: (t, 0, 0) if t < 0.5 else ((t, 0, 0), (0, 0, 0))
    ),
    "`time.light_travel_time` needs a length unit": emitree.Exposure(0, 1, light_travel_time=True),
}


@pytest.mark.parametrize("message", WRONG)
def test_what_is_wrong_is_refused_by_name(message):
    with pytest.raises(emitree.SceneError) as raised:
        emitree.render("1", CAMERA, (2, 2), exposure=WRONG[message])
    assert message in " ".join(str(raised.value).split())


def test_energies_beside_times_are_refused():
    with pytest.raises(emitree.SceneError, match=r"the scene has `\[time\]` and `\[energy\]`"):
        emitree.render(
            "E", CAMERA, (2, 2), exposure=emitree.Exposure(0, 1), energy=emitree.Energies(1, 2, 1)
        )
    snapshots = emitree.Exposure(0, 1, snapshots=True)
    with pytest.raises(emitree.SceneError, match="`energy` is given with an exposure of snapshots"):
        emitree.render("1", CAMERA, (2, 2), exposure=snapshots, energy=emitree.Energies(1, 2, 1))


def test_the_example_of_the_guide():
    guide = Path(__file__).parents[2] / "docs" / "guide.md"
    section = guide.read_text(encoding="utf-8").split("### `[time]`")[1]
    names = {}
    exec(section.split("```python")[1].split("```")[0], names)
    rendering = names["rendering"]
    assert rendering.converged and rendering.image.shape == (48, 64)
    # The same by hand: a camera of its own at each of some times.
    images = []
    for time in (np.arange(24) + 0.5) / 24 * 60:
        position, target = names["spacecraft"](time)
        camera = replace(names["camera"], position=position, target=target)
        frozen = lambda p, d, t=time: names["comet"](p, d, np.full(len(p), t))  # noqa: E731
        images.append(emitree.render(frozen, camera, (48, 64), tolerance=2e-3).image)
    assert error(rendering.image, np.mean(images, axis=0)) < 1.3e-2


def test_the_scene_of_the_guide(tmp_path):
    guide = Path(__file__).parents[2] / "docs" / "guide.md"
    section = guide.read_text(encoding="utf-8").split("### `[time]`")[1]
    scene = tmp_path / "comet.toml"
    scene.write_text(section.split("```toml")[1].split("```")[0], encoding="utf-8")
    rendering = emitree.render(scene)
    assert rendering.converged and rendering.image.shape == (3, 48, 64)
    assert rendering.times.tolist() == [0, 20, 40, 60]


def test_snapshots_are_of_the_method_with_an_error_of_each_pixel():
    snapshots = emitree.Exposure(0, 1, snapshots=True)
    with pytest.raises(emitree.SceneError, match='`method` is "los" with an exposure of snapshots'):
        emitree.render("t", CAMERA, (2, 2), exposure=snapshots, method="los")
