"""A camera that counts photons: the table `[instrument]` of a scene."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from emitree import _units
from emitree._native import SceneError

#: The units of the keys that are numbers; of rates, photons and counts are the same.
_UNITS = {
    "effective_area": ("cm2",),
    "exposure": ("s",),
    "psf.fwhm_arcsec": ("arcsec",),
    "psf.fwhm_pixels": ("", "pix"),
    "background.per_pixel": ("s-1", "ct s-1", "ph s-1", "ct s-1 pix-1"),
    "background.per_kev_sr": ("s-1 keV-1 sr-1", "ct s-1 keV-1 sr-1", "ph s-1 keV-1 sr-1"),
}


@dataclass(frozen=True, kw_only=True)
class Instrument:
    """A camera that counts the photons of a cube: `render(..., instrument=...)`.

    exposure: the exposure time [s].
    effective_area: one for all energies [cm2]; or the name of a file, an OGIP ARF (.arf, .fits) or
        a text table; left out only if `redistribution` includes it.
    redistribution: the name of an OGIP RMF or RSP; without it each energy bin is a channel.
    psf: a full width at half maximum as a quantity, or one of {"fwhm_arcsec": 15.0},
        {"fwhm_pixels": 2.0}, {"fwhm_pixels": (x, y)} and {"kernel": "psf.fits"}.
    background: {"per_pixel": ...}, counts s-1 in each channel of each pixel, or
        {"per_kev_sr": ...}, counts s-1 keV-1 sr-1.
    seed: of the counts that are drawn.

    Numbers may be astropy quantities.

    >>> import emitree
    >>> emitree.Instrument(effective_area=50.0, exposure=1e4, psf={"fwhm_pixels": 2.0}).table()
    {'effective_area': 50.0, 'exposure': 10000.0, 'psf': {'fwhm_pixels': 2.0}}
    """

    exposure: Any
    effective_area: Any = None
    redistribution: str | os.PathLike[str] | None = None
    psf: Any = None
    background: Mapping[str, Any] | None = None
    seed: int | None = None

    def table(self) -> dict[str, Any]:
        """The keys of a scene; names of files are those of the current folder."""
        names = sorted(field.name for field in fields(self))
        given = {name: getattr(self, name) for name in names}
        table = instrument_table({key: value for key, value in given.items() if value is not None})
        assert table is not None
        return table


def instrument_table(instrument: Any) -> dict[str, Any] | None:
    """The table `[instrument]` of an instrument or of a dictionary."""
    if instrument is None:
        return None
    if isinstance(instrument, Instrument):
        return instrument.table()
    if not isinstance(instrument, Mapping):
        raise SceneError(
            f"`instrument` is {instrument!r}: expected emitree.Instrument, or a dictionary with "
            "`effective_area` and `exposure`"
        )
    table = dict(instrument)
    if _units.is_quantity(table.get("psf")):
        table["psf"] = {"fwhm_arcsec": table["psf"]}
    return {key: _entry(key, value) for key, value in table.items()}


def _entry(key: str, value: Any) -> Any:
    """One value of the table, in the unit of its key."""
    if isinstance(value, Mapping):
        return {inner: _entry(f"{key}.{inner}", of_inner) for inner, of_inner in value.items()}
    if isinstance(value, str | os.PathLike):
        return os.path.abspath(value)
    units = _UNITS.get(key)
    if units is None or _units.first_unit([value]) is None:
        if _units.first_unit([value]) is not None:
            raise SceneError(f"`instrument.{key}` is {value}: expected a value without a unit")
        return _units.plain(value)
    for unit in units:
        try:
            return _units.plain(_units.value_in(value, unit, f"instrument.{key}"))
        except SceneError as error:
            wrong = error
    if len(units) == 1:
        raise wrong
    named = units[0] or "pixels"
    raise SceneError(
        f"`instrument.{key}` is {value}: expected a number in {named}, or a quantity that converts "
        "to it"
    )
