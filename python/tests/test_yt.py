"""Datasets of yt as AMR grids."""

import warnings

import numpy as np
import pytest

import emitree
from emitree import _yt

with warnings.catch_warnings():
    # Dependencies of yt may be newer than it.
    warnings.simplefilter("ignore", DeprecationWarning)
    yt = pytest.importorskip("yt")

yt.set_log_level("error")

RATE = ("stream", "rate")
RANDOM = np.random.default_rng(5)
BOX = np.array([[-1.0, 1.0], [-2.0, 2.0], [0.0, 4.0]])


def uniform(unit="1/(cm**3*s)", **options):
    rates = RANDOM.random((4, 8, 8))
    dataset = yt.load_uniform_grid({"rate": (rates, unit)}, rates.shape, bbox=BOX, **options)
    return rates, dataset


def test_a_uniform_grid_is_one_block():
    rates, dataset = uniform(length_unit="kpc")
    grid = emitree.from_yt(dataset, RATE, interpolation="nearest")
    assert grid.bounds == emitree.Box(min=(-1.0, -2.0, 0.0), max=(1.0, 2.0, 4.0))
    assert grid.unit is None and grid.length_unit is None
    centres = np.array([[-0.75, -1.75, 0.25], [0.75, 1.75, 3.75], [0.25, -1.25, 2.25]])
    np.testing.assert_allclose(grid(centres), rates[[0, 3, 2], [0, 7, 1], [0, 7, 4]])


def test_units_are_converted():
    units = pytest.importorskip("astropy.units")
    rates, dataset = uniform(length_unit="kpc")
    grid = emitree.from_yt(dataset, RATE, unit="m-3 s-1", length_unit="pc")
    assert grid.unit == "m-3 s-1" and grid.length_unit == "pc"
    # Parsecs of yt and of astropy differ in the tenth digit.
    np.testing.assert_allclose(grid.bounds.max.to_value(units.kpc), (1, 2, 4), rtol=1e-8)
    found = grid(np.array([[-750.0, -1750, 250]]))
    np.testing.assert_allclose(found.to_value("cm-3 s-1"), rates[0, 0, 0], rtol=1e-6)
    with pytest.raises(emitree.SceneError, match=r"is in 1/\(cm\*\*3\*s\), and `unit` is 'kg'"):
        emitree.from_yt(dataset, RATE, unit="kg")
    with pytest.raises(emitree.SceneError, match="`length_unit` is 's': expected a unit of length"):
        emitree.from_yt(dataset, RATE, length_unit="s")
    rates, dataset = uniform(unit="dimensionless")
    grid = emitree.from_yt(dataset, RATE, unit="cm-3 s-1 sr-1")
    found = grid(np.array([[-0.75, -1.75, 0.25]]))
    np.testing.assert_allclose(found.to_value("cm-3 s-1 sr-1"), rates[0, 0, 0], rtol=1e-12)


def nested():
    grids = [
        {"left_edge": [0, 0, 0], "right_edge": [1, 1, 1], "level": 0, "dimensions": [16] * 3},
        {"left_edge": [0.25] * 3, "right_edge": [0.75] * 3, "level": 1, "dimensions": [16] * 3},
        {"left_edge": [0.5] * 3, "right_edge": [0.625] * 3, "level": 2, "dimensions": [8] * 3},
    ]
    for grid in grids:
        grid[RATE] = RANDOM.random(grid["dimensions"])
    return yt.load_amr_grids(grids, [16] * 3)


def test_patches_are_as_in_yt():
    dataset = nested()
    at = RANDOM.uniform(0, 1, (200, 3))
    theirs = np.array(dataset.find_field_values_at_points([RATE], dataset.arr(at, "code_length")))
    assert np.array_equal(emitree.from_yt(dataset, RATE, interpolation="nearest")(at), theirs)
    grid = emitree.from_yt(dataset, RATE, interpolation="nearest", max_level=1)
    coarser = grid(at)
    changed = np.all((at >= 0.5) & (at < 0.625), axis=1)
    assert np.array_equal(coarser[~changed], theirs[~changed])
    assert "2 blocks" in repr(grid)
    with pytest.raises(emitree.SceneError, match="`max_level` is -1: expected 0 or more"):
        emitree.from_yt(dataset, RATE, max_level=-1)


def test_the_image_of_patches_is_that_of_their_blocks():
    dataset = nested()
    blocks = [
        emitree.Block(
            int(grid.Level), np.array(grid.LeftEdge), np.array(grid.RightEdge), np.array(grid[RATE])
        )
        for grid in dataset.index.grids
    ]
    camera = emitree.Orthographic(position=(9, 3, 2), target=(0.5, 0.5, 0.5), extent=(1, 1))
    ours, theirs = (
        emitree.render(grid, camera, (4, 4), tolerance=0.1).image
        for grid in (emitree.AmrGrid(blocks), emitree.from_yt(dataset, RATE))
    )
    assert np.array_equal(ours, theirs) and ours.max() > 0


def test_other_geometries_are_refused():
    rates = {"rate": np.ones((4, 4, 4))}
    box = np.array([[1.0, 2.0], [0.5, 1.0], [0.0, 1.0]])
    dataset = yt.load_uniform_grid(rates, (4, 4, 4), bbox=box, geometry="spherical")
    with pytest.raises(emitree.SceneError, match="has spherical coordinates: expected Cartesian"):
        emitree.from_yt(dataset, RATE)


def test_an_octree_is_sampled(monkeypatch):
    mask = np.array([8, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], dtype=np.uint8)
    # Each of the 15 leaves has eight cells.
    dataset = yt.load_octree(
        octree_mask=mask,
        data={RATE: RANDOM.random((15, 8))},
        bbox=np.array([[-1.0, 1.0]] * 3),
        num_zones=2,
    )
    grid = emitree.from_yt(dataset, RATE, interpolation="nearest")
    everything = dataset.all_data()
    centres = np.stack(
        [everything["index", axis].to_value("code_length") for axis in "xyz"], axis=1
    )
    assert len(centres) == 120
    assert np.array_equal(grid(centres), everything[RATE].value)
    assert emitree.from_yt(dataset, RATE, max_level=1).bounds == grid.bounds
    monkeypatch.setattr(_yt, "_MOST_CELLS", 511)
    with pytest.raises(emitree.SceneError, match=r"level 2 of the dataset has \(8, 8, 8\) cells"):
        emitree.from_yt(dataset, RATE)
