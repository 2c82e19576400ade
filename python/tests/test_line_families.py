"""Lines that share an image, against chords, error functions and lines one by one."""

import numpy as np
import pytest
from chords_of_lines import balls, gaussians, random_family
from models import torus

import emitree
from emitree._line_families import planes
from emitree._line_images import none_shared, shared_integrals

CAMERA = emitree.Perspective(
    position=(0, -4, 1), target=(0, 0, 0), field_of_view=(45, 35), far=np.inf
)
PARALLEL = emitree.Orthographic(
    position=(0, -4, 1), target=(0, 0, 0), extent=(4, 3), near=0, far=np.inf
)


PLANET = emitree.Sphere(center=(0, 0, 0), radius=0.7)


def beta(position, direction):
    return (1 + (position**2).sum(axis=1) / 0.09) ** -2.0


def ball(position, direction):
    return (np.linalg.norm(position, axis=1) < 1).astype(float)


def exosphere(position, direction):
    return np.exp(-4 * (np.linalg.norm(position, axis=1) - 0.7))


def distances(lines):
    """How far lines pass from the origin."""
    along = (lines.positions * lines.directions).sum(axis=1)
    return np.sqrt(np.maximum((lines.positions**2).sum(axis=1) - along**2, 0))


def chords(lines):
    """The lengths of lines in the ball."""
    nearest = -(lines.positions * lines.directions).sum(axis=1)
    half = np.sqrt(np.maximum(1 - distances(lines) ** 2, 0))
    first, last = (np.clip(nearest + side, 0, lines.lengths) for side in (-half, half))
    return last - first


def of_exosphere(lines):
    """By many panels: it is smooth up to the planet."""
    return emitree.line_integrals(exosphere, lines, tolerance=1e-5, shared=False).values


@pytest.mark.parametrize("camera", [CAMERA, PARALLEL], ids=["perspective", "orthographic"])
@pytest.mark.parametrize(
    ("emission", "counts"),
    [(torus(1.0, 0.4, 1.0, 0.5), {}), (beta, {})],
    ids=["torus", "beta"],
)
def test_lines_of_a_camera_cost_little_more_than_its_image(camera, emission, counts):
    shape = (100, 100)
    lines = camera.lines(shape)
    image = emitree.render(emission, camera, shape)
    found = emitree.line_integrals(emission, lines)
    assert found.converged and found.evaluations <= 1.5 * image.evaluations
    some = np.random.default_rng(1).choice(len(lines), 400, replace=False)
    alone = emitree.Lines(
        lines.positions[some], lines.directions[some], lines.lengths[some], scale=lines.scale[some]
    )
    truth = emitree.line_integrals(emission, alone, tolerance=1e-5)
    error = abs(found.values[some] - truth.values)
    assert error.max() <= 0.01 * truth.values.max()
    assert np.mean(error > found.error[some] + truth.error) <= 0.01


@pytest.mark.parametrize("emissions", [gaussians, balls])
@pytest.mark.parametrize("kind", ["pinhole", "parallel", "inside", "fan"])
def test_errors_are_below_the_tolerance_on_families_set_aside(emissions, kind):
    # The method was made with other seeds.
    for seed in range(4):
        rng = np.random.default_rng([20261126, seed, ord(kind[0])])
        emission, exact = emissions(rng)
        lines = random_family(rng, kind, 400)
        tolerance = [0.05, 0.01][seed % 2]
        found = emitree.line_integrals(emission, lines, tolerance=tolerance, shared=True)
        truth = exact(lines)
        error = abs(found.values - truth)
        assert found.converged and found.estimated_error <= tolerance
        assert error.max() <= tolerance * truth.max()
        assert np.mean(error > found.error + 1e-12) <= 0.01


