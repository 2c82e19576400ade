"""Integrals of functions along parts of lines of sight, to a tolerance for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from emitree._cells import Integers
from emitree._function import Floats

#: Half of the nodes of the Gauss-Kronrod rule with 15 nodes, its weights, and the weights of the
#: rule of Gauss with 7 nodes; from R. Piessens et al., QUADPACK (1983), routine qk15.
_NODES = [
    0.991455371120812639206854697526329,
    0.949107912342758524526189684047851,
    0.864864423359769072789712788640926,
    0.741531185599394439863864773280788,
    0.586087235467691130294144691693,
    0.405845151377397166906606412076961,
    0.207784955007898467600689403773245,
]
_KRONROD = [
    0.022935322010529224963732008058970,
    0.063092092629978553290700663189204,
    0.104790010322250183839876322541518,
    0.140653259715525918745189590510238,
    0.169004726639267902826583426598550,
    0.190350578064785409913256402421014,
    0.204432940075298892414161999234649,
]
_GAUSS = [
    0.0,
    0.129484966168869693270611432679082,
    0.0,
    0.279705391489276667901467771423780,
    0.0,
    0.381830050505118944950369775488975,
    0.0,
]
NODES = np.array([-x for x in _NODES] + [0.0] + _NODES[::-1])
KRONROD = np.array([*_KRONROD, 0.209482141084727828012999174891714, *_KRONROD[::-1]])
GAUSS = np.array([*_GAUSS, 0.417959183673469387755102040816327, *_GAUSS[::-1]])

#: Both rules, (2, nodes).
_RULES = np.stack([KRONROD, GAUSS])
#: What annihilates polynomials up to degree 12, as the difference of both rules does up to 13, with
#: the same norm: after J. Berntsen and T. O. Espelid, Error estimation in automatic quadrature
#: routines, ACM Trans. Math. Softw. 17 (1991) 233. One of the two may vanish by accident.
_DIFFERENCE = KRONROD - GAUSS
_OTHER = _DIFFERENCE * NODES
_OTHER *= np.linalg.norm(_DIFFERENCE) / np.linalg.norm(_OTHER)


def _extrapolation(place: float, nodes: Floats) -> Floats:
    """The weights of values at nodes in the polynomial through these, at a place."""
    differences = nodes[:, np.newaxis] - nodes + np.eye(len(nodes))
    others = np.where(np.eye(len(nodes), dtype=bool), 1.0, place - nodes)
    return np.asarray((others / differences).prod(axis=1))


#: The rates at both ends of a panel, by cubic polynomials through the four nodes that are nearest.
_ENDS = np.zeros((2, len(NODES)))
_ENDS[0, :4] = _extrapolation(-1.0, NODES[:4])
_ENDS[1, -4:] = _extrapolation(1.0, NODES[-4:])
#: The part of a panel between its last node and its end.
_GAP = 0.5 * (1.0 - NODES[-1])

#: A panel that has been halved this often is a jump.
_DEEPEST = 30
#: Errors of rounding, which no rule can be better than, relative to the integral over a panel.
_ROUNDING = 50.0 * np.finfo(float).eps
#: Panels with errors below this are not halved.
_ROUNDED = 1.1 * _ROUNDING
#: Values of a function that are computed together: their arrays stay in a cache of the processor.
_TOGETHER = 1 << 15

#: Values (panels, nodes, columns) at distances (panels, nodes) along the parts with the numbers
#: (panels,).
Evaluate = Callable[[Integers, Floats], Floats]
#: The errors (lines, columns) that are allowed, from integrals and errors of the same shape.
Allowed = Callable[[Floats, Floats], Floats]


def summed(number: Integers, values: Floats, count: int) -> Floats:
    """The sums (count, columns) of the rows of values (n, columns) that have the same number."""
    if values.shape[1] == 1:
        of_column = np.bincount(number, values[:, 0], minlength=count)
        return of_column[:, np.newaxis].astype(np.float64)
    # `np.add.at` takes ten times as long.
    from scipy.sparse import csr_array

    places = number, np.arange(len(number))
    ones = csr_array((np.ones(len(number)), places), shape=(count, len(number)))
    return cast(Floats, ones @ values)


class Along:
    """The integrals of functions along parts of lines.

    is_cautious: whether the error of a panel is at least what QUADPACK estimates, which is near the
        integral itself where rules disagree much, as at jumps; by default it is at most the
        difference of the rules.
    """

    def __init__(self, evaluate: Evaluate, columns: int, is_cautious: bool = False) -> None:
        self.evaluate = evaluate
        self.columns = columns
        self.is_cautious = is_cautious

    def integrals(
        self,
        starts: Floats,
        ends: Floats,
        panels: Integers,
        line: Integers,
        lines: int,
        target: Floats | Allowed | None,
        max_evaluations: int | None = None,
    ) -> tuple[Floats, Floats, int]:
        """Integrals and errors (lines, columns), and the number of evaluations.

        starts, ends: of parts (n,), each ends behind its start.
        panels: how many equal panels (n,) they have at first.
        line: the number (n,) of the line that each belongs to, below `lines`.
        target: the errors (lines, columns) that are allowed, or what determines them again before
            each step; None for the first panels alone.
        max_evaluations: after which no panel is halved, at least those of the first panels.

        Panels are halved where the error is larger: the sum of the others is at most half of it.
        """
        part = np.repeat(np.arange(len(starts)), panels)
        step = (ends - starts) / panels
        before = np.cumsum(panels) - panels
        first = starts[part] + step[part] * (np.arange(len(part)) - before[part])
        last = first + step[part]
        of_line = line[part]
        value, error, ends_of = self._panels(part, first, last)
        shown = error + self._gaps(part, first, last, ends_of)
        total, errors = summed(of_line, value, lines), summed(of_line, shown, lines)
        evaluations = len(part) * len(NODES)
        if target is None:
            return total, errors, evaluations
        is_good = np.zeros(lines, dtype=bool)
        for _ in range(_DEEPEST):
            allowed = target(total, errors) if callable(target) else target
            # What is allowed may become less, but the panels of a good line are gone.
            is_good |= np.all(errors <= allowed, axis=1)
            kept = ~is_good[of_line]
            part, first, last, of_line = part[kept], first[kept], last[kept], of_line[kept]
            value, error, ends_of, shown = value[kept], error[kept], ends_of[kept], shown[kept]
            if len(part) == 0:
                break
            share = 0.5 / np.bincount(of_line, minlength=lines)[of_line, np.newaxis]
            excess = (shown - share * allowed[of_line]).max(axis=1)
            is_split = (excess > 0.0) & np.any(shown > _ROUNDED * abs(value), axis=1)
            if max_evaluations is not None:
                most = max(0, (max_evaluations - evaluations) // (2 * len(NODES)))
                if np.count_nonzero(is_split) > most:
                    is_split[np.argsort(-excess, kind="stable")[most:]] = False
            if not is_split.any():
                break
            middle = 0.5 * (first + last)
            new_part = np.repeat(part[is_split], 2)
            new_first = np.stack([first[is_split], middle[is_split]], axis=1).ravel()
            new_last = np.stack([middle[is_split], last[is_split]], axis=1).ravel()
            new = self._panels(new_part, new_first, new_last)
            evaluations += len(new_part) * len(NODES)
            old = ~is_split
            value, error, ends_of = (
                np.concatenate([one[old], other])
                for one, other in zip((value, error, ends_of), new, strict=True)
            )
            of_line = np.concatenate([of_line[old], line[new_part]])
            part = np.concatenate([part[old], new_part])
            first = np.concatenate([first[old], new_first])
            last = np.concatenate([last[old], new_last])
            shown = error + self._gaps(part, first, last, ends_of)
            again = ~is_good[:, np.newaxis]
            total = np.where(again, summed(of_line, value, lines), total)
            errors = np.where(again, summed(of_line, shown, lines), errors)
        return total, errors, evaluations

    def _panels(self, part: Integers, first: Floats, last: Floats) -> tuple[Floats, Floats, Floats]:
        """The integrals and errors (panels, columns) of panels, and their rates at both ends.

        Those are (panels, 2, columns), extrapolated; (panels, 0, columns) if not needed.
        """
        value = np.empty((len(part), self.columns))
        error = np.empty_like(value)
        ends = np.empty((len(part), 2 if self.is_cautious else 0, self.columns))
        together = max(1, _TOGETHER // (len(NODES) * self.columns))
        for begin in range(0, len(part), together):
            some = slice(begin, begin + together)
            half = 0.5 * (last[some] - first[some])
            distance = (first[some] + half)[:, np.newaxis] + half[:, np.newaxis] * NODES
            rates = self.evaluate(part[some], distance)
            value[some], error[some] = _kronrod(rates, half[:, np.newaxis], self.is_cautious)
            if self.is_cautious:
                ends[some] = _integrals(rates, _ENDS)
        return value, error, ends

    def _gaps(self, part: Integers, first: Floats, last: Floats, ends: Floats) -> Any:
        """Errors (panels, columns) by jumps between the last node of a panel and the next panel.

        Neither rule sees them; the rates at both sides differ.
        """
        if not self.is_cautious:
            return 0.0
        found = np.zeros((len(part), self.columns))
        order = np.lexsort((first, part))
        is_pair = part[order[1:]] == part[order[:-1]]
        left, right = order[:-1][is_pair], order[1:][is_pair]
        jump = abs(ends[left, 1] - ends[right, 0])
        # Both panels have the error of the larger one, so that both are halved.
        gap = _GAP * np.maximum(last[left] - first[left], last[right] - first[right])
        np.add.at(found, left, gap[:, np.newaxis] * jump)
        np.add.at(found, right, gap[:, np.newaxis] * jump)
        return found


def _kronrod(rates: Floats, half: Floats, is_cautious: bool) -> tuple[Floats, Floats]:
    """Integrals and errors (n, columns) from rates (n, nodes, columns).

    The error is what QUADPACK estimates, or that of the rule with 7 nodes where it is smaller and
    this is not to be cautious.
    """
    means = 0.5 * _integrals(rates, _RULES)
    mean = means[:, 0]
    difference = 2.0 * abs(mean - means[:, 1])
    if is_cautious:
        difference = np.hypot(difference, _integrals(rates, _OTHER[np.newaxis])[:, 0])
    deviation = rates - means[:, :1]
    np.abs(deviation, out=deviation)
    spread = _integrals(deviation, _RULES[:1])[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = 200.0 * difference / spread
        scaled = spread * np.minimum(1.0, ratio * np.sqrt(ratio))
    if not is_cautious:
        scaled = np.minimum(scaled, difference)
    error = np.where(spread > 0.0, scaled, difference)
    rounding: Any = _ROUNDING * abs(2.0 * mean)
    return 2.0 * mean * half, np.maximum(error, rounding) * half


def _integrals(rates: Floats, rules: Floats) -> Floats:
    """Rules (r, nodes) on [-1, 1] for rates (n, nodes, columns): (n, r, columns)."""
    if rates.shape[2] == 1:
        return cast(Floats, rates[..., 0] @ rules.T)[..., np.newaxis]
    return cast(Floats, rules @ rates)
