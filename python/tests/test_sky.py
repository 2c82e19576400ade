"""Cameras of a WCS: their pixels are those of astropy and sunpy, or they are refused."""

import pickle

import numpy as np
import pytest

import emitree

u = pytest.importorskip("astropy.units")
coordinates = pytest.importorskip("astropy.coordinates")
from astropy.coordinates import ICRS, BarycentricMeanEcliptic, Galactic, SkyCoord  # noqa: E402
from astropy.time import Time  # noqa: E402
from astropy.wcs import WCS  # noqa: E402

EARTH = SkyCoord(0 * u.deg, 0 * u.deg, distance=0 * u.AU)
TIME = Time("2024-04-08T18:00:00")
KINDS = {"RA": ("RA--", "DEC-"), "GLON": ("GLON", "GLAT"), "ELON": ("ELON", "ELAT")}


def wcs_of(kind="RA", code="TAN", *, shape=(48, 64), scale=0.01, roll=0.0, **keys):
    """A WCS of an image as it is seen from inside, with the reference pixel in the middle."""
    height, width = shape
    longitude, latitude = KINDS.get(kind, ("HPLN", "HPLT"))
    hand = 1 if kind == "HPLN" else -1
    cos, sin = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    header = {
        "CTYPE1": f"{longitude}-{code}",
        "CTYPE2": f"{latitude}-{code}",
        "CUNIT1": "deg",
        "CUNIT2": "deg",
        "CRVAL1": 83.6,
        "CRVAL2": 22.0,
        "CRPIX1": 0.5 * (width + 1),
        "CRPIX2": 0.5 * (height + 1),
        "CDELT1": hand * scale,
        "CDELT2": scale,
        "PC1_1": cos,
        "PC1_2": -sin,
        "PC2_1": sin,
        "PC2_2": cos,
    }
    found = WCS(header | keys)
    found.array_shape = shape
    return found


def camera_of(wcs, **options):
    options = {"frame": Galactic(), "length_unit": "pc", "observer": EARTH, "far": 10} | options
    return emitree.Camera.from_wcs(wcs, **options)


def written(camera, **options):
    """The WCS in the file of a rendering with this camera."""
    rendering = emitree.render("0", camera, **options)
    return WCS(rendering.to_fits()[0].header, naxis=2)


def off(ours, theirs, shape, seed=0):
    """The largest distance of random places and of the corners of an image [pixels]."""
    height, width = shape
    corners = [[x, y] for x in (-0.5, width - 0.5) for y in (-0.5, height - 0.5)]
    inside = np.random.default_rng(seed).uniform([-0.5, -0.5], [width - 0.5, height - 0.5], (50, 2))
    places = np.concatenate([corners, inside])
    back = ours.all_world2pix(theirs.all_pix2world(places, 0), 0)
    return np.abs(back - places).max()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_a_tangent_plane_anywhere_is_exact(kind, seed):
    random = np.random.default_rng(seed)
    wcs = wcs_of(
        kind,
        scale=10.0 ** random.uniform(-4, 0),
        roll=random.uniform(-180, 180),
        CRVAL1=random.uniform(0, 360),
        CRVAL2=random.uniform(-90, 90),
    )
    frame = [ICRS(), Galactic(), BarycentricMeanEcliptic(), coordinates.Galactocentric()][seed]
    observer = SkyCoord(*random.normal(size=3) * u.kpc, representation_type="cartesian")
    camera = camera_of(wcs, frame=frame, observer=observer, length_unit="kpc")
    assert type(camera) is emitree.Perspective and camera.sky.deviation < 1e-5
    assert off(written(camera), wcs, (48, 64)) < 1e-5


