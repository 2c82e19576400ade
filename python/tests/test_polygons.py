"""Integrals over polygons of an image that is known by means over cells."""

import numpy as np
import pytest

from emitree._polygons import Cells, integrals

SIDE = 64


def quadrilaterals(random, count, size):
    """Corners and middles of borders (n, 8, 2), turned at random."""
    middle = random.uniform(1.2 * size + 3, SIDE - 1.2 * size - 3, (count, 1, 2))
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size / 2
    angle = random.uniform(0, 2 * np.pi, count)
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], 1)
    found = np.einsum("nij,kj->nki", turn, corners) + middle
    found += random.uniform(-0.1, 0.1, found.shape) * size
    around = np.empty((count, 8, 2))
    around[:, ::2], around[:, 1::2] = found, 0.5 * (found + np.roll(found, -1, axis=1))
    return around


def area(around):
    x, y = around[..., 0], around[..., 1]
    return 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)


def exact(function, around, nodes):
    """Integrals by many places in each quadrilateral."""
    each = (np.arange(nodes) + 0.5) / nodes
    u, v = (of.ravel() for of in np.meshgrid(each, each))
    corners = around[:, ::2]

    def at(*weights):
        return np.einsum("mk,nkc->nmc", np.stack(weights, axis=1), corners)

    place = at((1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v)
    of_u, of_v = at(v - 1, 1 - v, v, -v), at(u - 1, -u, u, 1 - u)
    jacobian = of_u[..., 0] * of_v[..., 1] - of_u[..., 1] * of_v[..., 0]
    return (function(place[..., 0], place[..., 1]) * jacobian).mean(axis=1)


def means(function, nodes=16):
    each = (np.arange(SIDE * nodes) + 0.5) / nodes
    values = function(*np.meshgrid(each, each))
    return values.reshape(SIDE, nodes, SIDE, nodes).mean(axis=(1, 3))


def test_an_image_that_is_linear_is_exact():
    random = np.random.default_rng(1)
    around = quadrilaterals(random, 200, 5.0)
    y, x = np.indices((SIDE, SIDE)) + 0.5
    (value, unknown), (ones, none) = integrals(
        [Cells.linear(3 + 0.2 * x - 0.1 * y), Cells.constant(np.ones((SIDE, SIDE)))], around
    )
    linear = exact(lambda x, y: 3 + 0.2 * x - 0.1 * y, around, 96)
    assert ones == pytest.approx(area(around), rel=1e-12)
    assert value == pytest.approx(linear, rel=1e-4)
    assert abs(unknown).max() < 1e-12 and abs(none).max() == 0.0


def test_it_does_not_matter_which_corner_is_the_first():
    # The border from the last corner to the first one is the longest.
    around = np.array([[[10.0, 10.2], [30.3, 12.0], [28.0, 15.0], [11.0, 13.0], [10.0, 12.5]]])
    image = means(lambda x, y: np.sin(x / 5) ** 2 + y / 20)
    first = [
        integrals([Cells.constant(image)], np.roll(around, turn, axis=1))[0][0][0]
        for turn in range(5)
    ]
    assert first == pytest.approx([first[0]] * 5, rel=1e-12)


@pytest.mark.parametrize("kind", ["jump", "root", "smooth", "beyond"])
@pytest.mark.parametrize("size", [2.0, 4.0, 8.0])
def test_errors_are_not_beyond_what_parts_of_cells_may_differ(kind, size):
    for seed in range(500, 502):
        random = np.random.default_rng(seed)
        middle, radius = random.uniform(25, 39, 2), random.uniform(10, 22)

        def function(x, y, middle=middle, radius=radius):
            square = (x - middle[0]) ** 2 + (y - middle[1]) ** 2
            if kind == "jump":
                return (square < radius**2) * 1.0
            if kind == "root":
                return np.sqrt(np.maximum(1 - square / radius**2, 0))
            if kind == "smooth":
                return np.exp(-2 * square / radius**2)
            return (square > radius**2) * np.exp(-square / 200) * (1 + 0.5 * np.sin(x / 3))

        around = quadrilaterals(random, 150, size)
        ((value, unknown),) = integrals([Cells.linear(means(function))], around)
        error = abs(value - exact(function, around, 64)) / area(around)
        # The places inside know their integral to this.
        assert (error <= unknown / area(around) + 5e-4).all()
        assert error.max() < 0.4 / size**1.5
