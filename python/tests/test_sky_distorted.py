"""Images of a WCS with distortions, by the corners of its pixels, against closed forms and astropy."""

import pickle

import numpy as np
import pytest

import emitree

u = pytest.importorskip("astropy.units")
pytest.importorskip("astropy.coordinates")
from astropy.coordinates import ICRS, SkyCoord  # noqa: E402
from astropy.wcs import WCS  # noqa: E402
from test_sky import EARTH, wcs_of  # noqa: E402
from test_sky_files import centroid  # noqa: E402

DISTANCE = 2000.0
SIP = {
    "A_ORDER": 2, "B_ORDER": 2, "A_2_0": 1e-3, "A_1_1": 4e-4, "A_0_2": -3e-4,
    "B_2_0": 5e-4, "B_1_1": -6e-4, "B_0_2": 8e-4,
}  # fmt: skip
#: By 1 / (100 pixels).
TPV = {"PV1_4": 0.4, "PV1_5": -0.2, "PV2_4": 0.3, "PV2_6": -0.5}


def distorted(kind, **options):
    """A WCS that no camera has."""
    if kind not in ("SIP", "TPV"):
        return wcs_of(code=kind, **options)
    scale = options.get("scale", 0.01)
    header = wcs_of(**options).to_header()
    code = "-TAN-SIP" if kind == "SIP" else "-TPV"
    header["CTYPE1"], header["CTYPE2"] = f"RA--{code}", f"DEC-{code}"
    if kind == "SIP":
        header.update(SIP)
    else:
        # astropy has the polynomials of TPV in degrees with CD, not with CDELT.
        for row in (1, 2):
            for column in (1, 2):
                sign = -1 if row == 1 else 1
                header[f"CD{row}_{column}"] = (
                    sign * scale * header.pop(f"PC{row}_{column}", row == column)
                )
            del header[f"CDELT{row}"]
        header.update({name: value / (100 * scale) for name, value in TPV.items()})
        header.update({"PV1_1": 1.0, "PV2_1": 1.0})
    found = WCS(header)
    found.array_shape = options.get("shape", (48, 64))
    return found


def camera_of(wcs, **options):
    centre = SkyCoord(83.6 * u.deg, 22 * u.deg, distance=DISTANCE * u.pc)
    given = {"frame": ICRS(), "length_unit": "pc", "observer": EARTH, "origin": centre}
    given |= {"near": 0.5 * DISTANCE, "far": 1.5 * DISTANCE}
    return emitree.WcsCamera.from_wcs(wcs, **(given | options))


