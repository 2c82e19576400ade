"""A plan for the images of several similar emissions, whose rates at its points are related.

The rates of a model at the points of a plan, for many values of its parameters, are often in the
span of a few of them (a reduced basis). Where a sample of the points shows that, the others are
calculated and not evaluated. The rendering compares its image with samples of the emission itself,
as that of any plan does: rates that are not in the span show in its error estimate.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from emitree._function import Floats
from emitree._plan import Plan
from emitree._points import Points
from emitree._recorded import Passed, Recorded
from emitree._result import Rendering

#: At how many points, spread over all, calculated rates are compared. Products have hundreds or
#: thousands of points.
_COMPARED = 64
#: Rates are taken as calculated if they differ at these points by less than this fraction of the
#: largest: more shows in the image, whose tolerance is 0.01 by default.
_SIMILAR = 3e-3
#: Samples besides its points that compare a plan with an emission: usually 512, half of which a
#: rendering in full has, too, if the plan does not suffice.
_CHECKED = 600
#: Directions of the rates below this fraction of the largest one are rounding.
_LEAST = 1e-12


class SharedPlan:
    """A plan of products, and the rates of several emissions at its points."""

    def __init__(self, plan: Plan, place: Floats, emission: Recorded | Passed) -> None:
        #: The plan, with the options of the renderings.
        self.plan = plan
        #: The parameters that it was made for.
        self.place = place
        #: Parameters for which it did not suffice.
        self.failed: list[Floats] = []
        self._rates: list[Floats] = []
        #: Errors of images with all of their own rates, over the square of the distance of their
        #: parameters: as the error of a plan grows.
        self._growths: list[float] = []
        if isinstance(emission, Recorded):
            self._rates.append(emission.rates(plan.points))

    @property
    def most_evaluations(self) -> int:
        """About the most evaluations of an image."""
        return len(self.plan) + _CHECKED

    def fails_before(self, place: Floats) -> bool:
        """Whether the plan did not suffice for parameters on the way to these."""
        way = place - self.place
        return any(
            float(way @ (failed - self.place)) >= float(np.sum((failed - self.place) ** 2))
            for failed in self.failed
        )

    def rendering(self, emission: Recorded | Passed, place: Floats) -> Rendering:
        """The rendering of another emission by this plan; it may not have converged.

        place: its parameters.
        """
        if isinstance(emission, Passed):
            return emission.rendered(lambda of, executor: self.plan.render(of, executor=executor))
        return self._of_recorded(emission, float(np.sum((place - self.place) ** 2)))

    def _of_recorded(self, recorded: Recorded, square: float) -> Rendering:
        plan, points = self.plan, self.plan.points
        calculated = self._calculated(recorded)
        if calculated is not None:
            with recorded.assuming(points, calculated):
                found = plan.render(recorded.emission)
            # Where the plan itself is expected to have such an error, its other rates do not help.
            expected = min(self._growths, default=0.0) * square
            if found.converged or (found.estimated_error or np.inf) <= expected:
                return found
        self._rates.append(recorded.rates(points))
        found = plan.render(recorded.emission)
        if square > 0 and found.estimated_error is not None:
            self._growths.append(found.estimated_error / square)
        return found

    def _calculated(self, recorded: Recorded) -> Floats | None:
        """All rates from those of a sample of the points, if these are in the span."""
        count = len(self.plan)
        if not self._rates or count < 4 * (_COMPARED + len(self._rates)):
            return None
        directions, sizes, _ = np.linalg.svd(np.array(self._rates).T, full_matrices=False)
        directions = directions[:, sizes > _LEAST * sizes[0]]
        spread = np.arange(_COMPARED) * count // _COMPARED
        sample = np.unique(np.concatenate((spread, _pivots(directions))))
        rates = recorded.rates(_some(self.plan.points, sample))
        weights = np.linalg.lstsq(directions[sample], rates, rcond=None)[0]
        found = directions @ weights
        largest = max(abs(found).max(), abs(rates).max())
        if not abs(found[sample] - rates).max() <= _SIMILAR * largest:
            return None
        found[sample] = rates
        return found


def _pivots(directions: Floats) -> NDArray[np.int64]:
    """A point for each direction, at which no combination of the former ones equals it.

    They are those of the empirical interpolation method (doi:10.1016/j.crma.2004.08.006).
    """
    chosen: list[int] = []
    for number in range(directions.shape[1]):
        former, direction = directions[:, :number], directions[:, number]
        if number:
            direction = direction - former @ np.linalg.solve(former[chosen], direction[chosen])
        chosen.append(int(np.argmax(abs(direction))))
    return np.array(chosen)


def _some(points: Points, numbers: NDArray[np.int64]) -> Points:
    energy = None if points.energy is None else points.energy[numbers]
    return Points(points.position[numbers], points.direction[numbers], energy)
