"""Views, without a browser: their work, their pictures, and what they say."""

import sys
import threading
import time

import numpy as np
import pytest
from models import peak, spectral_peak

import emitree
from emitree import _view_picture as pictures
from emitree._progressive import Frame
from emitree._view_messages import goal_of, message_of
from emitree._view_turn import can_turn, turned
from emitree._view_work import Target, Update, Work

CUBE = emitree.Canonical()
SIDE = emitree.Orthographic(position=(3, 0, 0), target=(0, 0, 0), extent=(2, 2), near=0, far=6)


def decoded(state, name):
    """An array of a picture, as the browser decodes it."""
    count = state["width"] * state["height"]
    if len(state[name]) == 4 * count:
        floats = np.frombuffer(state[name], "<f4")
    else:
        floats = (np.frombuffer(state[name], "<u2").astype("<u4") << 16).view("<f4")
    return floats.astype(float).reshape(state["height"], state["width"]) * state[f"{name}_scale"]


class Reports(list):
    """The updates of a work."""

    def __call__(self, update):
        self.append(update)
        return 0.0


def test_work_gives_what_render_gives_and_goes_on_without_evaluating_a_point_again():
    seen = set()

    def counted(position, direction):
        new = {tuple(row) for row in position}
        assert not new & seen
        seen.update(new)
        return peak(position, direction)

    reports = Reports()
    work = Work(counted, {}, reports)
    for tolerance in (0.01, 1e-4):
        target = Target(CUBE, (16, 16), {"tolerance": tolerance})
        work.start([target])
        assert work.wait(10)
        last = reports[-1]
        assert (last.phase, last.target) == ("done", target)
        at_once = emitree.render(peak, CUBE, (16, 16), tolerance=tolerance)
        assert np.array_equal(last.latest.image, at_once.image)
        assert last.evaluations == len(seen)


@pytest.mark.parametrize("emission", [peak, "exp(-50*((x-0.5)^2+(y-0.4)^2+(z-0.5)^2))"])
def test_work_reports_intermediate_images(emission):
    reports = Reports()
    work = Work(emission, {}, reports)
    work.start([Target(CUBE, (32, 32), {"tolerance": 1e-6})])
    work.wait(10)
    assert reports[0].phase == "running" and reports[-1].phase == "done"
    evaluations = [report.evaluations for report in reports]
    assert evaluations == sorted(evaluations) and evaluations[0] < evaluations[-1]


def test_work_stops_and_continues():
    is_called, may_go = threading.Event(), threading.Event()

    def slow(position, direction):
        is_called.set()
        assert may_go.wait(10)
        return peak(position, direction)

    reports = Reports()
    work = Work(slow, {}, reports)
    target = Target(CUBE, (16, 16), {})
    work.start([target])
    assert is_called.wait(10)
    work.stop()
    may_go.set()
    assert work.wait(10) and [report.phase for report in reports] == ["stopped"]
    work.start([target])
    assert work.wait(10) and reports[-1].phase == "done"


def test_a_formula_stops():
    reports = Reports()
    work = Work("1 + sin(300*x*y) * cos(200*y*z + 90*x)", {}, reports)
    work.start([Target(CUBE, (64, 64), {"tolerance": 1e-12})])
    time.sleep(0.2)
    work.stop()
    assert work.wait(5) and reports[-1].phase == "stopped", "it would take a minute"


def test_the_newest_work_replaces_others_and_calls_do_not_overlap():
    under_way, most = 0, 0

    def slow(position, direction):
        nonlocal under_way, most
        under_way += 1
        most = max(most, under_way)
        time.sleep(0.005)
        under_way -= 1
        return peak(position, direction)

    reports = Reports()
    work = Work(slow, {}, reports)
    targets = [Target(CUBE, (size, size), {}) for size in (8, 12, 16, 20)]
    for target in targets:
        work.start([target])
    assert work.wait(10) and most == 1
    assert [report.target for report in reports if report.phase == "done"] == targets[-1:]


