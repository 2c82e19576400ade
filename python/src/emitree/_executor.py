"""Batches divided over workers: threads, processes, clusters."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import closing
from contextvars import ContextVar
from typing import Any

from emitree._call_times import measure, seconds_per_call
from emitree._engines import engine_of
from emitree._function import Floats, Function
from emitree._late import Lateness
from emitree._on_workers import OnWorkers
from emitree._part_sizes import Cost, parts_of

#: How often a rendering that waits for workers checks whether it was cancelled [s].
_LOOK_SECONDS = 0.2

#: A batch with more points than this for each worker begins with a few points for each, if the time
#: of a point is unknown.
_LARGE, _FIRST = 256, 16

#: Raises an exception if the rendering was cancelled; set in the thread of that rendering.
still_wanted: ContextVar[Callable[[], None] | None] = ContextVar("still_wanted", default=None)

#: Some of the points of a batch, and their rates.
Part = tuple[slice, Floats]


class Serial:
    """All points of a batch at once, in the thread that called."""

    def __init__(self, function: Function) -> None:
        self.function = function

    def parts(self, position: Floats, direction: Floats, energy: Floats | None) -> Iterator[Part]:
        """The rates of all points."""
        yield slice(0, len(position)), self.function(position, direction, energy)


class Shared:
    """Parts of a batch for the workers of an executor.

    Their size follows the time that the points before took, and a part that is late is given to an
    idle worker as well. Which points are evaluated, and what becomes of their rates, depends on
    neither.
    """

    def __init__(self, function: Function, executor: Any) -> None:
        self.function = function
        self.engine = engine_of(executor)
        self.cost = Cost()
        #: Is called with the number of points so far, now and then.
        self.progress: Callable[[int], Any] | None = None
        self._workers = self._batches = self._count_of_parts = 0
        self._repeated = self._points = 0
        self._seconds = 0.0
        self._waited = 0.0

    @property
    def report(self) -> dict[str, Any]:
        """The work of the workers.

        How many there were, the batches, their parts, how many of these were given to a second
        worker, the time that calls took, of all workers together, and the time of the batches [s].
        """
        return {
            "workers": self._workers,
            "batches": self._batches,
            "parts": self._count_of_parts,
            "repeated": self._repeated,
            "seconds": self._seconds,
            "waited": self._waited,
        }

    def parts(self, position: Floats, direction: Floats, energy: Floats | None) -> Iterator[Part]:
        """The rates of each part, as they come."""
        start = time.perf_counter()
        workers = self.engine.workers()
        self._workers = max(self._workers, workers)
        count = len(position)
        # The time of a point is unknown, and too much may depend on it.
        is_large = self.cost.seconds_per_point is None and count > _LARGE * workers
        ends = [_FIRST * workers, count] if is_large else [count]
        try:
            for begin, end in zip([0, *ends[:-1]], ends, strict=True):
                of_some = None if energy is None else energy[begin:end]
                some = (position[begin:end], direction[begin:end], of_some)
                with closing(self._parts(workers, *some)) as parts:
                    for part, rates in parts:
                        yield slice(part.start + begin, part.stop + begin), rates
            self._batches += 1
        finally:
            self._waited += time.perf_counter() - start

    def _parts(
        self, workers: int, position: Floats, direction: Floats, energy: Floats | None
    ) -> Generator[Part, None, None]:
        done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        futures: dict[Future[Any], slice] = {}
        waiting: dict[int, slice] = {}

        def submit(part: slice, is_late: bool = False) -> None:
            of_part = None if energy is None else energy[part]
            arguments = (position[part], direction[part], of_part)
            submit_to = self.engine.submit_again if is_late else self.engine.submit
            future = submit_to(emission_rates, self.function, *arguments)
            futures[future] = part
            future.add_done_callback(done.put)

        try:
            if self.cost.seconds_per_point is not None:
                # Now workers have imported what they need.
                measure(self.engine, _next)
            costs = self.cost.seconds_per_point, seconds_per_call(self.engine)
            for part in parts_of(len(position), workers, *costs):
                waiting[part.start] = part
                submit(part)
            self._count_of_parts += len(waiting)
            lateness = Lateness(self.cost)
            while waiting:
                future = _next(done)
                if future is None:
                    for part in lateness.late(waiting.values(), workers - len(futures)):
                        self._repeated += 1
                        submit(part, is_late=True)
                    continue
                part = futures.pop(future)
                if part.start not in waiting:
                    # Another copy of it was faster.
                    self.engine.cancel([future])
                    continue
                rates, seconds, made_seconds = self.engine.result(future)
                del waiting[part.start]
                self._count(part.stop - part.start, seconds)
                lateness.came(made_seconds)
                yield part, rates
        except BrokenExecutor as error:
            error.add_note(
                "emitree: a worker was lost, and with it this executor; with `cache` the same call "
                "goes on with another one from the points that were evaluated"
            )
            raise
        except CancelledError as error:
            error.add_note(
                "emitree: parts of a batch were called off, but not by this rendering: by "
                "`shutdown` of the executor, or a restart of the cluster"
            )
            raise
        finally:
            # After an exception the others are not needed.
            self.engine.cancel(futures)

    def _count(self, points: int, seconds: float) -> None:
        self.cost.add(seconds, points)
        self._seconds += seconds
        self._points += points
        if self.progress is not None:
            self.progress(self._points)


def _next(done: queue.SimpleQueue[Future[Any]]) -> Future[Any] | None:
    """The next future that is done; None after a while, without waiting after a cancellation."""
    wanted = still_wanted.get()
    if wanted is not None:
        wanted()
    try:
        return done.get(timeout=_LOOK_SECONDS)
    except queue.Empty:
        return None


def emission_rates(
    function: Function, position: Floats, direction: Floats, energy: Floats | None
) -> tuple[Floats, float, float]:
    """The rates of a part, how long they took, and how long the emission took to be made [s].

    This is what a worker does; clusters show it by its name.
    """
    start = time.perf_counter()
    if isinstance(function.function, OnWorkers):
        function.function.function()
    made = time.perf_counter()
    rates = function(position, direction, energy)
    return rates, time.perf_counter() - made, made - start
