"""Integrals along given lines, against chords and error functions."""

import pickle

import chords_of_lines
import numpy as np
import pytest
from models import torus
from scipy.special import erf

import emitree

#: Between two samples, as a fraction of a line, with the default of 8 panels.
GAP = 0.104 / 8


def random_lines(rng, count=300):
    """Lines from a sphere of radius 2 through a box about the origin."""
    position = rng.normal(size=(count, 3))
    position *= 2 / np.linalg.norm(position, axis=1)[:, np.newaxis]
    target = rng.uniform(-0.8, 0.8, (count, 3))
    return emitree.Lines(position, target - position, rng.uniform(2, 6, count))


def gaussians(rng):
    """A sum of Gaussians, its integrals along lines, and nothing between samples."""
    emission, exact = chords_of_lines.gaussians(rng, narrowest=0.03)
    return emission, exact, lambda lines: np.zeros(len(lines))


def shells(rng):
    """A sum of balls and shells, its integrals, and what is between samples."""
    count = rng.integers(1, 5)
    centres, heights = rng.uniform(-0.6, 0.6, (count, 3)), rng.uniform(0.2, 1, count)
    outer = np.exp(rng.uniform(np.log(0.05), np.log(0.8), count))
    inner = outer * rng.uniform(0, 0.97, count) * rng.integers(0, 2, count)
    both = list(zip(centres, inner, outer, heights, strict=True))

    def emission(position, direction):
        total = np.zeros(len(position))
        for centre, low, high, height in both:
            square = ((position - centre) ** 2).sum(axis=1)
            total += height * ((square < high**2) & (square >= low**2))
        return total

    def crossings(lines, centre, radius):
        offset = lines.positions - centre
        along = (offset * lines.directions).sum(axis=1)
        square = radius**2 - (offset**2).sum(axis=1) + along**2
        half = np.sqrt(np.maximum(square, 0))
        ends = np.clip([-along - half, -along + half], 0, lines.lengths)
        return np.where(square > 0, ends, 0)

    def exact(lines):
        total = np.zeros(len(lines))
        for centre, low, high, height in both:
            chords = [np.diff(crossings(lines, centre, r), axis=0)[0] for r in (high, low)]
            total += height * (chords[0] - chords[1])
        return total

    def unseen(lines):
        """The integral, at most, over parts between two jumps that may have no sample."""
        jumps = [crossings(lines, c, r) for c, low, high, _ in both for r in (low, high)]
        parts = np.diff(np.sort(np.concatenate(jumps), axis=0), axis=0)
        return heights.sum() * np.where(parts <= GAP * lines.lengths, parts, 0).sum(axis=0)

    return emission, exact, unseen


@pytest.mark.parametrize("family", [gaussians, shells])
@pytest.mark.parametrize("tolerance", [0.05, 0.01, 1e-3, 1e-5])
def test_errors_are_below_the_tolerance_on_a_family_set_aside(family, tolerance):
    # The method was made with other seeds.
    for seed in range(25):
        rng = np.random.default_rng([20261126, seed])
        emission, exact, unseen = family(rng)
        lines = random_lines(rng)
        found = emitree.line_integrals(emission, lines, tolerance=tolerance)
        truth = exact(lines)
        error = np.maximum(abs(found.values - truth) - unseen(lines), 0)
        assert found.converged and found.estimated_error <= tolerance
        assert error.max() <= tolerance * truth.max()
        # Estimates are honest line by line, but for a few.
        assert np.mean(error > found.error + 1e-12) <= 0.01


def test_rates_that_are_relative_to_each_line():
    lines = emitree.Lines([(-5, y, 0) for y in np.linspace(0, 4, 9)], (1, 0, 0), 10.0)
    truth = np.sqrt(np.pi) * np.exp(-(lines.positions[:, 1] ** 2)) * erf(5)
    found = emitree.line_integrals("exp(-r^2)", lines, rtol=1e-6)
    assert found.converged and found.is_good.all()
    np.testing.assert_allclose(found.values, truth, rtol=1e-6)
    found = emitree.line_integrals("exp(-r^2)", lines, atol=1e-7)
    assert (abs(found.values - truth) <= 1e-7).all() and found.allowed.max() == 1e-7


