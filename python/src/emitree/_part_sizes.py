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
    workers end at about the same time, whatever the time of a point. No part takes less than
    `_least_seconds`.

    seconds_per_part: the time in which a part is sent, and its rates are received [s].
    """
    start = 0
    while start < count:
        left = count - start
        if seconds_per_point is None:
            size = math.ceil(math.ceil(count / workers) / 4)
        else:
            least_seconds = _least_seconds(count * seconds_per_point, workers, seconds_per_part)
            limits = (least_seconds, max(_MOST_SECONDS, least_seconds))
            least, most = (max(1, int(limit / seconds_per_point)) for limit in limits)
            size = min(max(math.ceil(left / (2 * workers)), least), most)
        yield slice(start, start + min(size, left))
        start += min(size, left)


def _least_seconds(work_seconds: float, workers: int, seconds_per_part: float) -> float:
    """The least time of a part [s] of a batch with so much work [s].

    If parts are sent one after the other, p parts take the time p t to be sent, and the last one
    ends the time w / p after that, of the work w: sqrt(w t) for each part is the best. Where
    workers are fewer, they are busy with parts that take as long as one is sent to each.
    """
    sent = math.sqrt(work_seconds * seconds_per_part)
    return max(_LEAST_SECONDS, min(workers * seconds_per_part, sent))
