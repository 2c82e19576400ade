"""The order of the images of a sweep: which are rendered in full, and which by the plan of another.

Images are taken from the middle outwards, each by the nearest plan. Where that does not suffice,
the next full rendering is half as far again from the middle of that plan. What may be lost, by
plans that do not suffice and by finer plans, is kept below a tenth of all images in full.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _progress
from emitree._cameras import Camera
from emitree._function import Floats
from emitree._plan import Plan
from emitree._recorded import Passed, Recorded
from emitree._render import render
from emitree._result import Rendering
from emitree._search import finer_tolerance, plan_of_products
from emitree._setup import Setup, function_of, is_function
from emitree._shared_plan import SharedPlan

#: The tolerance of plans relative to that of the images: at a quarter the plan of a torus serves
#: three times as many values, for a tenth to a third more evaluations.
_FINER = 0.25
#: The most evaluations of such a plan beyond those of its image, in these.
_MOST_OF_FINER = 0.5
#: The most evaluations of a sweep, in those of all images rendered in full.
_MOST = 1.1
#: The next full rendering after a plan does not suffice: its distance from that plan, in that of
#: the image that failed.
_NEXT = 1.5


@dataclass(frozen=True)
class Images:
    """How all images of a sweep are rendered: arguments as of `render`."""

    camera: Camera
    shape: Sequence[int] | int
    options: Mapping[str, Any]
    executor: Any
    progress: _progress.Progress

    def emission(self, emission: Any) -> Recorded | Passed:
        """An emission whose evaluations are counted, and kept if it is a function of arrays."""
        if not is_function(emission) or self.options.get("quantities"):
            return Passed(emission, self.executor)
        setup = Setup(self.camera, self.shape, self.options)
        function = function_of(emission, setup, setup.unit)
        return Recorded(function, self.executor)

    def full(self, emission: Recorded | Passed, **changes: Any) -> Rendering:
        """The rendering of an emission from nothing."""
        options = {**self.options, **changes}

        def rendered(of: Any, executor: Any) -> Rendering:
            return render(
                of, self.camera, self.shape, executor=executor, progress=self.progress, **options
            )

        return emission.rendered(rendered)

    def finer(self, emission: Recorded, image: Rendering) -> Plan | None:
        """The plan of a finer image, with the options of all; None if there is none."""
        changes, plan = finer_tolerance(self.options, _FINER), plan_of(image)
        if not changes or plan is None:
            return None
        options = {**self.options, **changes}
        most = int((1 + _MOST_OF_FINER) * image.evaluations)
        found = plan_of_products(emission.rates, self.camera, self.shape, options, most)
        return None if found is None else plan.with_points_of(found)


def plan_of(rendering: Rendering) -> Plan | None:
    """The plan of a rendering, if it may serve others."""
    try:
        plan = rendering.plan
    except ValueError:
        return None
    return plan if plan.is_of_products else None


class Emissions:
    """The emissions of all places, each with what is known of its rates."""

    def __init__(self, models: Sequence[Callable[[], Any]]) -> None:
        self._models = models
        self._known: dict[int, Recorded | Passed] = {}

    def __len__(self) -> int:
        return len(self._models)

    def of(self, number: int, images: Images) -> Recorded | Passed:
        """The emission of a place."""
        if number not in self._known:
            self._known[number] = images.emission(self._models[number]())
        return self._known[number]

    def forget(self, number: int) -> None:
        """Drops its rates, which take about 0.3 kB for each point."""
        self._known.pop(number, None)


def swept(
    emissions: Emissions, places: Floats, images: Images, *, is_last: bool = True
) -> tuple[list[Rendering], int]:
    """The renderings of some emissions, and the number of evaluations.

    places: the parameters of the emissions (n, parameters), as fractions of their ranges, in
        lexical order: of equally near ones the first is taken.
    is_last: whether the rates are not needed any more.
    """
    sweep = _Sweep(emissions, places, images, is_last)
    target: Floats | None = np.full(places.shape[1], 0.5)
    while sweep.remaining:
        target = sweep.next(target)
    return [sweep.found[number] for number in range(len(emissions))], sweep.evaluations


class _Sweep:
    def __init__(self, emissions: Emissions, places: Floats, images: Images, is_last: bool) -> None:
        self.emissions = emissions
        self.places = places
        self.images = images
        self.is_last = is_last
        self.remaining = list(range(len(emissions)))
        self.found: dict[int, Rendering] = {}
        self.evaluations = 0
        self.plans: list[SharedPlan] = []
        #: Evaluations of images that were rendered in full.
        self.full: list[int] = []

    def next(self, target: Floats | None) -> Floats | None:
        """Renders one image, in full if it is the nearest to a target; returns the next target."""
        if target is not None:
            self._in_full(self._nearest(target))
            return None
        number, plan = self._nearest_pair()
        if plan is None or not self._may_take(plan.most_evaluations):
            self._in_full(number)
            return None
        emission = self.emissions.of(number, self.images)
        before = emission.evaluations
        found = plan.rendering(emission, self.places[number])
        self.evaluations += emission.evaluations - before
        if found.converged:
            self._done(number, found)
            return None
        plan.failed.append(self.places[number])
        return plan.place + _NEXT * (self.places[number] - plan.place)

    def _in_full(self, number: int) -> None:
        """Renders an image in full, and makes a plan for those around it."""
        emission = self.emissions.of(number, self.images)
        before = emission.evaluations
        found = self.images.full(emission)
        self.full.append(found.evaluations)
        plan = plan_of(found)
        if plan is not None and len(self.remaining) > 1 and isinstance(emission, Recorded):
            spent = emission.evaluations - before
            if self._may_take(spent + int(_MOST_OF_FINER * found.evaluations), but=1):
                plan = self.images.finer(emission, found) or plan
        self.evaluations += emission.evaluations - before
        if plan is not None:
            self.plans.append(SharedPlan(plan, self.places[number], emission))
        self._done(number, found)

    def _done(self, number: int, found: Rendering) -> None:
        self.found[number] = found
        self.remaining.remove(number)
        if self.is_last:
            self.emissions.forget(number)

    def _may_take(self, evaluations: int, but: int = 0) -> bool:
        """Whether all images are within the limit if these evaluations are lost.

        but: how many of the remaining images are among them.
        """
        full = float(np.mean(self.full))
        of_others = full * (len(self.remaining) - but)
        return self.evaluations + evaluations + of_others <= _MOST * full * len(self.emissions)

    def _nearest(self, target: Floats) -> int:
        distances = [_distance(self.places[number], target) for number in self.remaining]
        return self.remaining[int(np.argmin(distances))]

    def _nearest_pair(self) -> tuple[int, SharedPlan | None]:
        """The image and the plan nearest to each other; the first image without a plan."""
        pairs = [
            (_distance(self.places[number], plan.place), number, index)
            for index, plan in enumerate(self.plans)
            for number in self.remaining
            if not plan.fails_before(self.places[number])
        ]
        if not pairs:
            return self.remaining[0], None
        _, number, index = min(pairs)
        return number, self.plans[index]


def _distance(first: Floats, second: Floats) -> float:
    """The distance, without the rounding that makes equal ones different."""
    return round(float(np.linalg.norm(first - second)), 9)
