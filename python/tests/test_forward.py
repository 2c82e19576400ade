"""Forward models: images, Jacobians and likelihoods of parameters, for optimizers."""

import pickle

import numpy as np
import pytest
from models import counted, torus

import emitree

CAMERA = emitree.Perspective(
    position=(6, -4, 5), target=(0, 0, 0), field_of_view=(35, 35), near=2, far=16
)
TRUTH = np.array([1.5, 0.3, 40.0, 0.3])
START = (1.3, 0.4, 30.0, 0.15)
SHAPE = (48, 48)


def slopes_of_torus(radius, width, height, tilt):
    """Its derivatives by the four parameters."""
    c, s = np.cos(tilt), np.sin(tilt)

    def slopes(position, direction):
        x, y, z = position.T
        y, z = c * y - s * z, s * y + c * z
        ring = np.hypot(x, y)
        squares = (ring - radius) ** 2 + z**2
        shape = np.exp(-squares / (2 * width**2))
        rate = height * shape
        by_tilt = 2 * (ring - radius) * y / ring * -z + 2 * z * y
        return np.stack(
            [
                rate * (ring - radius) / width**2,
                rate * squares / width**3,
                shape,
                -rate * by_tilt / (2 * width**2),
            ],
            axis=1,
        )

    return slopes


def forward_of_torus(**options):
    given = {"background": 1.0, "linear": [2], "derivative": slopes_of_torus} | options
    return emitree.Forward(torus, CAMERA, SHAPE, **given)


@pytest.fixture(scope="module")
def data():
    image = emitree.render(torus(*TRUTH), CAMERA, SHAPE, tolerance=1e-4).image
    return np.random.default_rng(1).poisson(image + 1)


def fitted(forward, start, data):
    from scipy.optimize import least_squares

    residuals, slopes = forward.cash_residuals, forward.cash_residuals_jacobian
    return least_squares(residuals, start, slopes, args=(data,), x_scale="jac").x


def deviations(forward, theta):
    """Standard deviations of the parameters, from the Fisher information."""
    slopes = forward.jacobian(theta).reshape(len(theta), -1)
    information = (slopes / forward(theta).ravel()) @ slopes.T
    return np.sqrt(np.diag(np.linalg.inv(information)))


@pytest.fixture(scope="module")
def best(data):
    """The least Cash statistic, by Fisher scoring with nine lines of sight a pixel."""
    session = emitree.Session(CAMERA, SHAPE, method="los", lines=3, tolerance=0.01)
    while points := session.ask():
        session.tell(torus(*TRUTH)(points.position, points.direction))
    plan, theta = session.mesh(), TRUTH
    for _ in range(4):
        image, slopes = emitree.jacobian(
            torus, theta, plan=plan, derivative=slopes_of_torus, linear=[2]
        )
        slopes, expected = slopes.reshape(4, -1), image.ravel() + 1
        information = (slopes / expected) @ slopes.T
        change = np.linalg.solve(information, (slopes / expected) @ (data.ravel() - expected))
        theta = theta + change
    deviation = np.sqrt(np.diag(np.linalg.inv(information)))
    assert (abs(change) < 0.01 * deviation).all()
    return theta, deviation


def test_a_fit_of_a_torus(data, best):
    forward = forward_of_torus()
    found = fitted(forward, START, data)
    theta, deviation = best
    assert (abs(found - theta) < 0.3 * deviation).all()
    # The draw itself is a little more than one standard deviation from the truth in two of four.
    assert (((found - TRUTH) / deviation) ** 2).sum() < 9.5
    assert 0 < forward.evaluations < 400_000
    image = emitree.render(torus(*found), CAMERA, SHAPE, tolerance=1e-4).image
    assert abs(forward(found) - 1 - image).max() < 0.01 * image.max()


def test_the_statistic_has_no_jitter(data):
    forward = forward_of_torus()
    forward(TRUTH)
    for radii in (1.5 + np.linspace(-0.02, 0.02, 50), 1.5 + np.linspace(-0.002, 0.002, 50)):
        statistics = [forward.cash([radius, *TRUTH[1:]], data) for radius in radii]
        cubic = np.polynomial.Polynomial.fit(radii, statistics, 3)
        assert np.std(statistics - cubic(radii)) < 1e-3
    assert forward.renewals == forward.checks == 0


