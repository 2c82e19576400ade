"""Plans: linear maps with fixed points, their transposes, their files, and derivatives on them."""

import copy
import math
import pickle
import sys

import numpy as np
import pytest
from models import counted, peak, torus

import emitree

CUBE = emitree.Canonical()


def ball(height, width):
    """A Gaussian about the middle of the unit cube."""

    def rate(position, direction):
        return height * np.exp(-((position - 0.5) ** 2).sum(axis=1) / width**2)

    return rate


def exact_ball(height, width, pixels):
    """Its image, and the derivative by the width: products of error functions."""

    def means(w, cells):
        edges = np.arange(cells + 1) / cells - 0.5
        primitive = [0.5 * math.sqrt(math.pi) * w * math.erf(edge / w) for edge in edges]
        return np.diff(primitive) * cells

    def slopes(w, cells):
        edges = np.arange(cells + 1) / cells - 0.5
        primitive = [
            0.5 * math.sqrt(math.pi) * math.erf(edge / w) - edge / w * math.exp(-((edge / w) ** 2))
            for edge in edges
        ]
        return np.diff(primitive) * cells

    rows, row_slopes = means(width, pixels), slopes(width, pixels)
    depth, depth_slope = means(width, 1)[0], slopes(width, 1)[0]
    image = rows[:, None] * rows * depth
    slope = row_slopes[:, None] * rows * depth + rows[:, None] * row_slopes * depth
    return height * image, height * (slope + rows[:, None] * rows * depth_slope)


def shell(radius, width):
    """A shell with a dent: no product of functions of x, y and z."""

    def rate(position, direction):
        x, y, z = (position - 0.5).T
        return np.exp(-((np.sqrt(x**2 + y**2 + 2 * z**2) - radius) ** 2) / (2 * width**2)) * (1 + x)

    return rate


@pytest.fixture(scope="module")
def plan():
    return emitree.render(shell(0.25, 0.08), CUBE, (12, 16)).plan


@pytest.mark.parametrize("method", ["vol", "paper", "los"])
def test_a_plan_gives_the_image_of_its_rendering(method):
    rendering = emitree.render(peak, CUBE, (8, 12), method=method)
    plan = rendering.plan
    assert plan.shape == rendering.image.shape and len(plan) == len(plan.positions)
    assert plan.directions.shape == (len(plan), 3) and plan.energies is None
    np.testing.assert_allclose(plan.apply(plan.rates(peak)), rendering.image, rtol=1e-11)


def test_it_is_linear(plan):
    one, two = np.random.default_rng(1).normal(size=(2, len(plan)))
    both = plan.apply(np.stack([one, two, 2 * one - 3 * two], axis=1))
    assert both.shape == (3, 12, 16)
    np.testing.assert_array_equal(both[0], plan.apply(one))
    np.testing.assert_allclose(both[2], 2 * both[0] - 3 * both[1], atol=1e-12 * abs(both).max())


def test_the_adjoint_is_the_transpose(plan):
    random = np.random.default_rng(2)
    rates, image = random.normal(size=len(plan)), random.normal(size=plan.shape)
    left = (plan.apply(rates) * image).sum()
    scale = np.linalg.norm(plan.apply(rates)) * np.linalg.norm(image)
    assert abs(left - rates @ plan.adjoint(image)) < 1e-12 * scale
    matrix = plan.matrix()
    assert matrix.shape == (12 * 16, len(plan)) and plan.matrix() is matrix
    np.testing.assert_allclose(matrix @ rates, plan.apply(rates).ravel(), atol=1e-13 * scale)
    np.testing.assert_allclose(matrix.T @ image.ravel(), plan.adjoint(image), atol=1e-13 * scale)


def test_pixels_without_an_image_count_as_0():
    camera = emitree.Fisheye(position=(0, 0, 0), target=(1, 0, 0), field_of_view=120, far=4)
    rendering = emitree.render("exp(-r^2)", camera, (8, 8), method="los", lines=1, steps=6)
    plan = rendering.plan
    rates = np.exp(-(plan.positions**2).sum(axis=1))
    missing = np.isnan(rendering.image)
    assert missing.any()
    np.testing.assert_array_equal(np.isnan(plan.apply(rates)), missing)
    ones = np.ones(plan.shape)
    np.testing.assert_array_equal(plan.adjoint(np.where(missing, 5.0, 1.0)), plan.adjoint(ones))
    vector = plan.operator.matvec(rates)
    np.testing.assert_allclose(vector, np.nan_to_num(plan.apply(rates)).ravel(), rtol=1e-12)


