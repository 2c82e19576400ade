"""Spectra: what a cube has at each energy, or an instrument in each channel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats

if TYPE_CHECKING:
    from emitree._result import Rendering


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A value for each bin or channel.

    values: (n,), in `unit`; error: their Poisson errors or bounds (n,), or None.
    low, high: (n,), the energies between which each of them is, in `energy_unit`.
    name: what the values are.

    >>> import emitree
    >>> cube = emitree.render("E", emitree.Canonical(), (2, 2), energy=emitree.Energies(1, 3, 2))
    >>> cube.spectrum().middle, cube.spectrum().values.round(3)
    (array([1.5, 2.5]), array([1.5, 2.5]))
    """

    low: Floats
    high: Floats
    values: Floats
    unit: str
    energy_unit: str
    name: str
    error: Floats | None = None

    @property
    def middle(self) -> Floats:
        """The energies (n,) in the middle of the bins or channels."""
        return 0.5 * (self.low + self.high)

    @property
    def width(self) -> Floats:
        """How much energy (n,) each of them spans."""
        return self.high - self.low

    def plot(self, ax: Any = None, *, per_energy: bool = False, **options: Any) -> Any:
        """Plots steps with matplotlib, and returns the axes.

        per_energy: whether values are divided by the widths of their bins; options go to `stairs`.
        """
        import matplotlib.pyplot as plt

        if ax is None:
            _, ax = plt.subplots()
        order = np.argsort(self.low, kind="stable")
        low, high = self.low[order], self.high[order]
        values = (self.values / self.width if per_energy else self.values)[order]
        ax.stairs(values, np.append(low, high[-1]), baseline=None, **options)
        unit = self.unit
        if per_energy:
            unit = f"{unit or '1'} / {self.energy_unit}"
        ax.set_xlabel(f"energy [{self.energy_unit}]")
        ax.set_ylabel(self.name + (f" [{unit}]" if unit else ""))
        return ax

    def __len__(self) -> int:
        return len(self.values)


def spectrum_of_cube(rendering: Rendering, seen: NDArray[np.bool_]) -> Spectrum:
    """The mean over the pixels seen (height, width); of irradiances the sum."""
    assert rendering.energies is not None
    is_sum = rendering.report["image"]["quantity"] == "irradiance"
    scale = 1.0 if is_sum else 1.0 / max(int(seen.sum()), 1)
    error = None if rendering.error is None else scale * rendering.error[:, seen].sum(axis=1)
    return Spectrum(
        low=rendering.energies[:-1],
        high=rendering.energies[1:],
        values=scale * rendering.image[:, seen].sum(axis=1),
        error=error,
        unit=rendering.unit,
        energy_unit=rendering.energy_unit or "",
        name=rendering.report["image"]["quantity"],
    )


def spectrum_of_counts(
    channels: Floats, counts: Floats, seen: NDArray[np.bool_], name: str
) -> Spectrum:
    """The sum of counts (channels, height, width) over the pixels seen, with Poisson errors."""
    values = counts[:, seen].sum(axis=1)
    return Spectrum(
        low=channels[:, 1],
        high=channels[:, 2],
        values=values,
        error=np.sqrt(values),
        unit="count",
        energy_unit="keV",
        name=name,
    )
