"""Fields and a formula of them: values, images with closed forms, derivatives, units, messages."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import emitree

CORE, HALF = 0.4, 1.0
COUNT = 80


def column(power, square, half=HALF):
    """The integral of (CORE^2 + b^2 + s^2)^-power over s from -half to half, at squares b^2."""
    a2 = CORE**2 + square
    first = 2 * np.arctan(half / np.sqrt(a2)) / np.sqrt(a2)
    second = half / (a2 * (a2 + half**2)) + first / (2 * a2)
    if power == 2:
        return second
    assert power == 3
    return half / (2 * a2 * (a2 + half**2) ** 2) + 3 / (4 * a2) * second


def exact(power, pixels, extent):
    """Means over pixels of the integral of (1 + r^2/CORE^2)^-power through a cube."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    width = extent / pixels
    starts = -extent / 2 + width * np.arange(pixels)
    places = starts[:, None] + width * (nodes + 1) / 2
    square = places[:, :, None, None] ** 2 + places**2
    means = np.einsum("iajb,a,b->ij", column(power, square), weights / 2, weights / 2)
    return CORE ** (2 * power) * means


def cube(function, count=COUNT, **options):
    nodes = np.linspace(-HALF, HALF, count)
    at = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1)
    return emitree.Grid(values=function(at), x=nodes, y=nodes, z=nodes, **options)


def density(at):
    """A beta model with beta = 2/3."""
    return 1 / (1 + (at**2).sum(axis=-1) / CORE**2)


def camera(extent=1.2):
    return emitree.Orthographic(
        position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), extent=(extent, extent)
    )


def worst(image, expected):
    return np.abs(image - expected).max() / expected.max()


def points(count=1000, extent=1.2):
    return np.random.default_rng(3).uniform(-extent, extent, (count, 3))


def test_an_isothermal_beta_model_has_its_closed_form():
    # n^2 sqrt(T) with T = 4 is twice n^2; linear interpolation of the data errs by 0.3 % at most.
    glow = emitree.Fields(
        {"n": cube(density), "T": cube(lambda at: 0 * at[..., 0] + 4)}, "n^2*sqrt(T)"
    )
    found = emitree.render(glow, camera(), (24, 24), tolerance=0.01)
    assert found.converged
    assert worst(found.image, 2 * exact(2, 24, 1.2)) < 0.01
    # The grid of the rates themselves, by the scene's own way.
    rates = emitree.render(
        cube(lambda at: 2 * density(at) ** 2), camera(), (24, 24), tolerance=0.01
    )
    assert worst(found.image, rates.image) < 0.02
    assert found.evaluations < 2 * rates.evaluations


def test_a_table_of_temperature_has_its_closed_form():
    # Lambda = 5 T, exact in logarithms, and T falls as n does: 5 (1 + r^2/CORE^2)^-3.
    cooling = emitree.Table([5e-3, 50], {"T": [1e-3, 10]}, logarithmic=["T", "values"])
    n = cube(density)
    glow = emitree.Fields({"n": n, "T": n}, "n^2*Lambda(T)", tables={"Lambda": cooling})
    found = emitree.render(glow, camera(), (24, 24), tolerance=0.01)
    assert worst(found.image, 5 * exact(3, 24, 1.2)) < 0.01


def test_a_spectrum_of_fields_has_its_closed_form():
    glow = emitree.Fields(
        {"n": cube(density), "T": cube(lambda at: 0 * at[..., 0] + 2)}, "n^2*exp(-E/T)/sqrt(T)"
    )
    energy = emitree.Energies(min=0.5, max=3.5, bins=3, unit="keV")
    found = emitree.render(glow, camera(), (16, 16), energy=energy, tolerance=0.01)
    edges = np.linspace(0.5, 3.5, 4)
    of_bins = 2 * (np.exp(-edges[:-1] / 2) - np.exp(-edges[1:] / 2)) / np.sqrt(2)
    expected = of_bins[:, None, None] * exact(2, 16, 1.2)
    assert worst(found.image, expected) < 0.01


def test_grids_amr_and_functions_in_one_formula():
    def linear(at):
        return 3 + at @ np.array([1.0, -0.5, 0.25])

    centres = np.linspace(-HALF, HALF, 17)
    centres = (centres[1:] + centres[:-1]) / 2
    at = np.stack(np.meshgrid(centres, centres, centres, indexing="ij"), axis=-1)
    block = emitree.Block(0, (-1, -1, -1), (1, 1, 1), linear(at))
    fields = {"n": cube(linear, 5), "T": emitree.AmrGrid([block]), "v": lambda at: at[:, 2]}
    glow = emitree.Fields(fields, "a*n*T + v*dz", {"a": 2.0})
    assert glow.names == ("n", "T", "v")
    at = points(extent=0.9)
    directions = np.tile([0.0, 0.6, -0.8], (len(at), 1))
    expected = 2 * linear(at) ** 2 - 0.8 * at[:, 2]
    np.testing.assert_allclose(glow(at, directions), expected, rtol=1e-12)
    at = points()
    outside = (np.abs(at) > 1).any(axis=1)
    assert outside.any()
    np.testing.assert_array_equal(glow(at, directions[: len(at)])[outside], 0.0)
    values = glow.values(at)
    np.testing.assert_array_equal(np.isnan(values["n"]), outside)
    np.testing.assert_array_equal(np.isnan(values["T"]), outside)
    np.testing.assert_array_equal(values["v"], at[:, 2])
    assert glow.bounds == emitree.Box(min=(-1, -1, -1), max=(1, 1, 1))