@pytest.mark.parametrize("code", ["CAR", "ARC", "ZEA"])
@pytest.mark.parametrize("seed", range(6))
def test_wide_fields_are_exact(code, seed):
    random = np.random.default_rng(seed)
    shape = (48, 64) if code == "CAR" else (48, 48)
    # The whole sky is a disc of radius pi (ARC) or 2 (ZEA).
    widest = {"CAR": 180 / 48, "ARC": 360 / 48, "ZEA": np.degrees(4) / 48}[code]
    wcs = wcs_of(
        ["RA", "GLON"][seed % 2],
        code,
        shape=shape,
        scale=random.uniform(0.4, 0.7) * widest,
        roll=0.0 if code == "CAR" else random.uniform(-180, 180),
        CRVAL1=random.uniform(0, 360),
        # The pole 40 degrees beside the middle, or its opposite, leaves latitudes up to 50 degrees.
        CRVAL2=(-1) ** seed * random.uniform(0, 45) if code == "CAR" else random.uniform(-80, 80),
        **({"LONPOLE": 180 * (seed % 2) + random.uniform(-40, 40)} if code == "CAR" else {}),
    )
    camera = camera_of(wcs)
    assert type(camera) is (emitree.Equirectangular if code == "CAR" else emitree.Fisheye)
    assert camera.sky.deviation < 1e-6
    again = written(camera)
    assert again.wcs.ctype[0].endswith(code)
    assert off(again, wcs, shape) < 1e-6


def test_a_whole_sky_is_closed():
    keys = {"CRVAL2": 0.0, "CDELT1": -360 / 64, "CDELT2": 180 / 48}
    camera = camera_of(wcs_of("GLON", "CAR", **keys))
    assert list(camera.field_of_view) == [360.0, 180.0]
    disc = camera_of(wcs_of("GLON", "ARC", shape=(48, 48), scale=360 / 48))
    assert disc.field_of_view == 360.0


def test_pixels_need_not_be_square():
    wcs = wcs_of(CDELT1=-0.3, CDELT2=0.5, PC1_2=0.0, PC2_1=0.0, PC1_1=1.0, PC2_2=1.0)
    assert off(written(camera_of(wcs)), wcs, (48, 64)) < 1e-6


@pytest.mark.parametrize("crpix", [(31.2, 25.7), (90.0, -12.0)])
def test_a_reference_pixel_beside_the_middle_agrees_in_a_narrow_field(crpix):
    wcs = wcs_of("GLON", "ARC", CRPIX1=crpix[0], CRPIX2=crpix[1], roll=20)
    camera = camera_of(wcs)
    assert 0 < camera.sky.deviation < emitree._sky_wcs.ALLOWED
    # No place inside is farther off than the corners.
    assert off(written(camera), wcs, (48, 64)) < 1.01 * camera.sky.deviation


@pytest.mark.parametrize("seed", range(8))
def test_a_tangent_plane_with_a_reference_pixel_anywhere_is_exact(seed):
    random = np.random.default_rng(seed)
    scale = 10.0 ** random.uniform(-3, 0)
    wcs = wcs_of(
        list(KINDS)[seed % len(KINDS)],
        scale=scale,
        roll=random.uniform(-180, 180),
        CRVAL1=random.uniform(0, 360),
        CRVAL2=random.uniform(-80, 80),
        # In the image, and up to 30 degrees from it.
        CRPIX1=random.uniform(-25 / scale if seed > 3 else 0, 64),
        CRPIX2=random.uniform(0, 48 + 25 / scale if seed > 3 else 48),
    )
    camera = camera_of(wcs)
    assert type(camera) is emitree.Perspective and camera.sky.deviation < 1e-4
    assert off(written(camera), wcs, (48, 64)) < 2e-4


def test_a_small_ball_is_where_the_wcs_says_beside_the_reference_pixel():
    wcs = wcs_of(scale=0.5, CRPIX1=40.2, CRPIX2=10.0, roll=30)
    camera = camera_of(wcs, near=1, far=100)
    assert list(camera.principal_point) == pytest.approx([39.7 / 64, 9.5 / 48], abs=1e-12)
    place = wcs.pixel_to_world(12.0, 31.0)
    x, y, z = camera.sky.positions(SkyCoord(place, distance=20 * u.pc))
    ball = f"exp(-((x - {x})^2 + (y - {y})^2 + (z - {z})^2) / 0.2^2)"
    image = emitree.render(ball, camera, tolerance=1e-3).image
    rows, columns = np.indices(image.shape)
    found = [(image * along).sum() / image.sum() for along in (columns, rows)]
    # The centroid of pixels that are not small, with larger solid angles towards the pointing.
    assert np.abs(np.array(found) - [12.0, 31.0]).max() < 0.05


