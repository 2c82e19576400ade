"""Counts of an instrument."""

import numpy as np
import pytest

import emitree

UNIT = "ph cm-3 s-1 sr-1 keV-1"
CAMERA = emitree.Perspective(
    position=(-10, 0, 0),
    target=(0, 0, 0),
    field_of_view=(1, 1),
    near=9,
    far=11,
    length_unit="cm",
)
ENERGY = {"min": 0.5, "max": 1.5, "bins": 4, "unit": "keV"}
INSTRUMENT = {
    "effective_area": 50.0,
    "exposure": 1e9,
    "psf": {"fwhm_pixels": 1.5},
    "background": {"per_pixel": 1e-8},
    "seed": 3,
}


def flat(position, direction, energy):
    return np.ones(len(position))


@pytest.fixture(scope="module")
def rendering():
    return emitree.render(flat, CAMERA, (6, 8), energy=ENERGY, unit=UNIT, instrument=INSTRUMENT)


def test_the_expected_counts_are_those_of_the_closed_form(rendering):
    half = np.tan(np.radians(0.5))
    solid_angle = 4 * np.arcsin(half**2 / (1 + half**2))
    steps = rendering.count_steps
    # 1 photon cm-3 s-1 sr-1 keV-1 over 2 cm, 1 keV, 1e9 s and 50 cm2; the paths of a pinhole are
    # longer off the axis by no more than 4e-5.
    assert list(steps) == ["photons", "area", "psf", "background"]
    assert steps["area"]["after"] == pytest.approx(2 * solid_angle * 1e9 * 50, rel=1e-4)
    for sums in steps.values():
        balance = sums["before"] + sums["added"] - sums["lost"] - sums["after"]
        assert abs(balance) <= 1e-11 * sums["after"]
    expected = rendering.expected_counts
    assert expected.shape == (4, 6, 8)
    assert expected.sum() == pytest.approx(list(steps.values())[-1]["after"])


def test_counts_are_drawn_by_seed(rendering):
    counts = rendering.draw_counts()
    assert np.array_equal(counts, rendering.draw_counts(3))
    assert not np.array_equal(counts, rendering.draw_counts(4))
    assert np.array_equal(counts, np.round(counts))
    expected = rendering.expected_counts.sum()
    assert abs(counts.sum() - expected) < 5 * np.sqrt(expected)


def test_without_an_instrument_nothing_counts():
    rendering = emitree.render("1", emitree.Canonical(), (2, 2))
    with pytest.raises(ValueError, match="nothing counts photons: expected `instrument`"):
        _ = rendering.expected_counts


def test_counts_as_fits(rendering, tmp_path):
    fits = pytest.importorskip("astropy.io.fits")
    rendering.counts_to_fits(tmp_path / "counts.fits")
    with pytest.raises(FileExistsError):
        rendering.counts_to_fits(tmp_path / "counts.fits")
    with fits.open(tmp_path / "counts.fits", checksum=True) as file:
        assert np.array_equal(file[0].data, rendering.draw_counts(3))
        header = file[0].header
        assert (header["BUNIT"], header["SEED"], header["EXPOSURE"]) == ("count", 3, 1e9)
        assert header["CTYPE1"].endswith("TAN") and header["CTYPE3"] == "CHANNEL"
        bounds = file["EBOUNDS"].data
        assert list(bounds["CHANNEL"]) == list(rendering.channels[:, 0])
        np.testing.assert_allclose(bounds["E_MIN"], [0.5, 0.75, 1.0, 1.25])
        np.testing.assert_allclose(bounds["E_MAX"], [0.75, 1.0, 1.25, 1.5])
    expected = rendering.counts_to_fits(expected=True)
    assert expected[0].name == "EXPECTED" and "SEED" not in expected[0].header
    assert np.array_equal(expected[0].data, rendering.expected_counts)
    assert rendering.counts_to_fits(seed=8)[0].header["SEED"] == 8


