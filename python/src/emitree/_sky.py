"""The sky of a camera: frames of astropy and sunpy for the model's axes and for the image.

The renderer knows no frames. A frame of the model gives its Cartesian axes a place: the observer is
converted to them, and directions are related by one rotation. Positions are geometric: light travel
time, aberration, the deflection of light and refraction are ignored.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _units
from emitree._function import Floats
from emitree._native import SceneError

if TYPE_CHECKING:
    from collections.abc import Mapping

#: Frames of sunpy that belong to the Sun: images of models in these are helioprojective.
_OF_THE_SUN = (
    "HeliographicStonyhurst",
    "HeliographicCarrington",
    "Heliocentric",
    "HeliocentricInertial",
    "HeliocentricEarthEcliptic",
)

#: By how much a transformation between frames may change lengths. Aberration, v/c = 1e-4, cancels
#: between opposite directions and leaves (v/c)^2 / 2 = 5e-9; refraction is larger.
_NOT_ROTATED = 1e-7


@dataclass(frozen=True)
class Sky:
    """Where on the sky the images of a camera are, and in which frame the model is.

    `Camera.from_wcs` makes it; it is `camera.sky`.

    frame: the frame of astropy or sunpy whose Cartesian axes are the axes of the model. That of
        Carrington has an observer, since the travel time of light turns its axes.
    coordinates: the frame of the longitudes and latitudes of images, such as
        `sunpy.coordinates.Helioprojective`, `ICRS` or `Galactic`.
    length_unit: the unit of the model's lengths.
    origin: a coordinate with a distance: where the origin of the model is; that of `frame` by
        default.
    time: when it was seen, an astropy `Time`, if it is known.
    shape: (height, width) of the WCS [pixels], if there was one.
    deviation: the largest distance between a place in the image and that of the WCS [pixels].
    """

    frame: Any
    coordinates: Any
    length_unit: str
    origin: Any = None
    time: Any = None
    shape: tuple[int, int] | None = None
    deviation: float | None = None

    def positions(self, coordinate: Any) -> Floats:
        """Coordinates with distances as positions in the model, (..., 3), in its length unit.

        Raises `SceneError` if there is no distance, or no transformation to the model's frame.

        >>> import emitree
        >>> import astropy.units as u
        >>> from astropy.coordinates import ICRS, Galactic, SkyCoord
        >>> sky = emitree.Sky(frame=Galactic(), coordinates=ICRS(), length_unit="kpc")
        >>> centre = SkyCoord(l=0 * u.deg, b=0 * u.deg, distance=8 * u.kpc, frame="galactic")
        >>> sky.positions(centre).round(9)
        array([8., 0., 0.])
        """
        places = xyz_in(self.frame, coordinate, "the coordinate")
        if self.origin is not None:
            places = places - xyz_in(self.frame, self.origin, "`origin`").reshape(
                (3,) + (1,) * (places.ndim - 1)
            )
        unit = _units.to_astropy(self.length_unit)
        return np.moveaxis(np.asarray(places.to_value(unit)), 0, -1)

    def coordinate(self, position: Any) -> Any:
        """Positions (..., 3) in the model as a `SkyCoord` in its frame: the inverse of `positions`.

        >>> import emitree
        >>> from astropy.coordinates import ICRS, Galactic
        >>> sky = emitree.Sky(frame=Galactic(), coordinates=ICRS(), length_unit="kpc")
        >>> round(float(sky.coordinate([0.0, 8.0, 0.0]).l.deg), 9)
        90.0
        """
        from astropy.coordinates import CartesianRepresentation, SkyCoord

        unit = _units.to_astropy(self.length_unit)
        places = np.moveaxis(np.asarray(position, dtype=np.float64), -1, 0) * unit
        if self.origin is not None:
            origin = xyz_in(self.frame, self.origin, "`origin`")
            places = places + origin.reshape((3,) + (1,) * (places.ndim - 1))
        return SkyCoord(self.frame.realize_frame(CartesianRepresentation(places)))

    def rotation(self) -> Floats:
        """The matrix (3, 3) by which a direction in the model becomes one in `coordinates`.

        Its determinant is -1 where the latter are left-handed, as helioprojective ones are.

        Raises `SceneError` if no rotation relates the two.
        """
        return rotation(self.frame, self.coordinates)

    @cached_property
    def table(self) -> dict[str, Any]:
        """The table `[sky]` of a scene file: names, and numbers in the model's length unit.

        Scenes of a camera that has this sky have it, and so has `Rendering.scene`.

        Raises `SceneError` if FITS has no such coordinates, or if something is missing.

        >>> import emitree
        >>> from astropy.coordinates import Galactic
        >>> sky = emitree.Sky(frame=Galactic(), coordinates=Galactic(), length_unit="kpc")
        >>> sky.table
        {'frame': 'Galactic', 'coordinates': 'Galactic'}
        """
        from emitree._sky_table import table_of

        return table_of(self)


def sky_of(
    frame: Any,
    *,
    length_unit: str | None,
    observer: Any = None,
    position: Any = None,
    origin: Any = None,
    coordinates: Any = None,
) -> Sky:
    """The sky of a camera at `position` in the model, which is to be where `observer` is.

    frame, origin, coordinates: as in `Sky`; by default those of `observer`, none, and
        helioprojective, galactic, ecliptic or ICRS coordinates, after the frame.
    """
    if frame is None and observer is None:
        raise SceneError("expected `frame`, whose axes are those of the model, or `observer`")
    if length_unit is None:
        raise SceneError("the camera has no `length_unit`: expected one, such as 'R_sun'")
    frame = bare(observer if frame is None else frame, "`frame`")
    time = time_of(frame, observer, coordinates)
    frame = completed(frame, time, observer)
    require_right_handed(frame)
    place = Sky(frame, None, length_unit, origin)
    if observer is not None and position is not None:
        require_same_place(place, observer, position)
    if observer is None and position is not None:
        observer = place.coordinate(position)
    if coordinates is None:
        coordinates = coordinates_for(frame, observer)
    else:
        coordinates = completed(bare(coordinates, "`coordinates`"), time, observer)
    return Sky(frame, coordinates, length_unit, origin, time)


def require_right_handed(frame: Any) -> None:
    """Refuses axes of a model that would mirror its images."""
    from astropy.coordinates import ICRS

    if np.linalg.det(rotation(frame, ICRS())) < 0:
        raise SceneError(
            f"`frame` is {type(frame).__name__}, whose axes are left-handed: expected right-handed "
            "axes of the model, such as those of ICRS, ITRS or HeliographicCarrington"
        )


def require_same_place(sky: Sky, observer: Any, position: Any) -> None:
    """Refuses an observer who is not at the position of the camera."""
    at = sky.positions(observer)
    apart = float(np.linalg.norm(at - position))
    if apart > 1e-6 * float(np.linalg.norm(position)) + 1e-12:
        raise SceneError(
            f"the observer is at {at.tolist()} {sky.length_unit} in the model, and the camera at "
            f"{list(map(float, position))}: expected one place"
        )


def coordinates_for(frame: Any, observer: Any) -> Any:
    """The coordinates of images of a model in `frame`."""
    from astropy.coordinates import FK5, ICRS, BarycentricMeanEcliptic, Galactic

    name = type(frame).__name__
    if name in _OF_THE_SUN:
        return sunpy_coordinates().Helioprojective(
            observer=seen_from(observer, frame.obstime), obstime=frame.obstime
        )
    if name in ("Galactic", "Galactocentric"):
        return Galactic()
    if name.endswith("MeanEcliptic"):
        return BarycentricMeanEcliptic(equinox=frame.equinox)
    return frame if isinstance(frame, FK5) else ICRS()


def sunpy_coordinates() -> Any:
    """The module of sunpy's frames."""
    try:
        from sunpy import coordinates
    except ImportError as error:
        raise ImportError(
            "sunpy is missing: expected it for coordinates of the Sun; "
            '`pip install "emitree[sky]"` installs it'
        ) from error
    return coordinates


