"""Reports of the progress of a rendering."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = bool | Callable[[int], Any]


@contextmanager
def hook(progress: Progress) -> Iterator[Callable[[int], Any] | None]:
    """What is called with the evaluations so far: a bar of tqdm, the caller's function, nothing."""
    if progress is False or progress is None:
        yield None
    elif progress is True:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            yield None
            return
        with tqdm(desc="emitree", unit=" evaluations", unit_scale=True) as bar:
            yield lambda evaluations: bar.update(evaluations - bar.n)
    else:
        yield progress


class Rising:
    """A hook that is told of larger numbers alone."""

    def __init__(self, hook: Callable[[int], Any]) -> None:
        self.hook = hook
        self.told = 0

    def __call__(self, evaluations: int) -> None:
        """The evaluations so far."""
        if evaluations > self.told:
            self.told = evaluations
            self.hook(evaluations)
