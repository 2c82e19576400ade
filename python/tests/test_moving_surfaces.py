"""Derivatives by parameters that move surfaces at which g jumps, and fits with them."""

import numpy as np
import pytest

import emitree
from emitree._clipping import divided
from emitree._image_places import image_places
from emitree._sight import View

PERSPECTIVE = emitree.Perspective(
    position=(10, 2, 1), target=(0.1, 0, 0), field_of_view=(20, 20), near=7, far=13
)
ORTHOGRAPHIC = emitree.Orthographic(
    position=(10, 2, 1), target=(0.1, 0, 0), extent=(3, 3), near=7, far=13, length_unit="km"
)
SHAPE = (24, 24)
#: Radius, centre, and the rates inside and outside.
TRUTH = np.array([1.2, 0.1, -0.05, 0.03, 2.0, 0.5])


def ball(radius, x, y, z, inside=2.0, outside=0.5):
    centre = np.array([x, y, z])
    return lambda r, d: np.where(np.linalg.norm(r - centre, axis=1) < radius, inside, outside)


def exact_image(theta, camera, lines=16):
    """Chords of many lines a pixel, weighted with their solid angles."""
    height, width = SHAPE
    places = [(np.arange(size * lines) + 0.5) / (size * lines) for size in SHAPE]
    y, x = (values.ravel() for values in np.meshgrid(*places, indexing="ij"))
    sight = View(camera, SHAPE).lines_at(x, y)
    to = theta[1:4, np.newaxis] - sight.origin
    squares = (to**2).sum(axis=0) - (to * sight.direction).sum(axis=0) ** 2
    chord = 2 * np.sqrt(np.maximum(theta[0] ** 2 - squares, 0))
    radiance = (theta[4] - theta[5]) * chord + theta[5] * (sight.far - sight.near)
    sums = [
        values.reshape(height, lines, width, lines).sum(axis=(1, 3))
        for values in (radiance * sight.density, sight.density)
    ]
    return sums[0] / sums[1]


def exact_derivative(number, camera, step=1e-3):
    moved = [TRUTH + sign * step * np.eye(6)[number] for sign in (1, -1)]
    above, below = (exact_image(theta, camera) for theta in moved)
    return (above - below) / (2 * step)


@pytest.mark.parametrize("camera", [PERSPECTIVE, ORTHOGRAPHIC])
def test_derivatives_of_a_ball(camera):
    image, derivatives = emitree.jacobian(ball, TRUTH, camera, SHAPE)
    exact = exact_image(TRUTH, camera)
    assert abs(image - exact).max() < 0.01 * exact.max()
    for number, found in enumerate(derivatives):
        expected = exact_derivative(number, camera)
        off = np.linalg.norm(found - expected) / np.linalg.norm(expected)
        assert off < 0.06, (number, off)
        # The part in the direction of the exact derivative, which is that of the step of a fit.
        assert (found * expected).sum() == pytest.approx((expected**2).sum(), rel=0.02), number


def test_the_whole_of_the_derivatives_is_that_of_the_volume():
    _, derivatives = emitree.jacobian(ball, TRUTH, ORTHOGRAPHIC, SHAPE)
    sums = derivatives.sum(axis=(1, 2)) * 9 / (SHAPE[0] * SHAPE[1])
    radius, _, _, _, inside, outside = TRUTH
    area, volume = 4 * np.pi * radius**2, 4 / 3 * np.pi * radius**3
    assert sums[0] == pytest.approx((inside - outside) * area, rel=0.01)
    assert abs(sums[1:4]).max() < 0.01 * area
    assert sums[4] == pytest.approx(volume, rel=0.01)
    assert sums[5] == pytest.approx(9 * 6 - volume, rel=0.01)


