"""How many points go in one part of a batch, by the time that points took before."""

from __future__ import annotations

import math
from collections.abc import Iterator

#: A part that takes less is not worth sending to another process or machine [s].
_LEAST_SECONDS = 0.002
#: And one that takes more makes others wait for it at the end of a batch [s].
_MOST_SECONDS = 0.5

#: How much of what was measured counts still after another part.
_MEMORY = 0.95


class Cost:
    """The measured time of a point [s]; None before there is one."""

    def __init__(self) -> None:
        self._seconds = 0.0
        self._points = 0.0

    def add(self, seconds: float, points: int) -> None:
        """Takes the time of a part; later ones count more."""
        self._seconds = _MEMORY * self._seconds + seconds
        self._points = _MEMORY * self._points + points

    @property
    def seconds_per_point(self) -> float | None:
        """The mean over points, at least a picosecond."""
        return max(self._seconds / self._points, 1e-12) if self._points else None


def parts_of(
    count: int, workers: int, seconds_per_point: float | None, seconds_per_part: float
) -> Iterator[slice]:
    """Parts of `count` points, one after the other.

    Each has half of the points that are left for a worker: parts become smaller, so that all
    workers end at about the same time, whatever the time of a point. No part is so small that
    others have to wait until theirs is sent.

    seconds_per_part: the time in which a part is sent, and its rates are received [s].
    """
    least_seconds = max(_LEAST_SECONDS, workers * seconds_per_part)
    most_seconds = max(_MOST_SECONDS, least_seconds)
    start = 0
    while start < count:
        left = count - start
        if seconds_per_point is None:
            size = math.ceil(math.ceil(count / workers) / 4)
        else:
            limits = (least_seconds, most_seconds)
            least, most = (max(1, int(limit / seconds_per_point)) for limit in limits)
            size = min(max(math.ceil(left / (2 * workers)), least), most)
        yield slice(start, start + min(size, left))
        start += min(size, left)
