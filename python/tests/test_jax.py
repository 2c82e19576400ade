"""Plans as functions of JAX arrays: the same images, and derivatives by the rates.

Arrays are on the default device of JAX: these tests check a GPU where JAX has one.
"""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from models import torus
from plans import CAMERA, KINDS, norm, plan_of, random_image, random_rates

import emitree

jax = pytest.importorskip("jax", reason="jax is missing: see requirements.txt")
jnp = jax.numpy

#: Rounding of sums of thousands of terms of both signs, relative to the norm of an image.
ROUNDING = 1e-13


@pytest.fixture
def in_64_bits():
    with jax.enable_x64(True):
        yield


def torus_of(radius, width, height, tilt):
    """The torus of `models`, in JAX."""

    def rate(position, direction):
        x, y, z = position.T
        y, z = jnp.cos(tilt) * y - jnp.sin(tilt) * z, jnp.sin(tilt) * y + jnp.cos(tilt) * z
        ring = jnp.hypot(x, y)
        return height * jnp.exp(-((ring - radius) ** 2 + z**2) / (2 * width**2))

    return rate


@pytest.mark.parametrize("kind", KINDS)
def test_images_and_gradients_are_those_of_the_plan(kind, in_64_bits):
    plan = plan_of(kind)
    rates, weights = random_rates(plan), random_image(plan)
    given = jnp.asarray(rates)
    expected, image = plan.apply(rates), plan.apply(given)
    assert isinstance(image, jax.Array) and image.dtype == jnp.float64
    assert image.devices() == given.devices()
    scale = norm(plan, expected)
    np.testing.assert_allclose(image, expected, atol=ROUNDING * scale, rtol=0)
    gradient = jax.grad(lambda rates: jnp.nansum(weights * plan.apply(rates)))(given)
    adjoint = plan.adjoint(weights)
    size = np.linalg.norm(adjoint)
    np.testing.assert_allclose(gradient, adjoint, atol=ROUNDING * size, rtol=0)
    product = np.nansum(weights * expected)
    assert abs(product - gradient @ given) < ROUNDING * scale * norm(plan, weights)


@pytest.mark.parametrize("kind", ["products", "trees", "lines"])
def test_transformations(kind, in_64_bits):
    plan = plan_of(kind)
    rates = jnp.asarray(random_rates(plan, (3,)))
    images = plan.apply(np.asarray(rates))
    scale = {"atol": ROUNDING * norm(plan, images), "rtol": 0}
    np.testing.assert_allclose(plan.apply(rates), images, **scale)
    np.testing.assert_allclose(jax.jit(plan.apply)(rates), images, **scale)
    np.testing.assert_allclose(jax.vmap(plan.apply)(rates.T), images, **scale)
    vectorized = jax.jit(jax.vmap(plan.apply, in_axes=1))
    np.testing.assert_allclose(vectorized(rates), images, **scale)
    image, tangent = jax.jvp(plan.apply, (rates[:, 0],), (rates[:, 1],))
    np.testing.assert_allclose(image, images[0], **scale)
    seen = ~np.isnan(images[1])
    np.testing.assert_allclose(tangent[seen], images[1][seen], **scale)
    transpose = jax.linear_transpose(plan.apply, rates[:, 0])
    weights = random_image(plan)
    adjoint = plan.adjoint(weights)
    found = jax.jit(lambda image: transpose(image)[0])(jnp.asarray(weights))
    np.testing.assert_allclose(found, adjoint, atol=ROUNDING * norm(plan, adjoint), rtol=0)


def chi_squared_of(plan, data):
    """The sum of squares of a torus as a function of its parameters."""
    position, direction = jnp.asarray(plan.positions), jnp.asarray(plan.directions)

    def chi_squared(theta):
        image = plan.apply(torus_of(*theta)(position, direction))
        return ((image - data) ** 2).sum()

    return chi_squared


def test_a_gradient_by_parameters_is_that_of_differences(in_64_bits):
    plan = plan_of("products")
    data = jnp.asarray(plan.apply(plan.rates(torus(1.45, 0.31, 1.1, 0.33))))
    chi_squared = jax.jit(chi_squared_of(plan, data))
    theta = jnp.array([1.5, 0.3, 1.0, 0.3])
    gradient = jax.grad(chi_squared)(theta)
    for number, step in enumerate(1e-5 * theta):
        moved = jnp.zeros(4).at[number].set(step)
        difference = (chi_squared(theta + moved) - chi_squared(theta - moved)) / (2 * step)
        # The error of central differences is the square of the relative step, and rounding.
        assert abs(difference - gradient[number]) < 1e-6 * abs(gradient).max()
    # The Jacobian of the image agrees with that by forward differentiation on the same points.
    image = jax.jacfwd(lambda theta: plan.apply(torus_of(*theta)(plan.positions, None)))(theta)
    _, slopes = emitree.jacobian(torus_of, theta, plan=plan, derivative="jax")
    scale = ROUNDING * np.linalg.norm(slopes)
    np.testing.assert_allclose(np.moveaxis(image, -1, 0), slopes, atol=scale, rtol=0)