@pytest.mark.parametrize("first", [0, 5, 10, 15])
def test_starts_from_everywhere_end_at_one_place(data, best, first):
    theta, deviation = best
    random = np.random.default_rng(7)
    starts = TRUTH * (1 + 0.3 * random.uniform(-1, 1, (20, 4)))
    for start in starts[first : first + 5]:
        found = fitted(forward_of_torus(), start, data)
        assert (abs(found - theta) < 0.5 * deviation).all()


def ball(height, width):
    """A Gaussian about the middle of the unit cube, a product of functions of x, y and z."""
    return lambda r, d: height * np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)


def forward_of_ball(**options):
    return emitree.Forward(ball, emitree.Canonical(), (16, 16), **options)


def test_expected_counts():
    exposure = np.linspace(1, 2, 256).reshape(16, 16)
    forward = forward_of_ball(exposure=exposure, background=3.0, tolerance=1e-3)
    image = emitree.render(ball(2, 0.2), emitree.Canonical(), (16, 16), tolerance=1e-4).image
    np.testing.assert_allclose(forward((2, 0.2)), exposure * image + 3, atol=1e-3 * 2 * image.max())
    slopes = forward.jacobian((2, 0.2))
    np.testing.assert_allclose(slopes[0], (forward((2, 0.2)) - 3) / 2, rtol=1e-6, atol=1e-9)


def test_gradients_are_those_of_the_statistics():
    forward, theta = forward_of_ball(background=0.5, linear=[0]), np.array([80.0, 0.25])
    counts = np.random.default_rng(2).poisson(forward((90.0, 0.24)))
    statistic, gradient = forward.cash_and_gradient(theta, counts)
    assert statistic == forward.cash(theta, counts)
    np.testing.assert_array_equal(gradient, forward.cash_gradient(theta, counts))
    expected = forward(theta)
    by_hand = 2 * (expected - counts * np.log(expected)).sum()
    assert abs(statistic - by_hand) < 1e-9 * abs(by_hand)
    residuals = forward.cash_residuals(theta, counts)
    constant = 2 * (counts - counts * np.log(np.maximum(counts, 1))).sum()
    assert abs((residuals**2).sum() - statistic + constant) < 1e-9 * abs(statistic)
    sigma = np.sqrt(expected)
    for number in range(2):
        step = np.zeros(2)
        step[number] = 1e-5 * theta[number]
        above, below = theta + step, theta - step
        difference = (forward.cash(above, counts) - forward.cash(below, counts)) / (
            2 * step[number]
        )
        assert abs(difference - gradient[number]) < 1e-5 * abs(gradient[number])
        for values, slopes in [
            (forward.cash_residuals, forward.cash_residuals_jacobian),
            (
                lambda t, c: forward.residuals(t, c, sigma),
                lambda t, c: forward.residuals_jacobian(t, c, sigma),
            ),
        ]:
            change = (values(above, counts) - values(below, counts)) / (2 * step[number])
            found = slopes(theta, counts)[:, number]
            np.testing.assert_allclose(found, change, atol=1e-5 * abs(change).max())


def test_pixels_that_are_not_numbers_do_not_count():
    forward = forward_of_ball(background=0.1, linear=[0])
    theta, counts = (50.0, 0.25), forward((60.0, 0.25))
    without = counts.copy()
    without[3, 4] = np.nan
    expected = forward(theta)[3, 4]
    missing = 2 * (expected - counts[3, 4] * np.log(expected))
    assert abs(forward.cash(theta, counts) - missing - forward.cash(theta, without)) < 1e-9
    for values in (forward.residuals(theta, without), forward.cash_residuals(theta, without)):
        assert values[3 * 16 + 4] == 0 and np.isfinite(values).all()
    assert np.isfinite(forward.residuals_jacobian(theta, without)).all()
    assert np.isfinite(forward.cash_residuals_jacobian(theta, without)).all()
    assert np.isfinite(forward.cash_gradient(theta, without)).all()