def test_units_are_those_of_the_image():
    def of(**options):
        theta = TRUTH[:4]
        return emitree.jacobian(ball, theta, ORTHOGRAPHIC, SHAPE, **options)

    plain, converted = of(), of(unit="ph cm-3 s-1 sr-1")
    # Rounding decides about samples: the surfaces are not the same.
    np.testing.assert_allclose(converted.image, 1e5 * plain.image, rtol=2e-3)
    largest = abs(plain.derivatives).max()
    assert abs(converted.derivatives / 1e5 - plain.derivatives).max() < 0.02 * largest


def test_a_derivative_of_rates_and_linear_parameters():
    def slopes(radius, x, y, z, inside, outside):
        def of(r, d):
            is_inside = np.linalg.norm(r - [x, y, z], axis=1) < radius
            zero = np.zeros(len(r))
            return np.stack([zero, zero, zero, zero, is_inside, ~is_inside], axis=1)

        return of

    differences = emitree.jacobian(ball, TRUTH, PERSPECTIVE, SHAPE).derivatives
    given = emitree.jacobian(ball, TRUTH, PERSPECTIVE, SHAPE, derivative=slopes).derivatives
    np.testing.assert_allclose(given, differences, atol=1e-9 * abs(differences).max())

    def brighter(height, radius):
        return lambda r, d: height * ball(radius, 0.1, -0.05, 0.03)(r, d)

    image, (by_height, _) = emitree.jacobian(brighter, (3.0, 1.2), PERSPECTIVE, SHAPE, linear=[0])
    np.testing.assert_array_equal(by_height, image / 3.0)


def test_a_fit_of_a_ball():
    exposure = 10.0
    counts = np.random.default_rng(1).poisson(exposure * exact_image(TRUTH, PERSPECTIVE))

    # The depth is hardly seen: it is known.
    def at_its_depth(radius, y, z):
        return ball(radius, TRUTH[1], y, z)

    forward = emitree.Forward(at_its_depth, PERSPECTIVE, SHAPE, exposure=exposure)
    fit = emitree.fit_counts(forward, counts, (1.25, -0.1, 0.08), max_images=12)
    assert fit.converged and forward.plan is None
    # The best parameters of the same counts are those of exact images.
    pull = (fit.theta - best_of(counts, exposure)) / fit.deviations
    assert abs(pull).max() < 0.3
    assert forward.evaluations < 1_000_000


@pytest.fixture(scope="module")
def data():
    """Counts of the ball, and the best radius and y of them."""
    counts = np.random.default_rng(1).poisson(10.0 * exact_image(TRUTH, PERSPECTIVE))
    return counts, best_of(counts, 10.0, (0, 2))


@pytest.mark.parametrize("first", range(0, 20, 2))
def test_starts_from_everywhere_end_at_one_place(data, first):
    def at_its_place(radius, y):
        return ball(radius, TRUTH[1], y, TRUTH[3])

    counts, best = data
    random = np.random.default_rng(7)
    starts = TRUTH[[0, 2]] + random.uniform(-0.2, 0.2, (20, 2))
    forward = emitree.Forward(at_its_place, PERSPECTIVE, SHAPE, exposure=10.0, tolerance=3e-2)
    for start in starts[first : first + 2]:
        fit = emitree.fit_counts(forward, counts, start)
        assert fit.converged and fit.images < 8
        assert (abs(fit.theta - best) < 0.3 * fit.deviations).all(), start


def best_of(counts, exposure, fitted=(0, 2, 3)):
    """The radius and the place with the least Cash statistic: by scoring of exact images."""
    theta, fitted = TRUTH.copy(), list(fitted)
    for _ in range(4):
        slopes = []
        for number in fitted:
            step = 1e-3 * np.eye(6)[number]
            above, below = (exact_image(theta + way * step, PERSPECTIVE) for way in (1, -1))
            slopes.append(exposure * (above - below).ravel() / 2e-3)
        slopes, expected = np.array(slopes), exposure * exact_image(theta, PERSPECTIVE).ravel()
        gradient = slopes @ ((counts.ravel() - expected) / expected)
        theta[fitted] += np.linalg.solve((slopes / expected) @ slopes.T, gradient)
    return theta[fitted]