def test_the_operator_solves_with_lsmr():
    from scipy.sparse.linalg import lsmr

    plan = emitree.render(peak, CUBE, (6, 6), method="los", lines=1, steps=4).plan
    image = plan.apply(plan.rates(peak))
    found = lsmr(plan.operator, image.ravel(), atol=1e-12, btol=1e-12, maxiter=500)[0]
    # The solution of least norm, from the pseudo-inverse.
    expected = np.linalg.pinv(plan.matrix().toarray()) @ image.ravel()
    np.testing.assert_allclose(found, expected, atol=1e-8 * abs(expected).max())


def test_another_emission_at_the_same_points(plan):
    other = shell(0.252, 0.08)
    rendering = plan.render(other)
    assert rendering.converged and rendering.estimated_error < 0.01
    assert np.array_equal(rendering.plan.positions, plan.positions)
    np.testing.assert_allclose(rendering.image, plan.apply(plan.rates(other)), rtol=1e-11)
    finer = emitree.render(other, CUBE, (12, 16), tolerance=1e-4).image
    assert abs(rendering.image - finer).max() < 0.01 * finer.max()


def test_points_that_do_not_suffice(plan):
    other = shell(0.33, 0.08)
    fixed, refined = plan.render(other), plan.refine(other)
    finer = emitree.render(other, CUBE, (12, 16), tolerance=1e-4).image
    assert not fixed.converged
    assert abs(fixed.image - finer).max() <= fixed.estimated_error * finer.max()
    assert refined.converged
    assert abs(refined.image - finer).max() < 0.01 * finer.max()
    again = refined.plan.apply(refined.plan.rates(other))
    np.testing.assert_allclose(again, refined.image, atol=1e-11 * finer.max())


def test_a_cube_with_units_and_quantities():
    units = pytest.importorskip("astropy.units")
    camera = emitree.Perspective(
        position=(3, 0, 0),
        target=(0, 0, 0),
        field_of_view=(20, 20),
        near=2,
        far=4,
        length_unit="km",
    )

    def rate(position, direction, energy):
        size = (position.to_value("km") ** 2).sum(axis=1)
        return np.exp(-size - energy.to_value("keV")) * units.Unit("cm-3 s-1 sr-1 keV-1")

    rendering = emitree.render(
        rate, camera, (4, 6), energy=emitree.Energies(1, 2, 3), unit="cm-3 s-1 sr-1 keV-1",
        quantities=True,
    )  # fmt: skip
    plan = rendering.plan
    assert plan.shape == (3, 4, 6) and plan.energies.shape == (len(plan),)
    np.testing.assert_allclose(plan.apply(plan.rates(rate)), rendering.image, rtol=1e-11)


def test_a_file_has_all_but_the_setup(plan, tmp_path):
    path = tmp_path / "plan.npz"
    plan.save(path)
    loaded = emitree.Plan.load(path)
    random = np.random.default_rng(3)
    rates, image = random.normal(size=len(plan)), random.normal(size=plan.shape)
    largest = abs(plan.apply(rates)).max()
    for other in (loaded, pickle.loads(pickle.dumps(plan)), pickle.loads(pickle.dumps(loaded))):
        assert (len(other), other.shape) == (len(plan), plan.shape)
        np.testing.assert_array_equal(other.positions, plan.positions)
        np.testing.assert_allclose(other.apply(rates), plan.apply(rates), atol=1e-12 * largest)
        np.testing.assert_array_equal(other.adjoint(image), plan.adjoint(image))
        assert (other.matrix() != plan.matrix()).nnz == 0
        np.testing.assert_allclose(
            other.operator.matvec(rates), plan.operator.matvec(rates), atol=1e-12 * largest
        )
        for act in (other.render, other.refine):
            with pytest.raises(ValueError, match=r"does not contain how .* expected one of"):
                act(peak)
        with pytest.raises(ValueError, match="expected `matrix` instead"):
            _ = other.weights
    with pytest.raises(FileExistsError):
        plan.save(path)
    plan.save(path, overwrite=True)
    assert copy.copy(plan) is plan and copy.deepcopy(plan) is plan