def test_expected_counts_that_are_not_positive():
    counts = np.ones((16, 16))
    forward = forward_of_ball(linear=[0])
    for height in (1e-12, 1.0, -1.0):
        statistic, gradient = forward.cash_and_gradient((height, 0.05), counts)
        assert np.isfinite(statistic) and np.isfinite(gradient).all()


def test_a_renewal_is_told_and_counted():
    told = []
    calls = []
    forward = emitree.Forward(
        counted(ball, calls), emitree.Canonical(), (16, 16), linear=[0],
        on_renewal=lambda theta, plan: told.append((theta, plan)),
    )  # fmt: skip
    for width in (0.3, 0.305, 0.05, 0.3):
        image = forward((2.0, width))
        finer = emitree.render(ball(2, width), emitree.Canonical(), (16, 16), tolerance=1e-4).image
        assert abs(image - finer).max() < 0.02 * finer.max()
    assert forward.renewals == len(told) == 1 and forward.checks == 1
    np.testing.assert_array_equal(told[0][0], (2.0, 0.05))
    assert forward.evaluations == sum(calls)
    assert forward.unconverged == []


def test_a_frozen_model_has_one_plan():
    forward = forward_of_ball(linear=[0])
    with pytest.raises(ValueError, match="no plan to freeze: expected an image before"):
        forward.freeze()
    image = forward((2.0, 0.3))
    assert forward.freeze() is forward and forward.frozen
    plan = forward.plan
    far = forward((2.0, 0.05))
    assert forward.plan is plan and forward.checks == forward.renewals == 0
    assert not forward.rendering((2.0, 0.05)).converged
    other = pickle.loads(pickle.dumps(forward))
    np.testing.assert_allclose(other((2.0, 0.05)), far, atol=1e-12 * abs(far).max())
    np.testing.assert_allclose(other((2.0, 0.3)), image, atol=1e-12 * abs(image).max())
    forward.thaw()((2.0, 0.05))
    assert forward.renewals == 1


def test_what_is_wrong_is_named():
    forward = forward_of_ball(bounds=[(0, None), (0.1, 0.5)])
    for theta, message in [
        ((1.0, 0.05), "parameter 1 of `theta` is 0.05: expected 0.1 to 0.5, its `bounds`"),
        ((1.0, np.inf), "parameter 1 of `theta` is inf: expected a finite number"),
        ((1.0,), "`bounds` are those of 2 parameters: expected 1"),
    ]:
        with pytest.raises(ValueError, match=message):
            forward(theta)
    with pytest.raises(ValueError, match="parameter 0 is 0 at first, and has no bounds: expected"):
        forward_of_ball()((0.0, 0.2))
    forward((1.0, 0.2))
    for act, message in [
        (lambda: forward.cash((1, 0.2), np.ones((2, 2))), r"the data have the shape \(2, 2\)"),
        (lambda: forward.cash((1, 0.2), -np.ones((16, 16))), "the counts have -1.0: expected 0 or"),
        (
            lambda: forward.residuals((1, 0.2), np.ones((16, 16)), 0),
            "`sigma` has 0.0: expected pos",
        ),
        (lambda: forward_of_ball(trust=0), "`trust` is 0: expected a positive number"),
        (lambda: forward_of_ball(bounds=[(1, 0)]), "the bounds of parameter 0 are .*low < high"),
        (lambda: forward_of_ball(ranges=[0]), "`ranges` are .*: expected a positive number"),
        (lambda: forward_of_ball(exposure=np.nan), "`exposure` is not finite"),
    ]:
        with pytest.raises(ValueError, match=message):
            act()
    with pytest.raises(TypeError, match="`model` returned 'x': expected a function"):
        emitree.Forward(lambda a: "x", emitree.Canonical(), (4, 4))((1.0,))
    limited = emitree.Forward(torus, CAMERA, SHAPE, max_evaluations=800)
    with pytest.raises(emitree.RenderError, match="the tolerance is not met at theta = "):
        limited(TRUTH)