def test_infinite_lines_and_directions_of_emission():
    lines = emitree.Lines([(0, 0, -3), (0, 2, -3)], (0, 0, 2), np.inf)
    impact = np.array([0.0, 2.0])
    width = np.sqrt(1 + impact**2)
    truth = (np.pi / 2 + np.arctan(3 / width)) / width
    found = emitree.line_integrals("1 / (1 + r^2)", lines, tolerance=1e-6)
    # The rate falls like s^-2: the map makes this smooth.
    np.testing.assert_allclose(found.values, truth, rtol=1e-6)
    finite = emitree.Lines((0, 0, -3), (0, 0, 2), 2.0)
    towards = emitree.line_integrals(lambda r, d: d[:, 2], finite)
    np.testing.assert_allclose(towards.values, [-2.0])


def test_components_share_their_points():
    def three(position, direction):
        square = (position**2).sum(axis=1)
        return np.stack([np.exp(-square), np.exp(-4 * square), 0 * square], axis=1)

    lines = emitree.Lines([(-9, 0, 0), (-9, 1, 0)], (1, 0, 0), 18)
    found = emitree.line_integrals(three, lines, tolerance=1e-8)
    truth = np.sqrt(np.pi) * np.array([[1, 0.5, 0], [np.exp(-1), 0.5 * np.exp(-4), 0]])
    assert found.values.shape == found.error.shape == (2, 3) and found.converged
    np.testing.assert_allclose(found.values, truth, atol=1e-8)
    several = emitree.line_integrals(["exp(-r^2)", "exp(-4 * r^2)"], lines, tolerance=1e-8)
    np.testing.assert_allclose(several.values, truth[:, :2], atol=1e-8)


@pytest.mark.parametrize("kind", ["dense", "sparse", "groups"])
def test_weighted_sums(kind):
    sparse = pytest.importorskip("scipy.sparse")
    lines = random_lines(np.random.default_rng(3), 6)
    matrix = np.array([[0.5, 0.5, 0, 0, 0, 0], [0, 0, 0.25, 0.25, 0.25, 0.25]])
    groups = [[0, 1], [2, 3, 4, 5]]
    weights = {"dense": matrix, "sparse": sparse.csr_array(matrix), "groups": None}[kind]
    options = {"weights": weights, "groups": groups if weights is None else None}
    emission, exact, _ = gaussians(np.random.default_rng(4))
    given = emitree.Lines(lines.positions, lines.directions, lines.lengths, **options)
    found = emitree.line_integrals(emission, given, tolerance=1e-4)
    truth = matrix @ exact(lines)
    assert found.converged and found.values.shape == (2,) and found.along_lines.shape == (6,)
    assert (abs(found.values - truth) <= 1e-4 * truth.max()).all()
    np.testing.assert_allclose(found.values, matrix @ found.along_lines)
    np.testing.assert_allclose(found.error, matrix @ found.along_lines_error)


def test_errors_of_differences_are_those_of_both():
    lines = emitree.Lines([(-5, 0, 0), (-5, 0.1, 0)], (1, 0, 0), 10, [[1.0, -1.0]])
    found = emitree.line_integrals("exp(-r^2)", lines, tolerance=1e-3)
    truth = np.sqrt(np.pi) * erf(5) * (1 - np.exp(-0.01))
    assert found.converged and abs(found.values[0] - truth) <= 1e-3 * truth
    np.testing.assert_allclose(found.error, found.along_lines_error.sum())


def test_bounds_and_bodies():
    count = 40
    rng = np.random.default_rng(5)
    position = np.array([0.0, 0.0, -6.0])
    target = rng.uniform(-1.5, 1.5, (count, 3))
    lines = emitree.Lines(position, target - position, np.inf)
    ball = emitree.Sphere(center=(0, 0, 0), radius=2)
    body = emitree.Ellipsoid(center=(0, 0, 0), semi_axes=(1, 1, 1), pole=(1, 1, 0))
    found = emitree.line_integrals("1", lines, bounds=ball, occulters=[body])
    along = (position * lines.directions).sum(axis=1)
    square = 36 - along**2
    chord = 2 * np.sqrt(np.maximum(4 - square, 0))
    hidden = chord / 2 - np.sqrt(np.maximum(1 - square, 0))
    np.testing.assert_allclose(found.values, np.where(square < 1, hidden, chord))
    box = emitree.Box(min=(-1, -2, -3), max=(1, 2, 3))
    found = emitree.line_integrals("1", emitree.Lines((0, 0, -9), (0, 0, 1), 10), bounds=box)
    np.testing.assert_allclose(found.values, [4.0])


