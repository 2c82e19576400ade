"""The mean over an exposure of images of cameras that do not move, with its error.

The nodes are those of Clenshaw and Curtis (1960), which are among those of twice the order: the
difference between the two orders, in each pixel, is the estimated error of the quadrature.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from emitree import _native, _units
from emitree._emissions import Expression, Model, Tree
from emitree._exposure import Exposure, _interpolated
from emitree._function import Floats
from emitree._grid import Grid
from emitree._result import Rendering

#: In a vacuum [m s-1], exact since 1983.
_SPEED_OF_LIGHT = 299_792_458.0
#: The orders of the quadrature: the number of its steps.
_FIRST_ORDER, _MOST_ORDER = 4, 256
#: The share of the tolerance that the images have; the quadrature has the rest.
_SHARE_OF_IMAGES = 0.5
#: Keywords of `render` that do not go with snapshots.
_REFUSED = (
    "energy", "instrument", "absorption", "rtol", "atol", "floor", "weights", "mask", "per_band",
    "sums", "cache", "frame", "max_seconds", "rounds", "quantities",
)  # fmt: skip


def refuse_options(options: Mapping[str, Any]) -> None:
    """Refuses keywords that snapshots can't have."""
    for name in _REFUSED:
        if options.get(name) is not None and options[name] is not False:
            raise _native.SceneError(
                f"`{name}` is given with an exposure of snapshots: expected none, or an exposure "
                "without `snapshots`"
            )
    if options.get("method") not in (None, "vol"):
        raise _native.SceneError(
            f'`method` is "{options["method"]}" with an exposure of snapshots: expected "vol", '
            "whose images have a tolerance in the unit of the image"
        )


def mean_of_snapshots(
    emission: Any,
    camera: Any,
    exposure: Exposure,
    length_unit: str | None,
    tolerance: float,
    max_evaluations: int | None,
    rendered: Callable[..., Rendering],
) -> Rendering:
    """The mean over the times of an exposure, to a tolerance, bin by bin.

    rendered: rendered(emission, camera, **options) renders one image.
    """
    cameras = _Cameras(camera, exposure, length_unit)
    start, stop = exposure.range_s
    edges = np.linspace(start, stop, exposure.bins + 1)
    budget = _Budget(max_evaluations)

    def at(time: float, atol: float | None) -> Rendering:
        allowed = {"atol": atol} if atol is not None else {"tolerance": 0.5 * tolerance}
        limit = {} if budget.left is None else {"max_evaluations": max(budget.left, 1)}
        camera = cameras.at(time)
        frozen = _at_time(emission, time, camera, exposure, length_unit)
        found = rendered(frozen, camera, **allowed, **limit)
        budget.spend(found)
        return found

    bins = [_Bin(low, high, at) for low, high in pairwise(edges)]
    largest = max(float(np.nanmax(abs(of.image))) for of in bins)
    for of in bins:
        largest = max(largest, of.refine(tolerance, largest, budget))
    return _combined(bins, exposure, budget, tolerance)


class _Budget:
    """Evaluations, batches and seconds of all images, and how many evaluations are left."""

    def __init__(self, most: int | None) -> None:
        self.most = most
        self.evaluations = self.batches = 0
        self.seconds = self.emission_seconds = 0.0

    @property
    def left(self) -> int | None:
        return None if self.most is None else self.most - self.evaluations

    @property
    def is_spent(self) -> bool:
        return self.left is not None and self.left <= 0

    def spend(self, found: Rendering) -> None:
        self.evaluations += found.evaluations
        self.batches += found.report["batches"]
        self.seconds += found.report["seconds"]["total"]
        self.emission_seconds += found.report["seconds"]["emission"]