def test_what_ends_a_rendering_is_told_and_raised():
    def fails(position, direction):
        raise ArithmeticError("no rate there")

    reports = Reports()
    work = Work(fails, {}, reports)
    work.start([Target(CUBE, (8, 8), {})])
    with pytest.raises(ArithmeticError, match="no rate there"):
        work.wait(10)
    assert message_of(reports[-1]) == "The rendering failed. ArithmeticError: no rate there"


def test_rates_that_are_not_finite_are_told():
    work = Work(lambda r, d: np.full(len(r), np.nan), {}, reports := Reports())
    work.start([Target(CUBE, (8, 8), {})])
    with pytest.raises(emitree.EmissionError):
        work.wait(10)
    assert "The rendering failed. EmissionError: " in message_of(reports[-1])


def test_options_of_functions_are_refused_for_others():
    with pytest.raises(TypeError, match="`executor` is for functions"):
        Work("1", {"executor": object()}, Reports())


def test_messages():
    target = Target(CUBE, (1, 2), {"tolerance": 0.05})
    frame = Frame(np.array([[4.0, 1.0]]), np.array([[0.5, 1.0]]), 12, 3)
    assert message_of(Update("running", target, frame, 1234)) == (
        "Rendering: 1,234 evaluations, estimated error 2.5e-01 of the largest pixel (tolerance 0.05)."
    )
    assert message_of(Update("stopped", target, None, 1)) == "Stopped: 1 evaluation, no image yet."
    assert message_of(Update("running", target, None, 0)) == "Rendering: no evaluations yet."
    limited = emitree.render(peak, CUBE, (8, 8), tolerance=1e-9, max_evaluations=300)
    done = Update("done", Target(CUBE, (8, 8), {"tolerance": 1e-9}), limited, limited.evaluations)
    assert message_of(done).endswith(
        " of the largest pixel. The tolerance 1e-09 is not met: the limit `max_evaluations` was reached."
    )
    steps = emitree.render(peak, CUBE, (8, 8), method="los", steps=4)
    done = Update("done", Target(CUBE, (8, 8), {"method": "los", "steps": 4}), steps, 256)
    assert message_of(done) == "256 evaluations, error not estimated."
    assert goal_of({"method": "los", "steps": 4}) is None
    assert goal_of(limited.report) == {"name": "tolerance", "value": 1e-9}


def test_cameras_turn_around_their_target():
    # From x towards -y and down, so that what is in front moves to the right and up.
    found = turned(SIDE, 0.5, 0.0)
    assert np.allclose(found.position, (0, -3, 0)) and found.target == (0.0, 0.0, 0.0)
    found = turned(SIDE, 0.0, 0.25)
    assert np.allclose(found.position, 3 * np.array([1, 0, -1]) / np.sqrt(2))
    found = turned(SIDE, 0.0, 2.0)
    angle = np.degrees(np.arccos(-found.position[2] / 3))
    assert np.isclose(angle, 1.0), "1 degree from the axis"
    back = turned(turned(SIDE, 0.2, 0.1), -0.2, -0.1)
    assert np.allclose(back.position, SIDE.position)


def test_other_cameras_turn_by_their_field_of_view():
    camera = emitree.Equirectangular(
        position=(1, 2, 3), target=(0, 2, 3), field_of_view=(90, 45), near=0, far=9
    )
    found = turned(camera, 1.0, 0.0)
    # Pointing to -x with z up, right is y: what is seen moves right, the pointing left.
    assert np.allclose(found.target, (1, 1, 3)) and found.position == (1.0, 2.0, 3.0)
    assert not can_turn(CUBE) and not can_turn(emitree.Healpix(position=(0, 0, 0)))


def test_a_turned_camera_keeps_its_units():
    u = pytest.importorskip("astropy.units")
    camera = emitree.Perspective(
        position=[2000, 0, 0] * u.m, target=[0, 0, 0] * u.m, field_of_view=(20, 20),
        near=0 * u.km, far=4 * u.km, length_unit="km",
    )  # fmt: skip
    found = turned(camera, 0.5, 0.0)
    assert np.allclose(found.position, (0, -2, 0)) and found.length_unit == "km"
    assert found.far == 4 * u.km


