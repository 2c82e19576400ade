"""How long an engine takes to send a call and to receive its result."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import Any
from weakref import WeakKeyDictionary

from emitree._engines import Engine

#: How many calls are sent, and how many of them are waited for: a worker may not respond.
_CALLS, _WAITED_FOR = 32, 24

#: How long it is measured at most [s].
_MOST_SECONDS = 2.0

#: Before it was measured [s].
_GUESS_SECONDS = 3e-4

#: What was measured, by the executor [s].
_known: WeakKeyDictionary[Any, float] = WeakKeyDictionary()


def seconds_per_call(engine: Engine) -> float:
    """The time that each call takes when many are sent [s]; a guess before `measure`."""
    with suppress(TypeError):
        return _known.get(engine.identity, _GUESS_SECONDS)
    return _GUESS_SECONDS


def measure(engine: Engine, wait: Callable[[queue.SimpleQueue[Future[Any]]], Any]) -> None:
    """Measures it by calls that do nothing, once for each executor.

    wait: waits for a while for a future that is done.
    """
    try:
        if engine.identity in _known:
            return
    except TypeError:
        # Without a weak reference it can't be known for longer than it is used.
        return
    done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
    start = time.perf_counter()
    futures = [engine.submit(nothing, None) for _ in range(_CALLS)]
    for future in futures:
        future.add_done_callback(done.put)
    came, seconds = 0, 0.0
    try:
        while came < _WAITED_FOR and seconds < _MOST_SECONDS:
            came += wait(done) is not None
            seconds = time.perf_counter() - start
    finally:
        engine.cancel(futures)
    _known[engine.identity] = seconds / max(came, 1)


def nothing(_: None) -> None:
    """What a worker does to measure the time of a call."""
