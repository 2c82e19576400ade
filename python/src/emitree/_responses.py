"""Integrals of basis functions along the lines of sight of cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from emitree._along import Along
from emitree._basis import Basis
from emitree._cells import Integers
from emitree._function import Floats, as_rates
from emitree._sight import Lines, Tubes, union
from emitree._supports import Interval, lengths

#: What a function may add to the mean of a cell without being seen: this fraction of the longest
#: part of a line in its support, times the value at its border; if no line of the cell meets the
#: support, or the cell is larger than a voxel, and if some lines do not meet it.
_UNSEEN, _BESIDE = 0.25, 0.1
#: Lines of a cell are close enough to see a smooth function if the cell is smaller than this many
#: widths, from its centre to its corners; and a voxel, if it is smaller than the voxel.
_RESOLVED = 2.0
#: First panels of a line are no longer than this many widths: one is nearly exact for half a
#: Gaussian.
_PANEL = 6.0
#: The most first panels of a part of a line.
_MOST_PANELS = 16
#: First panels of a line along a function of which nothing is known, as for `los`.
_PANELS_OF_UNKNOWN = 8


@dataclass(frozen=True)
class AlongLines:
    """Integrals along the lines of cells."""

    #: (cells, places, columns), with the errors of the integration along the lines.
    value: Floats
    error: Floats
    #: What the lines may have missed, in the mean of each cell (cells, columns).
    unseen: Floats
    evaluations: int


class Response(Protocol):
    """Some columns of a matrix: functions that are integrated along lines."""

    @property
    def functions(self) -> int:
        """The number of functions."""

    @property
    def columns(self) -> int:
        """How many functions are integrated together: 1, or all of them."""

    def candidates(self, tubes: Tubes, blocks: list[Integers]) -> tuple[Integers, Integers]:
        """Pairs of a tube and a function, (n,) and (n,), of all that may not be 0.

        blocks: the numbers of neighbouring tubes, each of which is in one of them.
        """

    def along(
        self, lines: Lines, tubes: Tubes, which: Integers, target: Floats | None
    ) -> AlongLines:
        """Integrals of the functions with the numbers (cells,) along lines (cells, places).

        target: the errors (cells, columns) that are allowed along each line.
        """


class OfBasis:
    """The functions of a basis, one by one, each where it is not 0."""

    columns = 1

    def __init__(self, basis: Basis) -> None:
        self.basis = basis
        self.functions = len(basis)

    def candidates(self, tubes: Tubes, blocks: list[Integers]) -> tuple[Integers, Integers]:
        """Pairs of a tube and a function, (n,) and (n,), of all that may not be 0."""
        tube, which = [], []
        for block in blocks:
            functions = np.arange(self.functions)
            all_of = union(tubes[block])[np.zeros(self.functions, dtype=np.int64)]
            functions = functions[self._longest(all_of, functions) > 0.0]
            first = np.repeat(block, len(functions))
            second = np.tile(functions, len(block))
            meets = self._longest(tubes[first], second) > 0.0
            tube.append(first[meets])
            which.append(second[meets])
        return np.concatenate(tube), np.concatenate(which)

    def along(
        self, lines: Lines, tubes: Tubes, which: Integers, target: Floats | None
    ) -> AlongLines:
        """Integrals of the functions with the numbers (cells,) along lines (cells, places)."""
        cells, places = lines.near.shape
        parts = self.basis.supports.inside(lines, which[:, np.newaxis])
        length = lengths(parts)
        grown = self._grown(tubes, which)
        ends = [np.where(end > start, end, 0.0) for start, end in grown]
        # The end of a part may be at infinity where a tube is wide.
        reach = np.minimum(np.max(ends, axis=0), np.finfo(float).max / 8.0)
        size = tubes.radius + tubes.spread * reach
        feature = self.basis.feature[which]
        misses = (length == 0.0) @ np.ones(places)
        height = np.where(misses > 0.0, _BESIDE, 0.0)
        height[misses == places] = _UNSEEN
        height *= self.basis.edge
        # Of voxels, only what is longer than the parts of lines that were seen is unseen.
        seen: Any = 0.0
        if self.basis.is_constant:
            value, error, evaluations = length, np.zeros_like(length), 0
            height[size > feature] = _UNSEEN
            seen = length.max(axis=1)
        else:
            value, error, evaluations = self._integrals(lines, which, parts, target)
            height[size > _RESOLVED * feature] = 1.0
        longer = np.maximum(self._longest_of(grown, which) - seen, 0.0)
        shape = (cells, places, 1)
        unseen = (height * longer)[:, np.newaxis]
        return AlongLines(value.reshape(shape), error.reshape(shape), unseen, evaluations)

    def _integrals(
        self, lines: Lines, which: Integers, parts: list[Interval], target: Floats | None
    ) -> tuple[Floats, Floats, int]:
        """Integrals and errors (cells * places, 1), and the number of evaluations."""
        places = lines.near.shape[1]
        flat = [(start.ravel(), end.ravel()) for start, end in parts]
        numbers = [np.flatnonzero(end > start) for start, end in flat]
        line = np.concatenate(numbers)
        starts = np.concatenate([start[of] for (start, _), of in zip(flat, numbers, strict=True)])
        ends = np.concatenate([end[of] for (_, end), of in zip(flat, numbers, strict=True)])
        origin = lines.origin.reshape(3, -1)[:, line]
        direction = lines.direction.reshape(3, -1)[:, line]
        functions = which[line // places]
        longest = _PANEL * self.basis.feature[functions]
        panels = np.clip(np.ceil((ends - starts) / longest), 1, _MOST_PANELS)

        def evaluate(number: Integers, distance: Floats) -> Floats:
            position = np.empty((3, *distance.shape))
            for axis in range(3):
                along = np.multiply(
                    distance, direction[axis][number, np.newaxis], out=position[axis]
                )
                along += origin[axis][number, np.newaxis]
            return self.basis.values(position, functions[number, np.newaxis])[..., np.newaxis]

        of_lines = None if target is None else np.repeat(target, places, axis=0)
        return Along(evaluate, 1).integrals(
            starts, ends, panels.astype(np.int64), line, lines.near.size, of_lines
        )

    def _grown(self, tubes: Tubes, which: Integers) -> list[Interval]:
        return self.basis.supports.inside(tubes.lines, which, (tubes.radius, tubes.spread))

    def _longest(self, tubes: Tubes, which: Integers) -> Floats:
        """The longest part (n,) of a line of each tube in a support, at most its diameter."""
        return self._longest_of(self._grown(tubes, which), which)

    def _longest_of(self, parts: list[Interval], which: Integers) -> Floats:
        return np.minimum(lengths(parts), self.basis.supports.sizes[which])


class OfFunction:
    """All components of a function of which nothing is known, together."""

    def __init__(self, function: Callable[[Floats, Floats], Any], functions: int) -> None:
        self.function = function
        self.functions = self.columns = functions

    def candidates(self, tubes: Tubes, blocks: list[Integers]) -> tuple[Integers, Integers]:
        """All tubes; the second number is 0."""
        is_seen = tubes.lines.far > tubes.lines.near
        tube = np.sort(np.concatenate(blocks))
        tube = tube[is_seen[tube]]
        return tube, np.zeros(len(tube), dtype=np.int64)

    def along(
        self, lines: Lines, tubes: Tubes, which: Integers, target: Floats | None
    ) -> AlongLines:
        """Integrals of all components along lines (cells, places)."""
        cells, places = lines.near.shape
        flat = lines.reshape(cells * places)
        line = np.flatnonzero(flat.far > flat.near)
        origin, direction = flat.origin[:, line].T, flat.direction[:, line].T

        def evaluate(number: Integers, distance: Floats) -> Floats:
            step = distance[..., np.newaxis] * direction[number, np.newaxis]
            position = (step + origin[number, np.newaxis]).reshape(-1, 3)
            towards = np.repeat(-direction[number], distance.shape[1], axis=0)
            rates = as_rates(self.function(position, towards), len(position), None, True)
            if rates.reshape(len(position), -1).shape[1] != self.columns:
                raise ValueError(
                    f"the rates have the shape {rates.shape}: expected "
                    f"({len(position)}, {self.columns})"
                )
            return rates.reshape(*distance.shape, self.columns)

        of_lines = None if target is None else np.repeat(target, places, axis=0)
        panels = np.full(len(line), _PANELS_OF_UNKNOWN)
        value, error, evaluations = Along(evaluate, self.columns).integrals(
            flat.near[line], flat.far[line], panels, line, len(flat.near), of_lines
        )
        shape = (cells, places, self.columns)
        unseen = np.zeros((cells, self.columns))
        return AlongLines(value.reshape(shape), error.reshape(shape), unseen, evaluations)
