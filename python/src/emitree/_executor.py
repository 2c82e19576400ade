"""Batches divided over any `concurrent.futures.Executor`: threads, processes, clusters."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, as_completed
from contextvars import ContextVar
from typing import Any

from emitree._function import Floats, Function
from emitree._native import SceneError

#: A part that takes less is not worth sending to another process or machine [s].
_LEAST_SECONDS = 0.002
#: And one that takes more makes others wait for it at the end of a batch [s].
_MOST_SECONDS = 0.5

#: How often a rendering that waits for workers checks whether it was cancelled [s].
_LOOK_SECONDS = 0.2

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

    Their size follows the time that the points before took. Which points are evaluated, and what
    becomes of their rates, does not depend on it.
    """

    def __init__(self, function: Function, executor: Executor) -> None:
        self.function = function
        self.executor = executor
        self.workers = worker_count(executor)
        self.seconds_per_point: float | None = None

    def part_size(self, count: int) -> int:
        """How many of `count` points go in one part."""
        even = math.ceil(count / self.workers)
        if self.seconds_per_point is None:
            return math.ceil(even / 4)
        seconds = max(self.seconds_per_point, 1e-12)
        least, most = (max(1, int(limit / seconds)) for limit in (_LEAST_SECONDS, _MOST_SECONDS))
        return min(max(even, least), most)

    def parts(self, position: Floats, direction: Floats, energy: Floats | None) -> Iterator[Part]:
        """The rates of each part, as they come."""
        size = self.part_size(len(position))
        futures: dict[Future[Any], slice] = {}
        try:
            for start in range(0, len(position), size):
                part = slice(start, min(start + size, len(position)))
                of_part = (None if energy is None else energy[part],)
                arguments = (position[part], direction[part], *of_part)
                futures[self.executor.submit(timed, self.function, *arguments)] = part
            for future in _as_they_come(futures):
                rates, seconds = future.result()
                part = futures[future]
                self.seconds_per_point = seconds / (part.stop - part.start)
                yield part, rates
        finally:
            # After an exception the others are not needed.
            for future in futures:
                future.cancel()


def _as_they_come(futures: Iterable[Future[Any]]) -> Iterator[Future[Any]]:
    """Futures that are done, without waiting after a cancellation."""
    wanted = still_wanted.get()
    waiting = set(futures)
    while waiting:
        done = as_completed(waiting, timeout=_LOOK_SECONDS)
        while True:
            if wanted is not None:
                wanted()
            try:
                future = next(done)
            except StopIteration:
                return
            except TimeoutError:
                break
            waiting.discard(future)
            yield future


def checked(executor: Any) -> Executor:
    """What `executor` stands for: itself, or that of a dask client."""
    if hasattr(executor, "get_executor"):
        # Rates are the same each time, but a pure function would be called once for equal arrays.
        return executor.get_executor(pure=False)
    if not callable(getattr(executor, "submit", None)) or isinstance(executor, type):
        raise SceneError(
            f"`executor` is {executor!r}: expected a concurrent.futures.Executor, which has "
            "`submit`, or a dask.distributed.Client"
        )
    return executor


def timed(
    function: Function, position: Floats, direction: Floats, energy: Floats | None
) -> tuple[Floats, float]:
    """The rates of a part, and how long they took [s]; what a worker does."""
    start = time.perf_counter()
    rates = function(position, direction, energy)
    return rates, time.perf_counter() - start


def worker_count(executor: Any) -> int:
    """How many workers an executor has, as far as it is known."""
    client = getattr(executor, "_client", None)
    if client is not None and hasattr(client, "nthreads"):
        return max(1, sum(client.nthreads().values()))
    workers = getattr(executor, "_max_workers", None)
    return workers if isinstance(workers, int) and workers > 0 else os.cpu_count() or 1