def bare(frame: Any, name: str) -> Any:
    """A frame without data."""
    from astropy.coordinates import BaseCoordinateFrame, SkyCoord

    if isinstance(frame, SkyCoord):
        frame = frame.frame
    if not isinstance(frame, BaseCoordinateFrame):
        raise SceneError(
            f"{name} is {frame!r}: expected a frame of astropy or sunpy, such as "
            "`astropy.coordinates.ICRS()`"
        )
    return frame.replicate_without_data()


def time_of(*places: Any) -> Any:
    """The time of the first of some frames or coordinates that has one; None if none has."""
    times = (getattr(place, "obstime", None) for place in places)
    return next((time for time in times if time is not None), None)


def completed(frame: Any, time: Any, observer: Any) -> Any:
    """The frame with a time and an observer, where it needs them and has none of its own.

    Carrington's longitudes depend on an observer by the travel time of light; for "self" each point
    would be its own, and axes would turn with distance.
    """
    changes: dict[str, Any] = {}
    if time is not None and "obstime" in frame.frame_attributes and frame.obstime is None:
        changes["obstime"] = time
    if "observer" in frame.frame_attributes and _is_open(frame.observer):
        if observer is None:
            if isinstance(frame.observer, str):
                raise SceneError(
                    f"{type(frame).__name__} has the observer 'self': expected `observer`, the "
                    "one place that its axes depend on"
                )
        else:
            changes["observer"] = seen_from(observer, changes.get("obstime", frame.obstime))
    if not changes:
        return frame
    attributes: Mapping[str, Any] = {
        name: getattr(frame, name)
        for name in frame.frame_attributes
        if not frame.is_frame_attr_default(name)
    }
    return type(frame)(**{**attributes, **changes})


