"""The coordinates that astropy finds in our headers, against the lines of sight of our cameras.

Neither side is made from the other: the header comes from the numbers of the scene, the lines of
sight are what the camera does with them. The pointing is computed here, from the scene.
"""

import tomllib

import healpy
import numpy as np
import pytest
from astropy import units
from astropy.io import fits
from astropy.wcs import WCS

AGREEMENT = 1e-9
UNITS = {"R_E": "6371 km"}
PARALLEL = ["radii", "units", "numbers"]
SPHERICAL = {
    "tangent": "TAN",
    "tangent_high": "TAN",
    "angles": "CAR",
    "angles_all": "CAR",
    "arc": "ARC",
    "arc_all": "ARC",
    "zea": "ZEA",
    "zea_all": "ZEA",
}
POLAR = ["polar", "polar_all"]


class View:
    """A scene, the coordinates of its header, and the lines through the corners of its pixels."""

    def __init__(self, samples, name):
        scene = tomllib.loads((samples / f"view_{name}.toml").read_text())
        self.projection = scene["projection"]
        self.shape = (scene["image"]["height"], scene["image"]["width"])
        self.wcs = WCS(fits.getheader(samples / f"view_{name}.fits"))
        lines = np.load(samples / f"view_{name}.npy")
        assert lines.shape == (self.shape[0] + 1, self.shape[1] + 1, 2, 3)
        rows, columns = np.indices(lines.shape[:2])
        self.in_image = np.isfinite(lines).all(axis=(2, 3))
        self.columns, self.rows = columns[self.in_image], rows[self.in_image]
        positions, directions = np.moveaxis(lines[self.in_image], 1, 0)
        position = np.array(self.projection["position"])
        forward = unit(self.projection["target"] - position)
        up = np.array(self.projection["up"])
        up = unit(up - (up @ forward) * forward)
        right = np.cross(forward, up)
        frame = np.array([right, up, forward])
        # Components to the right, up and forward, of points and of directions.
        self.points = (positions - position) @ frame.T
        self.sights = directions @ frame.T

    def world(self):
        """The corners by astropy; FITS counts pixels from 1 in their centres."""
        return self.wcs.all_pix2world(self.columns + 0.5, self.rows + 0.5, 1)


def unit(vector):
    return vector / np.linalg.norm(vector)


def sphere(longitude_deg, latitude_deg):
    """Directions (right, up, forward) of longitude and latitude about the pointing."""
    longitude, latitude = np.radians(longitude_deg), np.radians(latitude_deg)
    right, forward = np.sin(longitude), np.cos(longitude)
    return np.stack(
        [np.cos(latitude) * right, np.sin(latitude), np.cos(latitude) * forward], axis=-1
    )


def apart_deg(a, b):
    """Angles between unit vectors, to the last digit also where they are small."""
    return np.degrees(2 * np.arcsin(np.minimum(np.linalg.norm(a - b, axis=-1) / 2, 1)))


@pytest.mark.parametrize("name", SPHERICAL)
def test_angles_about_the_pointing(samples, name):
    view = View(samples, name)
    height, width = view.shape
    if SPHERICAL[name] in ("TAN", "CAR"):
        assert view.in_image.all()
    else:
        x, y = 2 * np.arange(width + 1) / width - 1, 2 * np.arange(height + 1) / height - 1
        np.testing.assert_array_equal(view.in_image, x**2 + y[:, np.newaxis] ** 2 <= 1)
    assert [text[5:] for text in view.wcs.wcs.ctype] == 2 * [SPHERICAL[name]]
    np.testing.assert_allclose(np.linalg.norm(view.sights, axis=-1), 1, rtol=0, atol=1e-14)
    np.testing.assert_array_less(apart_deg(sphere(*view.world()), view.sights), AGREEMENT)


@pytest.mark.parametrize("name", SPHERICAL)
def test_points_lie_on_their_lines(samples, name):
    view = View(samples, name)
    depth = (view.projection["near"] + view.projection["far"]) / 2
    np.testing.assert_allclose(view.points, depth * view.sights, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", PARALLEL)
def test_lengths_on_the_plane(samples, name):
    view = View(samples, name)
    assert view.in_image.all()
    length = view.projection.get("length_unit", "")
    length = units.Unit(UNITS.get(length, length))
    for axis, (extent, world) in enumerate(zip(view.projection["extent"], view.world())):
        found = world * units.Unit(view.wcs.wcs.cunit[axis])
        error = found.to_value(length) - view.points[:, axis]
        np.testing.assert_allclose(error / extent, 0, rtol=0, atol=AGREEMENT)
        assert np.ptp(view.points[:, axis]) == pytest.approx(extent, rel=1e-13)
    # All lines are along the pointing.
    assert apart_deg(view.sights, np.array([0.0, 0.0, 1.0])).max() < AGREEMENT


@pytest.mark.parametrize("name", POLAR)
def test_azimuth_and_angle(samples, name):
    view = View(samples, name)
    assert view.in_image.all()
    azimuth, angle = (np.radians(degrees) for degrees in view.world())
    across = np.sin(angle)
    expected = [across * np.cos(azimuth), across * np.sin(azimuth), np.cos(angle)]
    assert apart_deg(np.stack(expected, axis=-1), view.sights).max() < AGREEMENT
    right, up, forward = view.sights.T
    found = np.degrees(np.arctan2(np.hypot(right, up), forward))
    np.testing.assert_allclose(found, np.degrees(angle), rtol=0, atol=AGREEMENT)


NSIDE = 4
PIXELS = np.arange(12 * NSIDE**2)
OBSERVER = np.array([3.0, -2.0, 1.0])


def test_sky_pixels_are_those_of_healpy(samples):
    lines = np.load(samples / "sky_lines.npy")
    assert lines.shape == (len(PIXELS), 5, 2, 3)
    points, sights = lines[:, :, 0], lines[:, :, 1]
    middles = np.stack(healpy.pix2vec(NSIDE, PIXELS, nest=True), axis=-1)
    assert apart_deg(sights[:, 0], middles).max() < AGREEMENT
    corners = np.moveaxis(healpy.boundaries(NSIDE, PIXELS, step=1, nest=True), 1, 2)
    assert apart_deg(sights[:, 1:], corners).max() < AGREEMENT
    np.testing.assert_allclose(points, OBSERVER + 1.5 * sights, rtol=0, atol=1e-12)


def weighed_mean_sights():
    """x + 10 y + 100 z, as means over the 4096 smaller pixels that each pixel consists of."""
    small = np.arange(4096 * len(PIXELS))
    x, y, z = healpy.pix2vec(64 * NSIDE, small, nest=True)
    return (x + 10 * y + 100 * z).reshape(len(PIXELS), -1).mean(axis=1)


def test_a_rendered_sky_has_its_values_where_healpy_expects_them(samples):
    expected = weighed_mean_sights()
    # The rendering's tolerance; any two pixels differ by far more.
    tolerance = 1e-5 * np.abs(expected).max()
    assert np.diff(np.sort(expected)).min() > 30 * tolerance
    map_ = healpy.read_map(samples / "sky.fits", nest=True, dtype=np.float64)
    np.testing.assert_allclose(map_, expected, rtol=0, atol=tolerance)
    np.testing.assert_array_equal(np.load(samples / "sky.npy"), map_)
    rings = healpy.read_map(samples / "sky.fits", dtype=np.float64)
    np.testing.assert_array_equal(rings[healpy.nest2ring(NSIDE, PIXELS)], map_)
