"""Parts of a batch whose workers are slow, or do not respond."""

from __future__ import annotations

import time
from collections.abc import Iterable

from emitree._part_sizes import Cost

#: A part is late if nothing came for this time [s], and for this many times what it should take.
_LATE_SECONDS = 1.0
_LATE_FACTOR = 4.0

#: How often a part is given to another worker.
_MOST_COPIES = 3


class Lateness:
    """Which parts of one batch are late.

    Rates do not depend on the worker, so the first copy of a part that comes is as good as any.
    """

    def __init__(self, cost: Cost) -> None:
        self._cost = cost
        self._last = time.perf_counter()
        self._slowest_start = 0.0
        self._copies: dict[int, int] = {}

    def came(self, made_seconds: float) -> None:
        """A part came, whose worker took this long to make its emission [s]."""
        self._last = time.perf_counter()
        self._slowest_start = max(self._slowest_start, made_seconds)

    def late(self, waiting: Iterable[slice], idle: int) -> list[slice]:
        """Parts to be given to idle workers as well, one at a time if none is known to be idle.

        Then parts may be waiting behind the one that is late.
        """
        seconds = self._cost.seconds_per_point
        if seconds is None:
            return []
        waited = time.perf_counter() - self._last
        found: list[slice] = []
        for part in waiting:
            copies = self._copies.get(part.start, 0)
            expected = seconds * (part.stop - part.start) + self._slowest_start
            patience = 2**copies * max(_LATE_SECONDS, _LATE_FACTOR * expected)
            if copies < _MOST_COPIES and waited > patience and len(found) < max(1, idle):
                self._copies[part.start] = copies + 1
                found.append(part)
        return found
