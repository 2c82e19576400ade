"""A rendering in a thread of its own, which can be stopped, continued and replaced by another."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from emitree import _executor, _native
from emitree._cameras import Camera
from emitree._evaluator import BATCH_SIZE, evaluator
from emitree._function import Floats
from emitree._progressive import Frame
from emitree._render import render
from emitree._result import Rendering
from emitree._setup import Setup, function_in, is_function, scene_of_camera

#: How often an intermediate image is reported at most [s].
_LEAST_PAUSE_S = 0.25

#: The share of the time that reports of intermediate images may take.
_MOST_SHARE = 0.25

#: Keywords of `render` that say how a function is called.
CALL_OPTIONS = ("executor", "quantities", "batch_size", "threads", "cache")


@dataclass(frozen=True)
class Target:
    """What is to be rendered.

    options: keywords of `render` that define the scene and its method.
    """

    camera: Camera
    shape: Sequence[int] | int
    options: Mapping[str, Any]


@dataclass(frozen=True)
class Update:
    """How far a rendering has come.

    phase: "running", "done", "stopped" or "failed".
    latest: its latest image; None if it has none.
    evaluations: how many it took so far.
    error: what ended it, if it failed.
    """

    phase: str
    target: Target
    latest: Rendering | Frame | None
    evaluations: int
    error: BaseException | None = None


class _Stopped(BaseException):
    """The rendering is not wanted any more."""


@dataclass
class _Run:
    """One thread, and what it reports."""

    targets: Sequence[Target]
    stop: threading.Event = field(default_factory=threading.Event)
    thread: threading.Thread | None = None
    latest: Rendering | Frame | None = None
    evaluations: int = 0
    error: BaseException | None = None

    def check(self) -> None:
        """Raises `_Stopped` if the rendering is not wanted any more."""
        if self.stop.is_set() or not threading.main_thread().is_alive():
            raise _Stopped


class Work:
    """Renderings of one emission, one after the other: the newest replaces those before it.

    on_update: is called in the thread of the rendering with each `Update` of the newest one, and
        returns how long to wait before the next intermediate image [s].
    """

    def __init__(
        self, emission: Any, calls: Mapping[str, Any], on_update: Callable[[Update], float]
    ) -> None:
        self.emission = emission
        self._on_update = on_update
        renderer = _BySession if is_function(emission) else _ByRender
        self._renderer = renderer(emission, calls)
        self._lock = threading.Lock()
        self._newest: _Run | None = None

    def start(self, targets: Sequence[Target]) -> None:
        """Renders one target after the other, in place of all that was started before.

        A function is called by one thread at a time: the first call waits for the end of the last
        one before.
        """
        with self._lock:
            former = self._newest
            if former is not None:
                former.stop.set()
            run = _Run(targets)
            run.thread = threading.Thread(target=self._run, args=(run, former), name="emitree")
            self._newest = run
            run.thread.start()

    def stop(self) -> None:
        """Ends the rendering, after the call of a function that is under way."""
        with self._lock:
            if self._newest is not None:
                self._newest.stop.set()

    def wait(self, timeout_s: float | None = None) -> bool:
        """Waits for the end, and returns whether it has come; raises what ended the rendering."""
        until = None if timeout_s is None else time.monotonic() + timeout_s
        while (run := self._current()) is not None and run.thread is not None:
            run.thread.join(None if until is None else max(0.0, until - time.monotonic()))
            if run.thread.is_alive():
                return False
            if run is self._current():
                if run.error is not None:
                    raise run.error
                break
        return True

    def _current(self) -> _Run | None:
        with self._lock:
            return self._newest

    def _run(self, run: _Run, former: _Run | None) -> None:
        if former is not None and former.thread is not None:
            former.thread.join()
            if former.targets[-1].camera is run.targets[0].camera:
                run.latest, run.evaluations = former.latest, former.evaluations
        _executor.still_wanted.set(run.check)
        phase = "done"
        target = run.targets[0]
        try:
            for target in run.targets:
                self._render(run, target)
        except _Stopped:
            phase = "stopped"
        except BaseException as error:
            phase, run.error = "failed", error
        if run is self._current():
            try:
                self._report(run, phase, target)
            except Exception as error:
                run.error = run.error or error

    def _render(self, run: _Run, target: Target) -> None:
        next_s = 0.0

        def report(latest: Callable[[], Rendering | Frame | None], evaluations: int) -> None:
            nonlocal next_s
            run.check()
            run.evaluations = evaluations
            start_s = time.monotonic()
            if start_s >= next_s:
                run.latest = latest() or run.latest
                pause_s = self._report(run, "running", target)
                end_s = time.monotonic()
                next_s = end_s + max(_LEAST_PAUSE_S, pause_s, (end_s - start_s) / _MOST_SHARE)

        run.check()
        run.latest = self._renderer.render(target, run.check, report)
        run.evaluations = run.latest.evaluations
        if target is not run.targets[-1]:
            self._report(run, "running", target)

    def _report(self, run: _Run, phase: str, target: Target) -> float:
        return self._on_update(Update(phase, target, run.latest, run.evaluations, run.error))


#: Is called with a function that returns the latest image, and the evaluations so far.
_Report = Callable[[Callable[[], Rendering | Frame | None], int], None]


class _BySession:
    """Renders a function: a session for each camera, which evaluates no point twice."""

    def __init__(self, function: Any, calls: Mapping[str, Any]) -> None:
        self._function = function
        self._calls = calls
        self._session: _native.Session | None = None
        self._target: Target | None = None
        self._evaluations = 0

    def render(
        self, target: Target, still_wanted: Callable[[], None], report: _Report
    ) -> Rendering:
        session, scene = self._opened(target)
        unit = Setup(target.camera, target.shape, target.options).unit
        quantities = self._calls.get("quantities", False)
        function = function_in(self._function, scene, unit, quantities)

        def latest() -> Rendering | None:
            found = session.rendering()
            return None if found is None else self._rendering(found, target)

        with ExitStack() as stack:
            calls = (self._calls.get(name) for name in ("executor", "cache"))
            evaluated = evaluator(stack, scene, function, *calls)
            assert evaluated is not None, "functions have an evaluator"
            while asked := session.ask():
                parts = []
                for part in self._parts(len(asked[0])):
                    still_wanted()
                    position, direction, energy = asked
                    of_part = None if energy is None else energy[part]
                    parts.append(evaluated.rates(position[part], direction[part], of_part))
                still_wanted()
                session.tell(np.concatenate(parts))
                self._evaluations += len(asked[0])
                report(latest, self._evaluations)
        rendering = latest()
        assert rendering is not None, "a session that has ended has a rendering"
        return rendering

    def _opened(self, target: Target) -> tuple[_native.Session, _native.Scene]:
        """The session of the camera, continued to the target, or a new one."""
        scene = scene_of_camera(self._function, target.camera, target.shape, target.options)
        former = self._target
        if self._session is None or former is None or former.camera is not target.camera:
            self._session, self._evaluations = _native.Session(scene), 0
        elif former is not target:
            self._session.resume(scene)
        self._target = target
        return self._session, scene

    def _parts(self, count: int) -> Iterator[slice]:
        size = self._calls.get("batch_size") or BATCH_SIZE
        return (slice(start, start + size) for start in range(0, count, size))

    def _rendering(self, found: _native.Rendered, target: Target) -> Rendering:
        quantities = self._calls.get("quantities", False)
        setup = Setup(target.camera, target.shape, target.options, quantities)
        return Rendering(found, json.loads(found.report()), setup)


class _ByRender:
    """Renders a formula, a model, a grid or a tree, whose rates cost little: anew each time."""

    def __init__(self, emission: Any, calls: Mapping[str, Any]) -> None:
        for name in ("executor", "quantities", "cache"):
            if calls.get(name):
                raise TypeError(f"`{name}` is for functions: expected none with this emission")
        self._emission = emission
        self._calls = calls

    def render(
        self, target: Target, still_wanted: Callable[[], None], report: _Report
    ) -> Rendering:
        def frame(image: Floats, error: Floats, evaluations: int, batches: int) -> None:
            report(lambda: Frame(image, error, evaluations, batches), evaluations)

        def progress(evaluations: int) -> None:
            still_wanted()
            if not is_by_vol:
                report(lambda: None, evaluations)

        is_by_vol = target.options.get("method") in (None, "vol")
        return render(
            self._emission,
            target.camera,
            target.shape,
            **target.options,
            **self._calls,
            progress=progress,
            frame=frame if is_by_vol else None,
        )
