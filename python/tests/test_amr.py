"""Nested blocks of cells: the interpolant, images of it, units, and messages."""

import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import emitree
from emitree import _amr_lattice

SIGMA = 0.3
CENTRE = np.array([0.03, -0.07, 0.05])


def ball(position):
    """A Gaussian ball."""
    return np.exp(-(((position - CENTRE) / SIGMA) ** 2).sum(axis=-1) / 2)


def linear(position):
    return 1 + position @ np.array([1.0, -2.0, 3.0])


def centres(lower, upper, shape):
    axes = [
        low + (np.arange(n) + 0.5) * (high - low) / n
        for low, high, n in zip(lower, upper, shape, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def block(level, lower, upper, shape, rate=ball):
    return emitree.Block(level, lower, upper, rate(centres(lower, upper, shape)))


def two_levels(cells, rate=ball, **options):
    """A cube from -2 to 2, and within it one from -1 to 1 with cells of half the size."""
    coarse = block(0, (-2, -2, -2), (2, 2, 2), (cells,) * 3, rate)
    fine = block(1, (-1, -1, -1), (1, 1, 1), (cells,) * 3, rate)
    return emitree.AmrGrid([coarse, fine], **options)


def leaves(rate=ball, **options):
    """The same without coarse cells under fine ones, in many blocks of both levels."""
    found = []
    for at in np.ndindex(4, 4, 4):
        lower = np.array(at) - 2.0
        is_fine = np.all((lower >= -1) & (lower < 1))
        found.append(
            block(int(is_fine), lower, lower + 1, (8, 8, 8) if is_fine else (4, 4, 4), rate)
        )
    return emitree.AmrGrid(found[::-1], **options)


def points(extent, count=2000):
    return np.random.default_rng(1).uniform(-extent, extent, (count, 3))


# -- The interpolant.


@pytest.mark.parametrize("make", [lambda: two_levels(16, linear), lambda: leaves(linear)])
def test_linear_data_are_exact_across_all_borders(make):
    # Half a coarse cell from the end of the data, the rate is constant along an axis.
    inside = points(2 - 0.125)
    np.testing.assert_allclose(make()(inside), linear(inside), rtol=1e-12, atol=1e-12)


def test_centres_of_cells_have_their_values_and_the_outside_has_none():
    grid = two_levels(8)
    inner = centres((-1, -1, -1), (1, 1, 1), (8, 8, 8)).reshape(-1, 3)
    np.testing.assert_allclose(grid(inner), ball(inner), rtol=1e-13)
    coarse = centres((-2, -2, -2), (2, 2, 2), (8, 8, 8)).reshape(-1, 3)
    coarse = coarse[np.abs(coarse).max(axis=1) > 1]
    np.testing.assert_allclose(grid(coarse), ball(coarse), rtol=1e-13)
    just_outside = np.array([[2.0, 0, 0], [-2.0001, 0, 0], [0, 0, 1e300]])
    assert np.array_equal(grid(just_outside), np.zeros(3))
    assert np.array_equal(grid(np.empty((0, 3))), np.empty(0))


def test_the_rate_is_constant_beyond_the_last_centres():
    grid = two_levels(8, linear)
    np.testing.assert_allclose(
        grid(np.array([[1.99, 0.1, 0.1]])), grid(np.array([[1.75, 0.1, 0.1]]))
    )


def test_blocks_of_one_level_are_as_one_block():
    whole = emitree.AmrGrid([block(3, (-2, -2, -2), (2, 2, 2), (16, 16, 16))])
    parts = [
        block(3, lower, lower + 1, (4, 4, 4)) for lower in np.array(list(np.ndindex(4, 4, 4))) - 2.0
    ]
    at = points(2.1)
    np.testing.assert_allclose(emitree.AmrGrid(parts)(at), whole(at), rtol=1e-13, atol=1e-16)
    # Overlaps with the same values are no contradiction.
    twice = [*parts, block(3, (-1.5, -1.5, -1), (1, 1, 1.5), (10, 10, 10))]
    np.testing.assert_allclose(emitree.AmrGrid(twice)(at), whole(at), rtol=1e-13, atol=1e-16)


def test_overlaps_under_finer_blocks_do_not_matter():
    fine = block(1, (-1, -1, -1), (1, 1, 1), (8, 8, 8))
    left = block(0, (-2, -2, -2), (1, 2, 2), (6, 8, 8))
    right = block(0, (-1, -2, -2), (2, 2, 2), (6, 8, 8))
    at = points(2.1)
    for blocks in ([left, right, fine], [fine, right, left]):
        found = emitree.AmrGrid(blocks)(at)
        np.testing.assert_allclose(found, two_levels(8)(at), rtol=1e-13, atol=1e-16)


def test_values_under_finer_blocks_do_not_matter():
    fine = block(1, (-1, -1, -1), (1, 1, 1), (8, 8, 8))
    rates = ball(centres((-2, -2, -2), (2, 2, 2), (8, 8, 8)))
    rates[2:6, 2:6, 2:6] = 1e9
    grid = emitree.AmrGrid([fine, emitree.Block(0, (-2, -2, -2), (2, 2, 2), rates)])
    at = points(2.1)
    assert np.array_equal(grid(at), two_levels(8)(at))
    # Leaves alone give the same means to the coarse cells around.
    np.testing.assert_allclose(leaves()(at), two_levels(16)(at), rtol=1e-12, atol=1e-15)


def jump(cells):
    """The largest jump at the border of the levels."""
    y, z = np.random.default_rng(2).uniform(-1, 1, (2, 4000))
    sides = [np.stack([np.full(4000, 1 + shift), y, z], axis=1) for shift in (-1e-9, 1e-9)]
    grid = two_levels(cells)
    return np.abs(grid(sides[0]) - grid(sides[1])).max()


def test_errors_and_jumps_are_of_second_order():
    at = points(2, 20000)
    errors = [np.sqrt(np.mean((two_levels(cells)(at) - ball(at)) ** 2)) for cells in (32, 64)]
    assert 3.7 < errors[0] / errors[1] < 4.3
    jumps = [jump(cells) for cells in (32, 64)]
    assert jumps[0] < 1e-3 and 3.7 < jumps[0] / jumps[1] < 4.3


# -- Quadratic splines.


@pytest.mark.parametrize("make", [two_levels, lambda cells, rate, **given: leaves(rate, **given)])
def test_quadratic_splines_are_exact_for_linear_data(make):
    # The rate is constant in the outer half of the outermost cells, which bends two more cells.
    inside = points(2 - 0.7)
    found = make(16, linear, interpolation="quadratic")(inside)
    np.testing.assert_allclose(found, linear(inside), rtol=1e-12, atol=1e-12)


def test_quadratic_splines_are_exact_for_quadratic_data_in_a_block():
    def rate(position):
        x, y, z = np.moveaxis(position, -1, 0)
        return 20 + x * x - y * z + 3 * y * y + z - x * z

    one = emitree.AmrGrid(
        [block(0, (-2, -2, -2), (2, 2, 2), (16,) * 3, rate)], interpolation="quadratic"
    )
    inside = points(2 - 0.7)
    np.testing.assert_allclose(one(inside), rate(inside), rtol=1e-12)
    just_outside = np.array([[2.0, 0, 0], [-2.0001, 0, 0], [0, 0, 1e300]])
    assert np.array_equal(one(just_outside), np.zeros(3))


def test_errors_of_quadratic_splines_are_of_third_order_and_jumps_of_second():
    at = points(2, 20000)
    grids = [two_levels(cells, interpolation="quadratic") for cells in (32, 64)]
    errors = [np.sqrt(np.mean((grid(at) - ball(at)) ** 2)) for grid in grids]
    assert errors[0] < 2e-4 and errors[0] / errors[1] > 7
    y, z = np.random.default_rng(2).uniform(-1, 1, (2, 4000))
    sides = [np.stack([np.full(4000, 1 + shift), y, z], axis=1) for shift in (-1e-9, 1e-9)]
    jumps = [np.abs(grid(sides[0]) - grid(sides[1])).max() for grid in grids]
    assert jumps[0] < 1e-3 and jumps[0] / jumps[1] > 3.7


def test_slopes_of_quadratic_splines_are_continuous_in_a_level():
    blocks = [
        block(3, lower, lower + 1, (4, 4, 4)) for lower in np.array(list(np.ndindex(4, 4, 4))) - 2.0
    ]
    grid = emitree.AmrGrid(blocks, interpolation="quadratic")
    # At borders of cells, some of them of blocks.
    at = points(1.5, 500)
    at[:, 0] = np.round(at[:, 0] * 4) / 4
    step = np.array([1e-5, 0, 0])
    before, after = (grid(at) - grid(at - step)) / 1e-5, (grid(at + step) - grid(at)) / 1e-5
    assert np.abs(before - after).max() < 1e-3 * np.abs(before).max()


def test_quadratic_splines_of_rates_above_zero_are_not_negative():
    def step(position):
        return np.where(position[..., 0] < 0, 0.0, 1.0)

    at = points(2)
    grid = two_levels(16, step, interpolation="quadratic")
    assert grid(at).min() == 0 and 1.05 < grid(at).max() < 1.25
    lower = two_levels(16, lambda position: step(position) - 1, interpolation="quadratic")
    assert -1.25 < lower(at).min() < -1.05


def test_the_image_of_a_quadratic_spline_costs_what_that_of_the_function_costs():
    camera = orthographic((2, -1.5, 1), 2)
    box = emitree.Box(min=(-2, -2, -2), max=(2, 2, 2))
    smooth = emitree.render(lambda r, d: ball(r), camera, (24, 24), bounds=box)
    spline, linear = (
        emitree.render(two_levels(32, interpolation=name), camera, (24, 24))
        for name in ("quadratic", "linear")
    )
    evaluations = [found.evaluations for found in (smooth, spline, linear)]
    assert evaluations == [8330, 8343, 9607]
    assert np.abs(spline.image - smooth.image).max() < 0.01 * smooth.image.max()


def test_ratios_may_differ_by_axis_and_exceed_two():
    coarse = block(0, (0, 0, 0), (4, 4, 4), (4, 8, 4), linear)
    fine = block(2, (1, 1, 1), (3, 2, 3), (8, 2, 6), linear)
    grid = emitree.AmrGrid([coarse, fine])
    at = 0.5 + np.random.default_rng(3).uniform(0, 3, (500, 3))
    np.testing.assert_allclose(grid(at), linear(at), rtol=1e-12)


def test_long_axes_are_searched(monkeypatch):
    at = points(2.1)
    expected = two_levels(8)(at)
    of_leaves = leaves()(at)
    monkeypatch.setattr(_amr_lattice, "_MOST_CELLS", 4)
    assert np.array_equal(two_levels(8)(at), expected)
    assert np.array_equal(leaves()(at), of_leaves)


def test_arrays_of_any_kind_are_the_same():
    rates = np.rint(100 * ball(centres((-2, -2, -2), (2, 2, 2), (8, 8, 8))))
    at, box = points(2), ((-2, -2, -2), (2, 2, 2))
    expected = emitree.AmrGrid([emitree.Block(0, *box, rates)])(at)
    for change in (
        np.asfortranarray,
        np.float32,
        np.uint8,
        np.ndarray.tolist,
        np.ma.masked_invalid,
    ):
        found = emitree.AmrGrid([emitree.Block(np.int64(0), *box, change(rates))])(at)
        np.testing.assert_array_equal(found, expected)


def test_grids_are_pickled():
    grid = two_levels(8)
    assert np.array_equal(pickle.loads(pickle.dumps(grid))(points(2)), grid(points(2)))


# -- Images.


def axes_of(view):
    """The direction of sight, and the x and y axes of the image."""
    forward = -np.array(view) / np.linalg.norm(view)
    x = np.cross(forward, (0, 0, 1))
    x /= np.linalg.norm(x)
    return forward, x, np.cross(x, forward)


def orthographic(view, extent):
    forward, _, _ = axes_of(view)
    return emitree.Orthographic(
        position=tuple(-9 * forward), target=(0, 0, 0), up=(0, 0, 1), extent=(extent, extent)
    )


def exact_ball(count):
    """The means over pixels of the image along x of the ball, and those of its erf's."""

    def means(centre):
        primitive = [
            math.erf((edge - centre) / (math.sqrt(2) * SIGMA))
            for edge in np.linspace(-2, 2, count + 1)
        ]
        return math.sqrt(math.pi / 2) * SIGMA * np.diff(primitive) * count / 4

    along = math.sqrt(2 * math.pi) * SIGMA
    # Seen from +x with z up, x of the image is y.
    return along * means(CENTRE[2])[:, None] * means(CENTRE[1])


def integral_along_x(grid, cells, count):
    """The exact means over pixels of the interpolant, seen from +x.

    It is trilinear in boxes of half of a fine cell, so a midpoint for each is exact.
    """
    halves = 4 * cells
    middles = -2 + (np.arange(halves) + 0.5) * 4 / halves
    z, y = (of.ravel() for of in np.meshgrid(middles, middles, indexing="ij"))
    total = sum(grid(np.stack([np.full_like(y, x), y, z], axis=1)) for x in middles)
    pixels = total.reshape(count, halves // count, count, halves // count)
    return pixels.mean(axis=(1, 3)) * 4 / halves


def test_the_image_of_a_ball_converges_with_the_cells():
    exact = exact_ball(16)
    errors = [
        np.abs(integral_along_x(two_levels(cells), cells, 16) - exact).max() / exact.max()
        for cells in (16, 32)
    ]
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert errors[1] < 0.01
    # The rendering is as far from the ball as its interpolant is, and its tolerance.
    grid = two_levels(32)
    rendering = emitree.render(grid, orthographic((1, 0, 0), 4), (16, 16), tolerance=0.01)
    assert rendering.converged
    error = np.abs(rendering.image - exact).max() / exact.max()
    assert error < errors[1] + 0.01
    interpolant = integral_along_x(grid, 32, 16)
    assert np.abs(rendering.image - interpolant).max() <= 0.01 * interpolant.max()


def lines_of(view, extent, count):
    """Points of lines (count^2, 3) through middles of a lattice in the image, row by row."""
    _, x, y = axes_of(view)
    at = ((np.arange(count) + 0.5) / count - 0.5) * extent
    return (at[:, None, None] * y + at[None, :, None] * x).reshape(-1, 3)


def through(box, line, forward):
    """Lengths of lines within a cube from -box to box."""
    with np.errstate(divide="ignore"):
        ends = np.stack([(-box - line) / forward, (box - line) / forward])
    return np.maximum(ends.max(axis=0).min(axis=1) - ends.min(axis=0).max(axis=1), 0)


def binned(values, count):
    each = math.isqrt(len(values)) // count
    return values.reshape(count, each, count, each).mean(axis=(1, 3))


@pytest.mark.parametrize("view", [(1, 0.3, 0.2), (0.5, 0.5, 0.7)])
def test_an_oblique_image_is_right_to_the_tolerance(view):
    grid = two_levels(16)
    forward, _, _ = axes_of(view)

    def reference(lines, steps):
        depths = ((np.arange(steps) + 0.5) / steps - 0.5) * 7
        line = lines_of(view, 3, lines)
        return binned(sum(grid(line + depth * forward) for depth in depths) * 7 / steps, 16)

    exact = reference(64, 400)
    assert np.abs(reference(48, 301) - exact).max() < 0.002 * exact.max()
    rendering = emitree.render(grid, orthographic(view, 3), (16, 16), tolerance=0.01)
    assert rendering.converged
    # The difference of the two references is beyond their own error.
    assert np.abs(rendering.image - exact).max() <= 0.01 * exact.max()


@pytest.mark.parametrize(("view", "extent"), [((1, 0, 0), 3), ((1, 0.3, 0.2), 6)])
def test_constant_blocks_have_exact_lengths(view, extent):
    coarse = emitree.Block(0, (-2, -2, -2), (2, 2, 2), np.ones((4, 4, 4)))
    fine = emitree.Block(1, (-1, -1, -1), (1, 1, 1), np.full((4, 4, 4), 3.0))
    grid = emitree.AmrGrid([coarse, fine], interpolation="nearest")
    forward, _, _ = axes_of(view)

    def reference(lines):
        line = lines_of(view, extent, lines)
        return binned(through(2, line, forward) + 2 * through(1, line, forward), 12)

    exact = reference(480)
    assert np.abs(reference(360) - exact).max() < 0.001 * exact.max()
    rendering = emitree.render(grid, orthographic(view, extent), (12, 12), tolerance=0.01)
    assert rendering.converged
    assert np.abs(rendering.image - exact).max() <= 0.01 * exact.max()


def test_bounds_are_those_of_the_blocks_unless_given():
    grid = two_levels(8)
    assert grid.bounds == emitree.Box(min=(-2.0, -2.0, -2.0), max=(2.0, 2.0, 2.0))
    camera = orthographic((1, 0.3, 0.2), 4)
    rendering = emitree.render(grid, camera, (8, 8))
    given = emitree.render(grid, camera, (8, 8), bounds=grid.bounds)
    assert np.array_equal(rendering.image, given.image)
    half = emitree.Box(min=(-2, -2, -2), max=(2, 2, 0))
    assert emitree.render(grid, camera, (8, 8), bounds=half).image.sum() < 0.9 * given.image.sum()


def test_quantities_are_converted():
    u = pytest.importorskip("astropy.units")
    corners = (-2 * np.ones(3) * u.km, [2 * u.km, 2 * u.km, 2000 * u.m])
    rates = ball(centres((-2, -2, -2), (2, 2, 2), (8, 8, 8)))
    grid = emitree.AmrGrid([emitree.Block(0, *corners, rates * u.Unit("cm-3 s-1 sr-1"))])
    plain = emitree.AmrGrid([emitree.Block(0, (-2, -2, -2), (2, 2, 2), rates)])
    assert grid.length_unit == "km"
    at = points(2.1)
    in_metres = grid(1000 * at * u.m)
    assert in_metres.unit == u.Unit("cm-3 s-1 sr-1")
    np.testing.assert_allclose(in_metres.value, plain(at), rtol=1e-9, atol=1e-12)

    def image(emission, scale, length_unit, **options):
        camera = emitree.Orthographic(
            position=(9 * scale, 0, 0),
            target=(0, 0, 0),
            extent=(4 * scale, 4 * scale),
            length_unit=length_unit,
        )
        return emitree.render(emission, camera, (6, 6), **options)

    expected = image(plain, 1, "km", unit="cm-3 s-1 sr-1")
    for found in (
        image(grid, 1, "km"),
        image(grid, 1000, "m"),
        image(grid, 1000, "m", unit="m-3 s-1 sr-1"),
        image(grid, 1, "km", quantities=True),
    ):
        np.testing.assert_allclose(
            found.quantity.to_value(expected.quantity.unit), expected.image, rtol=1e-6, atol=1e-9
        )
    # Wherever the grid is called by the package itself.
    camera = emitree.Orthographic(
        position=(9000, 0, 0), target=(0, 0, 0), extent=(4000, 4000), length_unit="m"
    )
    options = {"bounds": grid.bounds, "unit": "cm-3 s-1 sr-1"}
    single = emitree.render(grid, camera, (6, 6), **options)
    both = emitree.render({"a": grid, "b": grid}, camera, (6, 6), **options)
    np.testing.assert_allclose(both["b"].image, single.image, atol=0.02 * single.image.max())
    plan = single.plan
    rates = plan.rates_at(grid, plan.points)
    scale = single.image.max()
    np.testing.assert_allclose(plan.apply(rates), single.image, rtol=0, atol=1e-12 * scale)
    swept = emitree.sweep(lambda: grid, {}, [camera], (6, 6), **options)
    np.testing.assert_allclose(swept.images[0], single.image, rtol=0, atol=1e-12 * scale)
    with pytest.raises(emitree.SceneError, match="lengths in km, and the camera in s"):
        grid.in_length_unit("s")
    with pytest.raises(emitree.SceneError, match="expected a number in s"):
        emitree.AmrGrid([emitree.Block(0, *corners, rates)], length_unit="s")


# -- Messages.

ONES = np.ones((4, 4, 4))
FIRST = emitree.Block(0, (0, 0, 0), (4, 4, 4), ONES)


def with_nan():
    values = ONES.copy()
    values[1, 2, 3] = np.nan
    return values


@pytest.mark.parametrize(("blocks", "message"), [
    ([], "`blocks` is empty: expected at least one"),
    ([FIRST, ONES], "block 1 is ndarray: expected emitree.Block"),
    ([FIRST, emitree.Block(-1, (0, 0, 0), (1, 1, 1), ONES)], "`level` of block 1 is -1: expected an integer"),
    ([FIRST, emitree.Block(0.5, (0, 0, 0), (1, 1, 1), ONES)], r"`level` of block 1 is 0\.5: expected an integer"),
    ([emitree.Block(0, (0, 0), (1, 1, 1), ONES)], r"`lower` of block 0 is \(0, 0\): expected three"),
    ([emitree.Block(0, (0, 0, 0), (1, np.inf, 1), ONES)], r"`upper` of block 0 is .*inf.*: expected three finite"),
    ([emitree.Block(0, (0, 0, 0), "abc", ONES)], "`upper` of block 0 is str: expected numbers"),
    ([FIRST, emitree.Block(0, (0, 5, 0), (4, 5, 4), ONES)], "`upper` of block 1 is 5 along y: expected more than `lower`, 5"),
    ([emitree.Block(0, (0, 0, 0), (1, 1, 1), ONES[0])], r"`values` of block 0 has the shape \(4, 4\): expected \(nx, ny, nz\)"),
    ([emitree.Block(0, (0, 0, 0), (1, 1, 1), with_nan())], r"`values` of block 0 is nan in cell \(1, 2, 3\): expected a number"),
    ([emitree.Block(0, (0, 0, 0), (1, 1, 1), np.ma.masked_equal([[[1.0, 2.0]]], 2))], r"`values` of block 0 is masked at \(0, 0, 1\): expected numbers"),
    ([emitree.Block(0, (0, 0, 0), (1, 1, 1), ONES * 1j)], "`values` of block 0 is an array of complex128: expected numbers"),
    ([FIRST, emitree.Block(0, (4, 0, 0), (6, 4, 4), ONES)], r"block 1 of level 0 has cells of \(0\.5, 1, 1\): expected \(1, 1, 1\), as block 0"),
    ([FIRST, emitree.Block(0, (4.5, 0, 0), (8.5, 4, 4), ONES)], r"block 1 of level 0 begins at x = 4\.5, 4\.5 cells from .*, 0: expected a whole number"),
    ([FIRST, emitree.Block(1, (0.25, 0, 0), (2.25, 2, 2), ONES)], r"block 1 of level 1 begins at x = 0\.25, 0\.5 cells"),
    ([FIRST, emitree.Block(1, (0, 0, 0), (3, 3, 3), ONES)], r"block 1 of level 1 has cells of \(0\.75, 0\.75, 0\.75\), and block 0 of level 0 of \(1, 1, 1\): expected whole ratios"),
    ([FIRST, emitree.Block(1, (0, 0, 0), (4, 4, 4), ONES)], "expected whole ratios, above 1"),
    ([FIRST, emitree.Block(1, (0, 0, 0), (8, 2, 2), ONES)], "expected whole ratios, above 1"),
    ([FIRST, emitree.Block(0, (2, 0, 0), (6, 4, 4), 2 * ONES)], r"block 1 and block 0 of level 0 overlap, and have 2 and 1 at \(2\.5, 0\.5, 0\.5\): expected the same value"),
])  # fmt: skip
def test_what_is_wrong_is_named(blocks, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.AmrGrid(blocks)


def test_too_many_tiles_are_refused(monkeypatch):
    monkeypatch.setattr(_amr_lattice, "_MOST_TILES", 26)
    with pytest.raises(
        emitree.SceneError, match=r"2 blocks .* \(3, 3, 3\) tiles: expected at most"
    ):
        two_levels(8)


def test_other_interpolations_are_refused():
    with pytest.raises(emitree.SceneError, match="`interpolation` is 'cubic': expected 'linear', "):
        emitree.AmrGrid([FIRST], interpolation="cubic")


def test_the_example_of_the_guide():
    guide = Path(__file__).parents[2] / "docs" / "guide.md"
    section = guide.read_text(encoding="utf-8").split("##### Adaptive meshes (Python)")[1]
    names = {}
    exec(section.split("```python")[1].split("```")[0], names)
    rendering = names["rendering"]
    assert rendering.converged
    # At the centre of the ball, the integral is sqrt(0.18 pi).
    assert rendering.image.max() == pytest.approx(math.sqrt(0.18 * math.pi), rel=0.08)