def test_outside_of_the_data_the_formula_has_no_effect():
    n = cube(density, 9)
    glow = emitree.Fields({"n": n}, "1/n + 3")
    assert glow(np.array([[2.0, 0, 0], [0, 0, 0]])).tolist() == [0.0, 4.0]
    strict = emitree.Fields({"n": cube(density, 9, outside="error")}, "n")
    with pytest.raises(
        emitree.EmissionError, match=r"the field `n`: the position \[2.0, 0.0, 0.0\]"
    ):
        strict(np.array([[2.0, 0, 0]]))


def test_spherical_fields_begin_and_end_at_spheres():
    r, theta = np.geomspace(1, 4, 30), np.linspace(0, np.pi, 9)
    values = np.broadcast_to(r[:, None, None] ** -2.0, (30, 9, 1))
    n = emitree.Grid(values=values, r=r, theta=theta, phi=[0.0], angle_unit="rad", logarithmic="r")
    glow = emitree.Fields({"n": n}, "n^2")
    assert glow.bounds == emitree.Sphere(center=(0, 0, 0), radius=4)
    assert glow.edges == [emitree.Sphere(center=(0, 0, 0), radius=1)]
    view = emitree.Orthographic(position=(-50, 0, 0), target=(0, 0, 0), extent=(6, 6))
    sun = emitree.Sphere(center=(0, 0, 0), radius=1)
    found = emitree.render(glow, view, (16, 16), occulters=[sun], tolerance=0.01)
    # n is linear in ln r between 30 nodes: 0.06 % from r^-2 at most, and n^2 0.12 %.
    nodes, weights = np.polynomial.legendre.leggauss(6)
    places = (np.arange(16)[:, None] + (nodes + 1) / 2) * 6 / 16 - 3
    b = np.hypot(places[:, :, None, None], places)
    half = np.sqrt(16 - np.minimum(b, 3.99) ** 2)
    # The integral of (b^2 + s^2)^-2 up to the sphere of radius 4.
    along = half / (b**2 * 16) + np.arctan(half / b) / b**3
    means = np.einsum("iajb,a,b->ij", along, weights / 2, weights / 2)
    clear = (b.min(axis=(1, 3)) > 1) & (b.max(axis=(1, 3)) < 3.9)  # of limbs
    assert clear.sum() > 100
    assert worst(found.image[clear], means[clear]) < 0.01


def test_lengths_and_units_of_quantities():
    u = pytest.importorskip("astropy.units")
    nodes = np.linspace(-1000, 1000, 5) * u.m
    values = np.full((5, 5, 5), 2.0) / u.cm**3
    grid = emitree.Grid(values=values, x=nodes, y=nodes, z=nodes)
    own = emitree.Fields({"n": grid}, "n^2")
    view = emitree.Orthographic(
        position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), extent=(1, 1), length_unit="km"
    )
    assert emitree.render(own, view, (2, 2)).image == pytest.approx(4 * 2, rel=0.01)
    in_metres = emitree.Fields({"n": grid}, "n^2", units={"n": "m-3"})
    assert emitree.render(in_metres, view, (2, 2)).image == pytest.approx(4e12 * 2, rel=0.01)
    with pytest.raises(emitree.SceneError, match="`units` has 'm': expected fields, n"):
        emitree.Fields({"n": grid}, "n", units={"m": "m-3"})


def test_data_arrays_are_fields():
    xarray = pytest.importorskip("xarray")
    nodes = np.linspace(-1, 1, 5)
    at = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1)
    data = xarray.DataArray(
        at @ [1.0, 2, 3], dims=("x", "y", "z"), coords=dict.fromkeys("xyz", nodes)
    )
    glow = emitree.Fields({"n": data.transpose("z", "x", "y"), "T": data}, "n - T + 1")
    np.testing.assert_allclose(glow(points(extent=1)), 1.0, atol=1e-12)


def test_constants_are_parameters_with_exact_derivatives():
    glow = emitree.Fields({"n": cube(density, 9)}, "a*n^b", {"a": 2.0, "b": 1.5})
    model = glow.model(["a", "b"])
    assert model.theta == (2.0, 1.5)
    at = points(extent=0.9)
    n = glow.values(at)["n"]
    np.testing.assert_allclose(model(3.0, 2.0)(at), 3 * n**2, rtol=1e-12)
    expected = np.stack([n**2, 3 * n**2 * np.log(n)], axis=1)
    np.testing.assert_allclose(
        model.derivative(3.0, 2.0)(at, None), expected, rtol=1e-11, atol=1e-14
    )
    image, by = emitree.jacobian(model, [2.0, 1.5], camera(), (6, 6), tolerance=0.01)
    # The image is proportional to a.
    np.testing.assert_allclose(by[0], image / 2, rtol=0.02)


