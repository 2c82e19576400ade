"""FITS headers of images on the sky: from longitudes about the pointing to those of a frame.

Calabretta & Greisen 2002 (doi:10.1051/0004-6361:20021327) for projections, Thompson 2006
(doi:10.1051/0004-6361:20054262) for helioprojective coordinates and the keywords of observers.
"""

from __future__ import annotations

import io
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._function import Floats
from emitree._native import SceneError
from emitree._sky import Sky, require_same_place, rotation, sky_of, sunpy_coordinates, xyz_in

if TYPE_CHECKING:
    from emitree._sky_result import OnSky

#: The letters of longitudes and latitudes in FITS, by the class of the frame.
_AXES = {
    "Helioprojective": ("HPLN", "HPLT"),
    "ICRS": ("RA--", "DEC-"),
    "FK5": ("RA--", "DEC-"),
    "Galactic": ("GLON", "GLAT"),
    "BarycentricMeanEcliptic": ("ELON", "ELAT"),
}

#: How far the pole of the sky has to be from the great circles on which the middle of a plate
#: carrée does not determine its rotation [rad]: here ten of sixteen digits are left.
_BESIDE = 1e-3

#: How far the axes of a HEALPix map may be from those of its coordinates [rad].
_ALIGNED_RAD = 1e-9


@dataclass(frozen=True)
class View:
    """Where a camera is and how it looks, in the model: what the scene of a rendering has.

    axes: rows are right, up and forward; None of a sky in HEALPix pixels.
    """

    type: str
    position: Floats
    axes: Floats | None
    length_unit: str | None

    @staticmethod
    def of(scene: str) -> View:
        """The view of the text of a scene."""
        # Changes of a scene file are comments at the end of its text, one in each line.
        if any(line.startswith("# changed: projection") for line in scene.splitlines()):
            raise SceneError(
                "`[projection]` of the scene file was changed by `changes`: expected the keys of "
                "the camera in the file, or a camera in Python"
            )
        table = tomllib.loads(scene)["projection"]
        kind, length_unit = table["type"], table.get("length_unit")
        position = np.array(table.get("position", [0.0, 0.0, 0.0]), dtype=np.float64)
        if "target" not in table:
            return View(kind, position, None, length_unit)
        forward = np.array(table["target"], dtype=np.float64) - position
        forward /= np.linalg.norm(forward)
        up = np.array(table.get("up", [0.0, 0.0, 1.0]), dtype=np.float64)
        # Twice: the first difference loses digits where up is nearly along the pointing.
        for _ in range(2):
            up = up - np.dot(up, forward) * forward
            up /= np.linalg.norm(up)
        return View(kind, position, np.stack([np.cross(forward, up), up, forward]), length_unit)


def placed(
    rendering: OnSky,
    *,
    observer: Any = None,
    frame: Any = None,
    origin: Any = None,
    coordinates: Any = None,
) -> tuple[Sky, View] | None:
    """The sky and the view of a rendering; None if nothing says where it is."""
    given = {"observer": observer, "frame": frame, "origin": origin, "coordinates": coordinates}
    named = [name for name, value in given.items() if value is not None]
    sky = rendering._sky
    if sky is None and not named:
        return None
    view = View.of(rendering.scene)
    if sky is not None:
        others = [name for name in named if name != "observer"]
        if others:
            raise SceneError(
                f"`{others[0]}` is given, and the camera has a sky of its own: expected none"
            )
        if observer is not None:
            require_same_place(sky, observer, view.position)
        return sky, view
    if view.axes is None:
        if coordinates is not None:
            raise SceneError(
                "`coordinates` is given, and a HEALPix map has the axes of the model: expected none"
            )
        given["coordinates"] = observer if frame is None else frame
    return sky_of(**given, position=view.position, length_unit=view.length_unit), view


def encoded(file: bytes, at: tuple[Sky, View] | None, extensions: bool = True) -> bytes:
    """The bytes of a FITS file on the sky, or with its first image alone."""
    from astropy.io import fits

    with fits.HDUList.fromstring(file) as hdus:
        if not extensions and hdus[0].data is not None:
            del hdus[1:]
        if at is not None:
            _on_sky(hdus, *at)
        buffer = io.BytesIO()
        hdus.writeto(buffer)
    return buffer.getvalue()


def _on_sky(hdus: Any, sky: Sky, view: View) -> None:
    """Gives HDUs of a rendering coordinates of the sky where they have those of the camera."""
    name = type(sky.coordinates).__name__
    for hdu in hdus:
        header = hdu.header
        if header.get("PIXTYPE") == "HEALPIX":
            _healpix(header, sky)
        elif header.get("CTYPE1", "").startswith("XLON-"):
            if name not in _AXES:
                raise SceneError(
                    f"`coordinates` are {name}: expected {', '.join(_AXES)}, which FITS has"
                )
            _celestial(header, sky, view, sky.rotation())
        elif hdu.header.get("CTYPE1"):
            raise SceneError(
                f"the camera {view.type} has no celestial projection: expected `Perspective`, "
                "`Equirectangular`, `Fisheye` or `Healpix`"
            )
        else:
            continue
        if "CHECKSUM" in header:
            hdu.add_checksum()


