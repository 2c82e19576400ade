"""Images on the sky: places in files and maps are where astropy and sunpy say."""

import numpy as np
import pytest

import emitree

pytest.importorskip("astropy")
import astropy.units as u
from astropy.coordinates import ICRS, BarycentricMeanEcliptic, Galactic, SkyCoord
from astropy.io import fits
from astropy.wcs import WCS
from test_sky import camera_of, off, wcs_of

RATE = "ph cm-3 s-1 sr-1"


def blob(position, width):
    """A Gaussian ball of a standard deviation `width` around a position."""

    def rate(at, direction):
        return np.exp(-((at - position) ** 2).sum(axis=1) / (2 * width**2))

    return rate


def centroid(image):
    """The middle of the light, column and row from 0."""
    rows, columns = np.indices(image.shape)
    return np.array([(image * columns).sum(), (image * rows).sum()]) / image.sum()


def seen_at(camera, place, pixel_deg, **options):
    """Where a small ball at a place on the sky is in the image, and the rendering."""
    position = camera.sky.positions(place)
    distance = np.linalg.norm(position - camera.position)
    width = 1.5 * np.radians(pixel_deg) * distance
    rendering = emitree.render(
        blob(position, width),
        camera,
        tolerance=1e-4,
        seeds=[(position.tolist(), 3 * width)],
        **options,
    )
    assert rendering.converged
    return centroid(rendering.image), rendering


@pytest.mark.parametrize("kind", ["RA", "GLON"])
@pytest.mark.parametrize("roll", [0, 110])
def test_a_ball_is_where_astropy_says(kind, roll):
    wcs = wcs_of(kind, roll=roll)
    coordinates = ICRS() if kind == "RA" else Galactic()
    lon, lat = wcs.all_pix2world([[50.3, 14.6]], 0)[0] * u.deg
    place = SkyCoord(lon, lat, distance=2 * u.kpc, frame=coordinates)
    camera = camera_of(wcs, frame=Galactic(), length_unit="pc", near=1999.0, far=2001.0)
    found, rendering = seen_at(camera, place, 0.01)
    assert np.abs(found - [50.3, 14.6]).max() < 0.01
    # astropy alone, from the file: the place in the sky in pixels.
    x, y = WCS(rendering.to_fits()[0].header).world_to_pixel(place)
    assert abs(float(x) - 50.3) < 1e-6 and abs(float(y) - 14.6) < 1e-6


def test_east_is_left_and_north_is_up():
    wcs = wcs_of()
    camera = camera_of(wcs, frame=ICRS(), length_unit="pc", near=1999.0, far=2001.0)
    east = SkyCoord(83.7 * u.deg, 22 * u.deg, distance=2 * u.kpc)
    north = SkyCoord(83.6 * u.deg, 22.1 * u.deg, distance=2 * u.kpc)
    (x, y), _ = seen_at(camera, east, 0.01)
    assert x < 23 and abs(y - 23.5) < 0.1
    (x, y), _ = seen_at(camera, north, 0.01)
    assert abs(x - 31.5) < 0.01 and abs(y - 33.5) < 0.01


def test_a_ball_has_parallax():
    """Two observers, one place: each sees it where astropy's vectors say."""
    place = SkyCoord(83.6 * u.deg, 22 * u.deg, distance=50 * u.AU)
    for shift in (-0.2, 0.3):
        observer = SkyCoord(
            *(np.array([0, shift, 0.1]) * u.AU), representation_type="cartesian", frame=ICRS()
        )
        line = SkyCoord(ICRS(place.cartesian - observer.cartesian))
        seen = wcs_of().all_world2pix([[line.ra.deg, line.dec.deg]], 0)[0]
        camera = camera_of(
            wcs_of(),
            frame=BarycentricMeanEcliptic(),
            observer=observer,
            length_unit="AU",
            near=49.0,
            far=51.0,
        )
        found, _ = seen_at(camera, place, 0.01)
        assert np.abs(found - seen).max() < 0.01
        assert abs(found[0] - 31.5) > 2


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("RA", {"RADESYS": "ICRS"}),
        ("GLON", {}),
        ("ELON", {"RADESYS": "ICRS", "EQUINOX": 2000.0}),
    ],
)
def test_headers_name_the_frame(kind, keys):
    rendering = emitree.render("0", camera_of(wcs_of(kind)))
    hdus = rendering.to_fits()
    hdus.verify("exception")
    assert [hdu.name for hdu in hdus] == ["RADIANCE", "ERROR", "EVALUATIONS"]
    for hdu in hdus:
        assert hdu.header["CTYPE1"].startswith(kind)
        assert {key: hdu.header[key] for key in keys} == keys
        assert "CNAME1" not in hdu.header and "DATE-OBS" not in hdu.header
        assert hdu.header["CDELT1"] < 0 < hdu.header["CDELT2"]


