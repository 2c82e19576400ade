"""The axes of grids: names of coordinates, xarray's arrays, and nodes as a scene has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _units
from emitree._native import SceneError
from emitree._real import real

#: The axes of each kind of coordinates, in the order of arrays without names.
COORDINATES = {
    "cartesian": ("x", "y", "z"),
    "cylindrical": ("rho", "phi", "z"),
    "spherical": ("r", "theta", "phi"),
}

#: The names of dimensions beside those of the axes, in lower case.
_OTHER_NAMES = {
    "radius": "r",
    "colatitude": "theta",
    "colat": "theta",
    "latitude": "theta",
    "lat": "theta",
    "azimuth": "phi",
    "longitude": "phi",
    "lon": "phi",
}
_LATITUDES = ("latitude", "lat")
ANGLES = ("theta", "phi")

_UNITS_OF_ANGLES = {"deg": ("deg", "degree", "degrees", "°"), "rad": ("rad", "radian", "radians")}


@dataclass(frozen=True)
class Nodes:
    """The nodes along an axis, as they are given.

    unit: of angles, where it is known; is_latitude: whether they are no colatitudes.
    """

    values: Any
    unit: str | None = None
    is_latitude: bool = False


def angle_unit_of(text: Any) -> str | None:
    """The unit of angles in an attribute, as scenes have it.

    >>> angle_unit_of("degrees_north"), angle_unit_of("radian"), angle_unit_of("km")
    ('deg', 'rad', None)
    """
    first = str(text).strip().lower().split("_")[0]
    return next((unit for unit, names in _UNITS_OF_ANGLES.items() if first in names), None)


def is_data_array(values: Any) -> bool:
    """Whether these are xarray's: an array with names of dimensions."""
    return hasattr(values, "dims") and hasattr(values, "coords")


def _axis_of(dim: Any) -> str:
    name = str(dim).lower()
    return _OTHER_NAMES.get(name, name)


def coordinates_of(values: Any, given: Mapping[str, Any]) -> str:
    """The coordinates that dimensions of an array, or else the given axes, have the names of."""
    found = {_axis_of(dim) for dim in values.dims} if is_data_array(values) else set(given)
    kinds = [kind for kind, axes in COORDINATES.items() if found and found <= set(axes)]
    return kinds[0] if kinds else "cartesian"


def of_data_array(
    values: Any, coordinates: str, given: Mapping[str, Any], length_unit: str | None
) -> tuple[Any, dict[str, Nodes]]:
    """The values of a DataArray in the order of the axes, and coordinates of axes not given."""
    axes = COORDINATES[coordinates]
    found = [_axis_of(dim) for dim in values.dims]
    for axis in axes:
        twice = [str(dim) for dim, of in zip(values.dims, found, strict=True) if of == axis]
        if len(twice) > 1:
            raise SceneError(
                f"`values` is a DataArray with two dimensions for {axis}, {' and '.join(twice)}: "
                "expected one"
            )
    if sorted(found) != sorted(axes):
        raise SceneError(
            f"`values` is a DataArray with the dimensions {tuple(values.dims)}: expected x, y and "
            "z, or rho, phi and z, or r, theta and phi in any order (`rename` them; `isel` or "
            "`sel` chooses a step of another dimension), or an array without names"
        )
    dims = dict(zip(found, values.dims, strict=True))
    ordered = values.transpose(*(dims[axis] for axis in axes))
    nodes = {
        axis: _coordinate(ordered, dims[axis], axis, length_unit)
        for axis in axes
        if axis not in given
    }
    if length_unit is None:
        _check_lengths(ordered, {axis: dims[axis] for axis in nodes if axis not in ANGLES})
    plain = ordered.data if _units.is_quantity(ordered.data) else ordered.to_numpy()
    return plain, nodes