@pytest.mark.parametrize("code", ["SIN", "STG", "ARC", "ZEA"])
def test_other_projections_agree_in_a_narrow_field(code):
    wcs = wcs_of("GLON", code)
    camera = camera_of(wcs)
    assert type(camera) is emitree.Perspective
    assert off(written(camera), wcs, (48, 64)) < 0.01


def sip(scale):
    """A WCS with a quadratic distortion of `scale` pixels at the edges."""
    header = wcs_of(code="TAN-SIP").to_header()
    header["CTYPE1"], header["CTYPE2"] = "RA---TAN-SIP", "DEC--TAN-SIP"
    header["A_ORDER"], header["B_ORDER"] = 2, 2
    header["A_2_0"], header["B_0_2"] = scale / 32**2, scale / 24**2
    found = WCS(header)
    found.array_shape = (48, 64)
    return found


def test_a_distortion_that_is_below_a_hundredth_of_a_pixel_agrees():
    wcs = sip(0.005)
    assert wcs.sip is not None
    assert off(written(camera_of(wcs)), wcs, (48, 64)) < 0.01


@pytest.mark.parametrize(
    ("wcs", "reason"),
    [
        (sip(0.5), "a distortion"),
        (wcs_of(code="SIN", scale=1), "the projection SIN"),
        (wcs_of(code="AIT", scale=4), "without some of its pixels"),
        (
            wcs_of("GLON", "ARC", shape=(48, 48), scale=0.5, CRPIX1=40.2),
            r"reference pixel at \(40.2, 24.5\).*middle.*\(24.5, 24",
        ),
        (wcs_of(scale=0.5, PC1_2=0.3), "not perpendicular"),
        (wcs_of("GLON", "CAR", scale=1, CRVAL2=0.0, CRPIX2=-40.0), "reference pixel"),
        (wcs_of(CDELT1=0.01), "mirrored"),
        (wcs_of(RADESYS="FK4", EQUINOX=1950.0), "FK4 .RADESYS.: expected ICRS or FK5"),
    ],
)
def test_what_no_camera_has_is_refused(wcs, reason):
    with pytest.raises(emitree.SceneError, match=reason):
        camera_of(wcs)


@pytest.mark.parametrize(
    "wcs", [sip(0.5), wcs_of("GLON", "STG", scale=0.35), wcs_of("GLON", "SIN", scale=0.2)]
)
def test_a_deviation_may_be_allowed_and_files_have_the_camera(wcs):
    with pytest.raises(emitree.SceneError, match=r"`max_deviation` is 0\.01"):
        camera_of(wcs)
    camera = camera_of(wcs, max_deviation=0.5)
    assert 0.01 < camera.sky.deviation < 0.5
    ours = written(camera)
    # The grid of corners has the largest deviation but for a tenth.
    assert 0.01 < off(ours, wcs, (48, 64)) < 1.1 * camera.sky.deviation
    again = camera_of(WCS(ours.to_header()), shape=(48, 64))
    assert again.sky.deviation < 1e-6 and np.allclose(again.target, camera.target, atol=1e-12)


def test_a_class_has_cameras_of_its_own_kind():
    wcs = wcs_of("GLON", "ARC", shape=(48, 48), scale=0.01)
    options = {"frame": Galactic(), "length_unit": "pc", "observer": EARTH, "far": 10}
    assert type(camera_of(wcs)) is emitree.Perspective
    camera = emitree.Fisheye.from_wcs(wcs, **options)
    assert type(camera) is emitree.Fisheye and camera.mapping == "ARC"
    assert off(written(camera), wcs, (48, 48)) < 1e-6
    with pytest.raises(emitree.SceneError, match="`Polar` has no celestial projection"):
        emitree.Polar.from_wcs(wcs, **options)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"wcs": 3}, "`wcs` is int: expected an `astropy.wcs.WCS`"),
        ({"wcs": WCS(naxis=2)}, "expected a longitude and a latitude"),
        ({"shape": (3, 4, 5)}, r"`shape` is \(3, 4, 5\): expected \(height, width\)"),
        ({"observer": None}, "`observer` is missing"),
        ({"observer": SkyCoord(0 * u.deg, 0 * u.deg)}, "expected a distance too"),
        ({"observer": (1, 2, 3)}, "expected an astropy `SkyCoord`"),
        ({"frame": "galactic"}, "`frame` is 'galactic': expected a frame of astropy or sunpy"),
        ({"frame": None}, "`frame` is None: expected a frame"),
        ({"length_unit": None}, "`length_unit` is None"),
        ({"max_deviation": 0}, "`max_deviation` is 0: expected a number above 0"),
        ({"distance": 3 * u.s}, "`distance` is 3.0 s"),
    ],
)
def test_wrong_arguments_are_named(options, reason):
    options = {"wcs": wcs_of()} | options
    with pytest.raises(emitree.SceneError, match=reason):
        camera_of(**options)


