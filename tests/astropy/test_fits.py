"""FITS files as astropy reads them."""

import numpy as np
import pytest
from astropy import units
from astropy.io import fits
from astropy.wcs import WCS
from conftest import HEIGHT, WIDTH

R_E_KM = 6371.0


def equirectangular(x, y, width_deg, height_deg):
    """Sights (right, up, forward) at canonical (x, y): uniform steps of two angles."""
    longitude = np.radians((x - 0.5) * width_deg)
    latitude = np.radians((y - 0.5) * height_deg)
    right = np.cos(latitude) * np.sin(longitude)
    return right, np.sin(latitude), np.cos(latitude) * np.cos(longitude)


def perspective(x, y, width_deg, height_deg):
    """Through a pinhole: straight lines to a plane at distance 1."""
    right = np.tan(np.radians(width_deg) / 2) * (2 * x - 1)
    up = np.tan(np.radians(height_deg) / 2) * (2 * y - 1)
    length = np.sqrt(right**2 + up**2 + 1)
    return right / length, up / length, 1 / length


def fisheye(x, y, fov_deg, equal_area):
    """A disc of radius 1/2: the angle from the pointing, or the sine of its half, is linear."""
    radius = np.hypot(x - 0.5, y - 0.5)
    if equal_area:
        sine = 2 * radius * np.sin(np.radians(fov_deg) / 4)
        angle = np.where(sine <= 1, 2 * np.arcsin(np.minimum(sine, 1)), np.nan)
    else:
        angle = np.radians(fov_deg) * radius
        angle = np.where(angle <= np.pi, angle, np.nan)
    azimuth = np.arctan2(y - 0.5, x - 0.5)
    return np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)


SPHERICAL = {
    "narrow": ("CAR", lambda x, y: equirectangular(x, y, 16.0, 27.0)),
    "all_sky": ("CAR", lambda x, y: equirectangular(x, y, 360.0, 180.0)),
    "perspective": ("TAN", lambda x, y: perspective(x, y, 100.0, 60.0)),
    "fisheye_arc": ("ARC", lambda x, y: fisheye(x, y, 200.0, False)),
    "fisheye_arc_360": ("ARC", lambda x, y: fisheye(x, y, 360.0, False)),
    "fisheye_zea": ("ZEA", lambda x, y: fisheye(x, y, 150.0, True)),
    "fisheye_zea_360": ("ZEA", lambda x, y: fisheye(x, y, 360.0, True)),
}
LINEAR = {
    "canonical": (["X", "Y"], ["", ""], lambda x, y: (x, y)),
    "orthographic": (
        ["X", "Y"],
        ["km", "km"],
        lambda x, y: (20 * R_E_KM * (x - 0.5), 35 * R_E_KM * (y - 0.5)),
    ),
    "polar": (["AZIMUTH", "ANGLE"], ["deg", "deg"], lambda x, y: (360 * x, 70 * y)),
}
FILES = [*SPHERICAL, *LINEAR]


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


def angles_deg(sight):
    """Longitude and latitude about the pointing."""
    right, up, forward = sight
    latitude = np.arctan2(up, np.hypot(right, forward))
    return np.degrees(np.arctan2(right, forward)), np.degrees(latitude)


def turned_deg(difference):
    """A difference of longitudes, from -180 to 180."""
    return (difference + 180.0) % 360.0 - 180.0


@pytest.mark.parametrize("camera", LINEAR)
@pytest.mark.parametrize("extension", ["RADIANCE", "ERROR"])
def test_linear_coordinates(samples, camera, extension):
    wcs = WCS(fits.getheader(samples / f"{camera}.fits", extension))
    types, cunits, expected = LINEAR[camera]
    first, second, x, y = corners()
    world = wcs.all_pix2world(first, second, 1)
    np.testing.assert_allclose(world, expected(x, y), rtol=1e-14, atol=1e-10)
    assert list(wcs.wcs.ctype) == types
    assert [str(unit) for unit in wcs.wcs.cunit] == cunits


