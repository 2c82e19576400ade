"""What a rendering has found, as arrays, pictures and files.

Row 0 of all arrays is the lowest y and column 0 the lowest x, as in FITS: seen from the observer x
points to the right and y up. Nothing is flipped; plots put row 0 at the bottom.
"""

from __future__ import annotations

import base64
import html
import os
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from emitree import _native, _units
from emitree._function import Floats


class Rendering:
    """An image or a cube, its error and its bill.

    >>> import emitree
    >>> rendering = emitree.render("1 + x", emitree.Canonical(), (2, 4))
    >>> rendering.image.round(3)
    array([[1.125, 1.375, 1.625, 1.875],
           [1.125, 1.375, 1.625, 1.875]])
    """

    def __init__(
        self, scene: _native.Scene, found: _native.Rendered, report: dict[str, Any]
    ) -> None:
        self._scene = scene
        self._found = found
        #: The bill and the settings: the keys of the command's report.json, but for the memory.
        self.report = report

    @cached_property
    def image(self) -> Floats:
        """The image (height, width), or the cube (bins, height, width), in `unit`.

        Row 0 is the lowest y, the first bin that of the lowest energies. Pixels where the camera
        has no image are NaN.
        """
        return self._found.values()

    @cached_property
    def error(self) -> Floats | None:
        """The estimated |error| of each value, of the shape of `image`, or None."""
        return self._found.errors()

    @cached_property
    def flat_image(self) -> Floats:
        """The image (height, width); of a cube, the integral over its energies."""
        return self._found.flat_image()

    @cached_property
    def evaluations_of_pixels(self) -> Floats:
        """How often the emission was evaluated for each pixel (height, width)."""
        return self._found.evaluations_of_pixels()

    def expected_counts(self) -> Floats:
        """What the `instrument` is expected to count, (channels, height, width); NaN off field."""
        return self._counted()[0]

    def count_steps(self) -> dict[str, dict[str, float]]:
        """The sum over all pixels at each step to the counts: before + added - lost = after."""
        names = ("before", "added", "lost", "after")
        return {step: dict(zip(names, sums, strict=True)) for step, sums in self._counted()[1]}

    def draw_counts(self, seed: int | None = None) -> Floats:
        """Poisson counts (channels, height, width) with a seed, by default that of `instrument`.

        The same seed gives the same counts, on every machine.
        """
        self._counted()
        drawn = self._found.draw_counts(seed)
        assert drawn is not None
        return drawn

    def _counted(self) -> tuple[Floats, list[tuple[str, tuple[float, float, float, float]]]]:
        counted = self._found.expected_counts()
        if counted is None:
            raise ValueError("nothing counts photons: expected `instrument` in `render`")
        return counted

    @property
    def evaluations(self) -> int:
        """How often the emission was evaluated."""
        return self._found.evaluations

    @property
    def estimated_error(self) -> float | None:
        """The largest estimated error over the largest |value|, or None."""
        return self._found.estimated_error

    @property
    def converged(self) -> bool:
        """Whether the method did all that it was asked for; False if a limit ended it."""
        return self._found.converged

    @property
    def unit(self) -> str:
        """The unit of the image, in the grammar of FITS; "" if it is not known."""
        return self._found.unit

    @property
    def quantity(self) -> Any:
        """The image as an astropy quantity."""
        return self._with_unit(self.image)

    @property
    def error_quantity(self) -> Any:
        """The error as an astropy quantity, or None."""
        return None if self.error is None else self._with_unit(self.error)

    def _with_unit(self, values: Floats) -> Any:
        if not self.unit:
            raise ValueError("the image has no unit: expected `unit` and a `length_unit` before")
        return values << _units.to_astropy(self.unit)

    @property
    def energies(self) -> Floats | None:
        """The borders of the energy bins (bins + 1,), or None."""
        energies = self._scene.energies
        return None if energies is None else energies[0]

    @property
    def energy_unit(self) -> str | None:
        """The unit of the energies, or None."""
        energies = self._scene.energies
        return None if energies is None else energies[1]

    @property
    def scene(self) -> str:
        """The text of the scene: what `emitree render` takes, but for functions and arrays."""
        return self._scene.text

    @property
    def tree(self) -> dict[str, Any] | None:
        """The tree of method "paper": its threshold, order and leaves per level; else None."""
        if self.report["threshold"] is None:
            return None
        return {key: self.report[key] for key in ("threshold", "order", "leaves_per_level")}

    @property
    def wcs(self) -> Any:
        """The coordinates of the image as an astropy WCS of two axes; None of a HEALPix sky."""
        if not self._found.axes():
            return None
        from astropy.wcs import WCS

        return WCS(self.to_fits()[0].header, naxis=2)

    def to_fits(
        self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False
    ) -> Any:
        """Image and error with units, coordinates and provenance, as FITS.

        With a path the file is written, which needs no astropy; without one, an astropy HDUList is
        returned.
        """
        encoded = self._found.fits()
        if path is None:
            from astropy.io import fits

            return fits.HDUList.fromstring(encoded)
        with Path(path).open("wb" if overwrite else "xb") as file:
            file.write(encoded)
        return None

    def to_xarray(self) -> Any:
        """An xarray Dataset of `image` and `error` with the coordinates of the pixels' centres.

        They are those of the plane that FITS projects to, whose axes are angles only where the
        camera's are linear; `wcs` knows the angles of all.
        """
        import xarray

        dims, coords = [], {}
        if self.energies is not None:
            middle = 0.5 * (self.energies[1:] + self.energies[:-1])
            dims.append("energy")
            coords["energy"] = ("energy", middle, {"units": self.energy_unit})
        axes = self._found.axes()
        for dim, axis in zip(("y", "x"), reversed(axes), strict=False):
            name, unit, places = axis
            coords[dim] = (dim, places, {"long_name": name, "units": unit or "1"})
        dims += ["y", "x"] if axes else ["face_row", "column"]
        values = {"image": self.image} | ({} if self.error is None else {"error": self.error})
        attributes = {"units": self.unit or "1"}
        variables = {name: (dims, array, attributes) for name, array in values.items()}
        about = {key: self.report[key] for key in ("evaluations", "method", "version")}
        return xarray.Dataset(variables, coords, about)

    def plot(self, ax: Any = None, *, bin: int | None = None, **options: Any) -> Any:
        """Plots the image with matplotlib, y up, with a colour bar, and returns the axes.

        bin: the energy bin of a cube; the integral over all of them by default. Options go to
        `imshow`. A HEALPix sky is shown as a Mollweide map.
        """
        import matplotlib.pyplot as plt

        axes = self._found.axes()
        if ax is None:
            _, ax = plt.subplots()
        if not axes:
            image, unit = self._found.picture(400), self._found.flat_unit
        elif self.image.ndim == 3 and bin is not None:
            image, unit = self.image[bin], self.unit
        else:
            image, unit = self.flat_image, self._found.flat_unit
        options = {"origin": "lower", "interpolation": "nearest", **options}
        if axes:
            options.setdefault("extent", [end for axis in axes for end in _ends(axis[2])])
            for axis, label in zip(axes, (ax.set_xlabel, ax.set_ylabel), strict=True):
                label(axis[0] + (f" [{axis[1]}]" if axis[1] else ""))
        else:
            ax.set_axis_off()
        shown = ax.imshow(image, **options)
        ax.figure.colorbar(shown, ax=ax, label=self.report["image"]["quantity"] + _bracketed(unit))
        return ax

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.image.shape))
        unit = f" in {self.unit}" if self.unit else ""
        error = "" if self.estimated_error is None else f", error {self.estimated_error:.1e}"
        ended = "" if self.converged else ", NOT CONVERGED"
        return f"<emitree.Rendering {shape}{unit}: {self.evaluations} evaluations{error}{ended}>"

    def _repr_png_(self) -> bytes:
        return self._found.png()

    def _repr_html_(self) -> str:
        image = base64.b64encode(self._found.png()).decode()
        low, high = self.report["image"]["min"], self.report["image"]["max"]
        error = self.estimated_error
        rows = {
            "shape": " &times; ".join(map(str, self.image.shape)),
            self.report["image"]["quantity"]: f"{low:.4g} to {high:.4g} {html.escape(self.unit)}",
            "method": self.report["method"],
            "evaluations": f"{self.evaluations:,}",
            "error": "not estimated" if error is None else f"{error:.2e} of the largest value",
            "converged": "yes" if self.converged else "<b>no</b>",
        }
        table = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in rows.items())
        style = "height:12em;image-rendering:pixelated"
        return (
            '<div style="display:flex;gap:1em;align-items:center">'
            f'<img alt="the image" style="{style}" src="data:image/png;base64,{image}">'
            f"<table>{table}</table></div>"
        )


def _ends(places: Floats) -> tuple[float, float]:
    """The outer borders of equally spaced pixels with these centres."""
    if len(places) == 1:
        return float(places[0]) - 0.5, float(places[0]) + 0.5
    half = 0.5 * float(np.diff(places).mean())
    return float(places[0]) - half, float(places[-1]) + half


def _bracketed(unit: str) -> str:
    return f" [{unit}]" if unit else ""