def test_wrong_files_are_named(plan, tmp_path):
    path = tmp_path / "plan.npz"
    with pytest.raises(FileNotFoundError, match=r"plan\.npz"):
        emitree.Plan.load(path)
    for content in (b"", b"no archive", b"PK\x03\x04 damaged"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"plan\.npz: not a file of NumPy.*expected a plan"):
            emitree.Plan.load(path)
    with path.open("wb") as file:
        np.save(file, np.ones(3))
    with pytest.raises(ValueError, match=r"plan\.npz: an array: expected a plan"):
        emitree.Plan.load(path)
    np.savez(path, something=1)
    with pytest.raises(ValueError, match=r"plan\.npz: the `format` is None: expected a plan"):
        emitree.Plan.load(path)
    plan.save(path, overwrite=True)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **arrays | {"version": 2})
    with pytest.raises(ValueError, match="a plan of version 2: expected version 1 to 1"):
        emitree.Plan.load(path)
    np.savez(path, **{name: array for name, array in arrays.items() if name != "data"})
    with pytest.raises(ValueError, match="a plan without `data`: expected a complete file"):
        emitree.Plan.load(path)
    np.savez(path, **arrays | {"position": arrays["position"][:5]})
    with pytest.raises(ValueError, match="the arrays of the plan do not agree"):
        emitree.Plan.load(path)


def test_what_is_wrong_is_named(plan, monkeypatch):
    with pytest.raises(ValueError, match=r"the rates have the shape \(1,\): expected \(\d+,\)"):
        plan.apply([1.0])
    with pytest.raises(ValueError, match=r"`image` has the shape \(2, 2\): expected \(12, 16\)"):
        plan.adjoint(np.ones((2, 2)))
    with pytest.raises(TypeError, match="the emission is '1 \\+ x': expected a function"):
        plan.rates("1 + x")
    rendering = emitree.render(peak, CUBE, (4, 4))
    with pytest.raises(ValueError, match="has no plan: it was pickled or copied; expected"):
        _ = pickle.loads(pickle.dumps(rendering)).plan
    monkeypatch.setitem(sys.modules, "scipy.sparse", None)
    with pytest.raises(ImportError, match=r"scipy is missing: expected .*emitree\[fit\]"):
        rendering.plan.matrix()


def test_no_plan_of_found_surfaces():
    def ball(position, direction):
        return np.where(np.linalg.norm(position - 0.5, axis=1) < 0.3, 2.0, 0.5)

    rendering = emitree.render(ball, CUBE, (32, 32))
    assert rendering.surfaces is not None
    with pytest.raises(ValueError, match="has no plan: its image is that of surfaces"):
        _ = rendering.plan


def test_the_former_names():
    assert emitree.Mesh is emitree.Plan


@pytest.mark.parametrize("derivative", ["differences", "function"])
def test_derivatives_of_a_gaussian(derivative):
    theta, options = (2.0, 0.2), {"tolerance": 1e-4}
    image, slope = exact_ball(*theta, 16)

    def slopes(height, width):
        def of_rate(position, direction):
            squares = ((position - 0.5) ** 2).sum(axis=1)
            rate = np.exp(-squares / width**2)
            return np.stack([rate, height * rate * 2 * squares / width**3], axis=1)

        return of_rate

    given = slopes if derivative == "function" else None
    found, derivatives = emitree.jacobian(
        ball, theta, CUBE, (16, 16), derivative=given, linear=[0], **options
    )
    assert abs(found - image).max() < 1e-4 * image.max()
    assert abs(derivatives[0] - image / 2).max() < 1e-4 * image.max()
    assert abs(derivatives[1] - slope).max() < 1e-3 * slope.max()


def test_derivatives_by_jax():
    jax = pytest.importorskip("jax")

    def model(height, width):
        def rate(position, direction):
            squares = ((position - 0.5) ** 2).sum(axis=1)
            return height * jax.numpy.exp(-squares / width**2)

        return rate

    image, slope = exact_ball(2.0, 0.2, 16)
    found, derivatives = emitree.jacobian(
        model, (2.0, 0.2), CUBE, (16, 16), derivative="jax", tolerance=1e-4
    )
    assert abs(found - image).max() < 1e-4 * image.max()
    assert abs(derivatives[0] - image / 2).max() < 1e-4 * image.max()
    assert abs(derivatives[1] - slope).max() < 1e-3 * slope.max()


