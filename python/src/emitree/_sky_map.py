"""Renderings as maps of sunpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from emitree._native import SceneError
from emitree._sky_wcs import ALLOWED

if TYPE_CHECKING:
    from emitree._sky_result import OnSky


def map_of(rendering: OnSky, **place: Any) -> Any:
    """The map of `Rendering.to_sunpy`."""
    try:
        import sunpy.map
    except ImportError as missing:
        raise ImportError(
            'sunpy.map is missing: `pip install "emitree[sky]"` installs it'
        ) from missing
    from astropy.nddata import UnknownUncertainty

    if rendering.image.ndim != 2:
        raise SceneError(
            "the rendering is a cube: expected an image, since a map has two axes "
            "(`rendering.to_fits()` has the cube)"
        )
    header = rendering.to_fits(extensions=False, **place)[0].header
    if not header.get("CTYPE1", "").startswith("HPLN"):
        raise SceneError(
            f"the image has the axes {header.get('CTYPE1')} and {header.get('CTYPE2')}: expected "
            "helioprojective ones, of a camera of `Camera.from_wcs`, or with `observer` and a "
            "`frame` of the Sun"
        )
    # The error is an estimate of the largest deviation, no standard deviation.
    error = None if rendering.error is None else UnknownUncertainty(rendering.error)
    made = sunpy.map.Map(rendering.image, header, uncertainty=error)
    _compare(made.wcs, rendering.image.shape, header, rendering._wcs)
    return made


def _compare(wcs: Any, shape: tuple[int, ...], header: Any, of_camera: Any) -> None:
    """Refuses coordinates that sunpy reads in another way."""
    from astropy.wcs import WCS

    height, width = shape
    corners = np.array([[x, y] for x in (-0.5, width - 0.5) for y in (-0.5, height - 0.5)])
    with np.errstate(invalid="ignore"):
        back = wcs.all_world2pix(WCS(header).all_pix2world(corners, 0), 0)
    if not np.abs(back - corners).max() <= ALLOWED:
        if of_camera is not None:
            raise SceneError(
                "sunpy's maps have no distortions, which the WCS of this image has: expected "
                "`to_fits`, or another WCS"
            )
        raise SceneError(
            f"sunpy's maps have no LONPOLE, which this image needs ({header['LONPOLE']:.6g} "
            "degrees): expected a `Perspective`, or solar north up and the equator in the middle"
        )
