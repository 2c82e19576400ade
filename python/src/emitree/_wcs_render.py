"""Images of a `WcsCamera`: means over its pixels of an image without distortions."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _units
from emitree._components import Columns, Components
from emitree._function import Floats, Function
from emitree._native import SceneError
from emitree._polygons import Cells, integrals
from emitree._result import Rendering
from emitree._setup import Setup, is_function
from emitree._sky_corners import Corners, Host
from emitree._sky_fits import sky_cards
from emitree._wcs_camera import WcsCamera

#: Keywords of `render` that do not go with the camera.
_REFUSED = (
    "energy", "exposure", "instrument", "rtol", "atol", "floor", "weights", "mask", "per_band",
    "sums", "frame",
)  # fmt: skip
#: The share of the tolerance that the image has; what its cells do not tell has the rest.
_SHARE = 0.7
#: Cells along the longer side of the first image, about; and how many a pixel has along each axis.
_SIDE, _FINER = 512, (2, 8)
#: The most cells of an image. They cost time, some 6 us each, but hardly any evaluations.
_MOST_CELLS = 1 << 22
#: How often an image with smaller cells, or less error, is made.
_ROUNDS = 4


@dataclass(frozen=True)
class _Means:
    """Means over the pixels of a WCS (height, width): values, errors and numbers of evaluations.

    unknown: what the parts of cells that are divided may add, in the error.
    """

    value: Floats
    error: Floats
    unknown: Floats
    evaluations: Floats


def shape_of(camera: WcsCamera, shape: Any) -> tuple[int, int]:
    """The shape of a WCS; refuses another one."""
    assert camera.sky is not None and camera.sky.shape is not None
    own = camera.sky.shape
    if shape is not None and np.asarray(shape).tolist() != list(own):
        raise SceneError(f"`shape` is {shape}, and that of the WCS is {own}: expected none, or it")
    return own


def rendered_by_corners(
    emission: Any,
    camera: WcsCamera,
    shape: Sequence[int] | int | None,
    options: Mapping[str, Any],
    rendered: Callable[..., Any],
) -> Any:
    """The rendering, or the components, of an emission.

    options: keywords of `render`; rendered: rendered(emission, camera, shape, **options).
    """
    for name in _REFUSED:
        if options.get(name) is not None and options[name] is not False:
            raise SceneError(f"`{name}` is given with a `WcsCamera`: expected none")
    if options.get("method") not in (None, "vol"):
        raise SceneError(
            f'`method` is "{options["method"]}" with a `WcsCamera`: expected "vol", whose pixels '
            "have errors"
        )
    if options.get("quantity") not in (None, "radiance"):
        raise SceneError(
            f'`quantity` is "{options["quantity"]}" with a `WcsCamera`: expected "radiance"'
        )
    tolerance = 0.01 if options.get("tolerance") is None else options["tolerance"]
    height, width = shape_of(camera, shape)
    assert camera.sky is not None
    corners = Corners.of(camera)
    given = {key: value for key, value in options.items() if value is not None}
    given.pop("tolerance", None)
    most = given.pop("max_evaluations", None)
    emission = _remembered(emission, given, camera.sky.length_unit)
    cells = int(np.prod(Host.of(camera, corners, 1).shape))
    most_finer = max(int(np.sqrt(_MOST_CELLS / cells)), 1)
    finer = min(int(np.clip(_SIDE // max(height, width), *_FINER)), most_finer)
    # A tolerance that is none is refused as it was given, and so are limits.
    is_number = isinstance(tolerance, int | float) and tolerance > 0.0
    allowed: dict[str, Any] = {"tolerance": _SHARE * tolerance if is_number else tolerance}
    spent, before = 0, np.inf
    seconds, begin = given.pop("max_seconds", None), time.monotonic()
    renderings: list[Rendering] = []
    means: list[_Means] = []
    names = None
    for number in range(_ROUNDS):
        host = Host.of(camera, corners, finer)
        budget: dict[str, Any] = {}
        if most is not None:
            budget["max_evaluations"] = max(most - spent, 1) if number > 0 else most
        if seconds is not None:
            passed = time.monotonic() - begin
            budget["max_seconds"] = max(seconds - passed, 1e-3) if number > 0 else seconds
        found = rendered(emission, host.camera, host.shape, **given, **allowed, **budget)
        spent = (
            emission.evaluations
            if isinstance(emission, _Remembered)
            else (spent + found.evaluations)
        )
        if not found.converged and means:
            # A limit has ended it: the image before is the better one.
            break
        names = found.names if isinstance(found, Components) else None
        renderings = list(found) if isinstance(found, Components) else [found]
        means = [_means(host, one) for one in renderings]
        left = [_beyond(of, tolerance) for of in means]
        is_limited = number + 1 == _ROUNDS or not found.converged
        if all(of_cells <= 1.0 and of_all <= 1.0 for of_cells, of_all, _ in left) or is_limited:
            break
        of_cells = max(of for of, _, _ in left)
        if of_cells > 0.9 * before:
            break
        before = of_cells if of_cells > 1.0 else before
        if of_cells > 1.0:
            # What is unknown beside jumps falls as the square of the sides of cells.
            wanted = int(np.ceil(finer * min(max(1.1 * np.sqrt(of_cells), 1.25), 4.0)))
            if min(wanted, most_finer) <= finer:
                break
            finer = min(wanted, most_finer)
        elif len(left) == 1:
            allowed = {"atol": _SHARE * left[0][2]}
        else:
            allowed = {"tolerance": 0.5 * allowed["tolerance"]}
    made = [
        _rendering(one, of, camera, (height, width), tolerance, options, spent)
        for one, of in zip(renderings, means, strict=True)
    ]
    if not isinstance(found, Components):
        return made[0]
    return Components(tuple(made), spent, names)


def _beyond(means: _Means, tolerance: float) -> tuple[float, float, float]:
    """Errors over those that are allowed: of cells, over what is left for them, and of all.

    Last is the error that is allowed.
    """
    largest = float(np.nanmax(abs(means.value), initial=0.0))
    allowed = tolerance * largest
    if allowed == 0.0:
        return 0.0, 0.0, 0.0
    of_image = means.error - means.unknown
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.maximum(allowed - of_image, 0.1 * allowed)
        of_cells = float(np.nanmax(means.unknown / room, initial=0.0))
    return of_cells, float(np.nanmax(means.error, initial=0.0)) / allowed, allowed


class _Remembered:
    """A function whose rates are known where it was evaluated before, for images of one view."""

    def __init__(self, function: Any, unit: Any, length_unit: str | None) -> None:
        self._columns = Columns(self._all)
        self._function = Function(
            function, unit=_units.to_text(unit), length_unit=length_unit, takes_components=True
        )
        self.evaluations = 0
        self._is_single = True
        named = function if hasattr(function, "__qualname__") else type(function)
        self.__qualname__, self.__module__ = named.__qualname__, named.__module__

    def _all(self, position: Floats, direction: Floats, energy: Floats | None) -> Floats:
        rates = self._function(position, direction, energy)
        self.evaluations += len(position)
        self._is_single = rates.ndim == 1
        return np.asarray(rates).reshape(len(position), -1)

    def __call__(self, position: Floats, direction: Floats) -> Floats:
        rates = self._columns.rows(position, direction)
        return rates[:, 0] if self._is_single else rates


def _remembered(emission: Any, given: Mapping[str, Any], length_unit: str | None) -> Any:
    """A plain function that remembers its rates; other emissions as they are."""
    if not _is_plain(emission, given):
        return emission
    return _Remembered(emission, given.get("unit"), length_unit)


def _is_plain(emission: Any, given: Mapping[str, Any]) -> bool:
    from emitree._emissions import Expression, Tree
    from emitree._fields import Fields

    others = (Expression, Tree, Fields, list, tuple, Mapping)
    has_own = any(hasattr(emission, name) for name in ("bounds", "unit", "seeds", "edges"))
    is_at_home = not any(given.get(name) for name in ("executor", "cache", "quantities"))
    return is_function(emission) and not isinstance(emission, others) and not has_own and is_at_home


def _means(host: Host, rendering: Rendering) -> _Means:
    """The means over the pixels of a WCS of an image."""
    if rendering.error is None:
        raise SceneError("the image has no errors: expected those of method `vol`")
    solid = host.solid_angles()
    counts = np.asarray(rendering.evaluations_per_pixel, dtype=np.float64)
    several = [
        Cells.linear(host.padded(solid)),
        Cells.linear(host.padded(rendering.image * solid)),
        Cells.constant(host.padded(rendering.error * solid)),
        Cells.constant(host.padded(counts)),
    ]
    shape = host.corners.shape
    found = np.full((4, shape[0] * shape[1]), np.nan)
    for some, directions in host.corners.blocks():
        places, is_seen = host.places(directions)
        (area, _), (value, unknown), (error, _), (numbers, _) = integrals(several, places[is_seen])
        block = found[:, some]
        block[:, is_seen] = value / area, error / area, unknown / area, numbers
        is_wide = np.isfinite(directions).all(axis=(1, 2)) & ~is_seen
        if is_wide.any():
            block[:, is_wide] = _wide(host, rendering, some.start + np.flatnonzero(is_wide))
    value, error, unknown, numbers = found.reshape(4, *shape)
    return _Means(value, error + unknown, unknown, np.where(np.isnan(numbers), 0.0, numbers))


def _wide(host: Host, rendering: Rendering, pixel: Any) -> Floats:
    """Means, errors, what is unknown, and evaluations (4, n) of pixels beside the poles."""
    assert rendering.error is not None
    directions, areas = host.corners.parts(pixel)
    row, column = host.cells(directions)
    values, errors = rendering.image[row, column], rendering.error[row, column]
    weights = areas / areas.sum(axis=1, keepdims=True)
    counts = np.asarray(rendering.evaluations_per_pixel)[row, column]
    # Half of the difference to the parts beside each, on average.
    side = int(np.sqrt(values.shape[1]))
    square = np.pad(values.reshape(-1, side, side), [(0, 0), (1, 1), (1, 1)], "edge")
    middle = square[:, 1:-1, 1:-1]
    around = (square[:, 1:-1, 2:], square[:, 1:-1, :-2], square[:, 2:, 1:-1], square[:, :-2, 1:-1])
    apart = np.max([abs(of - middle) for of in around], axis=0).reshape(values.shape)
    return np.stack(
        [
            (weights * values).sum(axis=1),
            (weights * errors).sum(axis=1),
            (weights * (0.5 * apart)).sum(axis=1),
            counts.mean(axis=1),
        ]
    )


def _rendering(
    host: Rendering,
    means: _Means,
    camera: WcsCamera,
    shape: tuple[int, int],
    tolerance: float,
    options: Mapping[str, Any],
    evaluations: int,
) -> Rendering:
    """The result, with the account of the image that it is made of."""
    kind, (account, *_) = host._found.__reduce__()
    largest = float(np.nanmax(abs(means.value), initial=0.0))
    error = float(np.nanmax(means.error, initial=0.0))
    estimated = error / largest if largest > 0 else (0.0 if error == 0 else np.inf)
    table = json.loads(account)
    ending = table["ending"]
    if estimated <= tolerance:
        ending = "complete"
    elif ending == "complete":
        ending = "budget"
    table |= {
        "evaluations": evaluations,
        "estimated_error": estimated,
        "error_over_allowed": estimated / tolerance,
        "tolerance": tolerance,
        "by_pixel": None,
        "ending": ending,
        "wcs": None,
        "overrides": [
            *table["overrides"],
            f"the means over the {shape[1]} x {shape[0]} pixels of a WCS of an image like this one",
        ],
    }
    value, error_of_each, counts = (
        np.ascontiguousarray(of[np.newaxis]) for of in (means.value, means.error, means.evaluations)
    )
    found = kind(json.dumps(table), value, error_of_each, counts, None)
    of_view = {key: value for key, value in options.items() if value is not None}
    made = Rendering(found, json.loads(found.report()), Setup(camera, shape, of_view))
    one = np.ones((1, 1, 1))
    # The account has the sky, which files of images without projection do not have.
    made._wcs, made._cards = camera.wcs, sky_cards(kind(account, one, one, one, None).fits())
    return made
