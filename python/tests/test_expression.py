"""Expressions as models of their constants, with exact derivatives."""

import numpy as np
import pytest

import emitree

CUBE = emitree.Canonical()
SHAPE = (12, 16)
BALL = emitree.Expression(
    "h * exp(-((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2) / w^2)", constants={"h": 2.0, "w": 0.2}
)


def means(count, width):
    """The means of exp(-(t - 1/2)^2/w^2) over `count` intervals of [0, 1], by Gauss-Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    places = (np.arange(count)[:, None] + (nodes + 1) / 2) / count
    return np.exp(-(((places - 0.5) / width) ** 2)) @ weights / 2


def slopes(count, width):
    """Their derivatives by the width, by the same quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    offsets = (np.arange(count)[:, None] + (nodes + 1) / 2) / count - 0.5
    rates = np.exp(-((offsets / width) ** 2)) * 2 * offsets**2 / width**3
    return rates @ weights / 2


def exact(height, width):
    """The image, and its derivatives by height and width."""
    rows, columns, depth = (means(count, width) for count in (*SHAPE, 8))
    of_rows, of_columns, of_depth = (slopes(count, width) for count in (*SHAPE, 8))
    image = np.outer(rows, columns) * depth.mean()
    by_width = (np.outer(of_rows, columns) + np.outer(rows, of_columns)) * depth.mean()
    by_width += np.outer(rows, columns) * of_depth.mean()
    return height * image, image, height * by_width


def test_jacobian_of_an_expression():
    image, by_height, by_width = exact(2.0, 0.2)
    found = emitree.jacobian(BALL, ["h", "w"], CUBE, SHAPE, tolerance=1e-3)
    assert found.converged and max(found.estimated_errors) < 1e-3
    assert abs(found.image - image).max() < 1e-3 * image.max()
    for derivative, expected in zip(found.derivatives, (by_height, by_width), strict=True):
        assert abs(derivative - expected).max() < 1e-3 * abs(expected).max()
    alone = emitree.jacobian(BALL, "w", CUBE, SHAPE, tolerance=1e-3)
    assert alone.derivatives.shape == (1, *SHAPE)


def test_derivatives_are_exact():
    points = np.random.default_rng(3).random((500, 3))
    direction = np.tile([0.0, 0.0, 1.0], (500, 1))
    model = BALL.model()
    assert model.names == ("h", "w") and model.theta == (2.0, 0.2)
    squares = ((points - 0.5) ** 2).sum(axis=1)
    peak = np.exp(-squares / 0.04)
    np.testing.assert_allclose(model(2.0, 0.2)(points, direction), 2 * peak, rtol=1e-13)
    np.testing.assert_allclose(model(w=0.2)(points, direction), 2 * peak, rtol=1e-13)
    found = model.derivative(2.0, 0.2)(points, direction)
    expected = np.stack([peak, 2 * peak * 2 * squares / 0.2**3], axis=1)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_derivatives_with_energies():
    line = emitree.Expression("exp(-((E - e0) / 0.1)^2)", constants={"e0": 0.5}).model()
    point, energy = np.zeros((2, 3)), np.array([0.5, 0.6])
    found = line.derivative(0.5)(point, point, energy)
    np.testing.assert_allclose(found[:, 0], [0, np.exp(-1) * 2 / 0.1], rtol=1e-12, atol=1e-15)


def test_models_of_expressions_are_fitted_and_swept():
    forward = emitree.Forward(BALL.model(), CUBE, SHAPE, linear=[0])
    found = forward.jacobian((2.0, 0.2))[1]
    # It is the derivative of the images of one plan, whose error is that of the plan.
    forward.freeze()
    images = [forward((2.0, 0.2 + step)) for step in (-1e-4, 1e-4)]
    difference = (images[1] - images[0]) / 2e-4
    assert abs(found - difference).max() < 1e-5 * abs(difference).max()
    sweep = emitree.sweep(BALL.model(), {"w": [0.2, 0.21]}, CUBE, SHAPE)
    assert sweep.converged
    assert abs(sweep.images[1] - exact(2.0, 0.21)[0]).max() < 0.01 * sweep.images[1].max()


def test_errors_name_the_constant():
    with pytest.raises(emitree.SceneError, match=r"`v` is not a constant .*constants: h, w"):
        BALL.model(["h", "v"])
    with pytest.raises(emitree.SceneError, match="`h` is differentiated by twice"):
        BALL.model(["h", "h"])
    with pytest.raises(TypeError, match=r"the parameters are \['v'\]: expected h, w"):
        BALL.model()(v=1.0)
    with pytest.raises(TypeError, match="expected h"):
        BALL.model(["h"])(1.0, 2.0)
    with pytest.raises(emitree.SceneError, match="unknown name `q`"):
        emitree.Expression("q * x").model([])
    with pytest.raises(emitree.SceneError, match=r"`position` has the shape \(1, 2\)"):
        BALL.model()(2.0, 0.2)(np.zeros((1, 2)), np.zeros((1, 3)))