def test_a_given_plan_is_the_only_mesh():
    plan = emitree.render(ball(1.0, 0.2), CUBE, (8, 8), method="los", lines=2, steps=32).plan
    calls = []
    image, derivatives = emitree.jacobian(counted(ball, calls), (2.0, 0.2), plan=plan, linear=[0])
    # The image, and two for the difference by the width.
    assert calls == [len(plan)] * 3
    np.testing.assert_allclose(derivatives[0], image / 2, rtol=1e-12)
    moved = [plan.apply(plan.rates(ball(2.0, 0.2 + step))) for step in (1e-5, -1e-5)]
    np.testing.assert_allclose(derivatives[1], (moved[0] - moved[1]) / 2e-5, rtol=1e-6, atol=1e-8)
    zero, derivatives = emitree.jacobian(ball, (0.0, 0.2), plan=plan, linear=[0])
    assert not zero.any()
    np.testing.assert_allclose(derivatives[0], image / 2, rtol=1e-12)


def test_what_is_wrong_with_derivatives_is_named(plan):
    def wrong(height, width):
        return lambda position, direction: np.ones((len(position), 3))

    for arguments, error, message in [
        ({"theta": [[1.0]]}, ValueError, r"`theta` has the shape \(1, 1\): expected \(p,\)"),
        ({"theta": (1, np.nan)}, ValueError, "parameter 1 of `theta` is nan: expected a finite"),
        ({"plan": None}, TypeError, "expected `camera` and `shape`, or a `plan`"),
        ({"camera": CUBE}, TypeError, "`camera` is given beside a `plan`"),
        ({"derivative": "torch"}, ValueError, "`derivative` is 'torch': expected a function"),
        ({"derivative": wrong}, ValueError, r"have the shape \(\d+, 3\): expected \(\d+, 2\)"),
        (
            {"difference_steps": [1.0]},
            ValueError,
            r"`difference_steps` have the shape \(1,\): expected \(2,\)",
        ),
        ({"steps": [1.0, 1.0]}, TypeError, "expected `difference_steps`, as `steps` is an option"),
        ({"linear": [2]}, ValueError, "`linear` has the parameter 2: expected 0 to 1"),
        ({"model": lambda a, b: "x"}, TypeError, "`model` returned 'x': expected a function"),
    ]:
        given = {"model": ball, "theta": (1.0, 0.2), "plan": plan} | arguments
        with pytest.raises(error, match=message):
            emitree.jacobian(**given)


def test_estimated_errors_of_derivatives():
    camera = emitree.Perspective(
        position=(6, -4, 5), target=(0, 0, 0), field_of_view=(35, 35), near=2, far=16
    )
    theta = (1.5, 0.3, 40.0, 0.3)
    found = emitree.jacobian(torus, theta, camera, (12, 12), linear=[2])
    lines = {"method": "los", "steps": 100, "lines": 8}
    finer = emitree.jacobian(torus, theta, camera, (12, 12), linear=[2], **lines)
    assert found.converged and finer.converged is None
    assert finer.estimated_errors == [None] * 4
    for slope, exact, error in zip(
        found.derivatives, finer.derivatives, found.estimated_errors, strict=True
    ):
        assert error <= 0.01
        assert abs(slope - exact).max() < 0.01 * abs(exact).max()
    again = pickle.loads(pickle.dumps(found))
    assert (again.converged, again.estimated_errors) == (True, found.estimated_errors)
    np.testing.assert_array_equal(again.image, found.image)


def moving(place, width):
    """A Gaussian: the functions of its derivatives by both parameters differ along x alone."""

    def rate(position, direction):
        x, y, z = position.T
        return np.exp(-((x - place) ** 2 + (y - 0.5) ** 2 + (z - 0.5) ** 2) / width**2)

    return rate


def test_derivatives_that_a_plan_does_not_serve_are_told():
    theta = (0.4, 0.15)
    found = emitree.jacobian(moving, theta, CUBE, (16, 16))
    finer = emitree.jacobian(moving, theta, CUBE, (16, 16), method="los", steps=200, lines=2)
    exact = finer.derivatives
    wrong = [abs(a - b).max() / abs(b).max() for a, b in zip(found.derivatives, exact, strict=True)]
    # No points are found that serve both derivatives, and the result says so.
    assert max(wrong) > 0.01 and found.converged is False
    assert max(found.estimated_errors) > 0.01
    served = [error <= 0.01 for error in found.estimated_errors]
    assert all(error <= 0.01 for error, is_good in zip(wrong, served, strict=True) if is_good)
