"""HEALPix maps as healpy and astropy read them."""

import healpy
import numpy as np
import pytest
from astropy import units
from astropy.io import fits

NSIDE = 8
PIXELS = 12 * NSIDE**2


@pytest.fixture
def path(samples):
    return samples / "healpix.fits"


def test_the_file_is_valid(path):
    with fits.open(path, checksum=True) as hdus:
        hdus.verify("exception")
        assert len(hdus) == 2
        for hdu in hdus:
            assert hdu.verify_datasum() == 1
            assert hdu.verify_checksum() == 1


def test_values_are_at_their_pixels(path):
    radiance, number = healpy.read_map(path, field=(0, 1), nest=True, dtype=np.float64)
    np.testing.assert_array_equal(number, np.arange(PIXELS))
    x, y, z = healpy.pix2vec(NSIDE, np.arange(PIXELS), nest=True)
    np.testing.assert_allclose(radiance, x + 10 * y + 100 * z, rtol=0, atol=1e-13)


def test_healpy_reorders_to_rings(path):
    radiance = healpy.read_map(path, dtype=np.float64)
    x, y, z = healpy.pix2vec(NSIDE, np.arange(PIXELS))
    np.testing.assert_allclose(radiance, x + 10 * y + 100 * z, rtol=0, atol=1e-13)


def test_headers(path):
    primary, table = fits.getheader(path, 0), fits.getheader(path, 1)
    assert primary["NAXIS"] == 0
    assert primary["METHOD"] == "vol"
    assert primary["CREATOR"] == "emitree"
    assert primary["DATE"] == "2026-11-21T02:30:00"
    assert "[projection]" in list(primary["HISTORY"])
    expected = {
        "PIXTYPE": "HEALPIX",
        "ORDERING": "NESTED",
        "NSIDE": NSIDE,
        "FIRSTPIX": 0,
        "LASTPIX": PIXELS - 1,
        "INDXSCHM": "IMPLICIT",
        "OBJECT": "FULLSKY",
        "NAXIS2": PIXELS,
        "TTYPE1": "RADIANCE",
        "TTYPE2": "NUMBER",
    }
    assert {key: table[key] for key in expected} == expected
    assert "COORDSYS" not in table and "TUNIT2" not in table
    unit = units.Unit(table["TUNIT1"], format="fits")
    assert unit == units.photon / (units.cm**2 * units.s * units.sr)
