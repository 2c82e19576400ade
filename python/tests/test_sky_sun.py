"""Images of the Sun: helioprojective cameras and maps of sunpy."""

from pathlib import Path

import numpy as np
import pytest

import emitree

# sunpy.map needs reproject, and warns without it.
pytest.importorskip("reproject")
pytest.importorskip("sunpy")
import astropy.units as u
import sunpy.map
from astropy.coordinates import (
    ICRS,
    BarycentricMeanEcliptic,
    SkyCoord,
    get_body_barycentric,
)
from astropy.io import fits
from astropy.time import Time
from astropy.wcs import WCS
from sunpy.coordinates import (
    GeocentricSolarEcliptic,
    GeocentricSolarMagnetospheric,
    HeliocentricInertial,
    HeliographicCarrington,
    HeliographicStonyhurst,
    Helioprojective,
)
from sunpy.map.header_helper import make_fitswcs_header
from test_sky import EARTH, off, wcs_of
from test_sky_files import blob, centroid, seen_at

TIME = "2024-04-08T18:00:00"
SPACECRAFT = SkyCoord(70 * u.deg, 5 * u.deg, 0.6 * u.AU, frame=HeliographicStonyhurst(obstime=TIME))
SHAPE = (60, 80)


def header_of(observer=SPACECRAFT, *, centre=(300, -200), scale=20.0, roll=0.0, beside=(0, 0)):
    """The header of an image by sunpy."""
    frame = Helioprojective(observer=observer, obstime=observer.obstime)
    middle = 0.5 * (np.array(SHAPE[::-1]) - 1)
    return make_fitswcs_header(
        SHAPE,
        SkyCoord(*centre * u.arcsec, frame=frame),
        reference_pixel=(middle + beside) * u.pix,
        scale=[scale, scale] * u.arcsec / u.pix,
        rotation_angle=roll * u.deg,
    )


def camera_of(wcs, **options):
    options = {
        "frame": HeliographicCarrington(observer="self"),
        "length_unit": "R_sun",
        "near": 120.0,
        "far": 140.0,
        "shape": SHAPE,
    } | options
    return emitree.Camera.from_wcs(wcs, **options)


@pytest.mark.parametrize("seed", range(6))
def test_maps_have_the_coordinates_of_the_wcs(seed):
    random = np.random.default_rng(seed)
    observer = SkyCoord(
        random.uniform(-180, 180) * u.deg,
        random.uniform(-30, 30) * u.deg,
        random.uniform(0.05, 5) * u.AU,
        frame=HeliographicStonyhurst(obstime=TIME),
    )
    wcs = WCS(
        header_of(
            observer,
            centre=random.uniform(-3000, 3000, 2),
            scale=random.uniform(1, 60),
            roll=random.uniform(-180, 180),
            beside=random.uniform(-3, 3, 2),
        )
    )
    frame = [HeliocentricInertial(), HeliographicStonyhurst(), ICRS()][seed % 3]
    camera = camera_of(wcs, frame=frame, near=0, far=2000)
    assert camera.sky.deviation < 0.01
    rendering = emitree.render("0", camera)
    ours = rendering.to_sunpy()
    assert off(ours.wcs, wcs, SHAPE) < 0.01 and off(rendering.wcs, wcs, SHAPE) < 0.01
    assert ours.observer_coordinate.separation_3d(observer) < 10 * u.m
    assert ours.date.isot == "2024-04-08T18:00:00.000"
    assert ours.rsun_meters == 695700 * u.km
    # Through coordinates: a pixel of one is a place, which is a pixel of the other.
    x, y = ours.wcs.world_to_pixel(wcs.pixel_to_world(11.3, 47.8))
    assert abs(x - 11.3) < 0.01 and abs(y - 47.8) < 0.01


