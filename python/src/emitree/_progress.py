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