def exact(wcs, shape, chord, nodes=16):
    """Means over pixels of a function of directions, by many places in each."""
    height, width = shape
    each = (np.arange(nodes) + 0.5) / nodes
    x, y = np.meshgrid(
        np.add.outer(np.arange(width), each).ravel(), np.add.outer(np.arange(height), each).ravel()
    )

    def sight(x, y):
        lon, lat = np.radians(wcs.all_pix2world(x - 0.5, y - 0.5, 0))
        return np.stack(
            [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1
        )

    step = 0.5 / nodes
    across = sight(x + step, y) - sight(x - step, y)
    up = sight(x, y + step) - sight(x, y - step)
    solid = np.linalg.norm(np.cross(across, up), axis=-1)
    parts = (height, nodes, width, nodes)
    total = (chord(sight(x, y)) * solid).reshape(parts).sum(axis=(1, 3))
    return total / solid.reshape(parts).sum(axis=(1, 3))


def chord_of_ball(place, radius):
    """The length in a ball of a line from the observer, whose place is relative to the observer."""

    def chord(sight):
        along = sight @ place
        return 2 * np.sqrt(np.maximum(radius**2 - (place @ place - along**2), 0.0))

    return chord


def column_of_gaussian(place, sigma):
    def column(sight):
        along = sight @ place
        return np.sqrt(2 * np.pi) * sigma * np.exp(-(place @ place - along**2) / (2 * sigma**2))

    return column


def ball(radius, at=(0, 0, 0)):
    return lambda position, direction: (np.linalg.norm(position - at, axis=1) < radius) * 1.0


def gaussian(sigma, at=(0, 0, 0)):
    return lambda position, direction: np.exp(-((position - at) ** 2).sum(axis=1) / (2 * sigma**2))


@pytest.mark.parametrize("kind", ["SIP", "TPV", "STG", "ZPN"])
def test_a_small_ball_is_where_astropy_says(kind):
    scale, shape = 0.3, (24, 32)
    keys = {"PV2_1": 1.0, "PV2_3": 2.0} if kind == "ZPN" else {}
    wcs = distorted(kind, scale=scale, roll=20, shape=shape, **keys)
    with pytest.raises(emitree.SceneError, match=r"`emitree\.WcsCamera\.from_wcs` has any WCS"):
        emitree.Camera.from_wcs(wcs, frame=ICRS(), length_unit="pc", observer=EARTH)
    lon, lat = wcs.all_pix2world([[20.3, 8.6]], 0)[0] * u.deg
    place = SkyCoord(lon, lat, distance=DISTANCE * u.pc)
    camera = camera_of(wcs)
    sigma = 1.5 * np.radians(scale) * DISTANCE
    found = emitree.render(gaussian(sigma, camera.sky.positions(place)), camera, tolerance=3e-3)
    assert found.converged
    middle = place.cartesian.xyz.to_value(u.pc)
    image = exact(wcs, shape, column_of_gaussian(middle, sigma), 8)
    assert np.abs(found.image - image).max() < 3e-3 * image.max()
    assert (np.abs(found.image - image) <= found.error + 1e-4 * image.max()).all()
    assert np.abs(centroid(found.image) - centroid(image)).max() < 0.01
    # astropy alone, from the file, which has the distortions. Pixels have different solid angles,
    # and radiances are per solid angle: the middle of the light is weighted with them.
    back = WCS(found.to_fits()[0].header)
    x, y = back.world_to_pixel(place)
    assert np.abs(np.array([x, y]) - [20.3, 8.6]).max() < 1e-4
    assert np.abs(centroid(found.image) - [x, y]).max() < 0.1
    rows, columns = np.indices(shape)
    assert (
        np.abs(
            back.all_pix2world(np.stack([columns, rows], -1).reshape(-1, 2), 0)
            - wcs.all_pix2world(np.stack([columns, rows], -1).reshape(-1, 2), 0)
        ).max()
        < 0.01 * scale
    )


@pytest.mark.parametrize("kind", ["SIP", "AZP"])
def test_a_ball_with_a_limb_is_within_the_tolerance(kind):
    shape = (12, 16)
    keys = {"PV2_1": 2.0} if kind == "AZP" else {}
    wcs = distorted(kind, scale=0.4, roll=-70, shape=shape, **keys)
    camera = camera_of(wcs)
    at, radius = np.array([10.0, -8.0, 5.0]), 4.3 * np.radians(0.4) * DISTANCE
    found = emitree.render(ball(radius, at), camera, tolerance=0.04)
    image = exact(wcs, shape, chord_of_ball(at - camera.position, radius), 32)
    error = np.abs(found.image - image)
    assert found.converged
    assert error.max() < 0.04 * image.max()
    assert (error <= found.error + 3e-4 * image.max()).all()
    assert found.evaluations < 25_000


def test_a_limb_in_front_of_a_uniform_medium_is_a_jump():
    shape = (16, 20)
    wcs = distorted("SIP", scale=0.4, shape=shape)
    camera = camera_of(wcs)
    radius = 4.2 * np.radians(0.4) * DISTANCE
    body = emitree.Sphere(center=(0, 0, 0), radius=radius)
    bounds = emitree.Sphere(center=(0, 0, 0), radius=6 * radius)

    def depth(sight):
        place = -np.array(camera.position)
        along = sight @ place
        apart = place @ place - along**2
        half = np.sqrt(np.maximum((6 * radius) ** 2 - apart, 0.0))
        front = np.sqrt(np.maximum(radius**2 - apart, 0.0))
        return np.where(apart < radius**2, half - front, 2 * half)

    found = emitree.render("1", camera, occulters=[body], bounds=bounds, tolerance=0.03)
    image = exact(wcs, shape, depth, 32)
    error = np.abs(found.image - image)
    assert found.converged
    assert (error <= found.error + 3e-3 * image.max()).all()
    assert error.max() < 0.03 * image.max()


def test_a_uniform_radiance_is_exact_on_the_whole_sky_and_pixels_beside_it_are_nan():
    shape = (18, 36)
    wcs = wcs_of("GLON", "AIT", shape=shape, scale=9.0, CRVAL1=0.0, CRVAL2=0.0)
    camera = camera_of(wcs, frame=ICRS(), near=0.0, far=10.0, origin=EARTH)
    found = emitree.render("1", camera)
    inside = ~np.isnan(found.image)
    assert inside[9, 18] and not inside[0, 0]
    assert 0.6 < inside.mean() < 0.85
    assert np.abs(found.image[inside] - 10).max() < 1e-9
    assert found.converged


@pytest.mark.parametrize("code", ["AIT", "CAR"])
def test_a_whole_sky_has_its_poles_and_is_closed(code):
    shape = (12, 24)
    wcs = wcs_of("GLON", code, shape=shape, scale=15.0, CRVAL1=0.0, CRVAL2=0.0)
    camera = camera_of(wcs, frame=ICRS(), near=0.0, far=10.0, origin=EARTH)
    found = emitree.render("1 + 0.05*x*z + 0.02*y", camera, tolerance=0.02)
    inside = ~np.isnan(found.image)

    def column(sight):
        galactic = SkyCoord(
            *sight.reshape(-1, 3).T, representation_type="cartesian", frame="galactic"
        )
        x, y, z = galactic.icrs.cartesian.xyz.value.reshape(3, *sight.shape[:-1])
        return 10 + 0.05 * x * z * 1000 / 3 + 0.02 * y * 50

    image = exact(wcs, shape, column, 8)
    error = np.abs(found.image - image)[inside]
    assert error.max() < 0.02 * image[inside].max()
    assert (error <= found.error[inside] + 1e-3 * image[inside].max()).all()


def test_components_units_and_copies():
    wcs = distorted("SIP", shape=(8, 10), scale=0.4)
    camera = camera_of(wcs)
    calls = []

    def pair(position, direction):
        calls.append(len(position))
        square = (position**2).sum(axis=1) / 50**2
        return np.stack([np.exp(-square), np.exp(-2 * square)], axis=1)

    both = emitree.render(pair, camera, tolerance=0.02)
    assert both.converged and both.image.shape == (2, 8, 10)
    assert both.evaluations == sum(calls)
    alone = emitree.render(
        lambda p, d: pair(p, d)[:, 1], camera, tolerance=0.02, unit="ph cm-3 s-1"
    )
    assert alone.unit == "ph cm-2 s-1"
    assert abs(both[1].image * 3.0857e18 - alone.image).max() < 0.05 * alone.image.max()
    again = pickle.loads(pickle.dumps(alone))
    assert again.wcs.sip is not None and again.to_fits()[0].header["CTYPE1"] == "RA---TAN-SIP"
    assert pickle.loads(pickle.dumps(camera)).sky.shape == (8, 10)


def test_lines_are_those_of_the_centres_and_agree_with_pixels():
    shape = (10, 12)
    wcs = distorted("SIP", shape=shape, scale=0.4)
    camera = camera_of(wcs)
    lines = camera.lines()
    lon, lat = np.radians(wcs.all_pix2world([[3.0, 7.0]], 0)[0])
    assert lines.directions[7 * 12 + 3] == pytest.approx(
        [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], abs=1e-12
    )
    values = emitree.line_integrals(gaussian(80.0), lines, tolerance=1e-3).values.reshape(shape)
    pixels = emitree.render(gaussian(80.0), camera, tolerance=1e-2).image
    assert abs(values - pixels).max() < 0.02 * pixels.max()


def test_files_of_the_sun_have_the_observer_and_distortions():
    pytest.importorskip("sunpy")
    from sunpy.coordinates import HeliographicCarrington, HeliographicStonyhurst, Helioprojective
    from test_sky_sun import SPACECRAFT, header_of

    header = header_of(centre=(0, 0), roll=10, scale=200.0)
    for key in ("HGLN_OBS", "HGLT_OBS", "DSUN_OBS"):
        header.pop(key, None)
    header["CTYPE1"], header["CTYPE2"] = "HPLN-TAN-SIP", "HPLT-TAN-SIP"
    header.update(SIP)
    header["CRPIX1"], header["CRPIX2"] = 16.5, 12.5
    camera = emitree.WcsCamera.from_wcs(
        WCS(header), frame=HeliographicCarrington(), length_unit="R_sun", observer=SPACECRAFT,
        shape=(24, 32), near=50, far=300,
    )  # fmt: skip
    assert camera.sky.time is not None
    rendering = emitree.render("exp(-r^2)", camera, tolerance=0.05)
    file = rendering.to_fits()
    assert file[0].header["A_2_0"] == SIP["A_2_0"] and file[1].header["CTYPE1"] == "HPLN-TAN-SIP"
    sun = SkyCoord(
        0 * u.deg, 0 * u.deg, 0 * u.m,
        frame=HeliographicCarrington(obstime=camera.sky.time, observer=SPACECRAFT),
    )  # fmt: skip
    place = sun.transform_to(Helioprojective(observer=SPACECRAFT, obstime=camera.sky.time))
    back = WCS(file[0].header)
    x, y = back.world_to_pixel(place)
    # sigma is 2.5 pixels.
    assert np.abs(centroid(rendering.image) - [x, y]).max() < 0.1
    of_file = HeliographicStonyhurst(
        file[0].header["HGLN_OBS"] * u.deg,
        file[0].header["HGLT_OBS"] * u.deg,
        file[0].header["DSUN_OBS"] * u.m,
        obstime=camera.sky.time,
    )
    assert SkyCoord(of_file).separation_3d(SPACECRAFT) < 10 * u.km
    with pytest.raises(emitree.SceneError, match="sunpy's maps have no distortions"):
        rendering.to_sunpy()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"energy": emitree.Energies(0.0, 1.0, 2)}, "`energy` is given with a `WcsCamera`"),
        ({"rtol": 0.1}, "`rtol` is given with a `WcsCamera`"),
        ({"method": "los"}, '`method` is "los" with a `WcsCamera`'),
        ({"quantity": "irradiance"}, '`quantity` is "irradiance" with a `WcsCamera`'),
        ({"shape": (3, 4)}, r"`shape` is \(3, 4\), and that of the WCS is \(8, 10\)"),
    ],
)
def test_what_the_camera_does_not_take_is_refused_by_name(options, reason):
    camera = camera_of(distorted("SIP", shape=(8, 10)))
    with pytest.raises(emitree.SceneError, match=reason):
        emitree.render("1", camera, **options)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"tolerance": -0.01}, "`render.tolerance` is -0.01"),
        ({"tolerance": "1%"}, "`render.tolerance`"),
        ({"max_evaluations": 0}, "`render.max_evaluations` is 0"),
    ],
)
def test_numbers_are_refused_as_they_were_given(options, reason):
    camera = camera_of(distorted("SIP", shape=(8, 10)))
    with pytest.raises(emitree.SceneError, match=reason):
        emitree.render(gaussian(60.0), camera, **options)