def test_lengths_are_lengths(samples):
    wcs = WCS(fits.getheader(samples / "orthographic.fits"))
    step = wcs.wcs.cdelt[0] * wcs.wcs.cunit[0]
    assert step.to_value(units.m) == pytest.approx(20 * R_E_KM * 1000 / WIDTH, rel=1e-14)


@pytest.mark.parametrize("camera", SPHERICAL)
@pytest.mark.parametrize("extension", ["RADIANCE", "ERROR"])
def test_angles_about_the_pointing(samples, camera, extension):
    wcs = WCS(fits.getheader(samples / f"{camera}.fits", extension))
    code, sight = SPHERICAL[camera]
    first, second, x, y = corners()
    expected = np.array(angles_deg(sight(x, y)))
    seen = np.isfinite(expected).all(axis=0)
    # Corners of the image beyond the back of the observer's head are on no line of sight.
    assert seen.all() or camera.endswith("_360") and seen.sum() >= 20
    longitude, latitude = wcs.all_pix2world(first[seen], second[seen], 1)
    difference = turned_deg(longitude - expected[0][seen])
    # At a pole of the angles any longitude is right.
    at_pole = np.abs(expected[1][seen]) > 90 - 1e-9
    np.testing.assert_allclose(difference[~at_pole], 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(latitude, expected[1][seen], rtol=0, atol=1e-9)
    assert list(wcs.wcs.ctype) == [f"XLON-{code}", f"XLAT-{code}"]
    assert [str(unit) for unit in wcs.wcs.cunit] == ["deg", "deg"]
    assert wcs.wcs.lng == 0 and wcs.wcs.lat == 1
    assert (wcs.wcs.cdelt > 0).all()


@pytest.mark.parametrize("camera", SPHERICAL)
def test_right_is_east_and_up_is_north(samples, camera):
    wcs = WCS(fits.getheader(samples / f"{camera}.fits"))
    middle = np.array([WIDTH / 2 + 0.5, HEIGHT / 2 + 0.5])
    angles = [wcs.all_pix2world(*(middle + step), 1) for step in [(0, 0), (0.01, 0), (0, 0.01)]]
    (here_lon, here_lat), (right_lon, right_lat), (up_lon, up_lat) = angles
    np.testing.assert_allclose(turned_deg(here_lon), 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(here_lat, 0.0, rtol=0, atol=1e-12)
    assert turned_deg(right_lon) > 1e-3 and abs(right_lat) < 1e-12
    assert up_lat > 1e-3 and abs(turned_deg(up_lon)) < 1e-12


@pytest.mark.parametrize("camera", SPHERICAL)
def test_angles_lead_back_to_pixels(samples, camera):
    wcs = WCS(fits.getheader(samples / f"{camera}.fits"))
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    sight = SPHERICAL[camera][1]((columns + 0.5) / WIDTH, (rows + 0.5) / HEIGHT)
    seen = np.isfinite(sight).all(axis=0)
    assert seen.sum() >= 20
    longitude, latitude = angles_deg(sight)
    back = wcs.all_world2pix(longitude[seen], latitude[seen], 0)
    np.testing.assert_allclose(back, [columns[seen], rows[seen]], rtol=0, atol=1e-9)


def test_units_of_images(samples):
    """BUNIT times the pixel is the unit of the rate times that of the length."""
    with fits.open(samples / "units.fits") as hdus:
        assert len(hdus) == 12
        for hdu in hdus:
            rate, length = hdu.header["EXTNAME"].split(" x ")
            unit = units.Unit(hdu.header.get("BUNIT", ""), format="fits")
            number, rate = (2.5, rate[4:]) if rate.startswith("2.5 ") else (1.0, rate)
            names = {"1": "", "R_sun": "solRad"}
            rate, length = (units.Unit(names.get(t, t), format="fits") for t in (rate, length))
            factor = (number * rate * length).to_value(unit)
            assert hdu.data[0, 0] == pytest.approx(factor, rel=4e-15), hdu.header["EXTNAME"]


def test_no_extension_of_another_shape_has_coordinates(hdus):
    assert "CTYPE1" not in hdus["EVALUATIONS"].header