def test_files_are_written_with_their_checksums(tmp_path):
    rendering = emitree.render("exp(-r^2)", camera_of(wcs_of(), far=3), tolerance=0.1)
    path = tmp_path / "image.fits"
    rendering.to_fits(path)
    with fits.open(path, checksum=True) as hdus:
        assert np.array_equal(hdus[0].data, rendering.image)
        assert np.array_equal(hdus["ERROR"].data, rendering.error)
        assert "HISTORY" in hdus[0].header
    with pytest.raises(FileExistsError):
        rendering.to_fits(path)
    rendering.to_fits(path, extensions=False, overwrite=True)
    with fits.open(path, checksum=True) as hdus:
        assert len(hdus) == 1


def test_cubes_and_counts_are_on_the_sky():
    rendering = emitree.render(
        "exp(-E)",
        camera_of(wcs_of(), length_unit="cm", near=1, far=2),
        unit=f"{RATE} keV-1",
        energy=emitree.Energies(0.5, 2.0, 3),
        instrument=emitree.Instrument(effective_area=50.0, exposure=1e4),
    )
    for hdu in (rendering.to_fits()[0], rendering.counts_to_fits()[0]):
        wcs = WCS(hdu.header)
        assert wcs.naxis == 3 and wcs.celestial.wcs.ctype[0] == "RA---TAN"
        assert off(wcs.celestial, wcs_of(), (48, 64)) < 1e-6
    ndcube = pytest.importorskip("ndcube")
    cube = ndcube.NDCube(rendering.image, WCS(rendering.to_fits()[0].header))
    assert cube.shape == (3, 48, 64)
    assert cube.array_axis_physical_types[0] == ("em.energy",)


def test_reproject_takes_an_image():
    """A ball of an ICRS image is at its place in a galactic one."""
    reproject = pytest.importorskip("reproject")
    place = SkyCoord(83.7 * u.deg, 22.05 * u.deg, distance=2 * u.kpc)
    camera = camera_of(wcs_of(), frame=ICRS(), length_unit="pc", near=1999.0, far=2001.0)
    _, rendering = seen_at(camera, place, 0.01)
    galactic = place.galactic
    target = wcs_of("GLON", CRVAL1=galactic.l.deg, CRVAL2=galactic.b.deg)
    again, _ = reproject.reproject_interp(rendering.to_fits()[0], target, shape_out=(48, 64))
    assert np.abs(centroid(np.nan_to_num(again)) - [31.5, 23.5]).max() < 0.02


def test_a_camera_made_by_hand_has_a_sky_by_its_frame():
    """Looking along the x axis of ICRS: right ascension 0, declination 0, with north up."""
    camera = emitree.Perspective(
        position=(-10, 0, 0), target=(0, 0, 0), field_of_view=(20, 10), far=20, length_unit="pc"
    )
    rendering = emitree.render("exp(-r^2)", camera, (10, 20), tolerance=0.1)
    assert rendering.to_fits()[0].header["CTYPE1"] == "XLON-TAN"
    header = rendering.to_fits(frame=ICRS())[0].header
    assert header["CTYPE1"] == "RA---TAN" and header["CRVAL1"] == 0 and header["CRVAL2"] == 0
    assert (header["PC1_1"], header["PC1_2"], header["PC2_1"], header["PC2_2"]) == (1, 0, 0, 1)
    observer = SkyCoord(180 * u.deg, 0 * u.deg, distance=10 * u.pc)
    assert rendering.to_fits(observer=observer)[0].header["CTYPE1"] == "RA---TAN"
    in_galactic = rendering.to_fits(frame=ICRS(), coordinates=Galactic())[0].header
    expected = SkyCoord(0 * u.deg, 0 * u.deg).galactic
    assert in_galactic["CRVAL1"] == pytest.approx(expected.l.deg, abs=1e-9)
    assert in_galactic["CRVAL2"] == pytest.approx(expected.b.deg, abs=1e-9)


