"""Emissions that worker processes make for themselves, instead of receiving them."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: The emissions of this process by their keys, and the locks under which they are made.
_made: dict[str, Callable[..., Any]] = {}
_locks: dict[str, threading.Lock] = {}
_lock = threading.Lock()


class OnWorkers:
    """A function that each process makes at its first call, and keeps; see `on_workers`."""

    def __init__(
        self, factory: Callable[..., Any], arguments: tuple[Any, ...], options: dict[str, Any]
    ) -> None:
        if not callable(factory):
            raise TypeError(
                f"`factory` is {factory!r}: expected a function that returns the emission"
            )
        #: What makes the emission.
        self.factory = factory
        self._arguments = arguments
        self._options = options
        self._key = uuid.uuid4().hex

    def function(self) -> Callable[..., Any]:
        """The emission of this process."""
        with _lock:
            lock = _locks.setdefault(self._key, threading.Lock())
        with lock:
            if self._key not in _made:
                made = self.factory(*self._arguments, **self._options)
                if not callable(made):
                    name = getattr(self.factory, "__qualname__", repr(self.factory))
                    raise TypeError(f"{name} returned {made!r}: expected a function of arrays")
                _made[self._key] = made
            return _made[self._key]

    def __call__(self, *arrays: NDArray[np.float64]) -> Any:
        """The rates at positions, directions and, of cubes, energies."""
        return self.function()(*arrays)


def on_workers(factory: Callable[..., Any], *arguments: Any, **options: Any) -> OnWorkers:
    """An emission that lives on the workers of an executor: `factory(*arguments, **options)`.

    For models that take long to load, or much memory: each worker process calls the factory before
    its first points, and keeps what it returned, a function as of `render`, until the process ends.
    Only the factory and its arguments are sent. Threads of a process share one function.

    Call `on_workers` once, and render it as often as needed: another call makes another function.

    Raises `TypeError` if the factory is no function, or returns none.

    >>> import emitree, numpy as np
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> def load(width):
    ...     table = np.linspace(0, 1, 1000)  # such as a file of 1 GB
    ...     return lambda position, direction: np.interp(position[:, 0], table, table / width)
    >>> ramp = emitree.on_workers(load, width=0.5)
    >>> with ThreadPoolExecutor(2) as executor:
    ...     found = emitree.render(ramp, emitree.Canonical(), (2, 2), executor=executor)
    >>> found.image.round(3).tolist()
    [[0.5, 1.5], [0.5, 1.5]]
    """
    return OnWorkers(factory, arguments, options)
