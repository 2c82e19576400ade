"""Rendering: from an emission and a camera to an image, its error and its bill."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from emitree import _native, _progress, _units
from emitree._cache import Cache
from emitree._cameras import Camera, Canonical
from emitree._emissions import Tree
from emitree._executor import Serial, Shared
from emitree._function import Floats, Function
from emitree._result import Rendering
from emitree._scene import compose, is_scene_file, open_scene

#: The most points of one call of a function: few enough for their arrays to stay in a cache of the
#: processor, enough for the call to cost nothing.
BATCH_SIZE = 65536


def render(
    emission: Any,
    camera: Camera | None = None,
    shape: Sequence[int] | int | None = None,
    *,
    tolerance: float | None = None,
    method: str | None = None,
    max_evaluations: int | None = None,
    executor: Executor | None = None,
    energy: Mapping[str, Any] | None = None,
    unit: Any = None,
    image_unit: Any = None,
    quantity: str | None = None,
    bounds: Any = None,
    occulters: Sequence[Any] = (),
    seeds: Sequence[tuple[Any, Any]] = (),
    instrument: Mapping[str, Any] | None = None,
    base_level: int | None = None,
    order: int | None = None,
    finest_level: int | None = None,
    rule: str | None = None,
    threshold: float | str | None = None,
    lines: int | None = None,
    steps: int | None = None,
    quantities: bool = False,
    batch_size: int | None = None,
    threads: int | None = None,
    cache: str | os.PathLike[str] | None = None,
    progress: _progress.Progress = False,
    frame: Callable[[Floats, Floats, int, int], Any] | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Rendering:
    """The image that a camera sees of an emission, to the error that is asked for.

    emission: what glows, one of
        * a function f(position, direction) -> rates, or f(position, direction, energy) -> rates
          if `energy` is given. position (n, 3) is in the camera's length unit, direction (n, 3)
          are unit vectors of emission, from the point to the observer, energy (n,) is in the unit
          of the bins, rates (n,). It is called with many points at once, in the thread that called
          `render`; the rate of a point must not depend on the others. Arrays of other libraries
          are taken through DLPack;
        * a text with a formula, or an `Expression`;
        * a `Model`, a `Grid` or a `Tree`;
        * the name of a scene file (a path, or a text that ends in ".toml"), without `camera`.
    camera: `Canonical`, `Orthographic`, `Perspective`, `Equirectangular`, `Polar`, `Fisheye` or
        `Healpix`.
    shape: (height, width) in pixels.
    tolerance: the largest error of a pixel, relative to the largest |pixel|; 0.01 by default.
    method: "vol" (the default), "paper" or "los".
    max_evaluations: how often the emission may be evaluated.
    executor: any `concurrent.futures.Executor`, whose workers share each batch of a function.
    energy: bins of a cube: {"min": 0.5, "max": 8.0, "bins": 24, "unit": "keV", "scale": "log"}.
    unit, image_unit: units of the rates and of the image: a text in the grammar of FITS, or an
        astropy unit; both need the camera's `length_unit`.
    quantity: "radiance" (the default) or "irradiance".
    bounds: a `Sphere`, `Ellipsoid` or `Box` outside of which nothing glows.
    occulters: opaque `Sphere`s and `Ellipsoid`s.
    seeds: pairs (position (3,), radius) of structures too small for the base lattice.
    instrument: a camera that counts photons, the table `[instrument]` of a scene, as in
        {"effective_area": 50.0, "exposure": 1e4, "psf": {"fwhm_pixels": 2.0}, "seed": 1}; needs
        `energy`.
    base_level, order, finest_level, rule, threshold, lines, steps: options of the methods, as in
        the table `[render]` of a scene.
    quantities: whether a function gets astropy quantities instead of plain arrays.
    batch_size: the most points of one call of a function.
    threads: how many threads work; as many as there are processors by default.
    cache: a folder, or an HDF5 file (.h5), that keeps each point that a function evaluated. After
        the process was killed the same call goes on from there. It knows points, not functions:
        each function needs a cache of its own.
    progress: True for a bar (of tqdm), or a function that is called with the evaluations so far.
    frame: a function that is called with each image on the way, its error (both of `shape`, in the
        unit of the final image; of a cube, the whole band), the evaluations and the batches so far.
    changes: of a scene file, {"render.tolerance": 0.1} and the like.

    Raises `SceneError` if something is wrong with what was asked for, `EmissionError` if a rate is
    not finite, and whatever a function raises, with a note of where it was asked for.

    >>> import emitree, numpy as np
    >>> def ball(position, direction):
    ...     return np.exp(-100 * ((position - 0.5) ** 2).sum(axis=1))
    >>> rendering = emitree.render(ball, emitree.Canonical(), (32, 64), tolerance=0.01)
    >>> rendering.image.shape, rendering.converged
    ((32, 64), True)
    >>> bool(abs(rendering.image.max() - np.sqrt(np.pi / 100)) < 0.01)
    True
    """
    settings = {
        "method": method,
        "tolerance": tolerance,
        "max_evaluations": max_evaluations,
        "base_level": base_level,
        "order": order,
        "finest_level": finest_level,
        "rule": rule,
        "threshold": threshold,
        "lines": lines,
        "steps": steps,
    }
    if camera is None:
        if not is_scene_file(emission):
            raise TypeError("expected a camera, or the name of a scene file alone")
        for name, given in (
            ("energy", energy),
            ("unit", unit),
            ("image_unit", image_unit),
            ("quantity", quantity),
            ("bounds", bounds),
            ("occulters", occulters or None),
            ("seeds", seeds or None),
            ("instrument", instrument),
        ):
            if given is not None:
                raise TypeError(f"`{name}` is for a camera: the scene file has its own")
        scene = _opened(emission, shape, settings, changes)
        function = None
    else:
        if shape is None:
            raise TypeError("expected `shape`, (height, width)")
        if changes is not None:
            raise TypeError("`changes` are for scene files: expected none")
        # Of `los`, equal steps and a tolerance exclude each other.
        if tolerance is None and method != "paper" and not (method == "los" and steps is not None):
            settings["tolerance"] = 0.01
        scene = compose(
            emission,
            camera,
            shape,
            unit=unit,
            image_unit=image_unit,
            quantity=quantity,
            energy=energy,
            bounds=bounds,
            occulters=occulters,
            seeds=seeds,
            instrument=instrument,
            render=settings,
        )
        function = _function(emission, scene, unit, quantities)
    return _rendered(scene, function, executor, batch_size, threads, cache, progress, frame)


def _opened(
    path: Any, shape: Any, settings: Mapping[str, Any], changes: Mapping[str, Any] | None
) -> _native.Scene:
    values = {f"render.{key}": value for key, value in settings.items()}
    if shape is not None:
        height, width = shape
        values |= {"image.height": height, "image.width": width}
    return open_scene(path, values | dict(changes or {}))


def _function(emission: Any, scene: _native.Scene, unit: Any, quantities: bool) -> Function | None:
    if isinstance(emission, str) or not callable(emission):
        return None
    energies = scene.energies
    return Function(
        emission,
        unit=_units.to_text(unit),
        length_unit=scene.length_unit,
        energy_unit=energies[1] if energies else None,
        quantities=quantities,
    )


def _rendered(
    scene: _native.Scene,
    function: Function | None,
    executor: Executor | None,
    batch_size: int | None,
    threads: int | None,
    cache: str | os.PathLike[str] | None,
    progress: _progress.Progress,
    frame: Callable[..., Any] | None,
) -> Rendering:
    with ExitStack() as stack:
        evaluate, opened = _evaluator(stack, scene, function, executor, cache)
        found = scene.render(
            function=evaluate,
            batch_size=_batch_size(batch_size, function),
            threads=threads,
            progress=stack.enter_context(_progress.hook(progress)),
            frame=frame,
        )
    report = found.report()
    if opened is not None:
        report["cache"] = {"found": opened.found, "added": opened.added}
    return Rendering(scene, found, report)


def _batch_size(given: int | None, function: Function | None) -> int | None:
    return BATCH_SIZE if given is None and function is not None else given


def _evaluator(
    stack: ExitStack,
    scene: _native.Scene,
    function: Function | None,
    executor: Executor | None,
    cache: str | os.PathLike[str] | None,
) -> tuple[Callable[..., Floats] | None, Cache | None]:
    """What is called with each batch."""
    if function is None:
        for name, given in (("executor", executor), ("cache", cache)):
            if given is not None:
                raise TypeError(f"`{name}` is for functions: expected none with this emission")
        return None, None
    evaluator = Serial(function) if executor is None else Shared(function, executor)
    if cache is not None:
        energies = scene.energies
        units = {
            "length_unit": scene.length_unit,
            "unit": function.unit,
            "energy_unit": energies[1] if energies else None,
        }
        opened = stack.enter_context(Cache(cache, units))
        return (lambda *batch: opened.rates(evaluator, *batch)), opened
    if executor is None:
        return function, None

    def shared(position: Floats, direction: Floats, energy: Floats | None) -> Floats:
        rates = np.empty(len(position))
        for part, of_part in evaluator.parts(position, direction, energy):
            rates[part] = of_part
        return rates

    return shared, None


@dataclass(frozen=True)
class Frame:
    """An image on the way.

    image, error: (height, width), in the unit of the final image; of a cube, the whole band.
    evaluations, batches: how many it took so far.
    """

    image: Floats
    error: Floats
    evaluations: int
    batches: int


class _Stopped(BaseException):
    """Nobody wants the next image."""


def progressive(*arguments: Any, **options: Any) -> Iterator[Frame | Rendering]:
    """Images on the way, coarse first, and the `Rendering` at the end; arguments as of `render`.

    Only method "vol" has images on its way. The rendering works in a thread of its own, which also
    calls the function, while the images are looked at; it ends when the loop does.

    >>> import emitree
    >>> wave = "1 + sin(5*x) * sin(7*y)"
    >>> *frames, last = emitree.progressive(wave, emitree.Canonical(), (16, 16), tolerance=0.001)
    >>> [frame.image.shape for frame in frames[:1]], last.converged
    ([(16, 16)], True)
    """
    images: queue.Queue[Any] = queue.Queue(maxsize=1)
    stop = threading.Event()

    def put(item: Any) -> None:
        while not stop.is_set():
            try:
                return images.put(item, timeout=0.05)
            except queue.Full:
                continue
        raise _Stopped

    def progress(evaluations: int) -> None:
        if stop.is_set():
            raise _Stopped
        if tell is not None:
            tell(evaluations)

    def frame(*image: Any) -> None:
        put(Frame(*image))

    def work() -> None:
        with suppress(_Stopped):
            try:
                put(render(*arguments, **options, progress=progress, frame=frame))
            except Exception as error:
                put(error)

    with _progress.hook(options.pop("progress", False)) as tell:
        worker = threading.Thread(target=work, name="emitree")
        worker.start()
        try:
            item: Any = None
            while not isinstance(item, Rendering):
                item = images.get()
                if isinstance(item, Exception):
                    raise item
                yield item
        finally:
            stop.set()
            worker.join()


def build_tree(
    emission: Any,
    path: str | os.PathLike[str],
    bounds: Any,
    *,
    tolerance: float | None = None,
    base_level: int | None = None,
    order: int | None = None,
    finest_level: int | None = None,
    max_evaluations: int | None = None,
    length_unit: Any = None,
    unit: Any = None,
    executor: Executor | None = None,
    batch_size: int | None = None,
    threads: int | None = None,
    cache: str | os.PathLike[str] | None = None,
    progress: _progress.Progress = False,
) -> Tree:
    """Builds a tree of an emission that is the same in all directions, once for many views.

    emission: as of `render`; path: the file that the tree is saved in, FITS.
    bounds: the `Box` that it fills; outside of it nothing glows.
    tolerance: details below this fraction of the largest rate are dropped; 0.001 by default.
    base_level, order, finest_level, max_evaluations: as in the table `[build]` of a scene.
    length_unit, unit: of the box and of the rates; the others as of `render`.

    >>> import emitree, tempfile, os
    >>> box = emitree.Box(min=(0, 0, 0), max=(1, 1, 1))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     tree = emitree.build_tree("1 + x", os.path.join(folder, "ramp.fits"), box)
    ...     emitree.render(tree, emitree.Canonical(), (4, 4)).image[0].round(3).tolist()
    [1.125, 1.375, 1.625, 1.875]
    """
    camera = Canonical(length_unit=length_unit)
    box = bounds.table(_units.to_text(length_unit))
    build = {
        "min": box["min"],
        "max": box["max"],
        "tolerance": tolerance,
        "base_level": base_level,
        "order": order,
        "finest_level": finest_level,
        "max_evaluations": max_evaluations,
    }
    build = {key: value for key, value in build.items() if value is not None}
    scene = compose(emission, camera, (1, 1), unit=unit, render={}, build=build)
    function = _function(emission, scene, unit, False)
    with ExitStack() as stack:
        evaluate, _ = _evaluator(stack, scene, function, executor, cache)
        encoded, report = scene.build_tree(
            function=evaluate,
            batch_size=_batch_size(batch_size, function),
            threads=threads,
            progress=stack.enter_context(_progress.hook(progress)),
        )
    Path(path).write_bytes(encoded)
    return Tree(path, report)
