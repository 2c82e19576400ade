"""The energy bins of a cube: the table `[energy]` of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _units
from emitree._function import Floats
from emitree._native import SceneError

#: The unit of energies without one.
_DEFAULT_UNIT = "keV"
#: How far a border may be from uniform steps or equal ratios, in widths of a bin: 32-bit rounding.
_UNEVEN = 1e-4


@dataclass(frozen=True)
class Energies:
    """Energy bins of equal widths, or of equal ratios: what makes an image a cube.

    min, max: the ends, energies; bins: how many there are between them.
    unit: of the energies, a text or an astropy unit; that of `min` if it is a quantity, else keV.
    scale: "linear" (the default) or "log".
    lines: energies of narrow spectral lines that are known beforehand, sampled by method "vol".

    >>> import emitree
    >>> emitree.Energies(0.5, 8.0, 4, scale="log").edges
    array([0.5, 1. , 2. , 4. , 8. ])
    >>> def line(position, direction, energy):
    ...     return energy
    >>> emitree.render(line, emitree.Canonical(), (1, 1), energy=emitree.Energies(1, 3, 2)).unit
    ''
    """

    min: Any
    max: Any
    bins: int
    unit: Any = None
    scale: str | None = None
    lines: Sequence[Any] | None = None

    @classmethod
    def from_edges(cls, edges: Any, unit: Any = None, lines: Any = None) -> Energies:
        """Bins from their borders (bins + 1,), ascending, in uniform steps or equal ratios.

        edges: numbers in `unit`, or a quantity.

        >>> import emitree
        >>> emitree.Energies.from_edges([1.0, 10.0, 100.0])
        Energies(min=1.0, max=100.0, bins=2, unit='keV', scale='log', lines=None)
        """
        unit = _units.to_text(unit or _units.first_unit([edges]) or _DEFAULT_UNIT)
        try:
            borders = np.asarray(_units.value_in(edges, unit, "energy"), dtype=np.float64)
        except (TypeError, ValueError) as error:
            if isinstance(error, SceneError):
                raise
            raise SceneError(
                f"`energy` is {edges!r}: expected emitree.Energies, a dictionary with `min`, `max` "
                "and `bins`, or an array of the borders of the bins"
            ) from None
        if borders.ndim != 1 or len(borders) < 2:
            raise SceneError(
                f"`energy` has the shape {borders.shape}: expected borders (bins + 1,), 2 or more"
            )
        widths = np.diff(borders)
        if not (np.isfinite(borders).all() and (widths > 0).all()):
            raise SceneError("`energy`: expected borders that are finite and ascend")
        ends = float(borders[0]), float(borders[-1])
        for scale in ("linear", "log"):
            if scale == "log" and ends[0] <= 0:
                continue
            even = cls(*ends, len(widths), unit, scale, lines)
            if (np.abs(borders - even.edges) <= _UNEVEN * widths.min()).all():
                return even
        ratios = borders[1:] / np.where(borders[:-1] == 0, np.nan, borders[:-1])
        raise SceneError(
            f"`energy` has borders in steps of {widths.min():.6g} to {widths.max():.6g} and ratios "
            f"of {np.nanmin(ratios):.6g} to {np.nanmax(ratios):.6g}: expected uniform steps or "
            "equal ratios"
        )

    @property
    def edges(self) -> Floats:
        """The borders of the bins (bins + 1,), in `unit`."""
        table = self.table()
        low, high = float(table["min"]), float(table["max"])
        if table.get("scale") == "log":
            return np.geomspace(low, high, self.bins + 1)
        return np.linspace(low, high, self.bins + 1)

    def table(self) -> dict[str, Any]:
        """The keys of a scene."""
        names = ("min", "max", "bins", "unit", "scale", "lines")
        return _in_one_unit({name: getattr(self, name) for name in names})


def energy_table(energy: Any) -> dict[str, Any] | None:
    """The table `[energy]` of bins, of a dictionary, or of an array of borders."""
    if energy is None:
        return None
    if isinstance(energy, Energies):
        return energy.table()
    if isinstance(energy, Mapping):
        return _in_one_unit(dict(energy))
    return Energies.from_edges(energy).table()


def _in_one_unit(table: dict[str, Any]) -> dict[str, Any]:
    ends = [table.get(name) for name in ("min", "max")]
    unit = table.get("unit") or _units.first_unit(ends) or _DEFAULT_UNIT
    table["unit"] = _units.to_text(unit)
    for name in ("min", "max", "lines"):
        if table.get(name) is not None:
            value = _units.value_in(table[name], table["unit"], f"energy.{name}")
            table[name] = _units.plain(value)
    return {name: value for name, value in table.items() if value is not None}