@pytest.mark.parametrize("roll", [0, 140])
def test_a_ball_over_a_place_of_the_sun_is_where_sunpy_says(roll):
    """Carrington axes of the model; sunpy alone converts the place to pixels."""
    camera = camera_of(WCS(header_of(roll=roll)))
    place = SkyCoord(
        85 * u.deg, -10 * u.deg, 1.3 * u.R_sun, frame=HeliographicStonyhurst(obstime=TIME)
    )
    found, rendering = seen_at(camera, place, 20 / 3600)
    x, y = WCS(header_of(roll=roll)).world_to_pixel(place)
    assert np.abs(found - [x, y]).max() < 0.01
    x, y = rendering.to_sunpy().wcs.world_to_pixel(place)
    assert np.abs(found - [float(x), float(y)]).max() < 0.01


def test_west_is_right_and_north_is_up():
    wcs = WCS(header_of(centre=(0, 0)))
    camera = camera_of(wcs)
    for lon, lat, right, up in ((1, 0, 1, 0), (0, 1, 0, 1)):
        # Longitudes of Stonyhurst increase to the solar west.
        place = SkyCoord(
            (70 + 15 * lon) * u.deg,
            (5 + 15 * lat) * u.deg,
            1 * u.R_sun,
            frame=HeliographicStonyhurst(obstime=TIME),
        )
        found, _ = seen_at(camera, place, 20 / 3600)
        shift = found - [39.5, 29.5]
        assert np.sign(np.round(shift / 5)).tolist() == [right, up]


def test_a_corona_around_the_sun_is_around_the_middle_of_the_disc():
    """Carrington's frame rotates with the Sun: a streamer's place in it does not depend on when."""
    found = []
    for time in ("2024-04-08", "2024-04-10"):
        streamer = SkyCoord(
            100 * u.deg,
            0 * u.deg,
            2 * u.R_sun,
            frame=HeliographicCarrington(obstime=time, observer="self"),
        )
        wcs = wcs_of("HPLN", shape=SHAPE, CRVAL1=0.0, CRVAL2=0.0)
        observer = SkyCoord(
            70 * u.deg, 5 * u.deg, 0.6 * u.AU, frame=HeliographicStonyhurst(obstime=time)
        )
        camera = camera_of(wcs, observer=observer, frame=HeliographicCarrington())
        # Between the place and the observer light travels 0.6 AU: a turn of 0.05 degrees.
        found.append(camera.sky.positions(streamer))
    assert np.allclose(
        found[0], [2 * np.cos(np.radians(100)), 2 * np.sin(np.radians(100)), 0], atol=3e-3
    )
    assert np.allclose(found[0], found[1], atol=3e-5)


def test_files_open_as_one_map(tmp_path):
    camera = camera_of(WCS(header_of()))
    rendering = emitree.render("exp(-r^2)", camera, tolerance=0.1, unit="ph cm-3 s-1 sr-1")
    assert rendering.to_fits(tmp_path / "image.fits", extensions=False) is None
    one = sunpy.map.Map(tmp_path / "image.fits")
    assert isinstance(one, sunpy.map.GenericMap)
    rendering.to_fits(tmp_path / "all.fits")
    first = sunpy.map.Map(tmp_path / "all.fits", hdus=0)
    again = rendering.to_sunpy()
    for found in (one, first, again):
        assert np.array_equal(found.data, rendering.image)
        assert found.coordinate_frame.name == "helioprojective"
        assert found.unit == u.Unit("ph cm-2 s-1 sr-1")
    assert np.array_equal(again.uncertainty.array, rendering.error)


def test_maps_can_be_cut_and_reprojected():
    """The ball of a rendering is at its place in a submap, and in the view of another observer."""
    place = SkyCoord(
        85 * u.deg, -10 * u.deg, 1 * u.R_sun, frame=HeliographicStonyhurst(obstime=TIME)
    )
    _, rendering = seen_at(camera_of(WCS(header_of())), place, 20 / 3600)
    whole = rendering.to_sunpy()
    x, y = whole.wcs.world_to_pixel(place)
    corner = [int(x) - 12, int(y) - 12] * u.pix
    part = whole.submap(corner, width=24 * u.pix, height=24 * u.pix)
    assert np.abs(centroid(part.data) - part.wcs.world_to_pixel(place)).max() < 0.01
    turned = WCS(header_of(roll=30))
    turned.array_shape = SHAPE
    again = whole.reproject_to(turned)
    expected = turned.world_to_pixel(place)
    assert np.abs(centroid(np.nan_to_num(again.data)) - expected).max() < 0.02