def test_pictures_keep_values():
    rendering = emitree.render(peak, CUBE, (12, 20), tolerance=1e-3)
    state = pictures.picture_of(rendering, False)
    assert (state["width"], state["height"], state["block"], state["bins"]) == (20, 12, 1, 0)
    assert np.allclose(
        decoded(state, "image"), rendering.image, rtol=1e-7, atol=1e-7 * rendering.image.max()
    )
    assert np.allclose(decoded(state, "error"), rendering.error, rtol=2.0**-8)
    assert np.allclose(decoded(state, "evaluations"), rendering.evaluations_per_pixel, rtol=2.0**-8)
    assert state["axes"][0] == {
        "name": "canonical x",
        "unit": "",
        "ends": pytest.approx([0.025, 0.975]),
    }


def test_pictures_of_values_beyond_32_bits():
    frame = Frame(np.array([[1e-60, 2e-60, np.nan]]), np.array([[1e-62, 0.0, np.nan]]), 1, 1)
    state = pictures.picture_of(frame, False)
    assert np.allclose(decoded(state, "image"), frame.image, rtol=1e-6, atol=0, equal_nan=True)
    assert np.allclose(decoded(state, "error"), frame.error, rtol=2.0**-8, atol=0, equal_nan=True)
    assert state["evaluations"] is None


def test_large_images_are_means_and_the_largest_errors(monkeypatch):
    monkeypatch.setattr(pictures, "MOST_PIXELS", 6)
    image = np.arange(15.0).reshape(3, 5)
    image[0, 0] = np.nan
    state = pictures.picture_of(Frame(image, image / 10, 1, 1), False)
    assert (state["width"], state["height"], state["block"]) == (3, 2, 2)
    # Blocks of 2 x 2 pixels, those at the border smaller, without the NaN.
    expected = [[(1 + 5 + 6) / 3, (2 + 3 + 7 + 8) / 4, (4 + 9) / 2], [10.5, 12.5, 14]]
    assert np.allclose(decoded(state, "image"), expected)
    assert np.allclose(decoded(state, "error"), [[0.6, 0.8, 0.9], [1.1, 1.3, 1.4]], rtol=2.0**-8)


def test_the_error_of_a_cube_is_at_least_that_of_its_band():
    options = {"energy": {"min": 1, "max": 3, "bins": 4}}
    cube = emitree.render(spectral_peak, CUBE, (6, 8), **options)
    steps = np.diff(cube.energies)[:, None, None]
    assert np.allclose(pictures.error_of(cube), (cube.error * steps).sum(axis=0))
    found = pictures.spectrum_at(cube, 2, 3, 1, False)
    assert found["values"] == cube.image[:, 2, 3].tolist()
    assert found["errors"] == cube.error[:, 2, 3].tolist() and found["energies"] == [
        1,
        1.5,
        2,
        2.5,
        3,
    ]


def test_skies_are_maps():
    camera = emitree.Healpix(position=(0, 0, 0), near=0, far=1)
    sky = emitree.render("1 + dx", camera, 8)
    state = pictures.picture_of(sky, True)
    assert np.array_equal(decoded(state, "image") > 0, ~np.isnan(sky._found.picture(200)))
    assert np.allclose(decoded(state, "image"), sky._found.picture(200), equal_nan=True)