def test_an_array_of_pinholes_has_a_family_for_each_and_other_lines_are_alone():
    rng = np.random.default_rng(3)
    pinholes = np.array([(-4, 0, 0), (0, -4, 1), (3, 3, 0)])
    count = 400
    targets = rng.uniform(-1, 1, (3, count, 3))
    directions = targets - pinholes[:, np.newaxis]
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    # Detectors lie behind the pinholes; their lines begin at a plane in front of it.
    starts = pinholes[:, np.newaxis] + rng.uniform(0.0, 1.0, (3, count, 1)) * directions
    strays = rng.normal(size=(30, 3))
    lines = emitree.Lines(
        np.concatenate([*starts, 4 * strays / np.linalg.norm(strays, axis=1)[:, np.newaxis]]),
        np.concatenate([*directions, -strays]),
        np.inf,
    )
    found = list(planes(lines))
    assert sorted(len(plane.line) for plane in found) == [count] * 3
    for plane in found:
        distance = np.linalg.norm(pinholes - np.array(plane.camera.position), axis=1)
        assert np.all(plane.line // count == np.argmin(distance)) and distance.min() < 1e-9
    # In a ball all lines of a pinhole have the same ends.
    ball = emitree.Sphere(center=(0, 0, 0), radius=2)
    emission, options = torus(0.8, 0.25, 1.0, 0.5), {"bounds": ball}
    one_by_one = emitree.line_integrals(emission, lines, **options)
    shared = emitree.line_integrals(emission, lines, shared=True, **options)
    assert shared.converged and shared.evaluations < 0.7 * one_by_one.evaluations
    error = abs(shared.values - one_by_one.values)
    assert error.max() <= 0.01 * one_by_one.values.max()
    np.testing.assert_array_equal(shared.values[-30:].shape, (30,))
    assert np.all(error <= shared.error + one_by_one.error)


def test_a_limb_scan_is_one_family():
    """A scan mirror turns lines of one place around the limb; the exosphere falls above it."""
    place = np.array([0.0, -6.0, 0.5])
    angle = np.linspace(0, 2 * np.pi, 500, endpoint=False)
    height = 1.05 + 0.3 * np.sin(7 * angle)
    targets = np.stack([height * np.cos(angle), np.zeros(500), height * np.sin(angle)], axis=1)
    lines = emitree.Lines(place, targets - place, np.inf, scale=6.0)
    planet = emitree.Sphere(center=(0, 0, 0), radius=0.7)

    def exosphere(position, direction):
        return np.exp(-4 * (np.linalg.norm(position, axis=1) - 0.7))

    options = {"tolerance": 1e-3, "occulters": [planet]}
    one_by_one = emitree.line_integrals(exosphere, lines, **options)
    shared = emitree.line_integrals(exosphere, lines, shared=True, **options)
    assert shared.converged and shared.evaluations < 0.7 * one_by_one.evaluations
    error = abs(shared.values - one_by_one.values)
    assert error.max() <= 1e-3 * one_by_one.values.max()
    # Nothing is shared unless it is asked for, but for the lines of a camera.
    assert one_by_one.evaluations >= 120 * 500


@pytest.mark.parametrize(
    ("emission", "exact", "options"),
    [
        (ball, chords, {}),
        # The limb is in front of the jump.
        (ball, chords, {"occulters": [emitree.Sphere(center=(0.4, 0.3, 0), radius=0.5)]}),
        (exosphere, of_exosphere, {"occulters": [PLANET]}),
    ],
    ids=["ball", "ball and planet", "exosphere"],
)
def test_lines_beside_jumps_and_limbs_cost_little_more_than_the_image(emission, exact, options):
    shape = (80, 80)
    lines = CAMERA.lines(shape, **options)
    image = emitree.render(emission, CAMERA, shape, **options)
    found = emitree.line_integrals(emission, lines, **options)
    assert found.converged and found.evaluations <= 1.5 * image.evaluations
    error = abs(found.values - exact(lines))
    assert error.max() <= 0.01 * found.values.max()
    assert np.mean(error > found.error + 1e-6) <= 0.01


def test_lines_that_begin_or_end_elsewhere_are_no_family():
    rng = np.random.default_rng(8)
    direction = rng.normal(size=(300, 3)) * [0.2, 0.2, 0] + [0, 0, 1]
    whole = emitree.Lines((0, 0, -3), direction, 6.0)
    uneven = emitree.Lines((0, 0, -3), direction, np.linspace(5, 6, 300))
    for lines, is_shared in ((whole, True), (uneven, False)):
        shared = emitree.line_integrals("exp(-4*r^2)", lines, shared=True)
        alone = emitree.line_integrals("exp(-4*r^2)", lines)
        assert (shared.evaluations < alone.evaluations) == is_shared
        assert abs(shared.values - alone.values).max() <= 0.01 * alone.values.max()
    # Those that pass the point that they have in common on their way.
    through = emitree.Lines(np.array([0, 0, -3]) - 2 * whole.directions, whole.directions, 8.0)
    shared = emitree.line_integrals("exp(-4*r^2)", through, shared=True)
    assert shared.evaluations == emitree.line_integrals("exp(-4*r^2)", through).evaluations


def test_errors_of_an_image_include_what_lines_contradict():
    lines = CAMERA.lines((30, 30))
    parts = np.zeros(900), np.full(900, np.inf)

    def nothing(position, direction, energy):
        return np.zeros(len(position))

    def found_with(values):
        def integrals(some, share):
            return np.full((len(some), 1), values), np.full((len(some), 1), 1e-6), 5

        return shared_integrals(
            nothing,
            lines,
            parts,
            1,
            bounds=None,
            occulters=(),
            seeds=(),
            allowed={"tolerance": 0.01},
            integrals=integrals,
            most=10**6,
        )

    assert found_with(0.0).is_known.all() and found_with(0.0).errors.max() <= 1e-6
    assert found_with(1e-3).errors.min() >= 1.9e-3
    assert not none_shared(3, 1).is_known.any()


def test_components_and_sums_share_images():
    lines = CAMERA.lines((20, 30))

    def both(position, direction):
        square = (position**2).sum(axis=1)
        return np.stack([np.exp(-2 * square), 3 * np.exp(-4 * square)], axis=1)

    found = emitree.line_integrals(both, lines, tolerance=1e-3)
    alone = emitree.line_integrals(both, lines, tolerance=1e-5, shared=False)
    assert found.converged and found.values.shape == (600, 2)
    assert found.evaluations < 0.5 * alone.evaluations
    assert (abs(found.values - alone.values).max(axis=0) <= 1e-3 * alone.values.max(axis=0)).all()
    groups = emitree.Lines(
        lines.positions, lines.directions, lines.lengths, groups=np.arange(600).reshape(60, 10)
    )
    sums = emitree.line_integrals(both, groups, tolerance=1e-3, shared=True)
    means = alone.values.reshape(60, 10, 2).mean(axis=1)
    assert sums.converged and sums.values.shape == (60, 2)
    assert (abs(sums.values - means).max(axis=0) <= 1e-3 * means.max(axis=0)).all()


def test_pixels_with_any_corners_and_pupils_are_sums_of_lines():
    """Quadrilaterals by Gauss's rule, and a pupil by places on it, share their lines' images."""
    width = 0.5
    corners = np.array(
        [
            [[-0.5, -0.4], [0.1, -0.5], [0.2, 0.3], [-0.6, 0.2]],
            [[0.1, -0.5], [0.8, -0.3], [0.7, 0.4], [0.2, 0.3]],
        ]
    )
    nodes, weights = np.polynomial.legendre.leggauss(12)
    u, v = (side.ravel() for side in np.meshgrid(0.5 + 0.5 * nodes, 0.5 + 0.5 * nodes))
    of_node = np.outer(weights, weights).ravel() / 4
    shapes = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    places = np.einsum("nk,pkc->pnc", shapes, corners)
    along_u = np.stack([-(1 - v), 1 - v, v, -v], axis=1)
    along_v = np.stack([-(1 - u), -u, u, 1 - u], axis=1)
    du, dv = (np.einsum("nk,pkc->pnc", of, corners) for of in (along_u, along_v))
    area = of_node * abs(du[..., 0] * dv[..., 1] - du[..., 1] * dv[..., 0])
    start = np.concatenate([places, np.full((*places.shape[:2], 1), -4.0)], axis=2)
    matrix = np.zeros((2, 288))
    for pixel in range(2):
        matrix[pixel, 144 * pixel :][:144] = area[pixel] / area[pixel].sum()
    lines = emitree.Lines(start.reshape(-1, 3), (0, 0, 1), 8.0, matrix)
    formula = f"exp(-r^2 / {2 * width**2})"
    found = emitree.line_integrals(formula, lines, tolerance=1e-3, shared=True)
    # The same by many midpoints, and a long line has all of the Gaussian.
    fine = (np.arange(400) + 0.5) / 400
    u, v = (side.ravel() for side in np.meshgrid(fine, fine))
    shapes = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    for pixel in range(2):
        at = shapes @ corners[pixel]
        du = np.stack([-(1 - v), 1 - v, v, -v], axis=1) @ corners[pixel]
        dv = np.stack([-(1 - u), -u, u, 1 - u], axis=1) @ corners[pixel]
        size = abs(du[:, 0] * dv[:, 1] - du[:, 1] * dv[:, 0])
        column = width * np.sqrt(2 * np.pi) * np.exp(-(at**2).sum(axis=1) / (2 * width**2))
        truth = (column * size).sum() / size.sum()
        assert abs(found.values[pixel] - truth) <= 1e-3 * found.values.max()
    assert found.converged and found.evaluations < 0.5 * 288 * 120