def test_the_precision_is_that_of_the_rates():
    plan = plan_of("products")
    rates = plan.rates(torus(1.5, 0.3, 1.0, 0.3))
    exact = plan.apply(rates)
    for given, error in [
        (jnp.asarray(rates), 2e-6),
        (jnp.asarray(rates, dtype=jnp.bfloat16), 0.1),
    ]:
        image = plan.apply(given)
        assert image.dtype == jnp.float32
        assert abs(image - exact).max() < error * exact.max()
    whole = plan.apply(jnp.ones(len(plan), dtype=int))
    ones = plan.apply(np.ones(len(plan)))
    np.testing.assert_allclose(whole, ones, atol=2e-6 * abs(ones).max())
    with jax.enable_x64(True):
        assert plan.apply(jnp.asarray(rates)).dtype == jnp.float64


def test_gradients_do_not_pass_pixels_without_an_image(in_64_bits):
    plan = plan_of("lines")
    rates = jnp.asarray(plan.rates(lambda r, d: np.exp(-(r**2).sum(axis=1))))
    image = plan.apply(rates)
    assert np.isnan(image).any()
    gradient = jax.grad(lambda rates: jnp.nansum(plan.apply(rates) ** 2))(rates)
    expected = plan.adjoint(2 * np.nan_to_num(image))
    np.testing.assert_allclose(gradient, expected, atol=ROUNDING * np.linalg.norm(expected))


def test_first_use_within_a_transformation_leaves_the_plan_usable(in_64_bits):
    plan = pickle.loads(pickle.dumps(plan_of("products")))
    rates = jnp.asarray(random_rates(plan))
    image = jax.jit(plan.apply)(rates)
    gradient = jax.jit(jax.grad(lambda rates: plan.apply(rates).sum()))(rates)
    scale = ROUNDING * norm(plan, image)
    np.testing.assert_allclose(plan.apply(rates), image, atol=scale)
    np.testing.assert_allclose(plan_of("products").apply(rates), image, atol=scale)
    np.testing.assert_allclose(gradient, plan.adjoint(np.ones(plan.shape)), rtol=1e-9)
    for other in (copy.copy(plan), pickle.loads(pickle.dumps(plan))):
        np.testing.assert_allclose(other.apply(rates), image, atol=scale)


def test_arrays_stay_on_their_device(in_64_bits):
    plan = plan_of("products")
    rates = jnp.asarray(random_rates(plan))
    with jax.transfer_guard_device_to_host("disallow"):
        image = plan.apply(rates)
    compiled = jax.jit(plan.apply).lower(rates).compile()
    with jax.transfer_guard("disallow"):
        again = compiled(rates)
    scale = ROUNDING * norm(plan, image)
    np.testing.assert_allclose(image, again, atol=scale)
    # On each device the same function gives the same bits.
    np.testing.assert_array_equal(image, plan.apply(rates))
    for device in jax.devices():
        there = plan.apply(jax.device_put(rates, device))
        assert there.devices() == {device}


def test_the_error_of_the_image_is_that_of_the_rendering():
    rendering = emitree.render(torus(1.5, 0.3, 1.0, 0.3), CAMERA, (20, 24))
    finer = emitree.render(torus(1.5, 0.3, 1.0, 0.3), CAMERA, (20, 24), tolerance=1e-5).image
    plan = rendering.plan
    image = plan.apply(torus_of(1.5, 0.3, 1.0, 0.3)(jnp.asarray(plan.positions), None))
    assert abs(image - finer).max() < 0.01 * finer.max()


def test_what_is_wrong_is_named():
    plan = plan_of("lines")
    for shape in [(1,), (len(plan), 2, 2), ()]:
        with pytest.raises(ValueError, match=r"the rates have the shape .*: expected \(\d+,\)"):
            plan.apply(jnp.zeros(shape))
    with pytest.raises(TypeError, match="the rates are of type complex64: expected real numbers"):
        plan.apply(jnp.zeros(len(plan), dtype=jnp.complex64))


def test_the_example_of_the_guide():
    guide = Path(__file__).parents[2] / "docs" / "guide.md"
    section = guide.read_text(encoding="utf-8").split("#### Derivatives by JAX or PyTorch")[1]
    names = {}
    exec(section.split("```python")[1].split("```")[0], names)
    chi_squared, gradient = names["chi_squared"], names["gradient"]
    theta = np.array([1.5, 0.3, 40.0])
    for number in range(3):
        step = np.zeros(3)
        step[number] = 1e-3 * theta[number]
        above, below = (float(chi_squared(theta + sign * step)) for sign in (1, -1))
        difference = (above - below) / (2 * step[number])
        # In 32 bits.
        assert abs(difference - gradient[number]) < 1e-2 * abs(gradient[number])
