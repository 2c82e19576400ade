"""Intermediate images, from a rendering in a thread of its own."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from emitree import _executor, _progress
from emitree._function import Floats
from emitree._render import render
from emitree._result import Rendering

#: How often the thread checks whether the loop has ended [s].
_LOOK_SECONDS = 0.05


@dataclass(frozen=True)
class Frame:
    """An intermediate image.

    image, error: (height, width), in the unit of the final image; of a cube, the whole band.
    evaluations, batches: how many it took so far.
    """

    image: Floats
    error: Floats
    evaluations: int
    batches: int


class _Stopped(BaseException):
    """The loop has ended."""


class _Failed:
    """The exception that ended the rendering, of any kind."""

    def __init__(self, error: BaseException) -> None:
        self.error = error


def progressive(*arguments: Any, **options: Any) -> Iterator[Frame | Rendering]:
    """Intermediate images, coarse first, and the `Rendering` at the end; arguments as of `render`.

    Only method "vol" has intermediate images: another is refused. The rendering runs in a thread of
    its own, which also calls the function; it ends when the loop does. An exception that ends the
    rendering, even `SystemExit`, is raised in the loop.

    >>> import emitree
    >>> wave = "1 + sin(5*x) * sin(7*y)"
    >>> *frames, last = emitree.progressive(wave, emitree.Canonical(), (16, 16), tolerance=0.001)
    >>> [frame.image.shape for frame in frames[:1]], last.converged
    ([(16, 16)], True)
    """
    images: queue.Queue[Any] = queue.Queue(maxsize=1)
    stop = threading.Event()

    def still_wanted() -> None:
        # When the program ends, an abandoned loop is not closed.
        if stop.is_set() or not threading.main_thread().is_alive():
            raise _Stopped

    def put(item: Any) -> None:
        while True:
            still_wanted()
            with suppress(queue.Full):
                return images.put(item, timeout=_LOOK_SECONDS)

    def progress(evaluations: int) -> None:
        still_wanted()
        if tell is not None:
            tell(evaluations)

    def frame(*image: Any) -> None:
        put(Frame(*image))

    def work() -> None:
        _executor.still_wanted.set(still_wanted)
        with suppress(_Stopped):
            try:
                put(render(*arguments, **options, progress=progress, frame=frame))
            except BaseException as error:
                put(_Failed(error))

    with _progress.hook(options.pop("progress", False)) as tell:
        worker = threading.Thread(target=work, name="emitree")
        worker.start()
        try:
            item: Any = None
            while not isinstance(item, Rendering):
                item = images.get()
                if isinstance(item, _Failed):
                    raise item.error
                yield item
        finally:
            stop.set()
            # The collector of garbage may close an abandoned loop in any thread.
            if threading.current_thread() is not worker:
                worker.join()
