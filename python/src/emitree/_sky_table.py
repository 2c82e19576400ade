"""From a sky to the table `[sky]` of a scene: frames and coordinates as names and numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _native, _units
from emitree._native import SceneError
from emitree._sky import sunpy_coordinates, xyz_in

if TYPE_CHECKING:
    from emitree._sky import Sky

#: The radius of the Sun that scenes have by default [m].
_SUN_RADIUS_M = 6.957e8


def table_of(sky: Sky) -> dict[str, Any]:
    """The table of a sky."""
    coordinates = sky.coordinates
    name, frame = type(coordinates).__name__, type(sky.frame).__name__
    known = _native.sky_coordinates()
    if name not in known:
        raise SceneError(f"`coordinates` are {name}: expected {', '.join(known)}, which FITS has")
    table: dict[str, Any] = {"frame": frame, "coordinates": name}
    axes = sky.rotation().T
    if name != frame or np.abs(axes - np.eye(3)).max() > 1e-14:
        table["axes"] = axes.tolist()
    if known[name]:
        table["equinox"] = float(coordinates.equinox.jyear)
    if sky.time is not None:
        table["date"] = str(sky.time.utc.isot)
    if name == "Helioprojective":
        table |= _observer(coordinates, sky.length_unit)
    return table


def _observer(frame: Any, length_unit: str) -> dict[str, Any]:
    """The observer of helioprojective coordinates, and a radius of the Sun that is another one."""
    import astropy.units as u

    if frame.obstime is None or frame.observer is None:
        raise SceneError(
            "the frame has no `obstime` or no observer: expected both for helioprojective "
            "coordinates"
        )
    of_sun = sunpy_coordinates().HeliographicStonyhurst(obstime=frame.obstime, rsun=frame.rsun)
    unit = _units.to_astropy(length_unit)
    x, y, z = xyz_in(of_sun, frame.observer, "`observer`").to_value(unit)
    found: dict[str, Any] = {
        "observer": {
            "longitude": float(np.degrees(np.arctan2(y, x))),
            "latitude": float(np.degrees(np.arctan2(z, np.hypot(x, y)))),
            "distance": float(np.sqrt(x * x + y * y + z * z)),
        }
    }
    if frame.rsun.to_value(u.m) != _SUN_RADIUS_M:
        found["sun_radius"] = float(frame.rsun.to_value(unit))
    return found