def test_pickles_and_line_integrals():
    glow = emitree.Fields(
        {"n": cube(density, 9)}, "f(n)", tables={"f": emitree.Table([0.0, 2], {"n": [0, 1]})}
    )
    at = points()
    before = glow(at)
    again = pickle.loads(pickle.dumps(glow))
    np.testing.assert_array_equal(again(at), before)
    lines = emitree.Lines([[0.0, 0.0, 5.0]], [[0.0, 0.0, -1.0]], 10.0)
    total = emitree.line_integrals(glow, lines, tolerance=1e-3).values[0]
    # Along the line of nodes the rate is linear between them: the trapezoidal rule is exact.
    nodes = np.linspace(-HALF, HALF, 9)
    along = density(np.stack([0 * nodes, 0 * nodes, nodes], axis=1))
    exact_total = 2 * 0.25 * (along.sum() - (along[0] + along[-1]) / 2)
    assert total == pytest.approx(exact_total, rel=1e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: emitree.Fields(["n"], "n"), "`fields` is list: expected a dictionary"),
        (lambda: emitree.Fields({"n": 3}, "n"), "the field `n` is int: expected an emitree.Grid"),
        (lambda: emitree.Fields({"n": len}, "rho"), "`expression`: unknown name `rho`"),
        (lambda: emitree.Fields({"r": len}, "r"), "the field `r` has the name of a variable"),
        (lambda: emitree.Fields({"n": len}, "f(n)"), "unknown function `f`"),
        (
            lambda: emitree.Fields({"n": len}, "f(n)", tables={"f": len}),
            "the table `f` is builtin_function_or_method: expected emitree.Table",
        ),
        (
            lambda: emitree.Fields({"n": emitree.Grid(values=np.ones((2, 2)), x=(0, 1))}, "n")(
                points(1)
            ),
            r"the field `n`: `values` has the shape \(2, 2\)",
        ),
        (
            lambda: emitree.Fields({"n": emitree.Grid(file="no.npz")}, "n")(points(1)),
            "the field `n`: the grid .*no.npz: it can't be read",
        ),
    ],
)
def test_messages_name_the_field(make, message):
    with pytest.raises(emitree.SceneError, match=message):
        make()


def test_values_of_functions_are_checked():
    glow = emitree.Fields({"n": lambda at: at}, "n")
    with pytest.raises(ValueError, match=r"the field `n`: the values have the shape \(4, 3\)"):
        glow(points(4))


def test_the_example_of_the_guide():
    guide = Path(__file__).parents[2] / "docs" / "guide.md"
    section = guide.read_text(encoding="utf-8").split("#### `emission.fields`")[1]
    names = {}
    exec(section.split("```python")[1].split("```")[0], names)
    rendering = names["rendering"]
    assert rendering.converged
    # The tolerance, and 1 % of linear interpolation at the centre of the data.
    assert worst(rendering.image, 36 * exact(3, 24, 1.0)) < 0.02


def test_arrays_beyond_the_memory_are_refused():
    xarray = pytest.importorskip("xarray")
    large = np.broadcast_to(1.0, (100_000, 100_000, 1000))
    nodes = {"x": np.arange(100_000.0), "y": np.arange(100_000.0), "z": np.arange(1000.0)}
    data = xarray.DataArray(large, dims=("x", "y", "z"), coords=nodes)
    with pytest.raises(emitree.SceneError, match="takes 160000000000000 bytes of memory"):
        emitree.Fields({"n": data}, "n")(points(1))


def test_steps_of_files(tmp_path):
    nodes = np.linspace(-1, 1, 3)
    values = np.arange(4.0)[:, None, None, None] + np.zeros((4, 3, 3, 3))
    axes = dict.fromkeys("xyz", nodes)
    np.savez(tmp_path / "run.npz", rho=values, t=[0.0, 1.0, 5.0, 7.0], **axes)
    given = {"file": tmp_path / "run.npz", "variable": "rho"}
    for step, expected in [(1, 1.0), (-1, 3.0), ({"value": 5.5, "axis": "t"}, 2.0)]:
        glow = emitree.Fields({"n": emitree.Grid(**given, step=step)}, "n")
        assert glow(np.zeros((1, 3))).tolist() == [expected]
        image = emitree.render(emitree.Grid(**given, step=step), camera(1.0), (2, 2)).image
        assert image == pytest.approx(2 * expected, rel=0.01)
    with pytest.raises(emitree.SceneError, match="or `step`, which chooses one of the 4 along"):
        emitree.render(emitree.Grid(**given), camera(1.0), (2, 2))
    with pytest.raises(
        emitree.SceneError, match="`step` is for files: expected none with an array"
    ):
        emitree.Grid(values=values[0], step=1)
