"""The camera and the model of `smile` are those of emitree, and its exact image is exact."""

import csv
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from . import gauss, harness, smile, smile_exact
from .contestants import CONTESTANTS
from .scene import Scene, relative_error


def seen_ramp(x, y, z):
    """Brighter upwards, more so towards the Sun, which is to the right of the view."""
    return 40 + x + 0.5 * z + 0 * y


def seen_ramp_image(shape):
    camera, order = smile.CAMERA, 4
    x, y = (gauss.panels(count, order)[0] for count in shape[::-1])
    direction = camera.directions(x, y[:, None])
    start, along = np.array(camera.position), camera.far / 2 * direction
    line = camera.far * seen_ramp(*(start + along).transpose(2, 0, 1))
    weight = gauss.nodes(order)[1]
    weight = np.outer(weight, weight)
    parts = (shape[0], order, shape[1], order)
    angle = np.broadcast_to(camera.solid_angle(y[:, None]), line.shape).reshape(parts)
    mean = lambda values: np.einsum("iajb,ab->ij", values, weight)  # noqa: E731
    return mean(angle * line.reshape(parts)) / mean(angle)


#: Those that have settings for it.
OF_SMILE = [one for one in CONTESTANTS.values() if one.settings_of("smile")]

SEEN_RAMP = Scene(
    "smile", "a ramp", seen_ramp, seen_ramp_image, seen_ramp_image, (20, 10), camera=smile.CAMERA
)


@pytest.mark.parametrize("contestant", OF_SMILE, ids=lambda one: one.name)
def test_every_contestant_gives_the_image_of_a_camera(contestant):
    exact = seen_ramp_image(SEEN_RAMP.shape)
    found = harness.measure(contestant, SEEN_RAMP, exact, contestant.settings_of("smile")[0])
    assert found.found, found.note
    # Flipped, the image is wrong by a tenth or more; settings are coarse, above all cells of grids.
    assert found.error < 0.02
    flips = (exact[::-1], exact[:, ::-1], exact[::-1, ::-1])
    assert min(relative_error(flip, exact) for flip in flips) > 0.1


def test_lines_of_sight_are_those_of_emitree():
    import emitree

    places = []

    def record(position, direction):
        places.append(np.hstack([position, direction]))
        return np.ones(len(position))

    shape, camera = (6, 4), smile.CAMERA
    view = emitree.Equirectangular(near=0, **asdict(camera))
    # One line through the centre of each pixel, and its middle.
    emitree.render(record, view, shape, method="los", lines=1, steps=1, threads=1)
    lines = camera.lines(shape, 1).reshape(-1, 3)
    expected = np.hstack([np.array(camera.position) + camera.far / 2 * lines, -lines])
    found = np.vstack(places)
    assert found.shape == expected.shape
    ordered = [values[np.lexsort(values[:, :3].round(6).T)] for values in (found, expected)]
    np.testing.assert_allclose(*ordered, atol=1e-12)


def test_solid_angles_of_pixels_are_means():
    camera = smile.CAMERA
    y, _ = gauss.panels(7, 8)
    means = camera.solid_angle(y).reshape(7, 8) @ gauss.nodes(8)[1]
    assert camera.pixel_angles((7, 3))[:, 0] == pytest.approx(means, abs=1e-14)


def test_the_rate_of_smile_is_the_model_of_emitree():
    import emitree

    view = emitree.Equirectangular(near=0, **asdict(smile.CAMERA))
    by_lines = {"method": "los", "lines": 3, "steps": 80}
    model = emitree.render(emitree.Model("cmem"), view, (20, 10), **by_lines)
    ours = emitree.render(lambda at, _: smile.rate(*at.T), view, (20, 10), **by_lines)
    np.testing.assert_allclose(ours.image, model.image, rtol=1e-12)


WAYS_ALONG = [
    {name: way[name] for name in ("samples", "panels", "nodes")}
    for way in smile_exact.WAYS.values()
]


@pytest.mark.parametrize("way", WAYS_ALONG)
def test_lines_of_smile_are_integrated_to_rounding(way):
    crates = Path(__file__).resolve().parents[2] / "crates"
    reference = crates / "emitree-models" / "tests" / "reference" / "smile_view1.csv"
    with reference.open(newline="", encoding="utf-8") as file:
        pixels = [
            [float(pixel[name]) for name in ("column", "row", "converged")]
            for pixel in csv.DictReader(file)
        ]
    column, line, converged = np.transpose(pixels)
    directions = smile.CAMERA.directions((column + 0.5) / 50, (line + 0.5) / 100)
    found = smile_exact.radiances(directions, **way)
    assert found == pytest.approx(converged, rel=1e-13)


def test_the_exact_image_of_smile_is_that_of_many_lines():
    exact, disagreement = smile.SCENE.verified_image()
    assert disagreement < smile.SCENE.agreement
    # The tests of the crate `emitree-models` have this from 8 x 8 lines a pixel.
    assert abs(exact.max() - 6.4742) < 1e-3
    height, width = exact.shape
    lines = smile.CAMERA.lines(exact.shape, 1)[:, :, 0, 0].reshape(-1, 3)
    parts = np.array_split(lines, 5)
    centre = np.concatenate([smile_exact.radiances(part, **WAYS_ALONG[0]) for part in parts])
    # Where one line is furthest off: folds. And some other pixels.
    off = np.abs(centre.reshape(exact.shape) - exact).ravel()
    chosen = [*np.argsort(off)[-6:], *range(17, height * width, 997)]
    many = smile.CAMERA.lines(exact.shape, 24).reshape(height * width, -1, 3)
    for pixel in chosen:
        mean = smile_exact.radiances(many[pixel], **WAYS_ALONG[1]).mean()
        assert abs(mean - exact.flat[pixel]) < 3e-4 * exact.max(), divmod(pixel, width)


def test_the_exact_image_of_smile_is_that_of_emitree():
    import emitree

    exact, _ = smile.SCENE.verified_image()
    view = emitree.Equirectangular(near=0, **asdict(smile.CAMERA))
    rendering = emitree.render(emitree.Model("cmem"), view, exact.shape, tolerance=1e-2)
    assert relative_error(rendering.image, exact) < 1e-2
