"""Plans as functions of PyTorch tensors: the same images, and derivatives by the rates.

Tensors are on a GPU where PyTorch has one. PyTorch is not among the packages of `requirements.txt`,
as it is far larger than all of them together.
"""

import numpy as np
import pytest
from models import torus
from plans import KINDS, norm, plan_of, random_image, random_rates

torch = pytest.importorskip("torch", reason="torch is missing: it is optional, and large")

# PyTorch 2.11 itself uses what it calls deprecated, in derivatives of forward mode.
pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script:DeprecationWarning")

DEVICE = "cuda" if torch.cuda.is_available() else "cpu"
#: Rounding of sums of thousands of terms of both signs, relative to the norm of an image.
ROUNDING = 1e-13


def tensor(array, **options):
    """A tensor on the device, in 64 bits unless it is to have another type."""
    return torch.tensor(np.asarray(array), device=DEVICE, **{"dtype": torch.float64, **options})


def numbers(found):
    """A tensor as an array."""
    return found.detach().cpu().numpy()


@pytest.mark.parametrize("kind", KINDS)
def test_images_and_gradients_are_those_of_the_plan(kind):
    plan = plan_of(kind)
    rates, weights = random_rates(plan), random_image(plan)
    given = tensor(rates, requires_grad=True)
    expected, image = plan.apply(rates), plan.apply(given)
    assert (image.dtype, image.device) == (torch.float64, given.device)
    scale = norm(plan, expected)
    np.testing.assert_allclose(numbers(image), expected, atol=ROUNDING * scale, rtol=0)
    torch.nansum(tensor(weights) * image).backward()
    gradient, adjoint = numbers(given.grad), plan.adjoint(weights)
    size = np.linalg.norm(adjoint)
    np.testing.assert_allclose(gradient, adjoint, atol=ROUNDING * size, rtol=0)
    product = np.nansum(weights * expected)
    assert abs(product - gradient @ rates) < ROUNDING * scale * norm(plan, weights)


@pytest.mark.parametrize("kind", ["cells", "bins"])
def test_numerical_derivatives(kind):
    plan = plan_of(kind)
    # A few numbers by which the rates depend on random directions.
    directions = tensor(random_rates(plan, (4,)))
    given = tensor([0.3, -0.2, 0.5, 0.1], requires_grad=True)

    def image(parameters):
        return plan.apply(directions @ parameters)

    assert torch.autograd.gradcheck(image, given)
    assert torch.autograd.gradgradcheck(lambda parameters: image(parameters) ** 2, given)


@pytest.mark.parametrize("kind", ["products", "trees", "lines"])
def test_several_columns_and_tangents(kind):
    plan = plan_of(kind)
    rates = random_rates(plan, (3,))
    images = plan.apply(rates)
    scale = {"atol": ROUNDING * norm(plan, images), "rtol": 0}
    np.testing.assert_allclose(numbers(plan.apply(tensor(rates))), images, **scale)
    forward = torch.autograd.forward_ad
    with forward.dual_level():
        given = forward.make_dual(tensor(rates[:, 0]), tensor(rates[:, 1]))
        image, tangent = forward.unpack_dual(plan.apply(given))
        tangent = numbers(tangent)
    np.testing.assert_allclose(numbers(image), images[0], **scale)
    seen = ~np.isnan(images[1])
    np.testing.assert_allclose(tangent[seen], images[1][seen], **scale)


def test_a_gradient_by_parameters_is_that_of_differences():
    plan = plan_of("products")
    data = tensor(plan.apply(plan.rates(torus(1.45, 0.31, 1.1, 0.33))))
    x, y, z = tensor(plan.positions).T

    def chi_squared(theta):
        radius, width, height, tilt = theta
        across = torch.cos(tilt) * y - torch.sin(tilt) * z
        above = torch.sin(tilt) * y + torch.cos(tilt) * z
        squares = (torch.hypot(x, across) - radius) ** 2 + above**2
        return ((plan.apply(height * torch.exp(-squares / (2 * width**2))) - data) ** 2).sum()

    theta = tensor([1.5, 0.3, 1.0, 0.3], requires_grad=True)
    (gradient,) = torch.autograd.grad(chi_squared(theta), theta)
    for number, step in enumerate(1e-5 * numbers(theta)):
        moved = np.zeros(4)
        moved[number] = step
        above, below = (chi_squared(theta.detach() + sign * tensor(moved)) for sign in (1, -1))
        difference = (above - below).item() / (2 * step)
        assert abs(difference - gradient[number].item()) < 1e-6 * abs(gradient).max().item()


def test_the_precision_is_that_of_the_rates():
    plan = plan_of("products")
    rates = plan.rates(torus(1.5, 0.3, 1.0, 0.3))
    exact = plan.apply(rates)
    for dtype, error in [(torch.float32, 2e-6), (torch.bfloat16, 0.1)]:
        image = plan.apply(tensor(rates, dtype=dtype))
        assert image.dtype == torch.float32
        assert abs(numbers(image) - exact).max() < error * exact.max()
    whole = plan.apply(torch.ones(len(plan), dtype=torch.int64, device=DEVICE))
    assert whole.dtype == torch.float32


def test_gradients_do_not_pass_pixels_without_an_image():
    plan = plan_of("lines")
    rates = plan.rates(lambda r, d: np.exp(-(r**2).sum(axis=1)))
    given = tensor(rates, requires_grad=True)
    image = plan.apply(given)
    assert torch.isnan(image).any()
    torch.nansum(image**2).backward()
    expected = plan.adjoint(2 * np.nan_to_num(numbers(image)))
    np.testing.assert_allclose(
        numbers(given.grad), expected, atol=ROUNDING * np.linalg.norm(expected)
    )


def test_what_is_wrong_is_named():
    plan = plan_of("lines")
    for shape in [(1,), (len(plan), 2, 2), ()]:
        with pytest.raises(ValueError, match=r"the rates have the shape .*: expected \(\d+,\)"):
            plan.apply(torch.zeros(shape))
    with pytest.raises(TypeError, match=r"the rates are of type torch\.complex64: expected real"):
        plan.apply(torch.zeros(len(plan), dtype=torch.complex64))
