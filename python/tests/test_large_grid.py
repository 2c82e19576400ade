"""Grids that are read block by block, beside the same grids in memory."""

import math
import pickle

import numpy as np
import pytest

import emitree

SHAPE = (37, 45, 30)
NODES = [np.cumsum(np.r_[0.0, 1.0 + 0.5 * np.sin(np.arange(n - 1))]) for n in SHAPE]
NODES = [6.0 * nodes / nodes[-1] - 3.0 for nodes in NODES]
VALUES = np.exp(-sum(at**2 for at in np.meshgrid(*NODES, indexing="ij")))
AXES = dict(zip("xyz", NODES, strict=True))


class Slices:
    """An array that remembers which parts of it were read."""

    def __init__(self, values):
        self.values, self.shape, self.read = values, values.shape, []

    def __getitem__(self, part):
        self.read.append(part)
        return self.values[part]


def points(count):
    return np.random.default_rng(7).uniform(-3.2, 3.2, (count, 3))


@pytest.mark.parametrize("interpolation", ["linear", "nearest", "cubic", "monotone"])
@pytest.mark.parametrize("block", [1, 8, 1000])
def test_rates_are_those_of_a_grid_in_memory(interpolation, block):
    whole = emitree.Grid(values=VALUES, interpolation=interpolation, **AXES)
    found = emitree.LargeGrid(VALUES, interpolation=interpolation, block=block, **AXES)
    at = points(60 if block == 1 else 3000)
    expected = whole(at)
    assert expected.min() == 0.0 < expected.max()
    np.testing.assert_allclose(found(at), expected, rtol=1e-13, atol=1e-16)


def test_the_borders_of_the_grid_belong_to_it():
    found = emitree.LargeGrid(VALUES, block=8, **AXES)
    corners = np.array([[nodes[end] for nodes in NODES] for end in (0, -1)])
    np.testing.assert_allclose(found(corners), [VALUES[0, 0, 0], VALUES[-1, -1, -1]])


def test_a_file_in_a_memory_map_has_the_image_of_a_grid(tmp_path):
    file = tmp_path / "values.bin"
    VALUES.tofile(file)
    mapped = np.memmap(file, dtype=np.float64, mode="r", shape=SHAPE)
    camera = emitree.Orthographic(position=(-9, 1, 2), target=(0, 0, 0), extent=(5, 5))
    images = [
        emitree.render(grid, camera, (12, 12), tolerance=0.01)
        for grid in (
            emitree.LargeGrid(mapped, interpolation="cubic", block=16, **AXES),
            emitree.Grid(values=VALUES, interpolation="cubic", **AXES),
        )
    ]
    assert images[0].converged
    # The mean of the Gaussian's columns over a pixel beside the middle, of 5 / 12 a side.
    side = 5.0 / 12.0
    along = math.erf(side) * math.sqrt(math.pi) / 2.0 / side
    assert abs(images[0].image.max() / (along**2 * math.sqrt(math.pi)) - 1.0) < 0.01
    np.testing.assert_allclose(images[0].image, images[1].image, atol=0.01 * images[1].image.max())


def test_a_dask_array_is_read_by_blocks():
    array = pytest.importorskip("dask.array")
    lazy = array.from_array(VALUES, chunks=10)
    at = points(200)
    found = emitree.LargeGrid(lazy, block=10, **AXES)(at)
    np.testing.assert_allclose(found, emitree.Grid(values=VALUES, **AXES)(at), rtol=1e-13)


def test_only_blocks_with_points_are_read_and_each_once_while_it_is_kept():
    slices = Slices(VALUES)
    grid = emitree.LargeGrid(slices, block=10, **AXES)
    corner = np.array([[nodes[2] for nodes in NODES]])
    assert slices.read == []
    grid(corner)
    grid(corner)
    assert slices.read == [(slice(0, 11),) * 3]
    # Room for one block: two in turn are read anew each time.
    small = emitree.LargeGrid(slices, block=10, memory_bytes=16 * 11**3, **AXES)
    for _ in range(2):
        small(np.array([[nodes[2] for nodes in NODES], [nodes[12] for nodes in NODES]]))
    assert len(slices.read) == 5


def test_a_pickled_grid_reads_its_own_blocks():
    grid = emitree.LargeGrid(VALUES, block=10, **AXES)
    at = points(20)
    rates = grid(at)
    assert np.array_equal(pickle.loads(pickle.dumps(grid))(at), rates)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"interpolation": "spline"}, "`interpolation` is 'spline': expected one of 'linear'"),
        ({"block": 0}, "`block` is 0: expected a number of cells above 0"),
        ({"x": NODES[0][:-1]}, "`values` has the shape (37, 45, 30): expected (36, 45, 30)"),
        ({"y": NODES[1][::-1]}, "`y` has the shape (45,): expected two or more nodes, all incr"),
        ({"memory_bytes": 1000}, "a block of 64 cells a side takes 799200 bytes: expected at mo"),
    ],
)
def test_errors_name_what_was_given(change, message):
    with pytest.raises(emitree.SceneError) as error:
        emitree.LargeGrid(VALUES, **AXES | change)
    assert message in str(error.value)


def test_values_that_are_not_finite_are_refused_where_they_are_read():
    values = VALUES.copy()
    values[20, 20, 20] = np.nan
    grid = emitree.LargeGrid(values, block=10, **AXES)
    assert grid(np.array([[nodes[2] for nodes in NODES]]))[0] > 0.0
    with pytest.raises(emitree.SceneError, match=r"nan|NaN"):
        grid(np.array([[nodes[20] for nodes in NODES]]))