def test_a_wcs_without_a_shape_needs_one():
    wcs = WCS(wcs_of().to_header())
    with pytest.raises(emitree.SceneError, match="`wcs` has no shape"):
        camera_of(wcs)
    assert camera_of(wcs, shape=(48, 64)).sky.shape == (48, 64)


def test_refraction_is_no_rotation():
    site = coordinates.EarthLocation.from_geodetic(10 * u.deg, 50 * u.deg, 0 * u.m)
    frame = coordinates.AltAz(obstime=TIME, location=site, pressure=1000 * u.hPa)
    with pytest.raises(emitree.SceneError, match="more than a rotation"):
        emitree._sky.rotation(frame, ICRS())


def test_left_handed_axes_of_the_model_are_refused():
    site = coordinates.EarthLocation.from_geodetic(10 * u.deg, 50 * u.deg, 0 * u.m)
    frame = coordinates.AltAz(obstime=TIME, location=site)
    with pytest.raises(emitree.SceneError, match="AltAz, whose axes are left-handed"):
        camera_of(wcs_of(), frame=frame)


def test_the_ground_is_a_place_too():
    """An observatory in a model that turns with the Earth."""
    site = coordinates.EarthLocation.from_geodetic(10 * u.deg, 50 * u.deg, 0 * u.m)
    place = SkyCoord(site.get_itrs(TIME))
    camera = camera_of(
        wcs_of(), frame=coordinates.ITRS(obstime=TIME), observer=place, length_unit="km"
    )
    geocentric = [x.to_value(u.km) for x in site.geocentric]
    assert np.allclose(camera.position, geocentric, atol=1e-6)


def test_axes_of_the_model_may_have_an_origin_elsewhere():
    """A galaxy cluster in its own coordinates is where its direction and distance say."""
    cluster = SkyCoord(83.6 * u.deg, 22 * u.deg, distance=100 * u.Mpc)
    wcs = wcs_of()
    camera = camera_of(wcs, frame=ICRS(), length_unit="Mpc", origin=cluster)
    assert np.linalg.norm(camera.position) == pytest.approx(100, rel=1e-9)
    assert np.allclose(camera.target, 0, atol=1e-9)
    place = SkyCoord(84 * u.deg, 23 * u.deg, distance=101 * u.Mpc)
    back = camera.sky.coordinate(camera.sky.positions(place))
    assert back.separation_3d(place) < 1e-9 * u.Mpc
    assert camera.sky.positions(SkyCoord([place, cluster])).shape == (2, 3)


def test_the_sky_is_kept_in_copies_and_plans():
    camera = camera_of(wcs_of())
    again = pickle.loads(pickle.dumps(camera))
    assert again == camera and again.sky.shape == (48, 64)
    rendering = emitree.render("exp(-r^2)", camera, tolerance=0.1)
    copy = pickle.loads(pickle.dumps(rendering))
    assert copy.wcs.wcs.ctype[0] == "RA---TAN"
    planned = rendering.plan.render(lambda position, direction: np.ones(len(position)))
    assert planned.wcs.wcs.ctype[0] == "RA---TAN"


def test_another_shape_has_the_same_field():
    wcs = wcs_of(scale=0.5)
    ours = written(camera_of(wcs), shape=(24, 32))
    corners = np.array([[-0.5, -0.5], [63.5, 47.5]])
    seen = ours.all_world2pix(wcs.all_pix2world(corners, 0), 0)
    assert np.allclose(seen, [[-0.5, -0.5], [31.5, 23.5]], atol=1e-9)
