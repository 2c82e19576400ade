"""Units at the edge: astropy quantities in, plain numbers inside. Only they need astropy."""

from __future__ import annotations

from typing import Any

import numpy as np

from emitree._native import SceneError

#: Lengths that FITS and astropy lack, or that astropy has with another value, in km: those of
#: emitree's own table.
_RADII_KM = {
    "R_E": 6371.0,
    "R_earth": 6371.0,
    "R_Earth": 6371.0,
    "R_E_eq": 6378.1,
    "R_mercury": 2439.4,
    "R_venus": 6051.8,
    "R_moon": 1737.4,
    "R_mars": 3389.5,
    "R_jup": 71492.0,
    "R_jupiter": 71492.0,
    "R_saturn": 60268.0,
    "R_sun": 695700.0,
    "R_Sun": 695700.0,
}


def is_quantity(value: Any) -> bool:
    """Whether a value has a unit, as astropy's quantities do."""
    return hasattr(value, "unit") and hasattr(value, "to_value")


def plain(value: Any) -> Any:
    """Arrays and NumPy's numbers as lists and Python's numbers."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    return value


def to_astropy(text: str) -> Any:
    """The astropy unit of a unit in emitree's grammar."""
    import astropy.units as u

    if text in _RADII_KM:
        return u.def_unit(text, _RADII_KM[text] * u.km)
    own = [u.def_unit(name, radius * u.km) for name, radius in _RADII_KM.items() if name in text]
    with u.add_enabled_units(own):
        return u.Unit(text)


def to_text(unit: Any) -> str | None:
    """A unit in emitree's grammar, which is that of FITS, from a text or an astropy unit."""
    if unit is None or isinstance(unit, str):
        return unit
    if str(unit) in _RADII_KM and unit == to_astropy(str(unit)):
        return str(unit)
    try:
        return unit.to_string("fits")
    except ValueError:
        # A radius that FITS has no name for, such as astropy's `R_earth`, the equatorial one.
        for name in _RADII_KM:
            if unit == to_astropy(name):
                return name
        raise SceneError(
            f"unit {unit}: expected one that FITS has, or a text such as 'R_E'"
        ) from None


def value_in(value: Any, unit: str | None, name: str) -> Any:
    """Numbers from a quantity, in `unit`; what is no quantity is in that unit already.

    name: the key, for messages.
    """
    if isinstance(value, list | tuple) and any(is_quantity(item) for item in value):
        return [value_in(item, unit, name) for item in value]
    if not is_quantity(value):
        return value
    if unit is None:
        raise SceneError(f"`{name}` is {value}: expected a `length_unit` too")
    from astropy.units import UnitConversionError

    try:
        return value.to_value(to_astropy(unit))
    except UnitConversionError:
        raise SceneError(
            f"`{name}` is {value}: expected a number in {unit}, or a quantity that converts to it"
        ) from None


def length_text(value: Any, name: str) -> Any:
    """A quantity as a text that a scene takes, as in "0.1 R_E"; all else as it is."""
    if not is_quantity(value):
        return value
    if not value.isscalar:
        raise SceneError(f"`{name}` is {value}: expected one length")
    return f"{float(value.value)!r} {to_text(value.unit)}"


def first_unit(values: list[Any]) -> Any | None:
    """The unit of the first of some values that has one."""
    for value in values:
        if isinstance(value, list | tuple):
            found = first_unit(list(value))
            if found is not None:
                return found
        elif is_quantity(value):
            return value.unit
    return None
