"""Published models as functions, and with derivatives by their parameters."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.special import gamma

import emitree

CAMERA = emitree.Orthographic(
    position=(9, 0, 0), target=(0, 0, 0), extent=(4, 4), near=-np.inf, far=np.inf
)
NEAR = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), extent=(4, 4), far=18)
SHAPE = (12, 16)
CLUSTER = emitree.Model("beta_model", amplitude=2.0, core_radius=0.7, beta=0.8)


def points(count=200, scale=2.0):
    generator = np.random.default_rng(5)
    position = scale * (generator.random((count, 3)) * 2 - 1)
    direction = np.tile([0.6, 0.0, -0.8], (count, 1))
    return position, direction


def radiances(amplitude, core_radius, beta, nodes=12):
    """The exact image of the cluster, by Gauss-Legendre over pixels of its closed form.

    amplitude sqrt(pi) Gamma(3 beta - 1/2) / Gamma(3 beta) rc (1 + b^2/rc^2)^(1/2 - 3 beta)
    """
    places, weights = np.polynomial.legendre.leggauss(nodes)

    def along(count, extent):
        edges = (np.arange(count)[:, None] + (places + 1) / 2) / count
        return extent * (edges - 0.5)

    x, y = along(SHAPE[1], 4.0), along(SHAPE[0], 4.0)
    squares = x[None, :, None, :] ** 2 + y[:, None, :, None] ** 2
    factor = amplitude * np.sqrt(np.pi) * gamma(3 * beta - 0.5) / gamma(3 * beta) * core_radius
    values = factor * (1 + squares / core_radius**2) ** (0.5 - 3 * beta)
    return np.einsum("ijkl,k,l->ij", values, weights, weights) / 4


def exact_derivatives(theta, step=1e-5):
    """Differences of the exact image, with an error of about 1e-10."""
    found = []
    for number in range(len(theta)):
        above, below = np.array(theta), np.array(theta)
        above[number] += step
        below[number] -= step
        found.append((radiances(*above) - radiances(*below)) / (2 * step))
    return np.array(found)


def test_a_model_is_a_function():
    position, direction = points()
    squares = (position**2).sum(axis=1)
    expected = 2 * (1 + squares / 0.49) ** -2.4
    np.testing.assert_allclose(CLUSTER(position, direction), expected, rtol=1e-13)
    hot = emitree.Model("bremsstrahlung")
    energy = np.linspace(1, 8, len(position))
    assert (hot(position, direction, energy) > 0).all()
    with pytest.raises(emitree.SceneError, match=r"`bremsstrahlung` depends on the energy, and"):
        hot(position, direction)


def test_derivatives_are_limits_of_differences():
    position, direction = points()
    model = CLUSTER.model(["core_radius", "beta", "centre_x"])
    theta = np.array(model.theta)
    assert model.theta == (0.7, 0.8, 0.0) and model.moves_jumps == ()
    found = model.derivative(*theta)(position, direction)
    for number, name in enumerate(model.names):
        step = 1e-5
        above, below = theta.copy(), theta.copy()
        above[number] += step
        below[number] -= step
        difference = (model(*above)(position, direction) - model(*below)(position, direction)) / (
            2 * step
        )
        assert abs(found[:, number] - difference).max() < 1e-8 * abs(difference).max(), name
    named = model.derivative(core_radius=0.7)(position, direction)
    np.testing.assert_array_equal(named, found)


def test_jacobian_of_a_model():
    names = ["amplitude", "core_radius", "beta"]
    found = emitree.jacobian(CLUSTER, names, CAMERA, SHAPE, tolerance=1e-3)
    theta = (2.0, 0.7, 0.8)
    image = radiances(*theta)
    assert abs(found.image - image).max() < 1e-3 * image.max()
    derivatives = zip(
        found.derivatives, exact_derivatives(theta), found.estimated_errors, strict=True
    )
    for derivative, exact, estimated in derivatives:
        error = abs(derivative - exact).max() / abs(exact).max()
        assert error < 1e-3 and error < estimated < 4e-3
    alone = emitree.jacobian(CLUSTER, "beta", CAMERA, SHAPE, tolerance=1e-3)
    assert alone.derivatives.shape == (1, *SHAPE)


def test_a_model_is_fitted_with_its_derivatives():
    data = emitree.render(CLUSTER, CAMERA, SHAPE, tolerance=1e-3).image
    model = CLUSTER.model()
    assert model.names == ("amplitude", "core_radius", "beta")
    forward = emitree.Forward(model, CAMERA, SHAPE, linear=[0], tolerance=1e-3)
    start = (1.5, 0.6, 0.7)
    found = least_squares(
        forward.residuals, start, forward.residuals_jacobian, args=(data,), x_scale="jac"
    )
    assert abs(found.x / np.array(model.theta) - 1).max() < 5e-3
    # The derivatives are those of the images of one plan.
    forward.freeze()
    theta = found.x
    derivatives, evaluations = forward.jacobian(theta), forward.evaluations
    points_of_plan = len(forward.plan)
    forward.jacobian(theta * (1 + 1e-9))
    # One image, and one evaluation with all derivatives at each point.
    assert forward.evaluations - evaluations == 2 * points_of_plan
    for number in (1, 2):
        step = 1e-4
        above, below = theta.copy(), theta.copy()
        above[number] += step
        below[number] -= step
        difference = (forward(above) - forward(below)) / (2 * step)
        assert abs(derivatives[number] - difference).max() < 1e-6 * abs(difference).max()


def test_parameters_that_move_jumps_are_refused():
    shell = emitree.Model("power_law", exponent=3.0, inner_radius=0.5)
    names = ["exponent", "inner_radius"]
    assert shell.model(names).moves_jumps == ("inner_radius",)
    with pytest.raises(ValueError, match="jump at a surface that moves with `inner_radius`"):
        emitree.jacobian(shell, names, CAMERA, SHAPE)
    model = shell.model(names)
    smooth = emitree.jacobian(
        model, model.theta, CAMERA, SHAPE, derivative=model.derivative, tolerance=0.1
    )
    assert not smooth.derivatives[1].any() and smooth.derivatives[0].any()
    forward = emitree.Forward(model, CAMERA, SHAPE, tolerance=0.1)
    forward(model.theta)
    with pytest.raises(ValueError, match="moves with `inner_radius`"):
        forward.jacobian(model.theta)
    assert emitree.Model("cmem").model(["A1", "beta"]).moves_jumps == ()
    assert emitree.Model("cmem").model(["A1", "density"]).moves_jumps == ("density",)


def test_models_are_taken_where_functions_are():
    alone = emitree.render(CLUSTER, CAMERA, SHAPE, tolerance=1e-3)
    both = emitree.render({"hot": CLUSTER, "x": "exp(-r^2)"}, CAMERA, SHAPE, tolerance=1e-3)
    assert abs(both["hot"].image - alone.image).max() < 2e-3 * alone.image.max()
    # A model alone is rendered by the library itself, not by calls.
    assert alone.scene.startswith('[emission]\nmodel = "beta_model"')
    plan = alone.plan
    np.testing.assert_allclose(plan.apply(plan.rates(CLUSTER)), alone.image, rtol=1e-12)
    lines = NEAR.lines(SHAPE)
    found = emitree.line_integrals(CLUSTER, lines, tolerance=1e-3)
    expected = emitree.line_integrals(lambda r, d: CLUSTER(r, d), lines, tolerance=1e-3)
    np.testing.assert_array_equal(found.values, expected.values)


def test_the_length_unit_is_that_of_the_model():
    wind = emitree.Model("jorgensen", bow_shock_r0=14.0)
    assert wind.length_unit == "R_E" and CLUSTER.length_unit is None
    camera = emitree.Orthographic(
        position=(0, 30, 0), target=(0, 0, 0), extent=(20, 20), far=60, length_unit="km"
    )
    message = "the length unit of the camera is `km`, and that of the model `jorgensen` is `R_E`"
    with pytest.raises(emitree.SceneError, match=message):
        emitree.jacobian(wind, ["A1"], camera, SHAPE)
    with pytest.raises(emitree.SceneError, match=message):
        emitree.Forward(wind.model(["A1"]), camera, SHAPE)
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render([wind, "x"], camera, SHAPE)
    with pytest.raises(emitree.SceneError, match=message):
        emitree.line_integrals([wind, wind], camera.lines(SHAPE))
    with pytest.raises(emitree.SceneError, match=message):
        emitree.sensitivity(wind, camera, SHAPE)
    with pytest.raises(emitree.SceneError, match=message):
        emitree.sweep(wind.model(["A1"]), {"A1": [1.0, 2.0]}, camera, SHAPE)
    plan = emitree.render(lambda r, d: np.exp(-(r**2).sum(axis=1)), camera, SHAPE).plan
    with pytest.raises(emitree.SceneError, match=message):
        emitree.jacobian(wind, ["A1"], plan=plan)


def test_errors_name_the_parameter():
    with pytest.raises(emitree.SceneError, match="`holmstrom` has no parameter `width`"):
        emitree.Model("holmstrom").model(["width"])
    with pytest.raises(emitree.SceneError, match="`alpha` of model `holmstrom` is differentiated"):
        emitree.Model("holmstrom").model(["alpha", "alpha"])
    with pytest.raises(emitree.SceneError, match="unknown model `cmen`: did you mean `cmem`"):
        emitree.Model("cmen").model([])
    with pytest.raises(TypeError, match=r"the parameters are \['v'\]: expected alpha"):
        emitree.Model("holmstrom").model(["alpha"])(v=1.0)
    with pytest.raises(emitree.SceneError, match=r"`position` has the shape \(1, 2\)"):
        CLUSTER(np.zeros((1, 2)), np.zeros((1, 3)))


def test_grids_are_taken_where_functions_are():
    nodes = np.linspace(-2, 2, 41)
    x, y, z = np.meshgrid(nodes, nodes, nodes, indexing="ij")
    grid = emitree.Grid(
        values=np.exp(-(x**2) - y**2 - 2 * z**2),
        x=(-2, 2),
        y=(-2, 2),
        z=(-2, 2),
        interpolation="cubic",
    )
    position, direction = points(scale=3.0)
    inside = (abs(position) <= 2).all(axis=1)
    rates = grid(position, direction)
    expected = np.exp(-(position**2) @ [1, 1, 2])
    assert abs(rates - expected)[inside].max() < 1e-3 and not rates[~inside].any()
    both = emitree.render([grid, "exp(-r^2)"], NEAR, SHAPE)
    alone = emitree.render(grid, NEAR, SHAPE)
    assert alone.scene.startswith("[emission]\ngrid = ")
    assert abs(both[0].image - alone.image).max() < 0.02 * alone.image.max()
    plan = alone.plan
    np.testing.assert_allclose(plan.apply(plan.rates(grid)), alone.image, rtol=1e-9, atol=1e-12)
    lines = NEAR.lines(SHAPE, bounds=emitree.Box(min=(-2, -2, -2), max=(2, 2, 2)))
    found = emitree.line_integrals(grid, lines, tolerance=1e-3)
    exact = emitree.line_integrals("exp(-x^2 - y^2 - 2*z^2)", lines, tolerance=1e-3)
    assert abs(found.values - exact.values).max() < 3e-3 * exact.values.max()