def test_the_spectrum_of_the_counts(rendering):
    spectrum = rendering.spectrum()
    np.testing.assert_allclose(spectrum.values, rendering.expected_counts.sum(axis=(1, 2)))
    np.testing.assert_allclose(spectrum.middle, [0.625, 0.875, 1.125, 1.375])
    np.testing.assert_allclose(spectrum.error, np.sqrt(spectrum.values))
    assert (spectrum.unit, spectrum.energy_unit, len(spectrum)) == ("count", "keV", 4)
    where = np.zeros((6, 8), dtype=bool)
    where[2, 3] = True
    drawn = rendering.draw_counts(5)
    assert np.array_equal(rendering.spectrum(drawn, where=where).values, drawn[:, 2, 3])
    with pytest.raises(ValueError, match=r"`counts` has the shape .*: expected \(4, 6, 8\)"):
        rendering.spectrum(drawn[:2])
    with pytest.raises(ValueError, match=r"`where` has the shape \(2, 2\): expected \(6, 8\)"):
        rendering.spectrum(where=np.ones((2, 2)))


def test_the_spectrum_of_a_cube():
    cube = emitree.render("x * E", emitree.Canonical(), (2, 4), energy=emitree.Energies(0, 2, 2))
    spectrum = cube.spectrum()
    np.testing.assert_allclose(spectrum.values, [0.25, 0.75], rtol=0.01)
    np.testing.assert_allclose(spectrum.values, cube.image.mean(axis=(1, 2)))
    assert (spectrum.error <= 0.01 * cube.image.max()).all()
    with pytest.raises(ValueError, match="the image has no energies: expected `energy`"):
        emitree.render("1", emitree.Canonical(), (2, 2)).spectrum()


def test_spectra_are_plotted(rendering):
    plt = pytest.importorskip("matplotlib.pyplot")
    ax = rendering.spectrum().plot(color="k")
    assert ax.get_xlabel() == "energy [keV]" and ax.get_ylabel() == "expected counts [count]"
    (steps,) = ax.patches
    np.testing.assert_allclose(steps.get_data().edges, [0.5, 0.75, 1.0, 1.25, 1.5])
    np.testing.assert_allclose(steps.get_data().values, rendering.spectrum().values)
    drawn = rendering.spectrum(rendering.draw_counts())
    ax = drawn.plot(plt.subplots()[1], per_energy=True)
    assert ax.get_ylabel() == "counts [count / keV]"
    np.testing.assert_allclose(ax.patches[0].get_data().values, 4 * drawn.values)
    ax.figure.canvas.draw()
    plt.close("all")


def test_quantities_in_an_instrument(rendering):
    u = pytest.importorskip("astropy.units")
    instrument = {
        "effective_area": 50e-4 * u.m**2,
        "exposure": 1e6 * u.ks,
        "psf": {"fwhm_pixels": 1.5 * u.pix},
        "background": {"per_pixel": 1e-5 / u.ks},
        "seed": 3,
    }
    as_class = emitree.Instrument(**instrument)
    for given in (instrument, as_class):
        ours = emitree.render(flat, CAMERA, (6, 8), energy=ENERGY, unit=UNIT, instrument=given)
        np.testing.assert_allclose(ours.expected_counts, rendering.expected_counts, rtol=1e-12)
    for background in ({"per_pixel": 1e-8 * u.ct / u.s}, {"per_kev_sr": 2 / u.s / u.keV / u.sr}):
        emitree.Instrument(exposure=1, background=background).table()
    for psf in (2 * u.arcmin, {"fwhm_arcsec": 2 * u.arcmin}):
        table = emitree.Instrument(exposure=1 * u.h, psf=psf).table()
        assert table == {"exposure": pytest.approx(3600.0), "psf": {"fwhm_arcsec": 120.0}}


@pytest.mark.parametrize(("key", "unit"), [
    ("exposure", "km"), ("effective_area", "s"), ("psf.fwhm_arcsec", "s"),
    ("background.per_pixel", "km"), ("seed", "s"),
])  # fmt: skip
def test_a_wrong_unit_names_its_key(key, unit):
    u = pytest.importorskip("astropy.units")
    outer, _, inner = key.partition(".")
    value = 2 * u.Unit(unit)
    instrument = {"exposure": 1.0, outer: {inner: value} if inner else value}
    with pytest.raises(emitree.SceneError, match=rf"`instrument\.{key}` is 2\.0 {unit}: expected"):
        emitree.render(flat, CAMERA, (2, 2), energy=ENERGY, unit=UNIT, instrument=instrument)


def test_wrong_instruments_are_refused():
    with pytest.raises(emitree.SceneError, match=r"instrument\.exposure"):
        emitree.render(
            flat, CAMERA, (2, 2), energy=ENERGY, unit=UNIT, instrument={"effective_area": 1.0}
        )
