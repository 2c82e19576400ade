"""Cubes of counts in channels as NumPy and astropy read them."""

import numpy as np
import pytest
from astropy import units
from astropy.io import fits
from astropy.wcs import WCS
from conftest import HEIGHT, WIDTH

# The numbers of the channels, and their coordinates: as in `write_samples`.
CHANNELS = {"even": [31, 32, 33, 34], "uneven": [31, 32, 33, 35]}
COORDINATES = {"even": [31, 32, 33, 34], "uneven": [1, 2, 3, 4]}


@pytest.fixture(params=CHANNELS)
def name(request) -> str:
    return request.param


@pytest.fixture
def hdus(samples, name):
    with fits.open(samples / f"counts_{name}.fits", checksum=True) as opened:
        yield opened


def test_the_file_is_valid(hdus):
    hdus.verify("exception")
    assert [hdu.name for hdu in hdus] == ["COUNTS", "EBOUNDS"]
    for hdu in hdus:
        assert hdu.verify_datasum() == 1
        assert hdu.verify_checksum() == 1


def test_counts_are_in_place(hdus):
    channels, rows, columns = np.mgrid[:4, :HEIGHT, :WIDTH]
    expected = channels * 1e6 + rows * 1000.0 + columns + 0.25
    np.testing.assert_array_equal(hdus[0].data, expected)
    assert units.Unit(hdus[0].header["BUNIT"], format="fits") == units.count


def test_the_table_has_the_channels(hdus, name):
    table = hdus["EBOUNDS"]
    assert table.header["HDUCLAS1"] == "RESPONSE"
    assert table.header["HDUCLAS2"] == "EBOUNDS"
    np.testing.assert_array_equal(table.data["CHANNEL"], CHANNELS[name])
    assert np.issubdtype(table.data["CHANNEL"].dtype, np.integer)
    np.testing.assert_array_equal(table.data["E_MIN"], [0.5, 1.0, 1.5, 2.0])
    np.testing.assert_array_equal(table.data["E_MAX"], [1.0, 1.5, 2.0, 2.5])
    for column in ["E_MIN", "E_MAX"]:
        assert units.Unit(table.columns[column].unit, format="fits") == units.keV


def test_the_third_axis_is_the_channel(hdus, name):
    wcs = WCS(hdus[0].header)
    assert wcs.naxis == 3
    assert hdus[0].header["CTYPE3"] == {"even": "CHANNEL", "uneven": "ROW"}[name]
    assert wcs.celestial.wcs.ctype[0] == "XLON-TAN"
    middle = [(WIDTH - 1) / 2, (HEIGHT - 1) / 2]
    found = [wcs.all_pix2world([[*middle, channel]], 0)[0] for channel in range(4)]
    np.testing.assert_allclose([world[2] for world in found], COORDINATES[name], rtol=1e-14)
    np.testing.assert_allclose([world[:2] for world in found], 0, atol=1e-12)
