"""Everything that is public can be pickled and copied."""

import copy
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from models import peak, rendered, spectral

import emitree

CUBE = emitree.Canonical()
CAMERA = emitree.Perspective(
    position=(-10, 0, 0), target=(0, 0, 0), field_of_view=(1, 1), near=9, far=11, length_unit="cm"
)
ENERGIES = emitree.Energies(0.5, 1.5, 4)
INSTRUMENT = emitree.Instrument(effective_area=50.0, exposure=1e9, psf={"fwhm_pixels": 1.5}, seed=3)


def again(thing):
    return pickle.loads(pickle.dumps(thing))


PLAIN = [
    CUBE,
    CAMERA,
    emitree.Orthographic(position=(0, 0, 1), target=(0, 0, 0), extent=(1, 1)),
    emitree.Equirectangular(position=(0, 0, 1), target=(0, 0, 0), field_of_view=(1, 1)),
    emitree.Polar(position=(0, 0, 1), target=(0, 0, 0), field_of_view=1),
    emitree.Fisheye(position=(0, 0, 1), target=(0, 0, 0), field_of_view=1),
    emitree.Healpix(position=(0, 0, 1)),
    emitree.Sphere(center=(0, 0, 0), radius=1),
    emitree.Ellipsoid(center=(0, 0, 0), semi_axes=(1, 2, 3)),
    emitree.Box(min=(0, 0, 0), max=(1, 1, 1)),
    emitree.Plane(position=(0, 0, 0), normal=(0, 0, 1)),
    emitree.SingularPoint(position=(0, 0, 0), exponent=2.5),
    emitree.SingularAxis(position=(0, 0, 0), direction=(0, 0, 1)),
    emitree.Expression("a * x", {"a": 2.0}),
    emitree.Model("cmem", density=5.0),
    emitree.Grid(file="cube.nc", variable="g"),
    emitree.Tree("tree.fits"),
    ENERGIES,
    INSTRUMENT,
]


@pytest.mark.parametrize("thing", PLAIN, ids=lambda thing: type(thing).__name__)
def test_what_is_asked_for(thing):
    for other in (again(thing), copy.copy(thing), copy.deepcopy(thing)):
        assert type(other) is type(thing) and repr(other) == repr(thing)
        assert other == thing


def test_grids_of_arrays():
    grid = emitree.Grid(values=np.ones((2, 2, 2)), x=(0, 1), y=(0, 1), z=(0, 1))
    other = again(grid)
    assert np.array_equal(other.values, grid.values)
    assert np.array_equal(
        emitree.render(other, CUBE, (2, 2)).image, emitree.render(grid, CUBE, (2, 2)).image
    )


UNIT = "ph cm-3 s-1 sr-1 keV-1"
SKY = emitree.Healpix(position=(1, 0, 0), far=9, length_unit="km")
RESULTS = {
    "image": lambda: emitree.render(peak, CUBE, (6, 8)),
    "lines": lambda: emitree.render(peak, CUBE, (6, 8), method="los", steps=8),
    "tree": lambda: emitree.render(peak, CUBE, (6, 8), method="paper"),
    "sky": lambda: emitree.render("exp(-r^2)", SKY, 4, unit="ph cm-3 s-1 sr-1"),
    "cube": lambda: emitree.render(spectral, CUBE, (4, 6), energy=ENERGIES),
    "counts": lambda: emitree.render(
        "exp(-E)", CAMERA, (6, 8), energy=ENERGIES, unit=UNIT, instrument=INSTRUMENT
    ),
}


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize("way", [again, copy.copy, copy.deepcopy])
def test_renderings(name, way):
    rendering = RESULTS[name]()
    other = way(rendering)
    assert other.report == rendering.report and repr(other) == repr(rendering)
    assert np.array_equal(other.image, rendering.image, equal_nan=True)
    if rendering.error is None:
        assert other.error is None
    else:
        assert np.array_equal(other.error, rendering.error, equal_nan=True)
    assert np.array_equal(other.flat_image, rendering.flat_image, equal_nan=True)
    assert np.array_equal(other.evaluations_per_pixel, rendering.evaluations_per_pixel)
    assert (other.unit, other.scene) == (rendering.unit, rendering.scene)
    assert other.estimated_error == rendering.estimated_error
    assert other._repr_png_() == rendering._repr_png_()
    # But for the time at which it is written.
    ours, theirs = (bytes(one._found.fits()) for one in (other, rendering))
    assert len(ours) == len(theirs)
    if rendering.energies is not None:
        assert np.array_equal(other.energies, rendering.energies)
    if name == "counts":
        assert np.array_equal(other.expected_counts, rendering.expected_counts)
        assert np.array_equal(other.draw_counts(), rendering.draw_counts())
        assert other.count_steps == rendering.count_steps
        assert np.array_equal(other.spectrum().values, rendering.spectrum().values)
    if name == "cube":
        assert np.array_equal(other.spectrum().values, rendering.spectrum().values)


def test_an_instrument_needs_no_files_afterwards(tmp_path):
    area = tmp_path / "area.txt"
    area.write_text("energy area\n0.2 10\n4.2 30\n")
    rendering = emitree.render(
        "exp(-E)", CAMERA, (4, 4), energy=ENERGIES, unit="ph cm-3 s-1 sr-1 keV-1",
        instrument=emitree.Instrument(effective_area=area, exposure=1e9),
    )  # fmt: skip
    kept = pickle.dumps(rendering)
    area.unlink()
    assert np.array_equal(pickle.loads(kept).expected_counts, rendering.expected_counts)


def test_counts_that_can_not_be_had_are_no_reason_not_to_pickle():
    options = {"energy": ENERGIES, "unit": UNIT, "instrument": INSTRUMENT}
    rendering = emitree.render("exp(-E)", CAMERA, (4, 4), quantity="irradiance", **options)
    for each in (rendering, again(rendering), again(again(rendering))):
        with pytest.raises(emitree.SceneError, match="an instrument takes radiances"):
            _ = each.expected_counts


def test_frames_spectra_and_errors():
    *frames, last = emitree.progressive(peak, CUBE, (8, 8))
    assert np.array_equal(again(frames[0]).image, frames[0].image)
    assert np.array_equal(again(last).image, last.image)
    cube = emitree.render(spectral, CUBE, (2, 2), energy=ENERGIES)
    assert np.array_equal(copy.deepcopy(cube.spectrum()).values, cube.spectrum().values)
    with pytest.raises(emitree.EmissionError) as raised:
        emitree.render(lambda r, d: np.full(len(r), np.inf), CUBE, (2, 2))
    other = again(raised.value)
    assert str(other) == str(raised.value) and other.rate == np.inf


def test_processes_may_return_renderings():
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as executor:
        found = executor.submit(rendered, (6, 8)).result()
    assert np.array_equal(found.image, emitree.render(peak, CUBE, (6, 8)).image)
    assert "models.peak" in found.scene