class TestView:
    """What needs anywidget."""

    @pytest.fixture(autouse=True)
    def _widgets(self):
        pytest.importorskip("anywidget")

    def test_it_renders_goes_on_and_turns(self):
        def blob(position, direction):
            return np.exp(-20 * ((position - [0.5, 0.0, 0.0]) ** 2).sum(axis=1))

        view = emitree.view(blob, SIDE, (24, 24))
        assert view.wait(10).converged and view.status["phase"] == "done"
        before = view.rendering.evaluations
        view.resume(tolerance=1e-5)
        assert view.wait(10).report["tolerance"] == 1e-5 and view.rendering.evaluations > before
        assert view.status["goal"] == {"name": "tolerance", "value": 1e-5}
        view._on_message(view, {"kind": "turn", "right": 0.5, "up": 0, "is_final": True}, [])
        view.wait(10)
        assert np.allclose(view.camera.position, (0, -3, 0))
        # The blob is 0.5 to the right of the middle: 1.5 of the width 2, in pixels of 1/12.
        assert view.rendering.image.sum(axis=0).argmax() in (17, 18)
        view._on_message(view, {"kind": "turn", "right": 0, "up": 0.1, "is_final": False}, [])
        view.wait(10)
        assert view.rendering.report["tolerance"] == 0.1

    @pytest.mark.parametrize("options", [
        {"rtol": 0.01, "mask": np.ones((96, 64))},
        {"method": "los", "steps": 8},
        {"method": "paper", "threshold": "1 %"},
    ], ids=lambda options: next(iter(options.values())))  # fmt: skip
    def test_coarse_pictures_of_other_options(self, options):
        view = emitree.view("exp(-3*(x^2+y^2+z^2))", SIDE, (96, 64), **options)
        assert view.wait(10).image.shape == (96, 64)
        view.turn(0.1, 0.1, is_final=False)
        assert view.wait(10).image.shape == (48, 32)
        view.turn(0, 0)
        assert view.wait(10).image.shape == (96, 64)

    def test_the_spectrum_follows_the_cursor(self):
        view = emitree.view("(1 + x) * E", CUBE, (4, 8), energy={"min": 1, "max": 3, "bins": 2})
        view.wait(10)
        assert view.spectrum == {}
        view.cursor = [0.7, 1.0]
        assert np.allclose(view.spectrum["values"], [1.6875 * 1.5, 1.6875 * 2.5])

    def test_what_is_wrong_is_raised_at_once(self):
        for arguments, options, pattern in [
            (
                ("scene.toml", CUBE, (4, 4)),
                {},
                "is the scene file 'scene.toml': expected an emission",
            ),
            ((["1", "x"], CUBE, (4, 4)), {}, "a list of emissions: expected one"),
            (("1", CUBE), {}, "expected `shape`"),
            (("1", CUBE, (4, 4)), {"frame": print}, "unknown option `frame`: expected one of"),
        ]:
            with pytest.raises(TypeError, match=pattern):
                emitree.view(*arguments, **options)
        with pytest.raises(emitree.SceneError, match="tolerance"):
            emitree.view("1", CUBE, (4, 4), tolerance=-1)

    def test_what_a_browser_sends_wrongly_is_told(self):
        view = emitree.view("1 + x", CUBE, (4, 4))
        view.wait(10)
        view._on_message(view, {"kind": "resume", "options": {"tolerance": -1}}, [])
        assert view.status["phase"] == "failed" and "SceneError" in view.status["message"]
        view._on_message(view, {"kind": "turn", "right": 1, "up": 0}, [])
        assert view.status["message"].startswith("ValueError: Canonical cannot be turned")
        view.resume(tolerance=0.1)
        assert view.wait(10).converged and view.status["phase"] == "done"

    def test_a_finished_rendering(self):
        rendering = emitree.render(peak, CUBE, (6, 8))
        view = rendering.view()
        assert view.wait() is rendering and not view.status["can_resume"]
        assert view.status["message"].endswith("The tolerance 0.01 is met.")
        assert "<img" in view._still()["text/html"]
        with pytest.raises(ValueError, match="that of a finished rendering"):
            view.resume(tolerance=1e-3)

    def test_a_sky_with_energies(self):
        camera = emitree.Healpix(position=(0, 0, 0), near=0, far=1)
        view = emitree.view("(2 + dx) * E", camera, 4, energy={"min": 1, "max": 3, "bins": 2})
        view.wait(10)
        assert (view.picture["height"], view.picture["width"], view.picture["bins"]) == (
            200,
            400,
            2,
        )
        view.cursor = [0.001, 0.001]
        assert view.spectrum == {}, "outside of the map"
        view.cursor = [0.5, 0.5]
        first, second = view.spectrum["values"]
        assert np.isclose(second / first, 2.5 / 1.5)


def test_without_anywidget(monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "emitree._view_widget", raising=False)
    with pytest.raises(ImportError, match=r'pip install "emitree\[notebook\]"'):
        emitree.view("1", CUBE, (4, 4))
