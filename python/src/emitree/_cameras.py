"""Cameras and shapes: `[projection]`, `[bounds]`, `[[occulter]]`, `[[edge]]`, `[[singularity]]`.

Keywords are the keys of the scene file. Lengths are in `length_unit`, angles in degrees; astropy
quantities are converted to these. What a scene calls a camera, and which of its keys are lengths or
angles, is in the table of cameras that the reader of scenes has: a class finds its row by its name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from emitree import _native, _units

if TYPE_CHECKING:
    from emitree._lines import Lines
    from emitree._sky import Sky

Vector = Sequence[float]


class _Table:
    """A table of a scene; what is `None` is left out."""

    _type: ClassVar[str]
    _lengths: ClassVar[tuple[str, ...]] = ()
    _angles: ClassVar[tuple[str, ...]] = ()

    def table(self, length_unit: str | None) -> dict[str, Any]:
        """The keys and values that a scene has for it, lengths in `length_unit`."""
        table: dict[str, Any] = {"type": self._type}
        for field in fields(self):  # type: ignore[arg-type]
            name, value = field.name, getattr(self, field.name)
            if name in self._lengths:
                value = _units.value_in(value, length_unit, name)
            elif name in self._angles:
                value = _units.value_in(value, "deg", name)
            if value is not None:
                table[name] = _units.plain(value)
        return table

    def lengths(self) -> list[Any]:
        """The values that are lengths."""
        return [getattr(self, name) for name in self._lengths]


_ROWS: dict[str, dict[str, Any]] = {row["python_class"]: row for row in _native.cameras()}


class Camera(_Table):
    """A camera: which line of sight belongs to which pixel."""

    length_unit: str | Any | None
    _is_sky: ClassVar[bool] = False

    #: Where on the sky its images are, of a camera of `from_wcs`; else None.
    sky: ClassVar[Sky | None] = None

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        # A subclass made by a user has no row: it inherits that of its base class.
        if cls.__module__ == __name__:
            row = _ROWS[cls.__name__]
            cls._type, cls._is_sky = row["name"], row["is_sky"]
            cls._lengths = tuple(key["name"] for key in row["keys"] if key["unit"] == "length")
            cls._angles = tuple(key["name"] for key in row["keys"] if key["unit"] == "deg")

    def lines(
        self, shape: Sequence[int] | int, *, bounds: Any = None, occulters: Sequence[Any] = ()
    ) -> Lines:
        """The lines of sight through the centres of the pixels, row by row, row 0 first.

        Each begins at `near`, and is as long as it is in view: outside of the bounds, and behind
        bodies, there is nothing of it. A pixel without an image, as in the corners of a `Fisheye`,
        has a line of the length 0. The values of `line_integrals` are at the centres; pixels of
        `render` are means.

        shape: (height, width) in pixels; nside of a `Healpix`.
        bounds, occulters: as of `render`.

        Raises `SceneError` if an argument is wrong, or if lines come from infinity.

        >>> import emitree
        >>> emitree.Canonical().lines((2, 3)).positions[0].round(3)
        array([0.167, 0.25 , 0.   ])
        """
        from emitree._lines import lines_of_camera

        return lines_of_camera(self, shape, bounds=bounds, occulters=occulters)

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
        max_deviation: float = 0.01,
    ) -> Camera:
        """The camera whose pixels are those of an astropy WCS, seen by an observer at a time.

        It is a `Perspective` (TAN), an `Equirectangular` (CAR) or a `Fisheye` (ARC and ZEA, whose
        corners outside of the disc are NaN). Corners of pixels all over the image are compared with
        the WCS: where no camera agrees to `max_deviation`, as with distortions, or in a wide field
        with a reference pixel beside the middle, it is refused. In a narrow field other projections
        agree. The camera has the
        observer, the frames and `shape` as `camera.sky`, and `render` takes the shape from there.
        Light travel time, aberration and refraction are ignored.

        wcs: an `astropy.wcs.WCS` of right ascension and declination, galactic, ecliptic or
            helioprojective longitude and latitude.
        frame: a frame of astropy or sunpy, whose Cartesian axes are those of the model, such as
            `HeliographicCarrington(obstime=..., observer="self")`. One without a time has that of
            the WCS, or of the observer.
        length_unit: the unit of the model's lengths, such as "R_sun".
        observer: a `SkyCoord` with a distance, as of a spacecraft; by default the one in the header
            (HGLN_OBS, HGLT_OBS, DSUN_OBS).
        origin: a `SkyCoord` with a distance: where the origin of the model is; that of `frame` by
            default.
        shape: (height, width) [pixels]; that of the WCS by default.
        distance: from the observer to the `target`, which should be where the emission is; by
            default that of the origin of the model.
        near, far: as of the camera.
        max_deviation: how far a corner of a pixel may be from that of the WCS [pixels]. Files have
            the coordinates of the camera, which are those of its pixels however large it is.

        Raises `SceneError` with the reason where no camera has these pixels, or where something is
        missing.

        >>> import astropy.units as u, emitree
        >>> from astropy.coordinates import ICRS, SkyCoord
        >>> from astropy.wcs import WCS
        >>> wcs = WCS({"CTYPE1": "RA---TAN", "CTYPE2": "DEC--TAN", "CRVAL1": 83.6, "CRVAL2": 22.0,
        ...     "CRPIX1": 32.5, "CRPIX2": 24.5, "CDELT1": -0.01, "CDELT2": 0.01, "RADESYS": "ICRS"})
        >>> camera = emitree.Camera.from_wcs(
        ...     wcs, frame=ICRS(), length_unit="pc", shape=(48, 64),
        ...     origin=SkyCoord(83.6 * u.deg, 22 * u.deg, distance=2000 * u.pc),
        ...     observer=SkyCoord(0 * u.deg, 0 * u.deg, distance=0 * u.pc), near=1990, far=2010,
        ... )
        >>> type(camera).__name__, camera.sky.shape
        ('Perspective', (48, 64))
        >>> rendering = emitree.render("exp(-r^2)", camera)
        >>> rendering.to_fits()[0].header["CTYPE1"]
        'RA---TAN'
        """
        from emitree._sky_wcs import camera_of

        return camera_of(
            cls,
            wcs,
            frame=frame,
            length_unit=length_unit,
            observer=observer,
            origin=origin,
            shape=shape,
            distance=distance,
            near=near,
            far=far,
            max_deviation=max_deviation,
        )


@dataclass(frozen=True)
class Canonical(Camera):
    """The unit cube itself, viewed along z: x to the right, y up, z away from the observer.

    >>> import emitree
    >>> emitree.Canonical()
    Canonical(length_unit=None)
    """

    length_unit: str | Any | None = None


@dataclass(frozen=True, kw_only=True)
class Orthographic(Camera):
    """Parallel lines of sight.

    position, target, up: (3,), the middle of the image plane, a target point, and the
        direction that is up in the image.
    extent: width and height of the image, lengths.
    near, far: depths along the lines, lengths; they may be infinite, and be left out where there
        are bounds.
    length_unit: the unit of all lengths, such as "R_E"; needed if units are.
    """

    position: Vector
    target: Vector
    extent: Vector
    up: Vector | None = None
    near: float | None = None
    far: float | None = None
    length_unit: str | Any | None = None


@dataclass(frozen=True, kw_only=True)
class Perspective(Camera):
    """A pinhole camera.

    position, target, up: (3,), the observer, a point in the middle of the image, and the direction
        that is up in the image.
    field_of_view: full width and height [deg], below 180.
    near, far: distances from the observer, lengths; `far` may be infinite, and be left out where
        there are bounds.
    length_unit: the unit of all lengths, such as "R_E"; needed if units are.
    principal_point: (2,), where the pointing is, as fractions of the width and the height of the
        image from its lower left corner; the middle, (0.5, 0.5), by default.
    """

    position: Vector
    target: Vector
    field_of_view: Vector
    up: Vector | None = None
    near: float | None = None
    far: float | None = None
    length_unit: str | Any | None = None
    principal_point: Vector | None = None


@dataclass(frozen=True, kw_only=True)
class Equirectangular(Camera):
    """Uniform steps of longitude and latitude about the pointing.

    Keywords as for `Polar`; field_of_view: full width and height [deg], up to [360, 180].
    """

    position: Vector
    target: Vector
    field_of_view: Vector
    up: Vector | None = None
    near: float | None = None
    far: float | None = None
    length_unit: str | Any | None = None


@dataclass(frozen=True, kw_only=True)
class Polar(Camera):
    """Azimuth about the pointing along x, angle from the pointing along y.

    Keywords as for `Perspective`; field_of_view: the full angle of the cone [deg], up to 360.
    """

    position: Vector
    target: Vector
    field_of_view: float
    up: Vector | None = None
    near: float | None = None
    far: float | None = None
    length_unit: str | Any | None = None


@dataclass(frozen=True, kw_only=True)
class Fisheye(Polar):
    """The sky about the pointing as a disc; pixels outside of it are NaN.

    Keywords as for `Polar`; mapping: "equidistant" (ARC, the default) or "equal_area" (ZEA).
    """

    mapping: str | None = None


@dataclass(frozen=True, kw_only=True)
class Healpix(Camera):
    """The whole sky in HEALPix pixels: twelve faces of nside x nside, one above the other.

    position: (3,), the observer; near, far: distances from it.
    The shape of its image is (12 nside, nside), or just nside.
    """

    position: Vector
    near: float | None = None
    far: float | None = None
    length_unit: str | Any | None = None


@dataclass(frozen=True, kw_only=True)
class Sphere(_Table):
    """A sphere, as bounds or an edge of the emission, or as an opaque body.

    center: (3,), lengths; radius: a length.
    """

    center: Vector
    radius: float
    _type = "sphere"
    _lengths = ("center", "radius")


@dataclass(frozen=True, kw_only=True)
class Ellipsoid(_Table):
    """An ellipsoid, as bounds or an edge of the emission, or as an opaque body.

    center, semi_axes: (3,), lengths; pole, meridian: (3,), directions of the third and of the first
        axis, z and x by default.
    """

    center: Vector
    semi_axes: Vector
    pole: Vector | None = None
    meridian: Vector | None = None
    _type = "ellipsoid"
    _lengths = ("center", "semi_axes")


@dataclass(frozen=True, kw_only=True)
class Box(_Table):
    """A box along the axes, as bounds of the emission: two corners (3,), lengths."""

    min: Vector
    max: Vector
    _type = "box"
    _lengths = ("min", "max")


@dataclass(frozen=True, kw_only=True)
class Plane(_Table):
    """A plane, as an edge of the emission: a surface on which it jumps or has a kink.

    In views without opaque bodies up to three planes divide lines of sight, where the emission
    jumps or has a kink: both sides of a plane are then smooth.

    position: (3,), a point of the plane, lengths; normal: (3,), a vector of any length that is
        perpendicular to the plane.

    >>> import emitree
    >>> emitree.Plane(position=(0, 0, 0.5), normal=(0, 0, 1))
    Plane(position=(0, 0, 0.5), normal=(0, 0, 1))
    """

    position: Vector
    normal: Vector
    _type = "plane"
    _lengths = ("position",)


@dataclass(frozen=True, kw_only=True)
class SingularPoint(_Table):
    """A point near which the emission grows as a power of the distance, or has a tiny peak.

    position: (3,), lengths; exponent: the rate grows as the distance to the power of -exponent,
        from 0 to below 3, 2 by default.

    >>> import emitree
    >>> emitree.SingularPoint(position=(0, 0, 0.5), exponent=1.5)
    SingularPoint(position=(0, 0, 0.5), exponent=1.5)
    """

    position: Vector
    exponent: float | None = None
    _type = "point"
    _lengths = ("position",)


@dataclass(frozen=True, kw_only=True)
class SingularAxis(_Table):
    """A straight line near which the emission grows as a power of the distance from it.

    position: (3,), a point of the line, lengths; direction: (3,), a vector of any length along it;
        exponent: the rate grows as the distance to the power of -exponent, from 0 to below 2, 1 by
        default.

    >>> import emitree
    >>> emitree.SingularAxis(position=(0, 0, 0), direction=(0, 0, 1)).exponent is None
    True
    """

    position: Vector
    direction: Vector
    exponent: float | None = None
    _type = "axis"
    _lengths = ("position",)
