"""The table `[sky]` of scenes: what Python writes, the command reads, and astropy and sunpy open."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import emitree

pytest.importorskip("reproject")
pytest.importorskip("sunpy")
import astropy.units as u
import sunpy.map
from astropy.coordinates import (
    FK5,
    ICRS,
    BarycentricMeanEcliptic,
    CartesianRepresentation,
    Galactic,
    SkyCoord,
    UnitSphericalRepresentation,
)
from astropy.io import fits
from astropy.wcs import WCS
from sunpy.coordinates import HeliographicCarrington, HeliographicStonyhurst
from test_sky import off, wcs_of
from test_sky_files import camera_of as camera_of_stars
from test_sky_sun import SHAPE, SPACECRAFT, TIME, camera_of, header_of

ROOT = Path(__file__).parents[2]
#: The command, which `cargo xtask python` builds for this; by hand: `cargo build -p emitree-cli`.
COMMAND = Path(os.environ.get("EMITREE_COMMAND", ROOT / "target/debug/emitree"))
#: What differs from run to run, or from a file to its name.
OTHERS = {"DATE", "CHECKSUM", "DATASUM", "SCENE"}


def cards(hdu):
    return [tuple(card) for card in hdu.header.cards if card.keyword not in OTHERS]


def by_command(scene, tmp_path, *options):
    """The HDUs of the file that the command makes of the text of a scene."""
    path, image = tmp_path / "scene.toml", tmp_path / "image.fits"
    path.write_text(scene)
    subprocess.run(
        [COMMAND, "render", path, *options, "-o", image, "--quiet"], check=True, timeout=60
    )
    return fits.open(image), image


@pytest.mark.parametrize("seed", range(4))
def test_a_camera_of_a_wcs_is_the_same_by_the_command(tmp_path, seed):
    random = np.random.default_rng(seed)
    if seed < 2:
        header = header_of(
            centre=random.uniform(-900, 900, 2), roll=random.uniform(-180, 180), scale=20.0
        )
        frame = [HeliographicCarrington(observer="self"), HeliographicStonyhurst()][seed]
        wcs, shape = WCS(header), SHAPE
        camera = camera_of(wcs, frame=frame)
    else:
        wcs, shape = wcs_of("RA" if seed == 2 else "GLON", roll=random.uniform(-180, 180)), (48, 64)
        camera = camera_of_stars(wcs, frame=[Galactic(), FK5()][seed - 2], length_unit="pc")
    rendering = emitree.render("exp(-r^2)", camera, tolerance=0.1)
    ours = rendering.to_fits()
    hdus, path = by_command(rendering.scene, tmp_path)
    with hdus:
        assert [hdu.name for hdu in hdus] == [hdu.name for hdu in ours]
        for one, other in zip(hdus, ours, strict=True):
            assert cards(one) == cards(other)
        assert off(WCS(hdus[0].header), wcs, shape) < 0.01
    if seed < 2:
        one = sunpy.map.Map(path, hdus=0)
        assert isinstance(one, sunpy.map.GenericMap) and off(one.wcs, wcs, SHAPE) < 0.01
        assert one.observer_coordinate.separation_3d(SPACECRAFT) < 10 * u.m
        assert one.date.isot == "2024-04-08T18:00:00.000"
    again = emitree.render(tmp_path / "scene.toml")
    assert cards(again.to_fits()[0]) == cards(ours[0])


HAND = """
[emission]
expression = "exp(-20 * ((x - 0.3)^2 + (y - {y})^2 + (z - {z})^2))"

[projection]
type = "{camera}"
position = [120.0, 160.0, 15.0]
target = [0.0, 0.0, 0.0]
up = [0.1, -0.2, 1.0]
field_of_view = {field}
near = 180
far = 220
length_unit = "R_sun"

[image]
width = 40
height = 30

[render]
tolerance = 1e-3

[[seed]]
position = [0.3, {y}, {z}]
radius = 0.3

