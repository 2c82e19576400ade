"""The times of an image: the table `[time]` of a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _units
from emitree._function import Floats
from emitree._native import SceneError

#: The first number of steps in which the path of an observer is sampled, and the largest.
_FIRST_STEPS, _MOST_STEPS = 4, 2048
#: How far the path between samples may be from the observer's, relative to the length of the path.
_PATH_ERROR = 1e-8


@dataclass(frozen=True)
class Exposure:
    """When an image is exposed, and how the observer moves meanwhile: `render(..., exposure=...)`.

    The emission is a function f(position, direction, time [s]) -> rates, or a formula with `t`.
    Pixels are means over the exposure: of one bin an image, of more a cube (bins, height, width).

    start, stop: the ends [s], numbers or quantities.
    bins: how many there are between them, each the mean over its times.
    observer: how the observer moves: a function f(time) -> position (3,), or -> (position, target),
        of one time [s], smooth; or a tuple (times (n,), positions (n, 3)) or (times, positions,
        targets), with cubic polynomials between them. Without targets the camera does not turn.
        The camera's own `position` and `target` say nothing then but which way is up, and what a
        camera without targets looks at.
    velocity: (3,), instead: from the camera's position at `start`, in lengths per second.
    light_travel_time: whether the emission, and the absorption, are those of the time at which the
        light that is seen was there: the time minus the distance to the observer, over the speed of
        light; of parallel lines of sight the distance to the plane of the image. It needs the
        camera's `length_unit`. Aberration is ignored.
    snapshots: whether the image is the mean of many images of cameras that do not move, at the
        nodes of a quadrature whose order is doubled until the tolerance is met. It takes more
        evaluations, but also bounds and bodies that do not move with the observer.

    >>> import emitree
    >>> camera = emitree.Orthographic(
    ...     position=(0, 0, 5), target=(0, 0, 0), up=(0, 1, 0), extent=(6, 6), far=10
    ... )
    >>> exposure = emitree.Exposure(0, 2)
    >>> trail = emitree.render("exp(-((x - t)^2 + y^2 + z^2))", camera, (32, 32), exposure=exposure)
    >>> trail.image.shape, trail.converged
    ((32, 32), True)
    >>> def blob(position, direction, time):
    ...     return np.exp(-(position**2).sum(axis=1))
    >>> moving = emitree.Exposure(0, 2, velocity=(-1, 0, 0))
    >>> same = emitree.render(blob, camera, (32, 32), exposure=moving)
    >>> bool(abs(same.image - trail.image).max() < 0.02 * trail.image.max())
    True
    """

    start: Any
    stop: Any
    bins: int = 1
    observer: Callable[[float], Any] | Sequence[Any] | None = None
    velocity: Any = None
    light_travel_time: bool = False
    snapshots: bool = False

    @property
    def range_s(self) -> tuple[float, float]:
        """The start and the end [s]."""
        ends = [_number(getattr(self, name), f"exposure.{name}") for name in ("start", "stop")]
        return ends[0], ends[1]

    @property
    def moves(self) -> bool:
        """Whether the observer moves."""
        return self.observer is not None or self.velocity is not None

    def table(self, length_unit: str | None) -> dict[str, Any]:
        """The keys of a scene, lengths in `length_unit`."""
        start, stop = self.range_s
        table: dict[str, Any] = {"start": start, "stop": stop, "bins": self.bins}
        if self.light_travel_time:
            table["light_travel_time"] = True
        if self.observer is not None and self.velocity is not None:
            raise SceneError("`exposure` has an `observer` and a `velocity`: expected one of them")
        if self.velocity is not None:
            unit = None if length_unit is None else f"{length_unit} s-1"
            velocity = _units.value_in(self.velocity, unit, "exposure.velocity")
            table["observer"] = {"velocity": _units.plain(velocity)}
        if self.observer is not None:
            table["observer"] = self._path_table(length_unit)
        return table

    def path(self, length_unit: str | None) -> tuple[Floats, Floats, Floats | None]:
        """The observer at times: times (n,), positions (n, 3), and targets (n, 3) if it turns."""
        if callable(self.observer):
            return _sampled(self.observer, self.range_s, length_unit)
        return _given_path(self.observer, length_unit)

    def _path_table(self, length_unit: str | None) -> dict[str, Any]:
        times, positions, targets = self.path(length_unit)
        table = {"times": times.tolist(), "positions": positions.tolist()}
        if targets is not None:
            table["targets"] = targets.tolist()
        return table


def exposure_table(exposure: Any, length_unit: str | None) -> dict[str, Any] | None:
    """The table `[time]` of an exposure."""
    if exposure is None:
        return None
    return checked_exposure(exposure).table(length_unit)


def checked_exposure(exposure: Any) -> Exposure:
    """An exposure; of anything else an error."""
    if isinstance(exposure, Exposure):
        return exposure
    raise SceneError(
        f"`exposure` is {type(exposure).__name__}: expected emitree.Exposure(start, stop), in "
        "seconds"
    )


def _number(value: Any, name: str) -> float:
    plain = _units.value_in(value, "s", name)
    try:
        return float(plain)
    except (TypeError, ValueError):
        raise SceneError(f"`{name}` is {value!r}: expected a time in seconds") from None


def _given_path(path: Any, length_unit: str | None) -> tuple[Floats, Floats, Floats | None]:
    """The arrays of a path, checked."""
    if not (isinstance(path, tuple | list) and len(path) in (2, 3)):
        raise SceneError(
            f"`exposure.observer` is {type(path).__name__}: expected a function of the time, or "
            "(times, positions) or (times, positions, targets)"
        )
    units = ["s", length_unit, length_unit]
    names = ["times", "positions", "targets"]
    arrays = []
    for values, unit, name in zip(path, units, names, strict=False):
        name = f"exposure.observer {name}"
        try:
            array = np.asarray(_units.value_in(values, unit, name), dtype=np.float64)
        except (TypeError, ValueError) as error:
            if isinstance(error, SceneError):
                raise
            raise SceneError(f"`{name}` is no array of numbers: expected one") from None
        arrays.append(array)
    times = arrays[0]
    for array, name in zip(arrays, names, strict=False):
        expected = (len(times),) if name == "times" else (len(times), 3)
        if array.shape != expected:
            raise SceneError(
                f"`exposure.observer` {name} have the shape {array.shape}: expected {expected}"
            )
    return times, arrays[1], arrays[2] if len(arrays) == 3 else None


def _sampled(
    observer: Callable[[float], Any], ends: tuple[float, float], length_unit: str | None
) -> tuple[Floats, Floats, Floats | None]:
    """A function as a path: samples are doubled until those between are where they should be."""
    steps = _FIRST_STEPS
    times = np.linspace(*ends, steps + 1)
    points = [_observed(observer, time, length_unit) for time in times.tolist()]
    while True:
        between = 0.5 * (times[1:] + times[:-1])
        new = [_observed(observer, time, length_unit) for time in between.tolist()]
        kinds = {len(point) for point in [*points, *new]}
        if len(kinds) > 1:
            raise SceneError(
                "`exposure.observer` returns a target at some times alone: expected one always, or "
                "never"
            )
        given, found = np.array(points), np.array(new)
        guessed = np.stack([_interpolated(times, of, between) for of in given.swapaxes(0, 1)], 1)
        extent = np.linalg.norm(np.diff(given, axis=0), axis=2).sum(axis=0).max()
        error = np.linalg.norm(guessed - found, axis=2).max()
        order = np.argsort(np.concatenate([times, between]), kind="stable")
        times = np.concatenate([times, between])[order]
        points = [[*points, *new][place] for place in order]
        steps *= 2
        if error <= _PATH_ERROR * extent:
            break
        if steps > _MOST_STEPS:
            raise SceneError(
                f"`exposure.observer` is not smooth: in {steps // 2} steps it is {error:.3g} from "
                f"the path through its samples, which is {extent:.6g} long; expected a smooth "
                "function, or (times, positions)"
            )
    path = np.array(points)
    return times, path[:, 0], path[:, 1] if path.shape[1] == 2 else None


def _observed(
    observer: Callable[[float], Any], time: float, length_unit: str | None
) -> list[list[float]]:
    """The position, and the target if there is one, at a time."""
    found = observer(time)
    is_pair = isinstance(found, tuple | list) and len(found) == 2
    pair = list(found) if is_pair else [found]
    name = "exposure.observer"
    try:
        points = [
            np.asarray(_units.value_in(point, length_unit, name), dtype=np.float64)
            for point in pair
        ]
    except (TypeError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        points = []
    if not is_pair and len(points) == 1 and points[0].shape == (2, 3):
        points = list(points[0])
    if not points or any(p.shape != (3,) or not np.isfinite(p).all() for p in points):
        raise SceneError(
            f"`exposure.observer` returns {found!r} at {time:g} s: expected a position (3,), or a "
            "pair (position, target), finite numbers"
        )
    return [point.tolist() for point in points]


def _interpolated(times: Floats, points: Floats, at: Floats) -> Floats:
    """Cubic polynomials between points, as scenes have them between those of a path."""
    count = min(len(times), 5)
    velocities = np.empty_like(points)
    for node in range(len(times)):
        first = min(max(node - count // 2, 0), len(times) - count)
        nodes, here = times[first : first + count], node - first
        weights = np.array([_weight(nodes, other, here) for other in range(count)])
        velocities[node] = weights @ (points[first : first + count] - points[node])
    piece = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    step = (times[piece + 1] - times[piece])[:, np.newaxis]
    s = (at - times[piece])[:, np.newaxis] / step
    p, q, v, w = points[piece], points[piece + 1], velocities[piece], velocities[piece + 1]
    along = s * (1 - s) ** 2 * v + s**2 * (s - 1) * w
    return p + s**2 * (3 - 2 * s) * (q - p) + step * along


def _weight(nodes: Floats, other: int, here: int) -> float:
    """The weight of a node in the derivative at another one of the polynomial through all."""
    if other == here:
        return 0.0
    others = [n for n in range(len(nodes)) if n not in (other, here)]
    product = np.prod((nodes[here] - nodes[others]) / (nodes[other] - nodes[others]))
    return float(product / (nodes[other] - nodes[here]))
