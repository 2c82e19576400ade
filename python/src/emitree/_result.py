"""The result of a rendering, as arrays, pictures and files.

Row 0 of all arrays is the lowest y and column 0 the lowest x, as in FITS: seen from the observer x
points to the right and y up. Nothing is flipped; plots put row 0 at the bottom.
"""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _display, _native, _units
from emitree._files import written
from emitree._function import Floats
from emitree._plan import Plan
from emitree._sky_result import OnSky
from emitree._spectrum import Spectrum, spectrum_of_counts, spectrum_of_cube
from emitree._sums import RegionSum, region_sums
from emitree._surfaces import Surfaces

if TYPE_CHECKING:
    from emitree._setup import Setup
    from emitree._view_widget import View

#: Expected counts, the sums of each step to them, and the number and energies of each channel.
_Counted = tuple[
    Floats, list[tuple[str, tuple[float, float, float, float]]], list[tuple[int, float, float]]
]


#: The most evaluations of a rendering that records its plan.
MOST_EVALUATIONS_OF_PLANS = 1_000_000


class Rendering(OnSky):
    """An image or a cube, its estimated error and its cost.

    It can be pickled and copied, and needs neither the emission nor any file for that.

    >>> import emitree
    >>> rendering = emitree.render("1 + x", emitree.Canonical(), (2, 4))
    >>> rendering.image.round(3)
    array([[1.125, 1.375, 1.625, 1.875],
           [1.125, 1.375, 1.625, 1.875]])
    """

    def __init__(
        self, found: _native.Rendered, report: dict[str, Any], setup: Setup | None = None
    ) -> None:
        self._found = found
        self._setup = setup
        self._sky = None if setup is None else setup.camera.sky
        #: The cost and the settings: report.json of the command, without the counts.
        self.report = report

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: arrays that can be made again are left out, counts are made for it."""
        state = {"_found": self._found, "report": self.report, "_setup": None, "_is_copy": True}
        state["_sky"] = self._sky
        if self._wcs is not None:
            state |= {"_wcs": self._wcs, "_cards": self._cards}
        if self._found.instrument is not None:
            try:
                state["_counted"] = self._counted
            except ValueError as error:
                state["_uncounted"] = str(error)
        return state

    @cached_property
    def image(self) -> Floats:
        """The image (height, width), or the cube (bins, height, width), in `unit`.

        Row 0 is the lowest y, the first bin that of the lowest energies
        or of the first times. Pixels where the camera
        has no image are NaN.
        """
        return self._found.values()

    @cached_property
    def error(self) -> Floats | None:
        """The estimated |error| of each value, of the shape of `image`, or None."""
        return self._found.errors()

    @cached_property
    def plan(self) -> Plan:
        """The points of the rendering, and the linear map from rates there to the image.

        It gives the images of neighbouring emissions without a new search; see `Plan`. Saved and
        loaded again it stays, while a pickled rendering has none.

        Raises `ValueError` with the reason if there is none.

        >>> import emitree, numpy as np
        >>> def ball(position, direction):
        ...     return np.exp(-30 * ((position - 0.5) ** 2).sum(axis=1))
        >>> rendering = emitree.render(ball, emitree.Canonical(), (16, 16))
        >>> plan = rendering.plan
        >>> bool(np.allclose(plan.apply(plan.rates(ball)), rendering.image, rtol=1e-9))
        True
        """
        mesh = self._found.plan
        if mesh is None:
            raise ValueError(f"the rendering has no plan: {self._reason_for_no_plan()}")
        return Plan.of_mesh(mesh, self._setup, None if self._setup is None else self._setup.unit)

    def _reason_for_no_plan(self) -> str:
        if self.__dict__.get("_is_copy"):
            return "it was pickled or copied; expected the original, or `plan.save` before"
        if self.absorption_evaluations is not None:
            return "the medium absorbs, and the image is not linear in rates and coefficients"
        if self._found.surfaces() is not None:
            return (
                "its image is that of surfaces at which g jumps, whose places do not depend on "
                'the rates linearly; expected method "paper" or "los"'
            )
        if self.evaluations > MOST_EVALUATIONS_OF_PLANS:
            return (
                f"it took {self.evaluations} evaluations; expected at most "
                f"{MOST_EVALUATIONS_OF_PLANS}, or a `Session`, whose `mesh` has no limit"
            )
        if self.report["ending"] in ("time", "unfinished"):
            return f"its end is {self.report['ending']!r}; expected a complete one"
        return "it was not recorded; expected a rendering of `render` or `Plan.refine`"

    @cached_property
    def sums(self) -> dict[str, RegionSum]:
        """The sums over the regions `sums`, by name; none if there were no regions."""
        return region_sums(self.report)

    @cached_property
    def surfaces(self) -> Surfaces | None:
        """The surfaces at which the rate jumps, or None if the image is not made of found surfaces.

        Only method "vol" finds surfaces, and only where the image follows from them to the
        tolerance. None does not mean that the rate has no jumps.

        >>> import emitree, numpy as np
        >>> def ball(position, direction):
        ...     return np.where(np.linalg.norm(position - 0.5, axis=1) < 0.3, 2.0, 0.5)
        >>> found = emitree.render(ball, emitree.Canonical(), (32, 32)).surfaces
        >>> radius = np.linalg.norm(found.position - 0.5, axis=1)
        >>> bool(np.median(abs(radius - 0.3)) < np.median(found.uncertainty))
        True
        >>> bool(np.allclose(found.jump, 1.5))
        True
        """
        arrays = self._found.surfaces()
        if arrays is None:
            return None
        return Surfaces(*arrays, *self._found.surface_units, self._found)

    @cached_property
    def flat_image(self) -> Floats:
        """The image (height, width); of a cube, the integral over its energies, or the mean over
        its times."""
        return self._found.flat_image()

    @cached_property
    def evaluations_per_pixel(self) -> Floats:
        """How often the emission was evaluated for each pixel (height, width)."""
        return self._found.evaluations_per_pixel()

    @property
    def evaluations_of_pixels(self) -> Floats:
        """The former name of `evaluations_per_pixel`."""
        return self.evaluations_per_pixel

    @property
    def expected_counts(self) -> Floats:
        """The expected counts of the `instrument`, (channels, height, width); NaN off field."""
        return self._counted[0]

    @property
    def count_steps(self) -> dict[str, dict[str, float]]:
        """The sum over all pixels at each step to the counts: before + added - lost = after."""
        names = ("before", "added", "lost", "after")
        return {step: dict(zip(names, sums, strict=True)) for step, sums in self._counted[1]}

    @property
    def channels(self) -> Floats:
        """The channels of the `instrument` (channels, 3): number, lower and upper energy [keV]."""
        return np.array(self._counted[2], dtype=np.float64).reshape(-1, 3)

    def draw_counts(self, seed: int | None = None) -> Floats:
        """Poisson counts (channels, height, width) with a seed, by default that of `instrument`.

        The same seed gives the same counts, on every machine.
        """
        return _native.draw_counts(self.expected_counts, self._seed(seed))

    def _seed(self, seed: int | None) -> int:
        instrument = self._found.instrument
        return seed if seed is not None else instrument[1] if instrument is not None else 0

    @cached_property
    def _counted(self) -> _Counted:
        uncounted = self.__dict__.get("_uncounted")
        if uncounted is not None:
            raise _native.SceneError(uncounted)
        counted = self._found.expected_counts()
        if counted is None:
            raise ValueError("nothing counts photons: expected `instrument` in `render`")
        return counted

    def counts_to_fits(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        seed: int | None = None,
        expected: bool = False,
        overwrite: bool = False,
    ) -> Any:
        """Counts (channels, height, width) as FITS, with coordinates and the table EBOUNDS.

        Counts that are drawn with a seed, by default that of `instrument`; or the expected ones.
        The table EBOUNDS has the number and the nominal energies of each channel [keV]; a sky in
        HEALPix pixels has none. With a path the file is written, without one an astropy HDUList is
        returned.

        >>> import emitree
        >>> camera = emitree.Perspective(
        ...     position=(-10, 0, 0), target=(0, 0, 0), field_of_view=(1, 1), near=9, far=11,
        ...     length_unit="cm",
        ... )
        >>> rendering = emitree.render(
        ...     "exp(-E)", camera, (4, 4), unit="ph cm-3 s-1 sr-1 keV-1",
        ...     energy=emitree.Energies(0.5, 2.0, 3),
        ...     instrument=emitree.Instrument(effective_area=50.0, exposure=1e4),
        ... )
        >>> [table.name for table in rendering.counts_to_fits()]
        ['COUNTS', 'EBOUNDS']
        """
        seed = None if expected else self._seed(seed)
        counts = self.expected_counts if seed is None else self.draw_counts(seed)
        encoded = self._found.counts_fits(counts, self._counted[2], seed)
        return written(encoded, path, overwrite)

    def spectrum(self, counts: Floats | None = None, *, where: Any = None) -> Spectrum:
        """The spectrum of a cube, or that of an instrument.

        With an instrument: the sum over pixels of its expected counts, or of other `counts`
        (channels, height, width), such as those of `draw_counts`, with errors after Poisson.
        Without: the mean over pixels, each with the same weight, and the mean of their errors; of
        irradiances the sum.
        where: (height, width), which pixels count; those that are NaN never do.

        >>> import emitree
        >>> bins = emitree.Energies(0.0, 2.0, 2)
        >>> cube = emitree.render("x * E", emitree.Canonical(), (2, 2), energy=bins)
        >>> cube.spectrum().values.round(3)
        array([0.25, 0.75])
        """
        if self._found.instrument is not None or counts is not None:
            return self._counts_spectrum(counts, where)
        if self.energies is None:
            raise ValueError("the image has no energies: expected `energy` in `render`")
        return spectrum_of_cube(self, self._seen(where))

    def _counts_spectrum(self, counts: Floats | None, where: Any) -> Spectrum:
        expected = self.expected_counts
        found = expected if counts is None else np.asarray(counts, dtype=np.float64)
        if found.shape != expected.shape:
            raise ValueError(f"`counts` has the shape {found.shape}: expected {expected.shape}")
        seen = self._seen(where) & ~np.isnan(expected).any(axis=0)
        name = "expected counts" if counts is None else "counts"
        return spectrum_of_counts(self.channels, found, seen, name)

    def _seen(self, where: Any) -> Any:
        """The pixels (height, width) that are numbers, and that `where` selects."""
        seen = ~np.isnan(self.image).any(axis=0)
        if where is None:
            return seen
        selected = np.asarray(where, dtype=bool)
        if selected.shape != seen.shape:
            raise ValueError(f"`where` has the shape {selected.shape}: expected {seen.shape}")
        return seen & selected

    @property
    def evaluations(self) -> int:
        """How often the emission was evaluated."""
        return self._found.evaluations

    @property
    def absorption_evaluations(self) -> int | None:
        """How often the absorption coefficient was evaluated; None if the medium does not absorb.

        `evaluations` does not include them.
        """
        return self._found.absorption_evaluations

    @property
    def estimated_error(self) -> float | None:
        """The largest estimated error over the largest |value|, or None."""
        return self._found.estimated_error

    @property
    def error_over_allowed(self) -> float | None:
        """The largest estimated error of a value over the error allowed there, or None.

        It is at most 1 if the tolerance is met; only method "vol" has it.
        """
        return self.report["error_over_allowed"]

    @property
    def smallest_feature(self) -> float | None:
        """The standard deviation of the smallest Gaussian that would have been detected, or None.

        It is a fraction of the edge of the view's cube, for a probability of 99 % and a peak in the
        image of 20 times the tolerance; only method "vol" has it.
        """
        return self.report["smallest_feature"]

    @property
    def converged(self) -> bool:
        """Whether the stopping criterion was met; False if a limit ended the rendering."""
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
        energies = self._found.energies
        return None if energies is None or self._is_exposed else energies[0]

    @property
    def energy_unit(self) -> str | None:
        """The unit of the energies, or None."""
        energies = self._found.energies
        return None if energies is None or self._is_exposed else energies[1]

    @property
    def times(self) -> Floats | None:
        """The borders of the bins of the exposure (bins + 1,) [s], or None without one.

        >>> import emitree
        >>> exposure = emitree.Exposure(0, 60, bins=3)
        >>> rendering = emitree.render("x * t", emitree.Canonical(), (2, 2), exposure=exposure)
        >>> rendering.times, rendering.image.shape
        (array([ 0., 20., 40., 60.]), (3, 2, 2))
        """
        exposed = self.report.get("time")
        if exposed is None:
            return None
        return np.linspace(exposed["start"], exposed["stop"], exposed["bins"] + 1)

    @property
    def _is_exposed(self) -> bool:
        return self.report.get("time") is not None

    @property
    def scene(self) -> str:
        """The text of the scene: what `emitree render` takes, but for functions and arrays.

        Changes of a scene file are comments at the end, one for each change.
        """
        return self._found.scene

    @property
    def tree(self) -> dict[str, Any] | None:
        """The tree of method "paper": its threshold, order and leaves per level; else None."""
        if self.report["threshold"] is None:
            return None
        return {key: self.report[key] for key in ("threshold", "order", "leaves_per_level")}

    def to_xarray(self) -> Any:
        """An xarray Dataset of `image` and `error` with the coordinates of the pixels' centres.

        They are those of the plane that FITS projects to, whose axes are angles only where the
        camera's are linear; `wcs` has the angles of all.
        """
        return _display.xarray_of(self, self._found)

    def plot(self, ax: Any = None, *, bin: int | None = None, **options: Any) -> Any:
        """Plots the image with matplotlib, y up, with a colour bar, and returns the axes.

        bin: the bin of a cube; the integral over all energies, or the mean over all times, by
        default. Options go to `imshow`. A HEALPix sky is shown as a Mollweide map.
        """
        return _display.plotted(self, self._found, ax, bin, options)

    def view(self) -> View:
        """A view in a notebook: image and error, values at the cursor, of a cube its spectra.

        It is that of `emitree.view`, which also goes on to a tighter tolerance and turns the
        camera: a rendering does not have the emission.

        Raises `ImportError` without anywidget.
        """
        from emitree._view import view_of

        return view_of(self)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.image.shape))
        unit = f" in {self.unit}" if self.unit else ""
        error = "" if self.estimated_error is None else f", error {self.estimated_error:.1e}"
        ended = "" if self.converged else ", NOT CONVERGED"
        return f"<emitree.Rendering {shape}{unit}: {self.evaluations} evaluations{error}{ended}>"

    def _repr_png_(self) -> bytes:
        return self._found.png()

    def _repr_html_(self) -> str:
        return _display.html_of(self, self._repr_png_())
