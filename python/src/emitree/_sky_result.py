"""Renderings as FITS files and maps, with coordinates of the sky where it is known."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from emitree import _native
from emitree._files import written

if TYPE_CHECKING:
    from emitree._function import Floats
    from emitree._sky import Sky


class OnSky(ABC):
    """What a rendering writes that has coordinates."""

    _found: _native.Rendered
    _sky: Sky | None
    #: Of images of a `WcsCamera`, whose files have its WCS.
    _wcs: Any = None
    _cards: dict[str, tuple[Any, str]] = {}  # noqa: RUF012

    @property
    @abstractmethod
    def image(self) -> Floats:
        """The image."""

    @property
    @abstractmethod
    def error(self) -> Floats | None:
        """Its estimated error."""

    @property
    @abstractmethod
    def scene(self) -> str:
        """The text of the scene."""

    @property
    def wcs(self) -> Any:
        """The coordinates of the image as an astropy WCS of two axes; None of a HEALPix sky."""
        if self._wcs is not None:
            return self._wcs
        if not self._found.axes():
            return None
        from astropy.wcs import WCS

        return WCS(self.to_fits()[0].header, naxis=2)

    def to_fits(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        observer: Any = None,
        frame: Any = None,
        origin: Any = None,
        coordinates: Any = None,
        extensions: bool = True,
        overwrite: bool = False,
    ) -> Any:
        """Image and error with units, coordinates and provenance, as FITS.

        With a path the file is written; without one, an astropy HDUList is returned. A file is
        whole or absent: one that is replaced stays until the other is complete.

        The image of a camera of `Camera.from_wcs`, of a scene file with `[sky]`, or of another one
        with `frame` or `observer`, has coordinates of the sky, with the time and the observer.
        Others have those about the pointing.

        observer: a `SkyCoord` with a distance: where the camera is. It is needed only where the
            model's frame has no time of its own, and has to agree with `position`.
        frame: the frame of astropy or sunpy whose axes are those of the model; that of `observer`
            by default.
        origin: a `SkyCoord` with a distance: where the origin of the model is; that of `frame` by
            default.
        coordinates: the frame of longitudes and latitudes; by default helioprojective in frames of
            the Sun, galactic, ecliptic or FK5 where the model is, and ICRS else.
        extensions: whether the error and the numbers of evaluations are written too. sunpy makes a
            map of each image in a file: without extensions, or with `sunpy.map.Map(path, hdus=0)`,
            there is one.

        Raises `SceneError` if the camera has no celestial projection, or if something is missing.
        """
        from emitree import _sky_fits

        at = _sky_fits.placed(
            self, observer=observer, frame=frame, origin=origin, coordinates=coordinates
        )
        encoded = self._found.fits(at)
        if self._wcs is not None:
            encoded = _sky_fits.with_wcs(encoded, self._wcs, self._cards)
        if not extensions:
            encoded = _sky_fits.first_image(encoded)
        return written(encoded, path, overwrite)

    def to_sunpy(
        self,
        *,
        observer: Any = None,
        frame: Any = None,
        origin: Any = None,
        coordinates: Any = None,
    ) -> Any:
        """The image as a `sunpy.map.Map`, with its error as `uncertainty`.

        Keywords as of `to_fits`; none are needed for a camera of `Camera.from_wcs`.

        Raises `SceneError` if there is no sky, or if a map can't have the coordinates.
        """
        from emitree import _sky_map

        return _sky_map.map_of(
            self, observer=observer, frame=frame, origin=origin, coordinates=coordinates
        )
