"""Nested blocks with values at the corners of cells: the interpolant, images of it, and messages."""

import math
import pickle

import numpy as np
import pytest

import emitree

SIGMA = 0.3
CENTRE = np.array([0.03, -0.07, 0.05])
#: Its pixels have no borders at nodes of the data.
CAMERA = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), up=(0, 0, 1), extent=(3.7, 3.7))


def ball(position):
    return np.exp(-(((position - CENTRE) / SIGMA) ** 2).sum(axis=-1) / 2)


def linear(position):
    return 1 + position @ np.array([1.0, -2.0, 3.0])


def block(level, lower, upper, cells, rate=ball):
    axes = [np.linspace(low, high, n + 1) for low, high, n in zip(lower, upper, cells, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return emitree.Block(level, lower, upper, rate(places), values_at="nodes")


def two_levels(cells, rate=ball, **options):
    """A cube from -2 to 2, and within it one from -1 to 1 with cells of half the size."""
    coarse = block(0, (-2, -2, -2), (2, 2, 2), (cells,) * 3, rate)
    fine = block(1, (-1, -1, -1), (1, 1, 1), (cells,) * 3, rate)
    return emitree.AmrGrid([fine, coarse], **options)


def points(extent, count=2000):
    return np.random.default_rng(1).uniform(-extent, extent, (count, 3))


def test_linear_data_are_exact_everywhere():
    at = points(2)
    np.testing.assert_allclose(two_levels(8, linear)(at), linear(at), rtol=1e-12, atol=1e-12)
    uneven = [
        block(0, (0, 0, 0), (4, 4, 4), (4, 8, 4), linear),
        block(2, (1, 1, 1), (3, 2, 3), (8, 2, 6), linear),
    ]
    inside = at + 2
    np.testing.assert_allclose(
        emitree.AmrGrid(uneven)(inside), linear(inside), rtol=1e-12, atol=1e-11
    )


def test_nodes_have_their_values_and_the_outside_has_none():
    grid = two_levels(8)
    axis = np.linspace(-1, 1, 9)[:-1]
    nodes = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    np.testing.assert_allclose(grid(nodes), ball(nodes), rtol=1e-13)
    just_outside = np.array([[2.0, 0, 0], [-2.0001, 0, 0], [0, 0, 1e300]])
    assert np.array_equal(grid(just_outside), np.zeros(3))
    # At the end of the data the values are those of the last nodes.
    bent = two_levels(8, linear)
    almost, end = np.array([[2 - 1e-12, 0.25, 0.25]]), np.array([[2, 0.25, 0.25]])
    np.testing.assert_allclose(bent(almost), linear(end), rtol=1e-10)


def test_one_block_is_as_a_grid():
    axis = np.linspace(-2, 2, 10)
    values = ball(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1))
    grid = emitree.Fields({"g": emitree.Grid(values=values, x=axis, y=axis, z=axis)}, "g")
    one = emitree.AmrGrid([block(0, (-2, -2, -2), (2, 2, 2), (9, 9, 9))])
    at = points(2.2)
    np.testing.assert_allclose(one(at), grid(at), rtol=1e-12, atol=1e-300)


def test_blocks_of_one_level_are_as_one_block():
    whole = emitree.AmrGrid([block(3, (-2, -2, -2), (2, 2, 2), (16, 16, 16))])
    parts = [
        block(3, lower, lower + 1, (4, 4, 4)) for lower in np.array(list(np.ndindex(4, 4, 4))) - 2.0
    ]
    twice = [*parts, block(3, (-1.5, -1.5, -1), (1, 1, 1.5), (10, 10, 10))]
    at = points(2.1)
    for blocks in (parts, twice):
        np.testing.assert_allclose(emitree.AmrGrid(blocks)(at), whole(at), rtol=1e-12, atol=1e-16)


def test_errors_and_jumps_are_of_second_order():
    at = points(2, 20000)
    grids = [two_levels(cells) for cells in (64, 128)]
    errors = [np.sqrt(np.mean((grid(at) - ball(at)) ** 2)) for grid in grids]
    assert 3.7 < errors[0] / errors[1] < 4.3
    y, z = np.random.default_rng(2).uniform(-1, 1, (2, 4000))
    sides = [np.stack([np.full(4000, 1 + shift), y, z], axis=1) for shift in (-1e-9, 1e-9)]
    jumps = [np.abs(grid(sides[0]) - grid(sides[1])).max() for grid in grids]
    assert jumps[0] < 1e-3 and jumps[0] / jumps[1] > 3.7


def test_the_nearest_node_has_its_value():
    grid = two_levels(8, interpolation="nearest")
    at = points(1)
    np.testing.assert_allclose(grid(at), ball(np.rint(at * 4) / 4), rtol=1e-12)
    beside = 1.0 + np.random.default_rng(3).uniform(0, 1, (500, 3))
    np.testing.assert_allclose(grid(beside), ball(np.floor(beside * 2 + 0.5) / 2), rtol=1e-12)


def exact_ball(count):
    """The means over pixels of the image along x of the ball, and those of its erf's."""

    def means(centre):
        edges = (np.linspace(-1.85, 1.85, count + 1) - centre) / (math.sqrt(2) * SIGMA)
        return (
            math.sqrt(math.pi / 2)
            * SIGMA
            * np.diff([math.erf(edge) for edge in edges])
            * count
            / 3.7
        )

    return math.sqrt(2 * math.pi) * SIGMA * means(CENTRE[2])[:, None] * means(CENTRE[1])


def test_the_image_of_a_ball_converges_with_the_cells():
    exact = exact_ball(15)
    errors = []
    for cells in (16, 32, 64):
        rendering = emitree.render(two_levels(cells), CAMERA, (15, 15), tolerance=0.001)
        assert rendering.converged
        errors.append(np.abs(rendering.image - exact).max() / exact.max())
    # Of second order in the size of the cells, up to the error of the rendering itself.
    assert errors[0] > 3 * errors[1] and errors[1] > 2 * errors[2] and errors[2] < 0.002


def test_a_field_of_a_formula_may_have_values_at_nodes():
    glow = emitree.Fields({"n": two_levels(8, linear)}, "n^2")
    at = points(2.5)
    inside = np.abs(at).max(axis=1) < 2
    np.testing.assert_allclose(glow(at), np.where(inside, linear(at) ** 2, 0), rtol=1e-9, atol=1e-9)
    again = pickle.loads(pickle.dumps(two_levels(8)))
    assert np.array_equal(again(at), two_levels(8)(at))


NODES = np.ones((5, 5, 5))
FIRST = emitree.Block(0, (0, 0, 0), (4, 4, 4), NODES, values_at="nodes")


def nodes(*arguments):
    return emitree.Block(*arguments, values_at="nodes")


def with_nan():
    values = NODES.copy()
    values[1, 2, 3] = np.nan
    return values


@pytest.mark.parametrize(("blocks", "options", "message"), [
    ([FIRST, emitree.Block(1, (0, 0, 0), (2, 2, 2), NODES)], {}, "block 1 has values at cells, and block 0 at nodes: expected the same"),
    ([emitree.Block(0, (0, 0, 0), (4, 4, 4), NODES, "corners")], {}, "`values_at` of block 0 is 'corners': expected 'cells' or 'nodes'"),
    ([FIRST], {"interpolation": "quadratic"}, "`interpolation` is 'quadratic': expected 'linear' or 'nearest' for values at nodes"),
    ([FIRST], {"interpolation": "cubic"}, "`interpolation` is 'cubic': expected 'linear', 'quadratic' or 'nearest'"),
    ([nodes(0, (0, 0, 0), (4, 4, 4), NODES[:1])], {}, r"the shape \(1, 5, 5\): expected \(nx, ny, nz\), a number for each node, 2 or more"),
    ([nodes(0, (0, 0, 0), (4, 4, 4), with_nan())], {}, r"`values` of block 0 is nan at node \(1, 2, 3\): expected a number"),
    ([FIRST, nodes(0, (2, 0, 0), (6, 4, 4), 2 * NODES)], {}, r"block 1 and block 0 of level 0 overlap, and have 2 and 1 at \(2, 0, 0\): expected the same"),
    # Values of cells taken for those at nodes: cells are no longer half as large.
    ([FIRST, nodes(1, (0, 0, 0), (2, 2, 2), NODES[1:, 1:, 1:])], {}, r"block 1 of level 1 has cells of \(0\.666667, .*: expected whole ratios"),
])  # fmt: skip
def test_what_is_wrong_is_named(blocks, options, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.AmrGrid(blocks, **options)
