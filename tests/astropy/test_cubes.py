"""Spectral cubes as NumPy, astropy, spectral-cube and healpy read them."""

import warnings

import healpy
import numpy as np
import pytest
from astropy import units
from astropy.io import fits
from astropy.wcs import WCS
from conftest import HEIGHT, WIDTH

# Ends, bins, unit, logarithmic: as in `write_samples`.
AXES = {
    "linear_kev": (0.3, 12.0, 9, "keV", False),
    "linear_ev": (0.0, 2000.0, 4, "eV", False),
    "linear_one": (6.39, 6.41, 1, "keV", False),
    "log_kev": (0.3, 12.0, 9, "keV", True),
    "log_gev": (0.1, 300.0, 3, "GeV", True),
    "log_j": (1e-17, 3e-15, 6, "J", True),
}


@pytest.fixture(params=AXES)
def name(request) -> str:
    return request.param


@pytest.fixture
def hdus(samples, name):
    with fits.open(samples / f"cube_{name}.fits", checksum=True) as opened:
        yield opened


def edges(low, high, bins, unit, logarithmic):
    """The borders of the bins, from the definition of the axis."""
    ends = np.geomspace if logarithmic else np.linspace
    return units.Quantity(ends(low, high, bins + 1), unit)


def centres(name):
    """The middle of each bin on its own scale."""
    borders = edges(*AXES[name])
    if AXES[name][-1]:
        return np.sqrt(borders[:-1] * borders[1:])
    return (borders[:-1] + borders[1:]) / 2


def expected(bins):
    bins, rows, columns = np.mgrid[:bins, :HEIGHT, :WIDTH]
    return bins * 1e6 + rows * 1000.0 + columns + 0.25


def test_the_file_is_valid(hdus):
    hdus.verify("exception")
    assert [hdu.name for hdu in hdus] == ["RADIANCE", "ERROR", "BAND", "ENERGIES"]
    for hdu in hdus:
        assert hdu.verify_datasum() == 1
        assert hdu.verify_checksum() == 1


def test_voxels_are_in_place(hdus, samples, name):
    bins = AXES[name][2]
    for hdu in hdus[:2]:
        assert hdu.data.shape == (bins, HEIGHT, WIDTH)
        assert [hdu.header[f"NAXIS{axis}"] for axis in (1, 2, 3)] == [WIDTH, HEIGHT, bins]
        assert hdu.header["BITPIX"] == -64
        np.testing.assert_array_equal(hdu.data, expected(bins))
    np.testing.assert_array_equal(np.load(samples / f"cube_{name}.npy"), hdus[0].data)
    assert hdus["BAND"].data.shape == (HEIGHT, WIDTH)


def test_the_table_has_the_ends_of_all_bins(hdus, name):
    table = hdus["ENERGIES"]
    borders = edges(*AXES[name])
    for column, ends in [("E_MIN", borders[:-1]), ("E_MAX", borders[1:])]:
        unit = units.Unit(table.columns[column].unit, format="fits")
        assert unit == units.Unit(AXES[name][3])
        found = units.Quantity(table.data[column], unit)
        np.testing.assert_allclose(found.to_value(units.J), ends.to_value(units.J), rtol=1e-12)
    np.testing.assert_array_equal(table.data["E_MIN"][1:], table.data["E_MAX"][:-1])


@pytest.mark.parametrize("extension", ["RADIANCE", "ERROR"])
def test_the_coordinates_have_the_energies_of_all_bins(hdus, name, extension):
    wcs = WCS(hdus[extension].header)
    assert wcs.naxis == 3
    logarithmic = AXES[name][-1]
    assert wcs.wcs.ctype[2] == ("ENER-LOG" if logarithmic else "ENER")
    assert hdus[extension].header["CUNIT3"] == "J"
    bins = AXES[name][2]
    world = wcs.all_pix2world(np.zeros(bins), np.zeros(bins), np.arange(bins), 0)
    found = units.Quantity(world[2], wcs.wcs.cunit[2])
    np.testing.assert_allclose(
        found.to_value(units.J), centres(name).to_value(units.J), rtol=1e-9, atol=0
    )
    # And back.
    pixels = wcs.all_world2pix(*world, 0)
    np.testing.assert_allclose(pixels[2], np.arange(bins), rtol=0, atol=1e-9)


def test_the_sky_is_that_of_each_image(hdus):
    cube, band = WCS(hdus["RADIANCE"].header), WCS(hdus["BAND"].header)
    assert band.naxis == 2
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    of_cube = cube.all_pix2world(columns, rows, np.zeros_like(rows), 0)
    of_band = band.all_pix2world(columns, rows, 0)
    np.testing.assert_allclose(of_cube[:2], of_band, rtol=0, atol=1e-12)


def test_units_parse(hdus):
    unit = units.Unit(hdus[0].header["BUNIT"], format="fits")
    assert unit == units.photon / (units.cm**2 * units.s * units.sr * units.keV)


def test_spectral_cube_reads_it(samples, name):
    with warnings.catch_warnings():
        # Of what the package imports, and of what it does with any file of several HDUs.
        warnings.simplefilter("ignore")
        from spectral_cube import SpectralCube

        cube = SpectralCube.read(samples / f"cube_{name}.fits", hdu=0)
    bins = AXES[name][2]
    assert cube.shape == (bins, HEIGHT, WIDTH)
    found = cube.spectral_axis.to_value(units.J)
    np.testing.assert_allclose(found, centres(name).to_value(units.J), rtol=1e-9, atol=0)
    np.testing.assert_array_equal(cube.unmasked_data[:].value, expected(bins))


def test_a_sky_has_a_column_for_each_bin(samples):
    path = samples / "cube_sky.fits"
    bands = healpy.read_map(path, field=(0, 1, 2), nest=True, dtype=np.float64)
    np.testing.assert_array_equal(bands, 100 * np.arange(3)[:, None] + np.arange(48))
    with fits.open(path, checksum=True) as hdus:
        hdus.verify("exception")
        assert hdus[1].columns.names == ["RADIANCE_1", "RADIANCE_2", "RADIANCE_3"]
        ends = hdus["ENERGIES"].data
        np.testing.assert_allclose(ends["E_MIN"], [0.5, 1.0, 2.0], rtol=1e-14)
        np.testing.assert_allclose(ends["E_MAX"], [1.0, 2.0, 4.0], rtol=1e-14)
        assert hdus["ENERGIES"].columns["E_MAX"].unit == "keV"