class _Bin:
    """One bin of an exposure: images at the nodes of a quadrature."""

    def __init__(
        self, low: float, high: float, at: Callable[[float, float | None], Rendering]
    ) -> None:
        self.low, self.high, self._at = low, high, at
        self.order = _FIRST_ORDER
        self.images: dict[float, Rendering] = {}
        self._render(None)

    def _nodes(self, order: int) -> list[float]:
        # Each node is the same number at all orders.
        places = [0.5 - 0.5 * float(np.cos(np.pi * (k / order))) for k in range(order + 1)]
        return [self.low + (self.high - self.low) * place for place in places]

    def _render(self, atol: float | None) -> None:
        for time in self._nodes(self.order):
            if time not in self.images:
                self.images[time] = self._at(time, atol)

    def _mean(self, of: Callable[[Rendering], Floats], order: int) -> Floats:
        weights = clenshaw_curtis(order)
        nodes = self._nodes(order)
        found = [w * of(self.images[t]) for w, t in zip(weights, nodes, strict=True)]
        return np.sum(found, axis=0)

    @property
    def image(self) -> Floats:
        """The mean (height, width)."""
        return self._mean(lambda found: found.image, self.order)

    @property
    def of_images(self) -> Floats:
        """The error that the images have in the mean (height, width)."""
        return self._mean(_error_of, self.order)

    @property
    def of_quadrature(self) -> Floats:
        """The difference between the two orders (height, width)."""
        return abs(self.image - self._mean(lambda found: found.image, self.order // 2))

    @property
    def error(self) -> Floats:
        """The estimated error of the mean (height, width)."""
        return self.of_images + self.of_quadrature

    def refine(self, tolerance: float, largest: float, budget: _Budget) -> float:
        """Doubles the order until the tolerance is met; the largest |pixel|."""
        while not budget.is_spent:
            largest = max(largest, float(np.nanmax(abs(self.image))))
            allowed = tolerance * largest
            atol = _SHARE_OF_IMAGES * allowed
            if np.nanmax(self.of_quadrature) > allowed - atol:
                if self.order >= _MOST_ORDER:
                    break
                self.order *= 2
                self._render(atol if atol > 0 else None)
            elif np.nanmax(self.of_images) > atol > 0:
                coarse = [t for t, of in self.images.items() if np.nanmax(_error_of(of)) > atol]
                if not coarse:
                    break
                for time in coarse:
                    self.images[time] = self._at(time, atol)
            else:
                break
        return largest


def _error_of(found: Rendering) -> Floats:
    return np.zeros_like(found.image) if found.error is None else found.error


def clenshaw_curtis(order: int) -> Floats:
    """Weights (order + 1,) of a mean over an interval at cos(pi k / order), for an even order.

    >>> clenshaw_curtis(2) * 6
    array([1., 4., 1.])
    """
    k = np.arange(order + 1)
    weights = np.ones(order + 1)
    for j in range(1, order // 2 + 1):
        half = 1.0 if 2 * j == order else 2.0
        weights -= half * np.cos(2 * np.pi * j * k / order) / (4 * j * j - 1)
    weights[[0, -1]] *= 0.5
    return weights / order


@dataclass(frozen=True)
class _Cameras:
    """The camera at each time of an exposure."""

    camera: Any
    exposure: Exposure
    length_unit: str | None

    def at(self, time: float) -> Any:
        exposure, camera = self.exposure, self.camera
        if not exposure.moves:
            return camera
        position = self._of("position")
        has_target = hasattr(camera, "target")
        pointing = self._of("target") - position if has_target else None
        if exposure.velocity is not None:
            table = exposure.table(self.length_unit)
            velocity = np.asarray(table["observer"]["velocity"], dtype=np.float64)
            position, target = position + velocity * (time - exposure.range_s[0]), None
        else:
            times, positions, targets = exposure.path(self.length_unit)
            here = np.array([time])
            position = _interpolated(times, positions, here)[0]
            target = None if targets is None else _interpolated(times, targets, here)[0]
        moved: dict[str, Any] = {"position": position.tolist()}
        if has_target:
            assert pointing is not None
            moved["target"] = (position + pointing if target is None else target).tolist()
        return replace(camera, **moved)

    def _of(self, name: str) -> Floats:
        value = _units.value_in(getattr(self.camera, name), self.length_unit, name)
        return np.asarray(value, dtype=np.float64)


def _at_time(
    emission: Any, time: float, camera: Any, exposure: Exposure, length_unit: str | None
) -> Any:
    """An emission at a time, seen by a camera."""
    if isinstance(emission, str):
        emission = Expression(emission)
    if isinstance(emission, Expression):
        if exposure.light_travel_time:
            raise _native.SceneError(
                "`exposure.light_travel_time` is given with `snapshots` and a formula: expected a "
                "function f(position, direction, time), or no `snapshots`"
            )
        names = emission.constants or {}
        return Expression(f"({emission.text}) + 0*t", {**names, "t": time})
    if isinstance(emission, Grid | Model | Tree):
        return emission
    return _Frozen(emission, time, *_retardation(camera, exposure, length_unit))


def _retardation(
    camera: Any, exposure: Exposure, length_unit: str | None
) -> tuple[Floats | None, Floats | None, float]:
    """The observer, the direction forward of parallel lines, and the speed of light."""
    if not exposure.light_travel_time:
        return None, None, np.inf
    if length_unit is None:
        raise _native.SceneError("`exposure.light_travel_time` needs the camera's `length_unit`")
    metre = float((1.0 * _units.to_astropy(length_unit)).to_value("m"))
    of = {
        name: np.asarray(_units.value_in(getattr(camera, name), length_unit, name), dtype=float)
        for name in ("position", "target")
        if hasattr(camera, name)
    }
    forward = None
    if hasattr(camera, "extent"):
        forward = of["target"] - of["position"]
        forward = forward / np.linalg.norm(forward)
    return of["position"], forward, _SPEED_OF_LIGHT / metre


@dataclass(frozen=True)
class _Frozen:
    """A function of position, direction and time, at the time at which an observer sees it."""

    function: Callable[..., Any]
    time: float
    observer: Floats | None
    forward: Floats | None
    speed: float

    def __call__(self, position: Any, direction: Any) -> Any:
        times = np.full(len(position), self.time)
        if self.observer is not None:
            apart = np.asarray(position) - self.observer
            far = np.linalg.norm(apart, axis=1) if self.forward is None else apart @ self.forward
            times = times - far / self.speed
        return self.function(position, direction, times)


def _combined(bins: list[_Bin], exposure: Exposure, budget: _Budget, tolerance: float) -> Rendering:
    """The result of all bins, with the account of the first image."""
    values = np.stack([of.image for of in bins])
    errors = np.stack([of.error for of in bins])
    first = next(iter(bins[0].images.values()))
    kind, (account, _, _, evaluations, *_) = first._found.__reduce__()
    counts = sum(np.asarray(of.evaluations_per_pixel) for one in bins for of in one.images.values())
    start, stop = exposure.range_s
    largest = float(np.nanmax(abs(values)))
    estimated = float(np.nanmax(errors)) / largest if largest > 0 else 0.0
    is_met = all(of.converged for one in bins for of in one.images.values())
    table = json.loads(account)
    exposed = {
        "start": start,
        "stop": stop,
        "bins": exposure.bins,
        "observer_moves": exposure.moves,
        "light_travel_time": exposure.light_travel_time,
    }
    many = {"min": start, "max": stop, "unit": "s", "bins": exposure.bins, "scale": "linear"}
    images = sum(len(one.images) for one in bins)
    table |= {
        "evaluations": budget.evaluations,
        "batches": budget.batches,
        "total_seconds": budget.seconds,
        "emission_seconds": budget.emission_seconds,
        "estimated_error": estimated,
        "error_over_allowed": estimated / tolerance,
        "tolerance": tolerance,
        "by_pixel": None,
        "ending": "complete" if estimated <= tolerance and is_met else "budget",
        "energies": images,
        "exposed": exposed,
        "bins": many if exposure.bins > 1 else None,
        "band_unit": table["unit"],
        "band_factor": 1.0 / (stop - start),
        "overrides": [
            *table["overrides"],
            f"the mean of {images} images like this one, from {start} s to {stop} s",
        ],
    }
    counts = np.broadcast_to(counts, evaluations.shape[1:])[np.newaxis]
    found = kind(json.dumps(table), values, errors, np.ascontiguousarray(counts), None)
    return Rendering(found, json.loads(found.report()))