def test_a_camera_made_by_hand_has_a_map_by_its_observer():
    """Along -x of Stonyhurst's axes from the Earth's longitude: the middle of the disc."""
    frame = HeliographicStonyhurst(obstime=TIME)
    observer = SkyCoord(0 * u.deg, 0 * u.deg, 200 * u.R_sun, frame=frame)
    camera = emitree.Perspective(
        position=(200, 0, 0),
        target=(0, 0, 0),
        field_of_view=(1, 0.75),
        near=190,
        far=210,
        length_unit="R_sun",
    )
    rendering = emitree.render(blob(np.array([0, 1.0, 0]), 0.05), camera, SHAPE, tolerance=1e-3)
    ours = rendering.to_sunpy(observer=observer)
    assert ours.reference_coordinate.Tx.deg == pytest.approx(0, abs=1e-12)
    assert ours.observer_coordinate.separation_3d(observer) < 10 * u.m
    assert np.array_equal(ours.data, rendering.to_sunpy(frame=frame).data)
    west = SkyCoord(90 * u.deg, 0 * u.deg, 1 * u.R_sun, frame=frame)
    found = centroid(rendering.image)
    assert np.abs(found - ours.wcs.world_to_pixel(west)).max() < 0.01
    with pytest.raises(emitree.SceneError, match="expected `frame`, whose axes"):
        rendering.to_fits(coordinates=ICRS())


def test_a_plate_carree_turned_is_no_map():
    camera = emitree.Equirectangular(
        position=(200, 0, 0),
        target=(0, 0, 0),
        up=(0, 1, 3),
        field_of_view=(40, 30),
        near=190,
        far=210,
        length_unit="R_sun",
    )
    rendering = emitree.render("0", camera, SHAPE)
    frame = HeliographicStonyhurst(obstime=TIME)
    assert rendering.to_fits(frame=frame)[0].header["CTYPE1"] == "HPLN-CAR"
    with pytest.raises(emitree.SceneError, match="sunpy's maps have no LONPOLE"):
        rendering.to_sunpy(frame=frame)


@pytest.mark.parametrize("frame", [GeocentricSolarEcliptic, GeocentricSolarMagnetospheric])
def test_a_magnetosphere_is_on_the_sky_of_the_stars(frame):
    """From 20 R_E north of the ecliptic down to the Earth: 90 degrees from the Sun's direction."""
    camera = emitree.Perspective(
        position=(0, 0, 20),
        target=(0, 0, 0),
        up=(1, 0, 0),
        field_of_view=(10, 10),
        far=40,
        length_unit="R_E",
    )
    rendering = emitree.render("0", camera, (4, 4))
    header = rendering.to_fits(frame=frame(obstime=TIME))[0].header
    assert header["CTYPE1"] == "RA---TAN" and header["DATE-OBS"].startswith("2024-04-08")
    pointing = SkyCoord(header["CRVAL1"] * u.deg, header["CRVAL2"] * u.deg)
    time = Time(TIME)
    sun, earth = (get_body_barycentric(body, time) for body in ("sun", "earth"))
    # The Sun from the Earth, by astropy alone: along the x axis of both frames.
    assert pointing.separation(SkyCoord(ICRS(sun - earth))).deg == pytest.approx(90, abs=0.01)
    if frame is GeocentricSolarEcliptic:
        pole = SkyCoord(0 * u.deg, -90 * u.deg, frame=BarycentricMeanEcliptic(equinox=time))
        assert pointing.separation(pole.icrs).deg < 0.01