def _celestial(header: Any, sky: Sky, view: View, to_sky: Floats) -> None:
    """Replaces the coordinates about the pointing by those of the sky."""
    assert view.axes is not None
    code = header["CTYPE1"][5:]
    longitude, latitude = _AXES[type(sky.coordinates).__name__]
    header["CTYPE1"], header["CTYPE2"] = f"{longitude}-{code}", f"{latitude}-{code}"
    header["WCSNAME"] = type(sky.coordinates).__name__
    for key in ("CNAME1", "CNAME2", "LATPOLE"):
        header.remove(key)
    # Columns: right, up and forward in coordinates of the sky.
    right, up, forward = (to_sky @ axis for axis in view.axes)
    # Seen from inside, right-handed longitudes increase to the left, and so does the first axis.
    hand = -1.0 if np.linalg.det(to_sky) > 0 else 1.0
    steps = np.array([header["CDELT1"], header["CDELT2"]])
    header["CDELT1"] = hand * steps[0]
    reference = forward
    if code == "CAR":
        # The native pole is up; the pole of the sky is at this native longitude.
        from_up = float(np.hypot(right[2], forward[2]))
        if from_up < 1e-14:
            right[2] = forward[2] = from_up = 0.0
        header["LONPOLE"] = float(np.degrees(np.arctan2(hand * right[2], forward[2])))
        if abs(forward[2]) < _BESIDE * from_up or abs(up[2]) < _BESIDE:
            # The middle does not determine the rotation: the native pole is the reference point.
            reference = up
            for number, value in ((0, 0.0), (1, 0.0), (2, 90.0)):
                header.set(f"PV1_{number}", value, "reference point: the pole", after="LONPOLE")
        else:
            latitude_of_pole = float(np.degrees(np.arcsin(np.clip(up[2], -1.0, 1.0))))
            header.set("LATPOLE", latitude_of_pole, "[deg] of the native pole", after="LONPOLE")
    lon = float(np.arctan2(reference[1], reference[0]))
    lat = float(np.arctan2(reference[2], np.hypot(reference[0], reference[1])))
    # Longitudes of the Sun are about its centre, others from 0 to 360 degrees.
    degrees = float(np.degrees(lon))
    header["CRVAL1"] = degrees if longitude == "HPLN" else degrees % 360.0
    header["CRVAL2"] = float(np.degrees(lat))
    if code != "CAR":
        header["LONPOLE"] = 180.0
        east = np.array([-np.sin(lon), np.cos(lon), 0.0])
        north = np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
        turned = np.array([[east @ right, east @ up], [north @ right, north @ up]])
        _set_matrix(header, turned * steps / np.array([[hand * steps[0]], [steps[1]]]))
    _of_frame(header, sky)


def _set_matrix(header: Any, matrix: Floats) -> None:
    """The matrix from pixels to the plane, without rounding where it is that of unity."""
    matrix = np.where(np.abs(matrix) < 1e-14, 0.0, matrix)
    matrix = np.where(np.abs(matrix - np.eye(2)) < 1e-14, np.eye(2), matrix)
    after = "CDELT2"
    for (row, column), value in np.ndenumerate(matrix):
        key = f"PC{row + 1}_{column + 1}"
        header.set(key, float(value), "rotation of the axes", after=after)
        after = key


def _of_frame(header: Any, sky: Sky) -> None:
    """The keywords of a frame: its equinox, the time, and the observer of the Sun."""
    frame, after = sky.coordinates, "LONPOLE"

    def add(key: str, value: Any, comment: str) -> None:
        nonlocal after
        header.set(key, value, comment, after=after)
        after = key

    name = type(frame).__name__
    if name in ("ICRS", "FK5"):
        add("RADESYS", name, "reference frame of the coordinates")
    if name == "BarycentricMeanEcliptic":
        add("RADESYS", "ICRS", "reference frame of the coordinates")
    if name in ("FK5", "BarycentricMeanEcliptic"):
        add("EQUINOX", float(frame.equinox.jyear), "[yr] mean equinox")
    if sky.time is not None:
        time = sky.time.utc
        add("TIMESYS", "UTC", "scale of times")
        add("DATE-OBS", time.isot, "time of the observer and of the frames")
        add("MJD-OBS", float(time.mjd), "[d] the same as a modified Julian date")
    if name == "Helioprojective":
        _observer(frame, add)


def _observer(frame: Any, add: Any) -> None:
    """The observer of helioprojective coordinates."""
    import astropy.units as u

    if frame.obstime is None or frame.observer is None:
        raise SceneError(
            "the frame has no `obstime` or no observer: expected both for helioprojective "
            "coordinates"
        )
    of_sun = sunpy_coordinates().HeliographicStonyhurst(obstime=frame.obstime, rsun=frame.rsun)
    x, y, z = xyz_in(of_sun, frame.observer, "`observer`").to_value(u.m)
    add("RSUN_REF", float(frame.rsun.to_value(u.m)), "[m] radius of the Sun")
    add("DSUN_OBS", float(np.sqrt(x * x + y * y + z * z)), "[m] from the observer to its centre")
    add("HGLN_OBS", float(np.degrees(np.arctan2(y, x))), "[deg] Stonyhurst longitude of observer")
    add("HGLT_OBS", float(np.degrees(np.arctan2(z, np.hypot(x, y)))), "[deg] its latitude")


def _healpix(header: Any, sky: Sky) -> None:
    """The system of the longitudes and latitudes of a HEALPix map: those of the model's axes."""
    from astropy.coordinates import ICRS, BarycentricMeanEcliptic, Galactic

    systems = {"G": Galactic(), "C": ICRS(), "E": BarycentricMeanEcliptic()}
    for letter, coordinates in systems.items():
        if np.abs(rotation(sky.frame, coordinates) - np.eye(3)).max() < _ALIGNED_RAD:
            header.set("COORDSYS", letter, "system of longitude and latitude", after="ORDERING")
            if letter == "C":
                header.set("RADESYS", "ICRS", "reference frame", after="COORDSYS")
            return
    raise SceneError(
        f"a HEALPix map has the axes of the model, {type(sky.frame).__name__}, for which it has no "
        "COORDSYS: expected Galactic, ICRS or BarycentricMeanEcliptic"
    )
