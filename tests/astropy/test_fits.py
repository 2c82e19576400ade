"""FITS files as astropy reads them."""

import numpy as np
import pytest
from astropy import units
from astropy.io import fits
from astropy.wcs import WCS
from conftest import HEIGHT, WIDTH

FILES = ["canonical", "narrow", "all_sky"]
FIELDS_DEG = {"narrow": (16.0, 27.0), "all_sky": (360.0, 180.0)}


@pytest.fixture(params=FILES)
def name(request) -> str:
    return request.param


@pytest.fixture
def hdus(samples, name):
    with fits.open(samples / f"{name}.fits", checksum=True) as opened:
        yield opened


def test_the_file_is_valid(hdus):
    hdus.verify("exception")
    for hdu in hdus:
        assert hdu.verify_datasum() == 1
        assert hdu.verify_checksum() == 1


def test_pixels_come_back_bit_for_bit(hdus, image, error):
    for hdu, expected in [(hdus[0], image), (hdus["ERROR"], error)]:
        assert hdu.data.shape == (HEIGHT, WIDTH)
        assert (hdu.header["NAXIS1"], hdu.header["NAXIS2"]) == (WIDTH, HEIGHT)
        assert hdu.header["BITPIX"] == -64
        assert hdu.data.tobytes() == expected.astype(">f8").tobytes()
    np.testing.assert_array_equal(hdus["EVALUATIONS"].data, [[1.0, 2.0, 3.0]])


def test_units_parse(hdus):
    for hdu in hdus[:2]:
        unit = units.Unit(hdu.header["BUNIT"], format="fits")
        assert unit == units.m**-2 * units.sr**-1 / units.s
    assert "BUNIT" not in hdus["EVALUATIONS"].header


def test_provenance(hdus):
    header = hdus[0].header
    assert header["EXTNAME"] == "RADIANCE"
    assert header["CREATOR"] == "emitree"
    assert header["VERSION"]
    assert header["DATE"] == "2026-11-21T02:30:00"
    assert header["METHOD"] == "vol"
    assert header["TOL"] == 0.1 + 0.2
    assert "ESTERR" in header and header["ESTERR"] is None
    assert header["NEVAL"] == 4066
    assert header["CONVERGD"] is True
    assert header["SCENE"] == "scenes/" + 30 * "long/" + "'s.toml"
    assert header["MODEL"] == r"J\u00f8rgensen & Holmstr\u00f6m"
    assert header.comments["TOL"] == "tolerance, relative to the largest pixel"


def test_the_scene_can_be_had_back(hdus):
    lines, unfinished = [], ""
    for record in hdus[0].header["HISTORY"]:
        if len(record) == 72 and record.endswith("\\"):
            unfinished += record[:-1]
        else:
            lines.append(unfinished + record)
            unfinished = ""
    ball = "exp(-a*((x-{})^2 + (y-0.5)^2 + (z-0.5)^2))"
    assert lines == [
        r"# R\u00f6ntgen image of the magnetosheath, 30 R\u2295 away",
        "[emission]",
        f'expression = "{ball.format(0.5)} + {ball.format(0.25)}"',
        "",
        "[projection]",
        'type = "equirectangular"  # equal angles',
    ]


def corners():
    """FITS pixel coordinates of all pixel corners, and their canonical x and y."""
    rows, columns = np.mgrid[: HEIGHT + 1, : WIDTH + 1]
    return columns + 0.5, rows + 0.5, columns / WIDTH, rows / HEIGHT


@pytest.mark.parametrize("extension", ["RADIANCE", "ERROR"])
def test_canonical_coordinates(samples, extension):
    header = fits.getheader(samples / "canonical.fits", extension)
    wcs = WCS(header)
    first, second, x, y = corners()
    world = wcs.all_pix2world(first, second, 1)
    np.testing.assert_allclose(world, [x, y], rtol=0, atol=1e-15)
    assert list(wcs.wcs.ctype) == ["X", "Y"]


@pytest.mark.parametrize("field", FIELDS_DEG)
@pytest.mark.parametrize("extension", ["RADIANCE", "ERROR"])
def test_angles_about_the_pointing(samples, field, extension):
    wcs = WCS(fits.getheader(samples / f"{field}.fits", extension))
    width_deg, height_deg = FIELDS_DEG[field]
    first, second, x, y = corners()
    longitude, latitude = wcs.all_pix2world(first, second, 1)
    expected = (x - 0.5) * width_deg
    difference = (longitude - expected + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(difference, 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(latitude, (y - 0.5) * height_deg, rtol=0, atol=1e-9)
    assert [str(unit) for unit in wcs.wcs.cunit] == ["deg", "deg"]
    assert wcs.wcs.lng == 0 and wcs.wcs.lat == 1
    assert wcs.wcs.cdelt[0] > 0


@pytest.mark.parametrize("field", FIELDS_DEG)
def test_angles_lead_back_to_pixels(samples, field):
    wcs = WCS(fits.getheader(samples / f"{field}.fits"))
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    longitude, latitude = wcs.all_pix2world(columns, rows, 0)
    back = wcs.all_world2pix(longitude, latitude, 0)
    np.testing.assert_allclose(back, [columns, rows], rtol=0, atol=1e-9)


def test_no_extension_of_another_shape_has_coordinates(hdus):
    assert "CTYPE1" not in hdus["EVALUATIONS"].header
