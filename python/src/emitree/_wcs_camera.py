"""The camera of any WCS, with its distortions: each pixel is what is between its corners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _units
from emitree._cameras import Camera, Vector
from emitree._function import Floats
from emitree._native import SceneError

if TYPE_CHECKING:
    from emitree._lines import Lines


@dataclass(frozen=True, kw_only=True, eq=False)
class WcsCamera(Camera):
    """The pixels of an astropy WCS with all its distortions, seen by an observer: of `from_wcs`.

    SIP, TPV, lookup tables and every projection that astropy has. A pixel is the mean over what is
    between its four corners and the middles of its borders; one without a direction at any of these
    is NaN. `render` makes the image of a camera without distortions, with pixels that are smaller
    than those of the WCS, and takes the means over the pixels of the WCS from that. The error of a
    pixel is that of the smaller pixels in it, and what those that its border divides may differ.

    `render` takes a `tolerance`, and all that describes the emission and the view, for method "vol"
    and images; no energies, exposures, weights, masks, sums or instruments. `lines` are the lines
    through the centres of the pixels, for `line_integrals`. `sweep` takes this camera, too;
    sessions, Jacobians and fits do not.

    wcs: the celestial axes of the WCS; position: (3,), the observer in the model; distance: to what
        is in view; near, far, length_unit: as of `Perspective`.

    >>> import astropy.units as u, emitree
    >>> from astropy.coordinates import ICRS, SkyCoord
    >>> from astropy.wcs import WCS
    >>> wcs = WCS({"CTYPE1": "RA---AIR", "CTYPE2": "DEC--AIR", "CRVAL1": 83.6, "CRVAL2": 22.0,
    ...     "CRPIX1": 8.5, "CRPIX2": 6.5, "CDELT1": -1.0, "CDELT2": 1.0, "RADESYS": "ICRS"})
    >>> camera = emitree.WcsCamera.from_wcs(
    ...     wcs, frame=ICRS(), length_unit="pc", shape=(12, 16),
    ...     origin=SkyCoord(83.6 * u.deg, 22 * u.deg, distance=20 * u.pc),
    ...     observer=SkyCoord(0 * u.deg, 0 * u.deg, distance=0 * u.pc), near=10, far=30,
    ... )
    >>> rendering = emitree.render("exp(-r^2)", camera)
    >>> rendering.to_fits()[0].header["CTYPE1"], rendering.converged
    ('RA---AIR', True)
    """

    wcs: Any
    position: Vector
    distance: float
    near: float | None = None
    far: float | None = None
    length_unit: str | Any | None = None

    @classmethod
    def from_wcs(
        cls,
        wcs: Any,
        *,
        frame: Any,
        length_unit: Any,
        observer: Any = None,
        origin: Any = None,
        shape: Sequence[int] | None = None,
        distance: Any = None,
        near: Any = None,
        far: Any = None,
        max_deviation: float = 0.0,
    ) -> WcsCamera:
        """The camera of a WCS, with arguments as of `Camera.from_wcs`; nothing deviates.

        Raises `SceneError` if something is missing, or if the WCS has another sky or is mirrored.
        """
        from emitree._sky_wcs import placed

        if max_deviation != 0.0:
            raise SceneError(
                f"`max_deviation` is {max_deviation}: expected none, as pixels are those of the WCS"
            )
        wcs, sky, position = placed(
            wcs, frame=frame, length_unit=length_unit, observer=observer, origin=origin, shape=shape
        )
        reach = _units.value_in(distance, sky.length_unit, "distance")
        if reach is None:
            reach = float(np.linalg.norm(position)) or 1.0
        camera = cls(
            wcs=wcs,
            position=tuple(position.tolist()),
            distance=reach,
            near=near,
            far=far,
            length_unit=sky.length_unit,
        )
        object.__setattr__(camera, "sky", sky)
        return camera

    def table(self, length_unit: str | None) -> dict[str, Any]:
        """Refuses: a scene has no such camera."""
        raise SceneError(
            "the camera is a `WcsCamera`: expected another one here, since only `emitree.render`, "
            "`lines` and through these `line_integrals` have pixels with distortions"
        )

    def lengths(self) -> list[Any]:
        """The values that are lengths."""
        return [self.position, self.near, self.far]

    def lines(
        self,
        shape: Sequence[int] | int | None = None,
        *,
        bounds: Any = None,
        occulters: Sequence[Any] = (),
    ) -> Lines:
        """The lines of sight through the centres of the pixels, as of `Camera.lines`.

        shape: that of the WCS, which is the default.
        """
        from emitree._lines import Lines
        from emitree._sky_corners import Corners
        from emitree._wcs_render import shape_of

        height, width = shape_of(self, shape)
        row, column = np.divmod(np.arange(height * width), width)
        corners = Corners.of(self)
        direction = corners.directions(np.stack([column, row], axis=-1) + 0.5)
        is_seen = np.isfinite(direction).all(axis=1)
        direction[~is_seen] = corners.axes[2]
        near, far = self._depths()
        position = np.array(self.position) + near * direction
        length = np.where(is_seen, far - near, 0.0)
        unit = _units.to_text(self.length_unit)
        whole = Lines(position, direction, length, scale=self.distance, length_unit=unit)
        return whole if bounds is None and len(occulters) == 0 else _cut(whole, bounds, occulters)

    def _depths(self) -> tuple[float, float]:
        unit = _units.to_text(self.length_unit)
        near, far = (_units.value_in(of, unit, "depth") for of in (self.near, self.far))
        return 0.0 if near is None else float(near), np.inf if far is None else float(far)


def _cut(lines: Lines, bounds: Any, occulters: Sequence[Any]) -> Lines:
    """The parts of lines inside of bounds and before bodies."""
    from emitree._line_parts import parts_of
    from emitree._lines import Lines

    near, far = parts_of(lines, bounds, occulters)
    is_seen = far > near
    near = np.where(is_seen, near, 0.0)
    position: Floats = lines.positions + near[:, np.newaxis] * lines.directions
    length = np.where(is_seen, far - near, 0.0)
    return Lines(
        position, lines.directions, length, scale=lines.scale, length_unit=lines.length_unit
    )