def seen_from(observer: Any, time: Any) -> Any:
    """An observer at a time, as frames of sunpy take it."""
    if time is None:
        raise SceneError("the frames have no `obstime`: expected one, of `frame` or `observer`")
    of_sun = sunpy_coordinates().HeliographicStonyhurst(obstime=time)
    return of_sun.realize_frame(_cartesian(xyz_in(of_sun, observer, "`observer`")))


def _cartesian(xyz: Any) -> Any:
    from astropy.coordinates import CartesianRepresentation, SphericalRepresentation

    return CartesianRepresentation(xyz).represent_as(SphericalRepresentation)


def _is_open(observer: Any) -> bool:
    return observer is None or (isinstance(observer, str) and observer == "self")


def xyz_in(frame: Any, coordinate: Any, name: str) -> Any:
    """Cartesian coordinates (3, ...) in a frame, with their unit."""
    from astropy.coordinates import BaseCoordinateFrame, SkyCoord

    if isinstance(coordinate, SkyCoord):
        coordinate = coordinate.frame
    if not (isinstance(coordinate, BaseCoordinateFrame) and coordinate.has_data):
        raise SceneError(
            f"{name} is {coordinate!r}: expected an astropy `SkyCoord` with a distance"
        )
    places = coordinate.data.without_differentials()
    if places.norm().unit.physical_type != "length":
        raise SceneError(f"{name} is {coordinate!r}: expected a distance too")
    return transformed(coordinate.realize_frame(places), frame, name).cartesian.xyz


def transformed(coordinate: Any, frame: Any, name: str) -> Any:
    """A coordinate in a frame."""
    from astropy.coordinates import ConvertError

    try:
        return coordinate.transform_to(frame)
    except (ConvertError, ValueError, TypeError) as error:
        raise SceneError(
            f"{name} can't be converted from {type(coordinate).__name__} to "
            f"{type(frame).__name__}: {error}"
        ) from None


def rotation(frame: Any, coordinates: Any) -> Floats:
    """The matrix by which a direction in `frame` becomes one in `coordinates`."""
    import astropy.units as u
    from astropy.coordinates import CartesianRepresentation

    def ends(length: Any) -> Any:
        both = np.concatenate([np.eye(3), -np.eye(3)]).T * length
        points = frame.realize_frame(CartesianRepresentation(both))
        found = transformed(points, coordinates, "a position").cartesian.xyz
        return found[:, :3], found[:, 3:]

    # The origins differ too: points as far apart as these keep their digits.
    length = 1 * u.au
    above, below = ends(length)
    apart = np.linalg.norm((above + below).to_value(length.unit), axis=0).max() * length.unit
    if apart > length:
        length = apart
        above, below = ends(length)
    matrix = np.asarray(((above - below) / (2 * length)).to_value(u.one))
    left, scales, right = np.linalg.svd(matrix)
    if not np.abs(scales - 1).max() <= _NOT_ROTATED:
        raise SceneError(
            f"directions in {type(frame).__name__} become those in {type(coordinates).__name__} by "
            f"more than a rotation (scales {scales.tolist()}): expected frames without refraction, "
            "such as ICRS, Galactic, BarycentricMeanEcliptic or those of sunpy"
        )
    nearest: Floats = left @ right
    return nearest
