"""From a WCS to the camera that has its pixels.

Directions of pixels are taken from the WCS with all its distortions. The camera is the
least-squares fit to them, which is exact for a WCS that a camera has, and is refused where a corner
of a pixel is off by more than is allowed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from emitree import _units
from emitree._cameras import Camera, Fisheye
from emitree._function import Floats
from emitree._native import SceneError
from emitree._sky import (
    Sky,
    bare,
    completed,
    require_right_handed,
    rotation,
    sunpy_coordinates,
    time_of,
    xyz_in,
)
from emitree._sky_fit import MIDDLE, Fit, Pixels, fit
from emitree._sky_planes import PLANES, Plane

#: How far a corner of a pixel of a camera may be from that of the WCS by default [pixels].
ALLOWED = 0.01

#: A camera with the pointing in the middle of its image that is as close as this to the WCS is
#: taken without trying another one [pixels].
_EXACT = 1e-4


def camera_of(
    kind: type[Camera],
    wcs: Any,
    *,
    frame: Any,
    length_unit: Any,
    observer: Any,
    origin: Any,
    shape: Any,
    distance: Any,
    near: Any,
    far: Any,
    max_deviation: float,
) -> Camera:
    """The camera of `Camera.from_wcs`."""
    if not max_deviation > 0:
        raise SceneError(f"`max_deviation` is {max_deviation}: expected a number above 0 [pixels]")
    wcs, sky, position = placed(
        wcs, frame=frame, length_unit=length_unit, observer=observer, origin=origin, shape=shape
    )
    assert sky.shape is not None
    height, width = sky.shape
    unit = sky.length_unit
    pixels = Pixels.of(wcs, (height, width), to_model(sky))
    fits = [fit(plane, pixels, MIDDLE) for plane in _planes_for(kind, wcs)]
    fits += [
        fit(of.plane, pixels, _reference(wcs, (height, width)))
        for of in fits
        if of.plane.code == _code(wcs) == "TAN" and of.off > _EXACT
    ]
    # Among planes that agree as well as others, a disc is the last choice: it has no corners.
    agreeing = [of for of in fits if of.off <= max_deviation]
    if not agreeing:
        nearest = min(fits, key=lambda of: of.off)
        raise SceneError(_refusal(wcs, (height, width), nearest, max_deviation))
    fitted = min(agreeing, key=lambda of: (of.off > ALLOWED, of.plane.is_disc, of.off))
    reach = _units.value_in(distance, unit, "distance")
    if reach is None:
        reach = float(np.linalg.norm(position)) or 1.0
    return _camera(fitted, position, reach, near, far, replace(sky, deviation=fitted.off))


def placed(
    wcs: Any, *, frame: Any, length_unit: Any, observer: Any, origin: Any, shape: Any
) -> tuple[Any, Sky, Floats]:
    """The celestial axes of a WCS, the sky of its images, and its observer in the model (3,)."""
    unit = _units.to_text(length_unit)
    if unit is None:
        raise SceneError("`length_unit` is None: expected the unit of the model's lengths")
    wcs = _celestial(wcs)
    sides = _shape_of(wcs, shape)
    model = bare(frame, "`frame`")
    coordinates = _coordinates_of(wcs)
    time = _time_of(wcs) or time_of(coordinates, observer, model)
    coordinates, observer = _seen(completed(coordinates, time, None), observer)
    model = completed(model, time, observer)
    require_right_handed(model)
    sky = Sky(model, coordinates, unit, origin, time, sides)
    return wcs, sky, sky.positions(observer)


def to_model(sky: Sky) -> Floats:
    """The matrix (3, 3) by which a direction in the coordinates of a sky becomes one in the model.

    Rows of the matrix of `Sky.rotation` are the axes of the sky in the model: its transpose is its
    inverse.
    """
    return rotation(sky.frame, sky.coordinates).T


def _celestial(wcs: Any) -> Any:
    """The celestial axes of a WCS."""
    from astropy.wcs import WCS

    if not isinstance(wcs, WCS):
        raise SceneError(
            f"`wcs` is {type(wcs).__name__}: expected an `astropy.wcs.WCS` (of a FITS header, "
            "`WCS(header)`; of a sunpy map, `map.wcs`)"
        )
    if not wcs.has_celestial:
        raise SceneError(
            f"`wcs` has the axes {list(wcs.wcs.ctype)}: expected a longitude and a latitude with a "
            "projection, such as HPLN-TAN and HPLT-TAN"
        )
    return wcs.celestial


def _shape_of(wcs: Any, shape: Any) -> tuple[int, int]:
    given = wcs.array_shape if shape is None else shape
    if given is None:
        raise SceneError("`wcs` has no shape: expected `shape`, (height, width)")
    sides = np.asarray(given).tolist()
    is_pair = isinstance(sides, list) and len(sides) == 2
    if not is_pair or any(not isinstance(side, int) or side < 1 for side in sides):
        raise SceneError(f"`shape` is {given}: expected (height, width)")
    return sides[0], sides[1]


def _time_of(wcs: Any) -> Any:
    """When a WCS was seen; None if it does not say."""
    from astropy.time import Time

    date = wcs.wcs.dateavg or wcs.wcs.dateobs or wcs.wcs.datebeg
    scale = str(wcs.wcs.timesys).lower()
    return Time(date, scale=scale if scale in Time.SCALES else "utc") if date else None


def _coordinates_of(wcs: Any) -> Any:
    """The frame of the longitudes and latitudes of a WCS."""
    from astropy.coordinates import FK5, ICRS, BarycentricMeanEcliptic
    from astropy.time import Time
    from astropy.wcs.utils import wcs_to_celestial_frame

    kind = wcs.wcs.ctype[wcs.wcs.lng][:4].rstrip("-")
    if kind == "ELON":
        equinox = wcs.wcs.equinox
        return BarycentricMeanEcliptic(
            equinox=Time(2000.0 if np.isnan(equinox) else equinox, format="jyear", scale="tt")
        )
    if kind not in ("RA", "GLON", "HPLN"):
        raise SceneError(
            f"`wcs` has longitudes of the kind {kind}: expected directions from an observer, RA, "
            "GLON, ELON or HPLN (HGLN, CRLN and those of planets are places on a surface)"
        )
    if kind == "HPLN":
        sunpy_coordinates()
    try:
        found = wcs_to_celestial_frame(wcs)
    except ValueError as error:
        raise SceneError(f"`wcs` has no celestial frame: {error}") from None
    if kind == "RA" and not isinstance(found, ICRS | FK5):
        raise SceneError(
            f"`wcs` has the reference frame {type(found).__name__} (RADESYS): expected ICRS or FK5"
        )
    return found


def _seen(coordinates: Any, observer: Any) -> tuple[Any, Any]:
    """The coordinates with their observer, and the observer."""
    if "observer" not in coordinates.frame_attributes:
        if observer is None:
            raise SceneError(
                "`observer` is missing: expected a `SkyCoord` with a distance, since the WCS does "
                "not say where it was observed"
            )
        return coordinates, observer
    if coordinates.obstime is None:
        raise SceneError("`wcs` has no date: expected DATE-OBS, or an `observer` with an `obstime`")
    own = coordinates.observer
    if observer is None:
        if own is None or isinstance(own, str):
            raise SceneError(
                "`observer` is missing: expected a `SkyCoord` with a distance, or HGLN_OBS, "
                "HGLT_OBS and DSUN_OBS in the header of the WCS"
            )
        return coordinates, own
    if own is None or isinstance(own, str):
        return completed(coordinates, coordinates.obstime, observer), observer
    frame = sunpy_coordinates().HeliographicStonyhurst(obstime=coordinates.obstime)
    given, of_wcs = (xyz_in(frame, place, "`observer`") for place in (observer, own))
    if np.linalg.norm(given - of_wcs) > 1e-6 * np.linalg.norm(of_wcs):
        raise SceneError(
            f"`observer` is at {given.to('R_sun')} in {type(frame).__name__} coordinates, and that "
            f"of the WCS at {of_wcs.to('R_sun')}: expected one place, or no `observer`"
        )
    return coordinates, own


def _reference(wcs: Any, shape: tuple[int, int]) -> Floats:
    """The reference pixel of a WCS, as fractions of the image."""
    height, width = shape
    # The centre of the first pixel is at 1, its edge at 1/2.
    return np.asarray((np.array(wcs.wcs.crpix) - 0.5) / np.array([width, height]))


def _planes_for(kind: type[Camera], wcs: Any) -> list[Plane]:
    """The image planes to try: those of a class of cameras, or of the projection of the WCS."""
    if kind is not Camera:
        planes = [plane for plane in PLANES.values() if issubclass(kind, plane.camera)]
        if not planes or kind not in [plane.camera for plane in planes]:
            raise SceneError(
                f"`{kind.__name__}` has no celestial projection: expected `Camera.from_wcs`, or "
                "that of `Perspective`, `Equirectangular` or `Fisheye`"
            )
        return [plane for plane in planes if plane.camera is kind]
    code = _code(wcs)
    # In a narrow field other projections are a tangent plane within rounding of pixels.
    return [PLANES[code] for code in dict.fromkeys((code, "TAN")) if code in PLANES]


def _code(wcs: Any) -> str:
    return str(wcs.wcs.ctype[wcs.wcs.lng])[5:8]


def _refusal(wcs: Any, shape: tuple[int, int], fitted: Fit, allowed: float) -> str:
    """Why no camera has the pixels of a WCS."""
    code = _code(wcs)
    height, width = shape
    off_centre = np.array(wcs.wcs.crpix) - 0.5 * np.array([width + 1, height + 1])
    axes = wcs.pixel_scale_matrix
    cosine = np.dot(*axes.T) / np.prod(np.linalg.norm(axes, axis=0))
    distorted = wcs.sip is not None or wcs.cpdis1 is not None or wcs.cpdis2 is not None
    distorted = distorted or wcs.det2im1 is not None or wcs.det2im2 is not None
    reasons = []
    if distorted:
        reasons.append("a distortion (SIP or a table)")
    if code not in PLANES:
        reasons.append(f"the projection {code}")
    if abs(cosine) > 1e-6:
        reasons.append("axes that are not perpendicular")
    if code != "TAN" and np.abs(off_centre).max() > ALLOWED:
        reference = ", ".join(f"{place:.6g}" for place in wcs.wcs.crpix)
        reasons.append(
            f"its reference pixel at ({reference}), while the middle is at "
            f"({0.5 * (width + 1):g}, {0.5 * (height + 1):g})"
        )
    has = f"; it has {', '.join(reasons)}" if reasons else ""
    off = (
        f"{fitted.off:.2g} pixels off" if np.isfinite(fitted.off) else "without some of its pixels"
    )
    return (
        f"no camera has the pixels of `wcs`: the nearest one, {fitted.plane.camera.__name__}, is "
        f"{off} at a corner, `max_deviation` is {allowed}{has}. Expected TAN or CAR, or ARC or ZEA "
        "in a square, without distortion, with perpendicular axes and (but for TAN) the reference "
        "pixel in the middle of the image; or a field so narrow, or a `max_deviation` so large, "
        "that the difference is below it. `emitree.WcsCamera.from_wcs` has any WCS, with its "
        "distortions"
    )


def _camera(
    fitted: Fit, position: Floats, distance: float, near: Any, far: Any, sky: Sky
) -> Camera:
    """The camera at a position that looks along fitted axes."""
    half = fitted.half
    if fitted.plane.code == "TAN":
        angles = 2 * np.degrees(np.arctan(half))
    elif fitted.plane.code == "ZEA":
        angles = 4 * np.degrees(np.arcsin(0.5 * half))
    else:
        angles = 2 * np.degrees(half)
    field = [_whole(float(angle)) for angle in angles]
    options: dict[str, Any] = {
        "position": position.tolist(),
        "target": (position + distance * fitted.axes[2]).tolist(),
        "up": fitted.axes[1].tolist(),
        "near": near,
        "far": far,
        "length_unit": sky.length_unit,
        "field_of_view": field[0] if fitted.plane.is_disc else field,
    }
    if fitted.pointing is not MIDDLE:
        options["principal_point"] = fitted.pointing.tolist()
    if fitted.plane.camera is Fisheye:
        options["mapping"] = fitted.plane.code
    camera = fitted.plane.camera(**options)
    object.__setattr__(camera, "sky", sky)
    return camera


def _whole(angle: float) -> float:
    """An angle [deg]; the whole circle and half of it exactly, where it is closed."""
    return next((whole for whole in (360.0, 180.0) if abs(angle - whole) < 1e-9), angle)
