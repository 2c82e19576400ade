"""Emissions with several rates at each point: one rendering for each, from shared evaluations."""

from __future__ import annotations

import html
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _native
from emitree._files import written
from emitree._function import Floats

if TYPE_CHECKING:
    from emitree._result import Rendering

#: The rates of a batch: (n,), or (n, k) of an emission with k components.
Evaluate = Callable[[Floats, Floats, Floats | None], Floats]


@dataclass(frozen=True)
class Components:
    """The renderings of an emission with k components: g returned rates (n, k).

    Each component is rendered to the tolerance by itself. All components of a point that one of
    them needs are known, so that the points that several need are evaluated once.

    >>> import emitree, numpy as np
    >>> def pair(position, direction):
    ...     square = ((position - 0.5) ** 2).sum(axis=1)
    ...     return np.stack([np.exp(-50 * square), np.exp(-30 * square)], axis=1)
    >>> both = emitree.render(pair, emitree.Canonical(), (12, 16))
    >>> both.image.shape, both.converged, both[1].image.shape
    ((2, 12, 16), True, (12, 16))
    """

    #: The rendering of each component. Its `evaluations` are those that it would take alone.
    renderings: tuple[Rendering, ...]
    #: How often the emission was evaluated, for all components together.
    evaluations: int
    #: The names of the components, of emissions that were given with names.
    names: tuple[str, ...] | None = None

    def __len__(self) -> int:
        """The number of components."""
        return len(self.renderings)

    def __getitem__(self, component: int | str) -> Rendering:
        """The rendering of a component, by its number or its name."""
        if isinstance(component, str):
            if component not in (self.names or ()):
                names = ", ".join(self.names) if self.names else "numbers, there are no names"
                raise KeyError(f"there is no component {component!r}: expected {names}")
            component = (self.names or ()).index(component)
        return self.renderings[component]

    def __iter__(self) -> Iterator[Rendering]:
        """The renderings of all components."""
        return iter(self.renderings)

    @property
    def image(self) -> Floats:
        """The images (k, height, width), or the cubes (k, bins, height, width)."""
        return np.stack([rendering.image for rendering in self.renderings])

    @property
    def error(self) -> Floats | None:
        """The estimated error of each value of `image`; None if the method has no estimate."""
        errors = [rendering.error for rendering in self.renderings]
        known = [error for error in errors if error is not None]
        return np.stack(known) if len(known) == len(errors) else None

    @property
    def converged(self) -> bool:
        """Whether all components are within the tolerance."""
        return all(rendering.converged for rendering in self.renderings)

    @property
    def estimated_error(self) -> float | None:
        """The largest of the components, each relative to its own largest value."""
        errors = [rendering.estimated_error for rendering in self.renderings]
        known = [error for error in errors if error is not None]
        return max(known) if len(known) == len(errors) else None

    def to_fits(
        self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False
    ) -> Any:
        """All images and errors with units, coordinates and provenance, as FITS.

        Each component is an HDU with its name in capitals, `COMPONENT_1` and so on without names;
        those of the errors have `_ERROR` after it, those of evaluations `_EVALUATIONS`. With a path
        the file is written; without one, an astropy HDUList is returned.

        >>> import emitree
        >>> found = emitree.render({"total": "1 + x", "half": "x"}, emitree.Canonical(), (2, 4))
        >>> [hdu.name for hdu in found.to_fits()][:4]
        ['TOTAL', 'HALF', 'TOTAL_ERROR', 'HALF_ERROR']
        """
        if any(rendering._wcs is not None for rendering in self.renderings):
            raise ValueError("the camera is a `WcsCamera`: expected `to_fits` of each component")
        numbered = tuple(f"component_{number}" for number in range(1, len(self) + 1))
        names = self.names or numbered
        found = [(name, of._found) for name, of in zip(names, self.renderings, strict=True)]
        return written(_native.components_fits(found, self.evaluations), path, overwrite)

    def _repr_html_(self) -> str:
        titles = self.names or tuple(f"component {number}" for number in range(len(self)))
        return "".join(
            f"<div><b>{html.escape(title)}</b></div>{rendering._repr_html_()}"
            for title, rendering in zip(titles, self.renderings, strict=True)
        )


class Columns:
    """The rates of one component at a time, with those of all components at known points."""

    def __init__(self, evaluate: Evaluate) -> None:
        self.evaluate = evaluate
        #: The number of components; None as long as nothing was evaluated, or of a rate alone.
        self.count: int | None = None
        #: The component whose rates are returned.
        self.component = 0
        #: How often the emission was evaluated.
        self.evaluations = 0
        self._rows: dict[bytes, Floats] = {}

    def __call__(self, position: Floats, direction: Floats, energy: Floats | None) -> Floats:
        """The rates (n,) of the component."""
        if self.count is None:
            rates = self.evaluate(position, direction, energy)
            if rates.ndim == 1:
                return rates
            self.count = rates.shape[1]
            self.evaluations += len(position)
            self._rows.update(zip(keys_of(position, direction, energy), rates, strict=True))
            return np.ascontiguousarray(rates[:, self.component])
        rows = self.rows(position, direction, energy)
        return np.ascontiguousarray(rows[:, self.component])

    def rows(self, position: Floats, direction: Floats, energy: Floats | None = None) -> Floats:
        """The rates (n, k) of all components, of which new points alone are evaluated."""
        keys = keys_of(position, direction, energy)
        # A batch may have a point twice.
        numbers = {key: number for number, key in enumerate(keys) if key not in self._rows}
        if numbers:
            new = list(numbers.values())
            of_new = None if energy is None else energy[new]
            rates = self.evaluate(position[new], direction[new], of_new)
            self.count = rates.shape[-1] if self.count is None else self.count
            if rates.shape != (len(new), self.count):
                shape = (len(new), self.count)
                raise ValueError(f"the rates have the shape {rates.shape}: expected {shape}")
            self.evaluations += len(new)
            self._rows.update(zip(numbers, rates, strict=True))
        return np.array([self._rows[key] for key in keys])


def keys_of(position: Floats, direction: Floats, energy: Floats | None) -> list[bytes]:
    """The bits of each point."""
    parts = [position, direction] + ([] if energy is None else [energy[:, np.newaxis]])
    # 0 and -0 are the same point.
    rows = np.ascontiguousarray(np.hstack(parts) + 0.0)
    found: list[Any] = rows.view(f"V{rows.itemsize * rows.shape[1]}")[:, 0].tolist()
    return found


def of_all(
    columns: Columns,
    first: Rendering,
    render: Callable[[], Rendering],
    names: tuple[str, ...] | None = None,
) -> Any:
    """The rendering of an emission with one rate, or those of all components."""
    if columns.count is None:
        return first
    renderings = [first]
    for component in range(1, columns.count):
        columns.component = component
        renderings.append(render())
    return Components(tuple(renderings), columns.evaluations, names)
