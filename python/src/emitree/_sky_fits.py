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
#: Cards of the file of a WCS that are not about it.
_STRUCTURE = frozenset(["SIMPLE", "BITPIX", "NAXIS", "NAXIS1", "NAXIS2", "EXTEND", "", "COMMENT"])
#: Cards of the sky that do not depend on the projection.
_OF_SKY = (
    "RADESYS", "EQUINOX", "DATE-OBS", "MJD-OBS", "RSUN_REF", "DSUN_OBS", "HGLN_OBS", "HGLT_OBS",
)  # fmt: skip


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


def with_wcs(file: bytes, wcs: Any, cards: dict[str, tuple[Any, str]]) -> bytes:
    """The bytes of a FITS file whose images have the coordinates of a WCS, with its distortions.

    cards: those of its sky, as of `sky_cards`, which go before those of the WCS.
    """
    from astropy.io import fits

    own = wcs.to_fits(relax=True)
    found = {
        card.keyword: (card.value, card.comment)
        for card in own[0].header.cards
        if card.keyword not in _STRUCTURE
    }
    with fits.HDUList.fromstring(file) as hdus:
        for hdu in hdus:
            if not (hdu.is_image and hdu.header["NAXIS"] == 2):
                continue
            last = "EXTNAME"
            for key, card in (found | cards).items():
                hdu.header.set(key, *card, after=last)
                last = key
        # Tables of distortions are extensions.
        hdus.extend(own[1:])
        buffer = io.BytesIO()
        hdus.writeto(buffer, checksum=True)
    return buffer.getvalue()


def sky_cards(file: bytes) -> dict[str, tuple[Any, str]]:
    """The cards of the sky in a FITS file: date, observer and reference frame."""
    from astropy.io import fits

    with fits.HDUList.fromstring(file) as hdus:
        header = hdus[0].header
        return {key: (header[key], header.comments[key]) for key in _OF_SKY if key in header}


def first_image(file: bytes) -> bytes:
    """The bytes of a FITS file with its first image alone."""
    from astropy.io import fits

    with fits.HDUList.fromstring(file) as hdus:
        if hdus[0].data is not None:
            del hdus[1:]
        buffer = io.BytesIO()
        hdus.writeto(buffer)
    return buffer.getvalue()