[sky]
frame = "HeliographicStonyhurst"
date = "2024-04-08T18:00:00"
"""


@pytest.mark.parametrize(
    ("camera", "field", "code"),
    [
        ("perspective", "[1.2, 0.9]", "TAN"),
        ("fisheye", "0.9", "ARC"),
        ("fisheye", "0.9\nmapping = 'ZEA'", "ZEA"),
    ],
)
def test_a_scene_by_hand_opens_as_one_map_of_the_sun(tmp_path, camera, field, code):
    """A ball is where sunpy, which alone has ephemerides, puts its place in Stonyhurst's frame."""
    y, z = 0.8, -0.5
    text = HAND.format(camera=camera, field=field, y=y, z=z)
    hdus, path = by_command(text, tmp_path)
    with hdus:
        assert hdus[0].header["CTYPE1"] == f"HPLN-{code}"
        image = hdus[0].data.astype(float)
    frame = HeliographicStonyhurst(obstime=TIME)
    place = SkyCoord(*([0.3, y, z] * u.R_sun), representation_type="cartesian", frame=frame)
    found = sunpy.map.Map(path, hdus=0)
    assert isinstance(found, sunpy.map.GenericMap)
    observer = SkyCoord(
        *([120.0, 160.0, 15.0] * u.R_sun), representation_type="cartesian", frame=frame
    )
    assert found.observer_coordinate.separation_3d(observer) < 10 * u.m
    x, y = found.wcs.world_to_pixel(place)
    rows, columns = np.indices(image.shape)
    image = np.nan_to_num(image)
    middle = [(image * columns).sum() / image.sum(), (image * rows).sum() / image.sum()]
    assert np.abs(np.array(middle) - [float(x), float(y)]).max() < 0.01
    # The same from Python, by a frame that is given to a scene without a sky.
    bare = text.split("[sky]")[0]
    (tmp_path / "bare.toml").write_text(bare)
    given = emitree.render(tmp_path / "bare.toml").to_fits(frame=frame)[0].header
    ours = fits.getheader(path)
    for key in ("CRVAL1", "CRVAL2", "PC1_1", "PC1_2", "PC2_1", "PC2_2", "HGLN_OBS", "HGLT_OBS"):
        assert given[key] == pytest.approx(ours[key], abs=1e-11), key
    assert given["DSUN_OBS"] == pytest.approx(ours["DSUN_OBS"], rel=1e-13)
    assert given["MJD-OBS"] == ours["MJD-OBS"] and given["CTYPE1"] == ours["CTYPE1"]


@pytest.mark.parametrize(
    ("frame", "of_astropy"),
    [
        ("ICRS", ICRS()),
        ("Galactic", Galactic()),
        ("BarycentricMeanEcliptic", BarycentricMeanEcliptic()),
        ("FK5", FK5()),
    ],
)
@pytest.mark.parametrize(
    ("camera", "field"), [("perspective", "[50, 40]"), ("equirectangular", "[80, 60]")]
)
def test_axes_of_the_stars_are_those_of_astropy(tmp_path, frame, of_astropy, camera, field):
    text = HAND.format(camera=camera, field=field, y=0, z=0).split("[sky]")[0]
    hdus, _ = by_command(f'{text}[sky]\nframe = "{frame}"\n', tmp_path, "--tolerance", "0.5")
    with hdus:
        wcs = WCS(hdus[0].header)

    def pixel(direction):
        unit = CartesianRepresentation(direction).represent_as(UnitSphericalRepresentation)
        if frame == "BarycentricMeanEcliptic":
            # The frame that astropy has for ELON is a true ecliptic, of another origin.
            return wcs.all_world2pix([[unit.lon.deg, unit.lat.deg]], 0)[0]
        place = SkyCoord(of_astropy.realize_frame(unit))
        return np.array(wcs.world_to_pixel(place), dtype=float)

    # The pointing is the middle of the image, and above it is the side of `up`.
    towards, up = np.array([-120.0, -160.0, -15.0]), np.array([0.1, -0.2, 1.0])
    np.testing.assert_allclose(pixel(towards), [19.5, 14.5], rtol=0, atol=1e-6)
    x, y = pixel(towards + 20 * up)
    assert abs(x - 19.5) < 1e-6 and y > 14.7


def test_a_sky_in_a_scene_is_the_only_one(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(HAND.format(camera="perspective", field="[1.2, 0.9]", y=0, z=0))
    rendering = emitree.render(path, tolerance=0.5)
    with pytest.raises(emitree.SceneError, match="the scene has a sky of its own: expected none"):
        rendering.to_fits(frame=ICRS())
    assert rendering.to_sunpy().coordinate_frame.name == "helioprojective"
    changed = emitree.render(
        path, tolerance=0.5, changes={"sky.frame": "Galactic", "projection.position": [9, 0, 200]}
    )
    assert changed.to_fits()[0].header["CTYPE1"] == "GLON-TAN"
    with pytest.raises(emitree.SceneError, match=r"line 28: `sky\.date` is `yesterday`"):
        path.write_text(path.read_text().replace("2024-04-08T18:00:00", "yesterday"))
        emitree.render(path)