CAMERAS = [
    emitree.Perspective(position=(0, -4, 1), target=(0, 0, 0), field_of_view=(45, 35), far=8),
    emitree.Orthographic(
        position=(0, -4, 1), target=(0, 0, 0), extent=(4, 3), near=0, far=float("inf")
    ),
    emitree.Healpix(position=(0.1, 0, 0), far=4),
]


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: type(camera).__name__)
def test_lines_of_a_camera_are_its_centres(camera):
    shape = (96, 8) if isinstance(camera, emitree.Healpix) else (48, 64)
    emission = torus(1.0, 0.4, 1.0, 0.5)
    rendering = emitree.render(emission, camera, shape, tolerance=1e-3)
    lines = camera.lines(shape)
    found = emitree.line_integrals(emission, lines, tolerance=1e-4)
    image = found.values.reshape(shape)
    # Pixel means are not centres: a few parts in a thousand, and a hundred on coarse faces.
    limit = 0.03 if isinstance(camera, emitree.Healpix) else 0.006
    assert found.converged and abs(image - rendering.image).max() < limit * image.max()


def test_lines_of_a_camera_end_at_bounds_and_bodies():
    camera = emitree.Fisheye(position=(-5, 0, 0), target=(0, 0, 0), field_of_view=60)
    bounds = emitree.Sphere(center=(0, 0, 0), radius=2)
    body = emitree.Sphere(center=(0, 0, 0), radius=1)
    lines = camera.lines((20, 20), bounds=bounds, occulters=[body])
    assert lines.lengths[0] == 0.0
    whole = camera.lines((20, 20), bounds=bounds)
    found = emitree.line_integrals("1", whole, occulters=[body])
    np.testing.assert_allclose(found.values, lines.lengths, atol=1e-7)
    parallel = emitree.Orthographic(
        position=(0, 0, 0), target=(1, 0, 0), extent=(1, 1), near=-np.inf, far=1
    )
    with pytest.raises(emitree.SceneError, match="`near` is -inf"):
        parallel.lines((2, 2))


def test_budgets():
    lines = random_lines(np.random.default_rng(6), 50)

    def ball(position, direction):
        return (np.linalg.norm(position, axis=1) < 1).astype(float)

    found = emitree.line_integrals(ball, lines, tolerance=1e-6, max_evaluations=8000)
    assert not found.converged and 6000 < found.evaluations <= 8000
    assert found.estimated_error > 1e-6 and "not converged" in repr(found)
    found = emitree.line_integrals(lambda r, d: r[:, 0], lines, max_evaluations=1000)
    assert not found.converged and found.evaluations == 751
    with pytest.raises(emitree.SceneError, match="`max_evaluations` is 100: expected at least 751"):
        emitree.line_integrals(ball, lines, max_evaluations=100)


def test_particles_and_meshes_have_their_bounds():
    pytest.importorskip("scipy.spatial")
    particles = emitree.Particles(np.zeros((1, 3)), emission=2.0, support_radius=0.5)
    sides = np.linspace(-0.6, 0.6, 41)
    y, z = (side.ravel() for side in np.meshgrid(sides, sides))
    start = np.stack([np.full(y.shape, -50.0), y, z], axis=1)
    weights = np.full((1, len(y)), (sides[1] - sides[0]) ** 2)
    # The sum over a plane of lines is the integral over the volume: the strength of the particle.
    lines = emitree.Lines(start, (1, 0, 0), 100.0, weights)
    found = emitree.line_integrals(particles, lines, tolerance=1e-4)
    assert found.converged and found.values[0] == pytest.approx(2.0, rel=1e-3)
    grid = emitree.AmrGrid(
        [emitree.Block(level=0, lower=(0, 0, 0), upper=(1, 1, 1), values=np.full((4, 4, 4), 3.0))]
    )
    through = emitree.Lines((-5, 0.5, 0.5), (1, 0, 0), 100.0)
    assert emitree.line_integrals(grid, through).values == pytest.approx([3.0])


def test_constants_and_pickles():
    lines = emitree.Lines((0, 0, 0), (1, 0, 0), 2.0, length_unit="km")
    found = emitree.line_integrals(emitree.Expression("a * x", {"a": 3.0}), lines)
    copy = pickle.loads(pickle.dumps(found))
    assert copy.values == pytest.approx([6.0]) and repr(copy) == repr(found)
    assert repr(pickle.loads(pickle.dumps(lines))) == "<emitree.Lines in km: 1 lines>"


def test_integrals_of_zero_end():
    lines = emitree.Lines((-1, 0, 0), [(1, 0, 0), (1, 0.1, 0)], 2.0)
    for formula in ("0", "x * (r < 5)", "x^3"):
        assert emitree.line_integrals(formula, lines, tolerance=1e-6).evaluations < 10_000
    none = emitree.line_integrals("1", emitree.Lines((0, 0, 0), (1, 0, 0), 0.0))
    assert none.values.tolist() == [0.0] and none.converged and none.evaluations == 0


