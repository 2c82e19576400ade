"""From a WCS to the camera that has its pixels.

Directions of pixels are taken from the WCS with all its distortions. The camera is the
least-squares fit to them, which is exact for a WCS that a camera has, and is refused where a corner
of a pixel is off by more than is allowed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
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
from emitree._sky_planes import PLANES, Plane

#: How far a corner of a pixel of a camera may be from that of the WCS by default [pixels].
ALLOWED = 0.01

#: How many corners along each axis are compared.
_CORNERS = 17


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
    unit = _units.to_text(length_unit)
    if unit is None:
        raise SceneError("`length_unit` is None: expected the unit of the model's lengths")
    wcs = _celestial(wcs)
    height, width = _shape_of(wcs, shape)
    model = bare(frame, "`frame`")
    coordinates = _coordinates_of(wcs)
    time = _time_of(wcs) or time_of(coordinates, observer, model)
    coordinates, observer = _seen(completed(coordinates, time, None), observer)
    model = completed(model, time, observer)
    require_right_handed(model)
    sky = Sky(model, coordinates, unit, origin, time, (height, width))
    position = sky.positions(observer)
    # Rows of the matrix are the axes of the sky in the model: its transpose is its inverse.
    to_model = rotation(model, coordinates).T
    pixels = _Pixels.of(wcs, (height, width), to_model)
    fits = [_fit(plane, pixels) for plane in _planes_for(kind, wcs)]
    # Among planes that agree as well as others, a disc is the last choice: it has no corners.
    agreeing = [fit for fit in fits if fit.off <= max_deviation]
    if not agreeing:
        nearest = min(fits, key=lambda fit: fit.off)
        raise SceneError(_refusal(wcs, (height, width), nearest, max_deviation))
    fitted = min(agreeing, key=lambda fit: (fit.off > ALLOWED, fit.plane.is_disc, fit.off))
    reach = _units.value_in(distance, unit, "distance")
    if reach is None:
        reach = float(np.linalg.norm(position)) or 1.0
    return _camera(fitted, position, reach, near, far, replace(sky, deviation=fitted.off))


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


@dataclass(frozen=True)
class _Pixels:
    """Corners of pixels over a whole image, and the directions that a WCS has for them.

    xy: (n, 2), from 0 to 1 over the image, right and up.
    sight: (n, 3), unit vectors in the model; NaN where the WCS has none.
    pixels: (n, 2, 3), by which a small change of a direction becomes pixels.
    axes: rows are right, up and forward in the middle of the image; mirrored images have none.
    """

    xy: Floats
    sight: Floats
    pixels: Floats
    axes: Floats
    shape: tuple[int, int]

    @staticmethod
    def of(wcs: Any, shape: tuple[int, int], to_model: Floats) -> _Pixels:
        height, width = shape
        sides = np.array([width, height], dtype=np.float64)

        def directions(places: Floats) -> Floats:
            # Pixel centres are at whole numbers: the lower left corner of an image is at -1/2.
            found = np.radians(wcs.all_pix2world(places - 0.5, 0))
            lon, lat = found[:, wcs.wcs.lng], found[:, wcs.wcs.lat]
            unit = [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]
            return np.asarray(np.stack(unit, axis=-1) @ to_model.T)

        x, y = (np.linspace(0.0, side, _CORNERS) for side in (width, height))
        places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        sight = directions(places)
        # Steps of half a pixel towards the middle do not leave the image.
        steps = np.where(places > 0.5 * sides, -0.5, 0.5)
        slopes = [
            (directions(places + steps[:, [axis]] * np.eye(2)[axis]) - sight) / steps[:, [axis]]
            for axis in (0, 1)
        ]
        jacobians = np.stack(slopes, axis=-1)
        known = np.isfinite(sight).all(axis=1) & np.isfinite(jacobians).all(axis=(1, 2))
        pixels = np.full((len(places), 2, 3), np.nan)
        pixels[known] = np.linalg.pinv(jacobians[known], rcond=1e-5)

        around = directions(
            0.5 * sides + 0.5 * np.array([[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]])
        )
        if not np.isfinite(around).all():
            raise SceneError("`wcs` has no direction in the middle of the image: expected one")
        forward, right, up = around[0], around[2] - around[1], around[4] - around[3]
        if np.dot(np.cross(forward, up), right) <= 0:
            raise SceneError(
                "`wcs` is mirrored: expected an image as seen by an observer, with east to the "
                "left of north (or solar west to the right); a mirrored one is the mirror image of "
                "that, whose WCS has the other sign of CDELT1"
            )
        up = up - np.dot(up, forward) * forward
        up /= np.linalg.norm(up)
        axes = np.stack([np.cross(forward, up), up, forward])
        return _Pixels(places / sides, sight, pixels, axes, shape)


@dataclass(frozen=True)
class _Fit:
    """A camera of an image plane: axes in rows, half extents, the largest deviation [pixels]."""

    plane: Plane
    axes: Floats
    half: Floats
    off: float


def _fit(plane: Plane, pixels: _Pixels) -> _Fit:
    """The camera with the smallest sum of squared distances, by Gauss and Newton."""
    known = np.isfinite(pixels.pixels).all(axis=(1, 2))
    centred = 2 * pixels.xy[known] - 1
    seen, to_pixels = pixels.sight[known], pixels.pixels[known]

    def distances(axes: Floats, half: Floats) -> Floats:
        sight = plane.sight(*(centred * half).T) @ axes
        return np.einsum("nij,nj->ni", to_pixels, sight - seen)

    axes = pixels.axes
    height, width = pixels.shape
    middle = np.argmin(np.abs(centred).sum(axis=1))
    # Half a pixel on the plane is half the angle of a pixel in the middle.
    right, up = (1 / np.linalg.norm(row) for row in to_pixels[middle])
    half = 0.5 * np.array([right * width, up * height])
    half = np.minimum(np.full(2, half.mean()) if plane.is_disc else half, plane.widest)
    tiny = 1e-6
    for _ in range(12):
        start = distances(axes, half)
        changes = [_turned(axes, tiny * vector) for vector in np.eye(3)]
        columns = [distances(turned, half) - start for turned in changes]
        scales = [np.ones(2)] if plane.is_disc else list(np.eye(2))
        columns += [distances(axes, half * (1 + tiny * scale)) - start for scale in scales]
        slopes = np.stack([column.ravel() for column in columns], axis=1) / tiny
        step = np.linalg.lstsq(slopes, -start.ravel(), rcond=None)[0]
        axes = _turned(axes, step[:3])
        half = np.minimum(half * (1 + np.clip(step[3:], -0.5, 0.5)), plane.widest)
        if np.abs(step).max() < 1e-15:
            break
    off = np.linalg.norm(distances(axes, half), axis=1).max()
    if not known.all() and not plane.is_disc:
        off = np.inf
    return _Fit(plane, axes, half, float(off))


def _turned(axes: Floats, by: Any) -> Floats:
    """Axes turned about themselves by a small vector [rad]."""
    angle = float(np.linalg.norm(by))
    x, y, z = by
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # Rodrigues' formula.
    turn = np.eye(3) + np.sinc(angle / np.pi) * cross
    turn += 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * cross @ cross
    return turn @ axes


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


def _refusal(wcs: Any, shape: tuple[int, int], fitted: _Fit, allowed: float) -> str:
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
    if np.abs(off_centre).max() > ALLOWED:
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
        "in a square, without distortion, with perpendicular axes and the reference pixel in the "
        "middle of the image; or a field so narrow, or a `max_deviation` so large, that the "
        "difference is below it"
    )


def _camera(
    fitted: _Fit, position: Floats, distance: float, near: Any, far: Any, sky: Sky
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
    if fitted.plane.camera is Fisheye:
        options["mapping"] = fitted.plane.code
    camera = fitted.plane.camera(**options)
    object.__setattr__(camera, "sky", sky)
    return camera


def _whole(angle: float) -> float:
    """An angle [deg]; the whole circle and half of it exactly, where it is closed."""
    return next((whole for whole in (360.0, 180.0) if abs(angle - whole) < 1e-9), angle)