def test_observers_and_times_that_are_missing_or_differ_are_named():
    with pytest.raises(emitree.SceneError, match="has no date: expected DATE-OBS"):
        camera_of(wcs_of("HPLN", shape=SHAPE))
    with pytest.raises(emitree.SceneError, match="HGLN_OBS"):
        camera_of(wcs_of("HPLN", shape=SHAPE, **{"DATE-OBS": TIME, "MJD-OBS": 60408.75}))
    bare = wcs_of("HPLN", shape=SHAPE, CRVAL1=0.0, CRVAL2=0.0)
    camera = camera_of(bare, observer=SPACECRAFT)
    distance = SPACECRAFT.radius.to_value(u.R_sun)
    assert np.linalg.norm(camera.position) == pytest.approx(distance, rel=1e-12)
    assert np.allclose(camera.target, 0, atol=1e-9)
    # An observer of the stars' frame has the time of the WCS.
    dated = wcs_of("HPLN", shape=SHAPE, **{"DATE-OBS": TIME, "MJD-OBS": 60408.75})
    of_stars = ICRS(SPACECRAFT.transform_to(ICRS()).cartesian)
    again = camera_of(dated, observer=SkyCoord(of_stars))
    assert np.allclose(again.position, camera.position, atol=1e-9)
    elsewhere = SkyCoord(
        70 * u.deg, 6 * u.deg, 0.6 * u.AU, frame=HeliographicStonyhurst(obstime=TIME)
    )
    with pytest.raises(emitree.SceneError, match="expected one place, or no `observer`"):
        camera_of(WCS(header_of()), observer=elsewhere)
    with pytest.raises(emitree.SceneError, match="longitudes of the kind CRLN"):
        header = header_of() | {"CTYPE1": "CRLN-CAR", "CTYPE2": "CRLT-CAR"}
        camera_of(WCS(header))
    with pytest.raises(emitree.SceneError, match="can't be converted"):
        camera_of(wcs_of("RA", shape=SHAPE), frame=HeliographicStonyhurst(), observer=EARTH)
    looking = {"target": (0, 0, 0), "field_of_view": (2, 1), "far": 9, "length_unit": "R_sun"}
    rendering = emitree.render("0", emitree.Perspective(position=(9, 0, 0), **looking), (2, 2))
    with pytest.raises(emitree.SceneError, match="has the observer 'self': expected `observer`"):
        rendering.to_fits(frame=HeliographicCarrington(obstime=TIME, observer="self"))


def test_cubes_and_other_skies_are_no_maps():
    cube = emitree.render("0", camera_of(WCS(header_of())), energy=emitree.Energies(1.0, 2.0, 2))
    with pytest.raises(emitree.SceneError, match="the rendering is a cube"):
        cube.to_sunpy()
    camera = emitree.Perspective(
        position=(9, 0, 0), target=(0, 0, 0), field_of_view=(2, 1), far=9, length_unit="pc"
    )
    with pytest.raises(emitree.SceneError, match="expected helioprojective ones"):
        emitree.render("0", camera, (2, 2)).to_sunpy(frame=ICRS())
    with pytest.raises(emitree.SceneError, match="expected helioprojective ones"):
        emitree.render("0", camera, (2, 2)).to_sunpy()


def test_the_examples_of_the_guide(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    guide = Path(__file__).parents[2] / "docs" / "guide.md"
    section = guide.read_text(encoding="utf-8").split("\n## Sky\n")[1]
    names = {}
    for part in section.split("```python")[1:]:
        exec(part.split("```")[0], names)
    with fits.open("corona.fits") as hdus:
        assert hdus[0].header["CTYPE1"] == "HPLN-TAN"
    image, camera = names["image"], names["camera"]
    assert names["rendering"].image.shape == (60, 80)
    # The streamer is at the longitude atan(0.8 / 0.6) of Carrington.
    streamer = SkyCoord(camera.sky.coordinate(np.array([0.6, 0.8, 0.0]) * 1.5))
    assert streamer.lon.deg == pytest.approx(np.degrees(np.arctan2(0.8, 0.6)))
    # The brightest pixel, at the limb, is on the side of the streamer.
    aside = np.array(image.wcs.world_to_pixel(streamer)) - [63.5, 47.5]
    row, column = np.unravel_index(np.nanargmax(image.data), image.data.shape)
    brightest = np.array([column, row]) - [63.5, 47.5]
    assert aside @ brightest > 0.98 * np.linalg.norm(aside) * np.linalg.norm(brightest)
