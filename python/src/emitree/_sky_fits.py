"""FITS files of images on the sky: the table `[sky]` of a rendering, from frames.

Headers are written from that table, as they are for scene files, without astropy.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._native import SceneError
from emitree._scene import document
from emitree._sky import require_same_place, rotation, sky_of

if TYPE_CHECKING:
    from emitree._sky import Sky
    from emitree._sky_result import OnSky

#: How far the axes of a HEALPix map may be from those of its coordinates [rad].
_ALIGNED_RAD = 1e-9


def placed(
    rendering: OnSky,
    *,
    observer: Any = None,
    frame: Any = None,
    origin: Any = None,
    coordinates: Any = None,
) -> str | None:
    """The text of the table `[sky]` of a rendering; None if the scene has it, or there is none."""
    given = {"observer": observer, "frame": frame, "origin": origin, "coordinates": coordinates}
    named = [name for name, value in given.items() if value is not None]
    camera, position, length_unit, has_sky = rendering._found.view
    if not named:
        return None
    if has_sky:
        known = rendering._sky
        others = [name for name in named if known is None or name != "observer"]
        if others:
            owner = "scene" if known is None else "camera"
            raise SceneError(
                f"`{others[0]}` is given, and the {owner} has a sky of its own: expected none"
            )
        if known is not None:
            require_same_place(known, observer, position)
        return None
    is_healpix = camera == "healpix"
    if is_healpix:
        if coordinates is not None:
            raise SceneError(
                "`coordinates` is given, and a HEALPix map has the axes of the model: expected none"
            )
        given["coordinates"] = observer if frame is None else frame
    sky = sky_of(**given, position=position, length_unit=length_unit)
    return document({"sky": _of_healpix(sky) if is_healpix else sky.table})


def _of_healpix(sky: Sky) -> dict[str, Any]:
    """The table of a HEALPix map, whose longitudes and latitudes are those of the model's axes."""
    from astropy.coordinates import ICRS, BarycentricMeanEcliptic, Galactic

    name = type(sky.frame).__name__
    for coordinates in (Galactic(), ICRS(), BarycentricMeanEcliptic()):
        if np.abs(rotation(sky.frame, coordinates) - np.eye(3)).max() < _ALIGNED_RAD:
            table = {"frame": name, "coordinates": type(coordinates).__name__}
            return table | {"axes": np.eye(3).tolist()}
    raise SceneError(
        f"a HEALPix map has the axes of the model, {name}, for which it has no "
        "COORDSYS: expected Galactic, ICRS or BarycentricMeanEcliptic"
    )


def first_image(file: bytes) -> bytes:
    """The bytes of a FITS file with its first image alone."""
    from astropy.io import fits

    with fits.HDUList.fromstring(file) as hdus:
        if hdus[0].data is not None:
            del hdus[1:]
        buffer = io.BytesIO()
        hdus.writeto(buffer)
    return buffer.getvalue()