def test_units():
    u = pytest.importorskip("astropy.units")
    lines = emitree.Lines([0, 0, 0] * u.km, (1, 0, 0), 2000 * u.m)
    assert lines.length_unit == "km" and lines.lengths.tolist() == [2.0]
    found = emitree.line_integrals(
        lambda r, d: np.ones(len(r)) * u.Unit("W m-3"), lines, unit="W m-3"
    )
    assert found.quantity.to_value("W m-2") == pytest.approx([2000.0])
    given = emitree.line_integrals(
        lambda r, d: r[:, 0].to_value("m"), lines, quantities=True, unit="W m-3"
    )
    assert given.values == pytest.approx([2000.0])
    with pytest.raises(emitree.SceneError, match="`unit` is None"):
        _ = emitree.line_integrals("1", lines).quantity


@pytest.mark.parametrize("arguments, options, message", [
    (([0, 0], (1, 0, 0), 1), {}, r"`positions` has the shape \(2,\): expected \(n, 3\) or \(3,\)"),
    (([0, 0, np.nan], (1, 0, 0), 1), {}, r"`positions\[0\]` is \[ 0.  0. nan\]: expected finite"),
    (((0, 0, 0), [(1, 0, 0), (0, 0, 0)], 1), {}, r"`directions\[1\]` .* length above 0"),
    (((0, 0, 0), (1, 0, 0), -1), {}, r"`lengths\[0\]` is -1.0: expected 0 or more, or inf"),
    (((0, 0, 0), (1, 0, 0), "far"), {}, "`lengths` is str: expected an array"),
    ((np.zeros((2, 3)), np.ones((3, 3)), 1), {}, "`positions` 2, `directions` 3"),
    (((0, 0, 0), (1, 0, 0), 1), {"scale": 0}, r"`scale\[0\]` is 0.0"),
    (((0, 0, 0), (1, 0, 0), 1, [[1.0, 2.0]]), {}, r"`weights` has the shape \(1, 2\)"),
    (((0, 0, 0), (1, 0, 0), 1), {"groups": [[0], [1]]}, r"`groups\[1\]` is \[1\]: expected numbers of"),
    (((0, 0, 0), (1, 0, 0), 1), {"groups": [[0.0]]}, r"`groups\[0\]` is \[0.0\]: expected numbers"),
    (((0, 0, 0), (1, 0, 0), 1), {"groups": 3}, "`groups` is 3: expected a list of lists"),
    (((0, 0, 0), (1, 0, 0), 1, [[1]]), {"groups": [[0]]}, "expected one or the other"),
    (((0, 0, 0), (1, 0, 0), 1, [[np.nan]]), {}, "`weights` has numbers that are not finite"),
])  # fmt: skip
def test_lines_are_checked(arguments, options, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.Lines(*arguments, **options)


@pytest.mark.parametrize("emission, options, error, message", [
    ("1", {"tolerance": 2}, emitree.SceneError, "`tolerance` is 2: expected a number above 0"),
    ("1", {"tolerance": 0.1, "rtol": 0.1}, emitree.SceneError, "beside `rtol` or `atol`"),
    ("1", {"atol": -1}, emitree.SceneError, "`atol` is -1: expected a finite number above 0"),
    ("1", {"panels": 0}, emitree.SceneError, "`panels` is 0"),
    ("1", {"bounds": 3}, emitree.SceneError, "`bounds` is 3: expected a Sphere"),
    ("1", {"occulters": [emitree.Sphere(center=(0, 0, 0), radius=9)]}, emitree.SceneError,
     r"line 0 begins inside of `occulters\[0\]`"),
    ("1 / (x - x)", {}, emitree.EmissionError, "the rate is inf at .* on line 0"),
    (emitree.Tree("tree.fits"), {}, TypeError, "the emission is Tree: expected a function"),
    (lambda r, d: np.ones(3), {}, ValueError, r"the rates have the shape \(3,\)"),
])  # fmt: skip
def test_options_are_checked(emission, options, error, message):
    lines = emitree.Lines((-1, 0, 0), (1, 0, 0), 2)
    with pytest.raises(error, match=message):
        emitree.line_integrals(emission, lines, **options)
    with pytest.raises(TypeError, match="the lines are int"):
        emitree.line_integrals("1", 3)