def _coordinate(array: Any, dim: Any, axis: str, length_unit: str | None) -> Nodes:
    if dim not in array.coords:
        raise SceneError(
            f"`values` has no coordinate for its dimension {dim}: expected one "
            f"(`assign_coords`), or the keyword `{axis}`"
        )
    coordinate = array.coords[dim]
    places = real(coordinate.to_numpy(), f"the coordinate `{dim}` of `values`", "numbers")
    unit = coordinate.attrs.get("units")
    if axis in ANGLES:
        known = angle_unit_of(unit)
        if known is None and unit not in (None, "", "1"):
            raise SceneError(
                f"the coordinate `{dim}` of `values` is in {unit!r}: expected degrees or radians"
            )
        return Nodes(places, known, str(dim).lower() in _LATITUDES)
    if length_unit is None or unit in (None, "", "1", length_unit):
        return Nodes(places)
    try:
        own = _units.to_astropy(_in_short(str(unit)))
        in_unit = (places * own).to_value(_units.to_astropy(length_unit))
    except ValueError:
        raise SceneError(
            f"the coordinate `{dim}` of `values` is in {unit!r}: expected {length_unit!r}, or a "
            "length that converts to it"
        ) from None
    return Nodes(np.asarray(in_unit))


def _in_short(unit: str) -> str:
    """A unit as astropy has it, from one as in attributes of files.

    >>> _in_short("kilometres"), _in_short("Meters"), _in_short("R_sun")
    ('kilometer', 'meter', 'R_sun')
    """
    name = unit.strip().lower().replace("metre", "meter")
    return name.removesuffix("s") if name.endswith(("meter", "meters")) else unit


def _check_lengths(array: Any, dims: Mapping[str, Any]) -> None:
    """Refuses coordinates with different units of lengths, which no camera's unit makes one."""
    units = {dim: array.coords[dim].attrs.get("units") for dim in dims.values()}
    units = {dim: unit for dim, unit in units.items() if unit not in (None, "", "1")}
    if len({_in_short(str(unit)) for unit in units.values()}) > 1:
        shown = ", ".join(f"`{dim}` in {unit!r}" for dim, unit in units.items())
        raise SceneError(
            f"the coordinates of `values` are {shown}: expected one unit, or a camera with a "
            "`length_unit`, which they are converted to"
        )


def given_nodes(axis: str, values: Any, length_unit: str | None, is_latitude: bool) -> Nodes:
    """The nodes of a keyword: quantities in a unit of scenes."""
    if isinstance(values, str):
        return Nodes(values, None, is_latitude)
    if axis not in ANGLES:
        return Nodes(_units.value_in(values, length_unit, axis))
    if not _has_unit(values):
        return Nodes(values, None, is_latitude)
    return Nodes(_units.value_in(values, "deg", axis), "deg", is_latitude)


def _has_unit(values: Any) -> bool:
    if isinstance(values, list | tuple):
        return any(_units.is_quantity(value) for value in values)
    return _units.is_quantity(values)


def in_one_unit(nodes: Mapping[str, Nodes], unit: str | None) -> tuple[dict[str, Any], str | None]:
    """The nodes with all angles in one unit, and the unit, where it is known."""
    angles = {axis: of for axis, of in nodes.items() if axis in ANGLES}
    known = {of.unit for of in angles.values()} - {None}
    if unit is None and known:
        unit = "deg" if "deg" in known else "rad"
        without = [axis for axis, of in angles.items() if of.unit is None]
        if without:
            raise SceneError(
                f"`{without[0]}` has no unit, but others have: expected `angle_unit`, its unit, "
                "'deg' or 'rad'"
            )
    converted = {axis: _converted(of, unit) for axis, of in nodes.items()}
    return converted, unit


def _converted(nodes: Nodes, unit: str | None) -> Any:
    if nodes.unit is None or unit is None or nodes.unit == unit:
        return nodes.values
    return np.degrees(nodes.values) if unit == "deg" else np.radians(nodes.values)


def as_in_scenes(nodes: Any, count: int | None, name: str) -> Any:
    """The nodes of an axis as a scene has them: a name, a range or a list."""
    if isinstance(nodes, str):
        if count is not None:
            raise SceneError(f"`{name}` is {nodes!r}: expected nodes, names are for files")
        return nodes
    found = real(nodes, f"`{name}`", "the coordinates of the nodes")
    if found.ndim > 1:
        raise SceneError(
            f"`{name}` has the shape {found.shape}: expected one axis, the coordinates of the "
            "nodes along it"
        )
    if found.shape == (2,) and count != 2:
        first, last = found.tolist()
        if first < last:
            return {"min": first, "max": last}
    return np.atleast_1d(found).tolist()
