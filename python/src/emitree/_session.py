"""A rendering in ask-and-tell form: the caller has the loop."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any

from emitree import _native, _units
from emitree._cameras import Camera
from emitree._function import Floats, as_rates
from emitree._plan import Plan
from emitree._points import Points
from emitree._result import Rendering
from emitree._session_cache import Stored
from emitree._setup import OF_VIEW, Setup, scene_of_camera

#: Keywords of `render` that set how a view is rendered: `resume` may change them.
_OF_METHOD = frozenset(
    [
        "tolerance",
        "rtol",
        "atol",
        "floor",
        "weights",
        "mask",
        "per_band",
        "sums",
        "method",
        "max_evaluations",
        "max_seconds",
        "rounds",
        "smallest_feature",
        "base_level",
        "order",
        "finest_level",
        "rule",
        "threshold",
        "lines",
        "steps",
    ]
)

#: Keywords of `render` that a session takes.
SESSION_OPTIONS = (OF_VIEW - {"absorption"}) | _OF_METHOD


class Session:
    """One rendering that is held between its batches, for any way of evaluating an emission.

    `ask` gives points, `tell` takes their rates; `rendering()` has the latest image, which only
    method "vol" has before the end. A session that has ended can be continued with `resume`: no
    point is evaluated twice, and the result is, bit by bit, that of the new options at once.

    camera, shape: as of `render`.
    cache: a folder that keeps each point and its rate, as of `render`: `ask` gives no point that is
        there. A process that is started later, with the same arguments or another tolerance, goes
        on where the last one ended; `close` it, or use the session in `with`.
    options: keywords of `render` that define the rendering: tolerance, rtol, atol, floor, weights,
        mask, per_band, sums, method, max_evaluations, max_seconds, rounds, smallest_feature,
        energy, exposure, unit, image_unit, quantity, bounds, occulters, edges, singularities,
        seeds, instrument, and the options of the methods.

    >>> import emitree, numpy as np
    >>> session = emitree.Session(emitree.Canonical(), (16, 16), tolerance=0.01)
    >>> while points := session.ask():
    ...     session.tell(np.exp(-100 * ((points.position - 0.5) ** 2).sum(axis=1)))
    >>> coarse = session.rendering()
    >>> session.resume(tolerance=1e-6)
    >>> while points := session.ask():
    ...     session.tell(np.exp(-100 * ((points.position - 0.5) ** 2).sum(axis=1)))
    >>> fine = session.rendering()
    >>> fine.converged and coarse.evaluations < fine.evaluations
    True
    """

    def __init__(
        self,
        camera: Camera,
        shape: Sequence[int] | int,
        *,
        cache: str | os.PathLike[str] | None = None,
        **options: Any,
    ) -> None:
        refuse_unknown(options, SESSION_OPTIONS)
        self._camera = camera
        self._shape = shape
        self._options = options
        scene = self._scene(shape, options)
        self._native = _native.Session(scene)
        self._stored = None if cache is None else Stored(self._native, scene, cache, self._unit)

    @property
    def _unit(self) -> str | None:
        return _units.to_text(self._options.get("unit"))

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the cache, which another process may use then."""
        if self._stored is not None:
            self._stored.close()

    def _scene(self, shape: Sequence[int] | int, options: Mapping[str, Any]) -> _native.Scene:
        return scene_of_camera(_told, self._camera, shape, options)

    def ask(self) -> Points | None:
        """The points at which rates are needed next; None once the rendering has ended."""
        if self._stored is not None:
            return self._stored.ask()
        asked = self._native.ask()
        return Points(*asked) if asked is not None else None

    def tell(self, rates: Any) -> None:
        """Takes the rates (n,) at the points of `ask`, in `unit`, and continues to the next points.

        Raises `ValueError` if there are not as many rates as points, `EmissionError` if one is not
        finite: then the session still waits for them.
        """
        stored = self._stored
        count = self._native.waits_for() if stored is None else stored.waits_for()
        if count is None:
            raise ValueError("rates were given: expected none, as the session waits for no rates")
        given = as_rates(rates, count, self._unit)
        if stored is None:
            self._native.tell(given)
        else:
            stored.tell(given)

    def resume(self, shape: Sequence[int] | int | None = None, **options: Any) -> None:
        """Continues to a tighter tolerance, to more pixels, or with a larger budget.

        Points that `ask` returned before are void; if it fails the session is as it was.

        shape: of the new image; as it is by default.
        options: those of the method and its limits; others stay as they are.
        """
        refuse_unknown(options, _OF_METHOD)
        shape = self._shape if shape is None else shape
        changed = self._options | options
        self._native.resume(self._scene(shape, changed))
        self._shape, self._options = shape, changed
        if self._stored is not None:
            self._stored.advance()

    def rendering(self) -> Rendering | None:
        """The rendering so far; None if there is no image yet.

        Before the rendering has ended it is the latest intermediate image, which has not converged.
        """
        found = self._native.rendering()
        if found is None:
            return None
        return Rendering(found, json.loads(found.report()), self._setup())

    def _setup(self) -> Setup:
        return Setup(self._camera, self._shape, self._options)

    def mesh(self) -> Plan:
        """The plan of a session that has ended, which evaluates nothing again.

        Raises `ValueError` before the end, `RenderError` if there is no mesh: the session depends
        on its time limit, or its image is that of surfaces found, which is not linear in the rates.
        """
        setup = self._setup()
        return Plan.of_mesh(self._native.mesh(), setup, setup.unit)


def _told(position: Floats, direction: Floats) -> Floats:
    """A placeholder for the emission, whose rates `tell` takes."""
    raise NotImplementedError


def refuse_unknown(options: Mapping[str, Any], known: frozenset[str]) -> None:
    """Raises `TypeError` if an option is not one of those that are known."""
    for name in options:
        if name not in known:
            raise TypeError(f"unknown option `{name}`: expected one of {', '.join(sorted(known))}")