def test_a_grid_in_another_unit_is_the_function_that_it_samples():
    camera = camera_of(distorted("SIP", shape=(8, 10), scale=0.4))
    nodes = np.linspace(-200.0, 200.0, 41)
    x, y, z = np.meshgrid(nodes, nodes, nodes, indexing="ij")
    values = np.exp(-(x**2 + y**2 + z**2) / (2 * 60.0**2))
    axes = {name: (nodes / 1000) * u.kpc for name in "xyz"}
    grid = emitree.Grid(values=values, interpolation="cubic", **axes)
    found, expected = (emitree.render(of, camera, tolerance=0.01) for of in (grid, gaussian(60.0)))
    assert found.converged
    assert abs(found.image - expected.image).max() < 0.02 * expected.image.max()


def test_other_functions_refuse_the_camera():
    camera = camera_of(distorted("SIP", shape=(8, 10)))
    with pytest.raises(emitree.SceneError, match="the camera is a `WcsCamera`"):
        emitree.Session(camera, (8, 10))


def test_a_budget_leaves_an_image_that_has_not_converged():
    camera = camera_of(distorted("SIP", shape=(8, 10), scale=0.4))
    found = emitree.render(ball(60.0), camera, tolerance=1e-3, max_evaluations=3000)
    assert not found.converged and found.report["ending"] == "budget"
    assert found.evaluations <= 3000 and found.estimated_error > 1e-3
    assert np.isfinite(found.image).all()


def test_a_folded_wcs_is_refused():
    wcs = distorted("SIP", shape=(8, 10))
    wcs.sip.a[2, 0] = 0.3
    with pytest.raises(
        emitree.SceneError, match="`wcs` is folded at the pixel in row 0 and column"
    ):
        emitree.render("1", camera_of(wcs))