def test_what_does_not_fit_together_is_refused(tmp_path):
    looking = {"target": (0, 0, 0), "far": 20, "length_unit": "pc"}
    camera = emitree.Perspective(position=(-10, 0, 0), field_of_view=(20, 10), **looking)
    rendering = emitree.render("0", camera, (2, 2))
    elsewhere = SkyCoord(0 * u.deg, 0 * u.deg, distance=10 * u.pc)
    with pytest.raises(emitree.SceneError, match="expected one place"):
        rendering.to_fits(tmp_path / "image.fits", observer=elsewhere)
    with pytest.raises(emitree.SceneError, match="`coordinates` are Galactocentric"):
        rendering.to_fits(
            tmp_path / "image.fits",
            frame=ICRS(),
            coordinates=SkyCoord(
                0, 0, 0, unit="kpc", representation_type="cartesian", frame="galactocentric"
            ),
        )
    with pytest.raises(emitree.SceneError, match="`frame` is given, and the camera has a sky"):
        emitree.render("0", camera_of(wcs_of())).to_fits(frame=ICRS())
    with pytest.raises(emitree.SceneError, match="expected one place"):
        emitree.render("0", camera_of(wcs_of())).to_fits(observer=elsewhere)
    polar = emitree.Polar(position=(-10, 0, 0), field_of_view=20, **looking)
    with pytest.raises(emitree.SceneError, match="camera `polar` has no celestial projection"):
        emitree.render("0", polar, (2, 2)).to_fits(tmp_path / "image.fits", frame=ICRS())
    plain = emitree.Perspective(position=(9, 0, 0), target=(0, 0, 0), field_of_view=(2, 1), far=9)
    with pytest.raises(emitree.SceneError, match="no `length_unit`"):
        emitree.render("0", plain, (2, 2)).to_fits(frame=ICRS())
    assert not list(tmp_path.iterdir())


def test_a_scene_file_has_a_sky_by_its_frame(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[emission]\nexpression = "0"\n[projection]\ntype = "perspective"\n'
        "position = [-10, 0, 0]\ntarget = [0, 0, 0]\nfield_of_view = [20, 10]\nfar = 20\n"
        'length_unit = "pc"\n[image]\nwidth = 4\nheight = 2\n'
    )
    header = emitree.render(scene).to_fits(frame=ICRS())[0].header
    assert header["CTYPE1"] == "RA---TAN" and header["CRVAL1"] == 0
    changed = emitree.render(scene, changes={"projection.position": [0, -10, 0]})
    assert changed.to_fits(frame=ICRS())[0].header["CRVAL1"] == 90


@pytest.mark.parametrize(
    ("frame", "letter"), [(Galactic(), "G"), (ICRS(), "C"), (BarycentricMeanEcliptic(), "E")]
)
def test_a_sky_in_healpix_pixels_names_its_system(frame, letter):
    healpix = pytest.importorskip("astropy_healpix")
    camera = emitree.Healpix(position=(0, 0, 0), far=4, length_unit="kpc")
    place = SkyCoord(83.6 * u.deg, 22 * u.deg, distance=2 * u.kpc).transform_to(frame)
    position = place.cartesian.xyz.to_value(u.kpc)
    rendering = emitree.render(blob(position, 0.2), camera, 8, tolerance=0.05)
    table = rendering.to_fits(frame=frame)[1]
    assert table.header["COORDSYS"] == letter
    map_of = healpix.HEALPix(nside=8, order="nested", frame=frame)
    assert np.argmax(table.data["RADIANCE"]) == map_of.skycoord_to_healpix(place)
    with pytest.raises(emitree.SceneError, match="has the axes of the model: expected none"):
        rendering.to_fits(frame=frame, coordinates=ICRS())
    with pytest.raises(emitree.SceneError, match="no COORDSYS: expected Galactic"):
        rendering.to_fits(
            frame=SkyCoord(
                0, 0, 0, unit="kpc", representation_type="cartesian", frame="galactocentric"
            )
        )


def sights(camera, shape):
    """Longitude and latitude [rad] of pixel centres of a plate carrée, from its definition."""
    rows, columns = np.indices(shape)
    width, height = np.radians(camera.field_of_view)
    right = ((columns + 0.5) / shape[1] - 0.5) * width
    up = ((rows + 0.5) / shape[0] - 0.5) * height
    forward = np.array(camera.target, float) - camera.position
    forward /= np.linalg.norm(forward)
    aside = np.cross(forward, camera.up)
    aside /= np.linalg.norm(aside)
    axes = np.stack([aside, np.cross(aside, forward), forward])
    native = [np.cos(up) * np.sin(right), np.sin(up), np.cos(up) * np.cos(right)]
    return np.stack(native, axis=-1) @ axes