def test_rendering_and_freeze_without_a_plan():
    forward = emitree.Forward(ball, PERSPECTIVE, SHAPE)
    rendering = forward.rendering(TRUTH)
    assert rendering.surfaces is not None and rendering.converged
    np.testing.assert_array_equal(forward(TRUTH), rendering.image)
    evaluations = forward.evaluations
    forward(TRUTH)
    assert forward.evaluations == evaluations
    with pytest.raises(ValueError, match="no plan to freeze"):
        forward.freeze()


def test_places_are_those_of_lines_of_sight():
    random = np.random.default_rng(2)
    fisheye = emitree.Fisheye(position=(1, 2, 3), target=(0, 0, 0), field_of_view=180, far=9)
    for camera in (PERSPECTIVE, ORTHOGRAPHIC, fisheye):
        view = View(camera, SHAPE)
        x, y = random.uniform(0.2, 0.8, (2, 50))
        lines = view.lines_at(x, y)
        distance = lines.near + 0.3 * (lines.far - lines.near)
        found = image_places(view, (lines.origin + distance * lines.direction).T)
        assert found.is_seen.all()
        np.testing.assert_allclose([found.x, found.y], [x, y], atol=1e-9)
        np.testing.assert_allclose(found.distance, distance, rtol=1e-9)


def test_parts_of_triangles_add_up():
    random = np.random.default_rng(3)
    x, y = random.uniform(0, 5, (2, 200, 3))
    found = divided(x, y, np.linspace(0, 5, 6), np.linspace(0, 5, 11))
    whole = np.bincount(found.triangle, found.part, minlength=200)
    np.testing.assert_allclose(whole, 1, atol=1e-9)
    np.testing.assert_allclose(found.centroid.sum(axis=1), 1, atol=1e-9)
    for values, lines, number in ((x, 5, found.column), (y, 10, found.row)):
        middle = (found.centroid * values[found.triangle]).sum(axis=1) * lines / 5
        assert ((middle > number - 1e-9) & (middle < number + 1 + 1e-9)).all()
        moments = np.bincount(found.triangle, found.part * middle * 5 / lines, minlength=200)
        np.testing.assert_allclose(moments, values.mean(axis=1), atol=1e-8)


@pytest.mark.parametrize("shift", [0.0, 1e-6])
def test_a_parameter_near_0(shift):
    def moved(shift):
        return ball(1.2, 0.1, -0.05 + shift, 0.03)

    found = emitree.jacobian(moved, [shift], PERSPECTIVE, SHAPE)[1][0]
    expected = exact_derivative(2, PERSPECTIVE)
    assert (found * expected).sum() == pytest.approx((expected**2).sum(), rel=0.02)


def test_a_smooth_derivative_with_a_large_step():
    # A step of 1 changes the rate by more than a quarter of the jump.
    steps = [0.01, 0.01, 0.01, 0.01, 1.0, 0.01]
    found = emitree.jacobian(ball, TRUTH, ORTHOGRAPHIC, SHAPE, difference_steps=steps)[1][4]
    expected = exact_derivative(4, ORTHOGRAPHIC)
    assert np.linalg.norm(found - expected) < 0.06 * np.linalg.norm(expected)


def test_a_medium_that_absorbs_is_refused():
    def kappa(r, d):
        return np.full(len(r), 0.3)

    with pytest.raises(ValueError, match="medium that absorbs"):
        emitree.jacobian(ball, TRUTH, ORTHOGRAPHIC, SHAPE, absorption=kappa)


def test_surfaces_that_the_first_parameters_do_not_have():
    def appearing(radius, inside):
        sharp = ball(radius, 0, 0, 0, inside, 0)
        return lambda r, d: np.exp(-(r**2).sum(axis=1)) + sharp(r, d)

    forward = emitree.Forward(
        appearing, ORTHOGRAPHIC, SHAPE, ranges=(1.0, 0.1), renewal_limit=10**7
    )
    forward((1.2, 0.0))
    with pytest.raises(emitree.RenderError, match="the rates jump at surfaces at theta"):
        forward((1.2, 2.0))
