"""Integrals of an emission along given lines of sight, to a tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _options, _units
from emitree._allowance import Allowance
from emitree._along import NODES, Along
from emitree._cells import Integers
from emitree._emissions import Expression
from emitree._fields import Fields
from emitree._function import Floats, Function
from emitree._line_images import LOOSEST, SHARE, Shared, none_shared, shared_integrals
from emitree._line_parts import parts_of
from emitree._lines import Lines
from emitree._native import EmissionError, SceneError
from emitree._setup import in_length_unit, with_own
from emitree._several import Several

#: Samples of a panel: nodes of a rule of Gauss and Kronrod.
SAMPLES = len(NODES)
#: Parts of a line at first.
PANELS = 8
#: As in `render`.
MAX_EVALUATIONS = 50_000_000
#: How often lines are integrated one by one because the errors that are allowed have become less.
_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class LineIntegrals:
    """Integrals of an emission along lines, or weighted sums of them: what `line_integrals` found.

    >>> import emitree
    >>> lines = emitree.Lines([(-5, 0, 0), (-5, 1, 0)], (1, 0, 0), 10.0)
    >>> found = emitree.line_integrals("exp(-r^2)", lines, tolerance=1e-6)
    >>> found.values.round(5), found.converged
    (array([1.77245, 0.65205]), True)
    """

    #: The integral along each line (n,), or each weighted sum (m,); (n, k) or (m, k) of k rates.
    values: Floats
    #: The estimated errors, of the same shape: those of sums are sums of |weight| times error.
    error: Floats
    #: The errors that were allowed, of the same shape.
    allowed: Floats
    #: Whether all errors are at most those that were allowed.
    converged: bool
    #: How often the emission was evaluated, at all points together.
    evaluations: int
    #: The integral along each line and its error, also where there are weights: (n,) or (n, k).
    along_lines: Floats
    along_lines_error: Floats
    #: The unit of the rates and that of the lengths, whose product is that of the values; or None.
    unit: str | None
    length_unit: str | None

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        return (
            f"<emitree.LineIntegrals: {' x '.join(map(str, self.values.shape))} values, {state}, "
            f"estimated error {self.estimated_error:.2g}, {self.evaluations} evaluations>"
        )

    @property
    def estimated_error(self) -> float:
        """The largest error, relative to the largest |value| (of its component)."""
        largest = abs(self.values).max(axis=0, initial=0.0)
        error = self.error.max(axis=0, initial=0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(error > 0.0, error / largest, 0.0)
        return float(relative.max(initial=0.0))

    @property
    def is_good(self) -> NDArray[np.bool_]:
        """Whether the error of each value is at most what was allowed."""
        return np.asarray(self.error <= self.allowed)

    @property
    def quantity(self) -> Any:
        """The values as an astropy quantity in the unit of the rates times that of the lengths."""
        if self.unit is None or self.length_unit is None:
            raise SceneError(
                f"`unit` is {self.unit} and `length_unit` of the lines is {self.length_unit}: "
                "expected both for a quantity"
            )
        return self.values << (_units.to_astropy(self.unit) * _units.to_astropy(self.length_unit))


def line_integrals(
    emission: Any,
    lines: Lines,
    *,
    tolerance: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    max_evaluations: int | None = None,
    panels: int | None = None,
    shared: bool | None = None,
    bounds: Any = None,
    occulters: Sequence[Any] = (),
    unit: Any = None,
    quantities: bool = False,
) -> LineIntegrals:
    """Integrals of an emission along lines of sight, each to a tolerance.

    Lines are integrated one by one in adaptive steps. With `shared`, those that pass through one
    point, or are parallel, and have equal ends (the same length, or those of the bounds) are places
    in the image of a camera, which is rendered, if they are 100 or more; only those beside jumps of
    the image are integrated one by one.

    emission: one of
        * a function f(position, direction) -> rates: position (n, 3), direction (n, 3), unit
          vectors of emission, from the point to the observer, that is minus the direction of the
          line; rates (n,), or (n, k) for k components. `Particles` and `AmrGrid` are such, too;
        * a text with a formula, an `Expression`, a `Model`, or a `Grid`;
        * a list of such formulas and functions, or a dictionary of them.
    lines: where. The errors below are those of the weighted sums if there are `weights`.
    tolerance: the largest error of a value, relative to the largest |value| of its component; 0.01
        by default.
    rtol, atol: instead of `tolerance`, the error allowed in each value: atol + rtol * |value|.
    max_evaluations: how often the emission may be evaluated, 50,000,000 by default. A budget that
        does not suffice for the first samples leaves fewer; then the result is not converged.
    panels: into how many equal parts a line is divided at first, with 15 samples each, 8 by
        default. A feature between these samples is not seen: the longest gap between two is
        0.104 / panels of the line (of what is inside of the bounds), 1.3 % by default.
    shared: whether lines of one family are integrated by an image, which sees fewer small features
        than panels do: those that `render` sees. By default only lines of `camera.lines` are,
        without `panels`.
    bounds: a `Sphere`, `Ellipsoid` or `Box` outside of which the emission is 0; by default the
        attribute `bounds` of a function. Nothing is evaluated outside.
    occulters: opaque `Sphere`s and `Ellipsoid`s, at which lines end.
    unit: the unit of the rates; `LineIntegrals.quantity` is in this times `length_unit`.
    quantities: whether a function gets astropy quantities instead of plain arrays.

    Raises `SceneError` if an argument is wrong, `EmissionError` if a rate is not finite, and any
    exception of a function.

    >>> import emitree, numpy as np
    >>> def ball(position, direction):
    ...     return (np.linalg.norm(position, axis=1) < 1).astype(float)
    >>> lines = emitree.Lines([(-5, 0, 0), (-5, 0.6, 0)], (1, 0, 0), 10.0)
    >>> found = emitree.line_integrals(ball, lines, tolerance=1e-4)
    >>> bool(abs(found.values - [2.0, 1.6]).max() < 2e-4)
    True
    """
    if not isinstance(lines, Lines):
        raise TypeError(
            f"the lines are {type(lines).__name__}: expected emitree.Lines, as of "
            "`camera.lines(shape)`"
        )
    allowance = Allowance.of(tolerance, rtol, atol, lines.weights)
    has_panels = panels is not None
    panels = _options.count("panels", panels, "a number of parts of a line", 100_000) or PANELS
    if shared is not None and not isinstance(shared, bool):
        raise SceneError(f"`shared` is {shared!r}: expected True or False")
    most = _options.count("max_evaluations", max_evaluations, "a number of evaluations")
    most = MAX_EVALUATIONS if most is None else most
    if isinstance(emission, str):
        emission = Expression(emission)
    if isinstance(emission, Fields):
        emission = emission.in_length_unit(lines.length_unit)
    own = with_own(emission, {"bounds": bounds, "unit": unit})
    unit = _units.to_text(own["unit"])
    function = _function(emission, unit, lines.length_unit, quantities)
    near, far = parts_of(lines, own["bounds"], occulters)
    columns = Sampler(function, lines, near, far)
    line = np.flatnonzero(far > near)
    count = columns.count(line)
    is_shared = lines.is_of_camera and not has_panels if shared is None else shared
    found = none_shared(len(lines), count)
    if is_shared:
        found = shared_integrals(
            function,
            lines,
            (near, far),
            count,
            bounds=own["bounds"],
            occulters=occulters,
            seeds=getattr(emission, "seeds", ()),
            allowed=allowance.of_image(SHARE, LOOSEST),
            integrals=lambda some, share: _first_panels(
                columns, some, count, max(round(share * panels), 1)
            ),
            most=most - columns.evaluations - SAMPLES * len(line),
        )
    is_complete = _one_by_one(found, columns, line, allowance, panels, most)
    value, error = found.values, found.errors
    sums, of_sums = allowance.sums(value), allowance.bounds(error)
    allowed = allowance.of_values(sums, of_sums, is_final=True)
    is_good = bool(np.all(of_sums <= allowed)) and is_complete
    arrays = [sums, of_sums, allowed, value, error]
    if columns.is_single:
        arrays = [array[:, 0] for array in arrays]
    return LineIntegrals(
        values=arrays[0],
        error=arrays[1],
        allowed=arrays[2],
        converged=is_good,
        evaluations=found.evaluations + columns.evaluations,
        along_lines=arrays[3],
        along_lines_error=arrays[4],
        unit=unit,
        length_unit=lines.length_unit,
    )


def _first_panels(
    columns: Sampler, line: Integers, count: int, panels: int
) -> tuple[Floats, Floats, int]:
    """Integrals and errors (n, k) of lines (n,) in equal panels, and the evaluations."""
    along = Along(columns.values_of(line), count, is_cautious=True)
    number = np.arange(len(line))
    start, end = np.zeros(len(line)), np.ones(len(line))
    return along.integrals(start, end, np.full(len(line), panels), number, len(line), None)


def _one_by_one(
    found: Shared, columns: Sampler, line: Integers, allowance: Allowance, panels: int, most: int
) -> bool:
    """Integrates what images do not tell well enough, and whether all lines had all panels."""
    is_in = np.zeros(len(found.is_known), dtype=bool)
    is_in[line] = True
    is_complete = True
    for number in range(_ROUNDS):
        target = allowance.of_lines(found.values, found.errors)
        is_good = np.all(found.errors <= target, axis=1)
        some = np.flatnonzero(is_in & ~(found.is_known & is_good))
        if len(some) == 0:
            break
        left = most - found.evaluations - columns.evaluations
        fewer = min(panels, left // (SAMPLES * len(some)))
        if fewer < 1 and number > 0:
            return False
        if fewer < 1:
            raise SceneError(
                f"`max_evaluations` is {most}: expected at least {SAMPLES * len(line) + 1}, "
                f"{SAMPLES} for each line and 1 more"
            )
        is_complete &= fewer == panels
        is_in[some] = False
        found.values[some], found.errors[some] = 0.0, 0.0
        values, errors = found.values.copy(), found.errors.copy()

        def allowed(value: Floats, error: Floats, values=values, errors=errors) -> Floats:
            return allowance.of_lines(values + value, errors + error)

        along = Along(columns.values_of(some), values.shape[1], is_cautious=True)
        value, error, evaluations = along.integrals(
            np.zeros(len(some)),
            np.ones(len(some)),
            np.full(len(some), fewer),
            some,
            len(values),
            allowed,
            left,
        )
        found.values += value
        found.errors += error
        found.evaluations += evaluations
    return is_complete


def _function(emission: Any, unit: Any, length_unit: str | None, quantities: bool) -> Function:
    """An emission as a function of arrays."""
    if isinstance(emission, Expression):
        emission = emission.model([])()
    elif isinstance(emission, list | tuple | Mapping):
        emission = Several.of(emission)
    emission = in_length_unit(emission, length_unit)
    if not callable(emission):
        raise TypeError(
            f"the emission is {type(emission).__name__}: expected a function f(position, "
            "direction), a text with a formula, an emitree.Expression, Model or Grid, or a list of "
            "these"
        )
    if quantities and length_unit is None:
        raise SceneError("`quantities` is given: expected a `length_unit` of the lines too")
    return Function(
        emission, unit=unit, length_unit=length_unit, quantities=quantities, takes_components=True
    )


class Sampler:
    """The rates along lines, as functions of a variable from 0 to 1 along each.

    An infinite line has the distance near + scale ((1 - t)^-2 - 1), as in `render`.
    """

    def __init__(self, function: Function, lines: Lines, near: Floats, far: Floats) -> None:
        self.function = function
        self.lines = lines
        self.near = near
        self.far = far
        #: Those that only served to find the number of components.
        self.evaluations = 0
        #: Whether the rates are (n,), not (n, k).
        self.is_single = True

    def count(self, line: Integers) -> int:
        """The number of components, by one evaluation on the first of some lines."""
        if len(line) == 0:
            return 1
        first = line[:1]
        distance, _ = self._distances(first, np.full((1, 1), 0.5))
        self.evaluations = 1
        rates = self._rates(first, distance)
        self.is_single = rates.ndim == 1
        self._count = rates.reshape(1, -1).shape[1]
        return self._count

    def values_of(self, line: Integers) -> Any:
        """What gives values (panels, nodes, columns) by numbers (panels,) in some lines."""

        def evaluate(number: Integers, t: Floats) -> Floats:
            of_line = line[number]
            distance, slope = self._distances(of_line, t)
            rates = self._rates(of_line, distance).reshape(distance.size, -1)
            if rates.shape[1] != self._count:
                raise ValueError(
                    f"the rates have the shape {rates.shape}: expected "
                    f"({distance.size}, {self._count})"
                )
            found = rates.reshape(*distance.shape, -1)
            found *= slope[..., np.newaxis]
            return found

        return evaluate

    def _distances(self, line: Integers, t: Floats) -> tuple[Floats, Floats]:
        """Distances (panels, nodes), and their derivatives by t."""
        near, far = self.near[line, np.newaxis], self.far[line, np.newaxis]
        is_finite = np.isfinite(far)
        length = np.where(is_finite, far, near) - near
        distance, slope = near + length * t, np.broadcast_to(length, t.shape)
        if is_finite.all():
            return distance, slope
        scale, left = self.lines.scale[line, np.newaxis], 1.0 - t
        return (
            np.where(is_finite, distance, near + scale * (left**-2 - 1.0)),
            np.where(is_finite, slope, 2.0 * scale * left**-3),
        )

    def _rates(self, line: Integers, distance: Floats) -> Floats:
        direction = self.lines.directions[line]
        step = distance[..., np.newaxis] * direction[:, np.newaxis]
        position = (self.lines.positions[line][:, np.newaxis] + step).reshape(-1, 3)
        towards = np.repeat(-direction, distance.shape[1], axis=0)
        rates = self.function(position, towards, None)
        wrong = np.flatnonzero(~np.isfinite(rates.reshape(len(rates), -1)).all(axis=1))
        if len(wrong):
            x, y, z = position[wrong[0]]
            raise EmissionError(
                f"the rate is {rates[wrong[0]]} at ({x:g}, {y:g}, {z:g}), on line "
                f"{line[wrong[0] // distance.shape[1]]}: expected finite rates"
            )
        return np.array(rates)