@pytest.mark.parametrize("code", ["RA", "HPLN"])
@pytest.mark.parametrize(
    ("target", "up"),
    [
        ((1, 0, 0), (0, 0, 1)),
        ((1, 0, 0), (0, 0, -1)),
        ((1, 0, 0), (0, 1, 0)),
        ((1, 0, 0), (0, 1, 3)),
        ((1, 0, 0), (0, 1e-5, 3)),
        ((1, 0, 1e-5), (0, 1, 3)),
        ((1, 0, 1e-2), (0, 1, 3)),
        ((1, 2, -1), (0, 0, 1)),
        ((1, 2, -1), (0, 0, -1)),
        ((1, 2, -1), (2, -1, 1e-4)),
        ((0, 0, 1), (0, 1, 0)),
        ((0, 0, -1), (1, 1, 1e-7)),
        ((0.3, -0.2, 0.1), (0.5, 0.2, -0.9)),
    ],
)
def test_any_plate_carree_is_on_the_sky(code, target, up):
    """Also where the reference point of CAR does not determine its rotation."""
    camera = emitree.Equirectangular(
        position=(0, 0, 0), target=target, up=up, field_of_view=(40, 30), far=3, length_unit="pc"
    )
    shape = (6, 8)
    rendering = emitree.render("0", camera, shape)
    expected = sights(camera, shape)
    options = {"frame": ICRS()}
    if code == "HPLN":
        sunpy = pytest.importorskip("sunpy.coordinates")
        time = "2024-04-08"
        observer = SkyCoord(
            9 * u.deg, 9 * u.deg, 1 * u.AU, frame=sunpy.HeliographicStonyhurst(obstime=time)
        )
        frame = sunpy.Helioprojective(observer=observer, obstime=time)
        options["coordinates"] = frame
        expected = expected @ emitree._sky.rotation(ICRS(), frame).T
    wcs = WCS(rendering.to_fits(**options)[0].header)
    rows, columns = np.indices(shape)
    lon, lat = np.radians(wcs.all_pix2world(columns.ravel(), rows.ravel(), 0))
    found = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)
    assert np.abs(found - expected.reshape(-1, 3)).max() < 1e-9


def test_the_time_is_that_of_the_wcs_or_of_the_observer():
    sunpy = pytest.importorskip("sunpy.coordinates")
    dated = {"DATE-OBS": "2024-04-08T18:00:00", "MJD-OBS": 60408.75}
    header = emitree.render("0", camera_of(wcs_of(**dated))).to_fits()[0].header
    assert header["DATE-OBS"] == "2024-04-08T18:00:00.000" and header["MJD-OBS"] == 60408.75
    place = sunpy.HeliographicStonyhurst(9 * u.deg, 9 * u.deg, 1 * u.AU, obstime="2025-01-01")
    camera = camera_of(wcs_of(), observer=SkyCoord(place))
    assert emitree.render("0", camera).to_fits()[0].header["DATE-OBS"].startswith("2025-01-01")
    # A frame without a time has that of the WCS.
    camera = camera_of(wcs_of(**dated), frame=sunpy.GeocentricSolarEcliptic(), length_unit="R_E")
    assert camera.sky.frame.obstime.isot == "2024-04-08T18:00:00.000"


def test_the_axes_of_a_wcs_may_be_swapped_and_be_part_of_a_cube():
    plain = wcs_of(roll=30)
    header = plain.to_header()
    swapped = header.copy()
    for key in ("CTYPE", "CRVAL", "CUNIT", "CDELT"):
        swapped[f"{key}1"], swapped[f"{key}2"] = header[f"{key}2"], header[f"{key}1"]
    for column in (1, 2):
        ones, twos = header[f"PC1_{column}"], header[f"PC2_{column}"]
        swapped[f"PC1_{column}"], swapped[f"PC2_{column}"] = twos, ones
    expected = camera_of(plain)
    found = camera_of(WCS(swapped), shape=(48, 64))
    assert np.allclose(found.up, expected.up) and np.allclose(found.target, expected.target)
    energies = {"WCSAXES": 3, "CTYPE3": "ENER", "CRPIX3": 1.0, "CDELT3": 1.0, "CUNIT3": "J"}
    cube = WCS(dict(header) | energies)
    cube.array_shape = (5, 48, 64)
    assert camera_of(cube).sky.shape == (48, 64)


@pytest.mark.parametrize("code", ["TAN", "CAR", "ARC", "ZEA"])
def test_lines_of_sight_of_the_renderer_are_those_of_astropy(code):
    """A rate that is the line of sight itself: its image is where each pixel looks."""
    shape = (48, 48)
    scale = 1.5
    wcs = wcs_of("GLON", code, shape=shape, scale=scale, roll=0 if code == "CAR" else 25, CRVAL2=20)
    camera = camera_of(wcs, frame=BarycentricMeanEcliptic(), near=0, far=1)
    rendered = emitree.render(lambda position, direction: -direction, camera, tolerance=1e-5)
    rows, columns = np.indices(shape)
    seen = SkyCoord(wcs.pixel_to_world(columns, rows)).transform_to(BarycentricMeanEcliptic())
    apart = np.linalg.norm(rendered.image - seen.cartesian.xyz.value, axis=0)
    within = np.hypot(rows - 23.5, columns - 23.5) < 22.5
    assert not np.isnan(apart[within]).any()
    # Means over pixels differ from their centres, by half of this at most.
    assert np.nanmax(apart[within]) < 0.01 * np.radians(scale)
