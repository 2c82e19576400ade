"""Rendering: from an emission and a camera to an image, its estimated error and its cost."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Any

from emitree import _native, _options, _progress
from emitree._cameras import Camera, Canonical
from emitree._components import Columns, Components, of_all
from emitree._evaluator import batch_size_of, evaluator
from emitree._exposure import Exposure
from emitree._fields import Fields
from emitree._function import Floats, Function
from emitree._result import Rendering
from emitree._scene import is_scene_file, length_unit_of
from emitree._setup import (
    Setup,
    absorption_in,
    before_camera,
    function_in,
    opened_scene,
    refuse_unused,
    scene_of_camera,
    values_of,
    with_own,
)
from emitree._several import Several
from emitree._snapshots import mean_of_snapshots, refuse_options
from emitree._wcs_camera import WcsCamera
from emitree._wcs_render import rendered_by_corners


def render(
    emission: Any,
    camera: Camera | None = None,
    shape: Sequence[int] | int | None = None,
    *,
    tolerance: float | None = None,
    rtol: float | None = None,
    atol: Any = None,
    floor: float | None = None,
    weights: Any = None,
    mask: Any = None,
    per_band: bool | None = None,
    sums: Mapping[str, Any] | None = None,
    method: str | None = None,
    max_evaluations: int | None = None,
    max_seconds: Any = None,
    rounds: int | None = None,
    smallest_feature: Any = None,
    minimize: str | None = None,
    executor: Any = None,
    energy: Any = None,
    exposure: Any = None,
    unit: Any = None,
    image_unit: Any = None,
    quantity: str | None = None,
    bounds: Any = None,
    occulters: Sequence[Any] = (),
    edges: Sequence[Any] = (),
    singularities: Sequence[Any] = (),
    seeds: Sequence[tuple[Any, Any]] = (),
    instrument: Any = None,
    absorption: Any = None,
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
    """The image of an emission from a camera, to a tolerance.

    emission: one of
        * a function f(position, direction) -> rates, or f(position, direction, energy) -> rates
          if `energy` is given, or f(position, direction, time) -> rates if `exposure` is.
          position (n, 3) is in the camera's length unit, direction (n, 3)
          are unit vectors of emission, from the point to the observer, energy (n,) is in the unit
          of the bins, rates (n,), or (n, k) for k components: then `Components` are returned.
          It is called with many points at once, in the thread that called
          `render`; the rate of a point must not depend on the others. Arrays of other libraries
          are taken through DLPack;
        * a text with a formula, or an `Expression`;
        * a list of such formulas and functions, or a dictionary of them by name: `Components`;
        * a `Model`, a `Grid`, an `AmrGrid` or a `Tree`;
        * the name of a scene file (a path, or a text that ends in ".toml"), without `camera`;
          `Components` if it has `expressions`.
    camera: a `Camera`, such as `Perspective` or `Healpix`.
    shape: (height, width) in pixels; by default that of the camera's WCS, if it is of one.
    tolerance: the largest error of a pixel, relative to the largest |pixel|; 0.01 by default.
    rtol, atol, floor: instead of `tolerance`, the error allowed in each pixel:
        atol + rtol * max(|pixel|, floor * largest |pixel|). `atol` is in the unit of the image, a
        number or a quantity; `floor` is 1e-5 by default, and 0 beside `atol`.
    weights: an image (height, width) by which the error allowed in each pixel is divided; a pixel
        with the weight 0 does not matter. An array, or the name of a FITS or NPY file.
    mask: an image (height, width) that is not 0 in the pixels that matter; an array or a file.
    per_band: whether each band of a cube is rendered to the largest |voxel| of its own.
    sums: regions by name whose sum is to be right to a tolerance of its own: for each a mask
        (height, width) of weights, an array or a file, or a dictionary with one of
        circle={"center": (x, y), "radius": r}, box={"min": (x, y), "max": (x, y)} and mask=...,
        and with of="sum" (the default), "mean" or "flux", tolerance=0.01, atol, and
        coordinates="pixels" (0 at the edge of the image) or "axes" (degrees or lengths of the
        camera). The results are `Rendering.sums`. With sums, `tolerance` may be 1: then the pixels
        matter for the sums alone.
    method: "vol" (the default), "paper" or "los".
    max_evaluations: how often the emission may be evaluated.
    max_seconds: how long the rendering may take [s], a number or a quantity; it ends with the best
        image so far, after the call of a function that is under way.
    rounds: the number of batches that is aimed at, 1 or more: where a batch takes long, points that
        are expected to be needed soon are evaluated with those that are needed. A smaller number
        takes fewer batches and more evaluations; the result has the same bits.
    smallest_feature: the standard deviation of the smallest Gaussian that may not be missed: a
        fraction of the edge of the view's cube, or a length as a quantity or as in "0.1 R_E".
    minimize: "evaluations" (the default) or "time": with time, an emission that takes
        nanoseconds, such as an expression, is integrated along lines of sight on a lattice of
        pixels where that is faster, to the same tolerance.
    executor: any `concurrent.futures.Executor`, as that of `mpi4py.futures`, a dask `Client`, or
        the module `ray`: its workers share each batch of a function. The result has the same bits
        for any number of workers. See also `on_workers`.
    energy: bins of a cube: `Energies`, a dictionary with the same keys, or their borders
        (bins + 1,) in uniform steps or equal ratios, in keV or a quantity.
    exposure: an `Exposure`: pixels are means over its times, in seconds, during which the emission
        changes, the observer moves, or both. There are no energies beside it.
    unit, image_unit: units of the rates and of the image: a text in the grammar of FITS, or an
        astropy unit; both need the camera's `length_unit`.
    quantity: "radiance" (the default) or "irradiance".
    bounds: a `Sphere`, `Ellipsoid` or `Box` outside of which the emission is 0; by default the
        attribute `bounds` of a function that has such a one, as an `AmrGrid` and `Particles` have.
    occulters: opaque `Sphere`s and `Ellipsoid`s.
    edges: `Sphere`s, `Ellipsoid`s and `Plane`s: surfaces on which the emission jumps or has a kink.
        They describe the emission and do not change it.
    singularities: `SingularPoint`s and `SingularAxis`es: where the emission is singular, or has a
        peak far smaller than a pixel. They describe the emission, too.
    seeds: pairs (position (3,), radius) of structures too small for the base lattice; by default
        the attribute `seeds` of a function that has one.
    instrument: a camera that counts photons: an `Instrument`, or a dictionary with the same keys;
        needs `energy`.
    absorption: the absorption coefficient of the medium, in one over the camera's length unit: a
        function of the same arguments as the emission, which returns coefficients (n,), a formula,
        an `Expression`, a `Grid` and so on. The image is the integral of the emission times
        exp(-tau), where tau is the integral of the coefficient from the observer to the point. Its
        evaluations are `Rendering.absorption_evaluations`. An `executor` and a `cache` are for the
        emission alone, and there are no components beside it.
    base_level, order, finest_level, rule, threshold, lines, steps: options of the methods, as in
        the table `[render]` of a scene; one that the method does not use is an error.
    quantities: whether a function gets astropy quantities instead of plain arrays.
    batch_size: the most points of one call of a function.
    threads: how many threads work, 1 to 1024; as many as there are processors by default.
    cache: a folder, or an HDF5 file (.h5), that keeps each point that a function evaluated. After
        the process was killed the same call goes on from there. Each function needs a cache of its
        own: a few stored points are evaluated again, and another function is refused.
    progress: True for a bar (of tqdm), or a function that is called with the evaluations so far.
    frame: a function that is called with each intermediate image, its error (both of `shape`, in
        the unit of the final image; of a cube, the whole band), the evaluations and the batches so
        far; of method "vol" only.
    changes: of a scene file, {"render.tolerance": 0.1} and the like.

    Raises `SceneError` if an argument is wrong, `EmissionError` if a rate is
    not finite, and any exception of a function, with a note of the points that it was called with.

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
        "rtol": rtol,
        "atol": atol,
        "floor": floor,
        "weights": weights,
        "mask": mask,
        "per_band": per_band,
        "sums": sums,
        "max_evaluations": max_evaluations,
        "max_seconds": max_seconds,
        "rounds": rounds,
        "smallest_feature": smallest_feature,
        "minimize": minimize,
        "base_level": base_level,
        "order": order,
        "finest_level": finest_level,
        "rule": rule,
        "threshold": threshold,
        "lines": lines,
        "steps": steps,
    }
    of_view = {
        "energy": energy,
        "exposure": exposure,
        "unit": unit,
        "image_unit": image_unit,
        "quantity": quantity,
        "bounds": bounds,
        "occulters": occulters,
        "edges": edges,
        "singularities": singularities,
        "seeds": seeds,
        "instrument": instrument,
        "absorption": absorption,
    }
    if camera is None:
        if not is_scene_file(emission):
            raise TypeError("expected a camera, or the name of a scene file alone")
        for name, given in of_view.items():
            if given is not None and not (isinstance(given, Sequence) and len(given) == 0):
                raise TypeError(f"`{name}` is for a camera: the scene file has its own")
        scene = opened_scene(emission, shape, values_of(settings, image_unit), changes)
        refuse_unused(scene, settings, energy, seeds, changes)
        function, coefficient, setup = None, None, None
    else:
        if isinstance(camera, WcsCamera):
            if changes is not None:
                raise TypeError("`changes` are for scene files: expected none")
            others = {
                "executor": executor,
                "batch_size": batch_size,
                "threads": threads,
                "progress": progress,
                "cache": cache,
                "frame": frame,
                "quantities": quantities,
            }
            with_others = of_view | settings | others | {"image_unit": image_unit}
            return rendered_by_corners(emission, camera, shape, with_others, render)
        if shape is None and camera.sky is not None:
            shape = camera.sky.shape
        if shape is None:
            raise TypeError("expected `shape`, (height, width)")
        if changes is not None:
            raise TypeError("`changes` are for scene files: expected none")
        if isinstance(exposure, Exposure) and exposure.snapshots:
            others = {
                "executor": executor,
                "batch_size": batch_size,
                "threads": threads,
                "progress": progress,
            }
            beside = {"cache": cache, "frame": frame, "quantities": quantities}
            return _of_snapshots(
                emission, camera, shape, exposure, of_view | settings | beside, others
            )
        several = Several.of(emission)
        emission = emission if several is None else several
        if several is not None and absorption is not None:
            raise TypeError("`absorption` is given with several emissions: expected one emission")
        shapes = [*([] if bounds is None else [bounds]), *occulters, *edges, *singularities]
        emission = before_camera(emission, camera, shapes)
        of_view["absorption"] = absorption = before_camera(absorption, camera, shapes)
        options = with_own(emission, of_view | settings)
        if isinstance(camera, Canonical) and isinstance(emission, Fields) and bounds is None:
            # The unit cube is a volume of its own.
            options |= {"bounds": None, "edges": edges}
        setup = Setup(camera, shape, options, quantities, batch_size, threads)
        scene = scene_of_camera(emission, camera, shape, setup.options)
        takes_components = cache is None and frame is None and absorption is None
        function = function_in(emission, scene, setup.unit, quantities, takes_components)
        coefficient = absorption_in(absorption, scene, quantities)
    if quantities and function is None and coefficient is None:
        raise _native.SceneError("`quantities` is for functions: expected none with this emission")
    return _rendered(
        scene,
        function,
        executor,
        batch_size,
        threads,
        cache,
        progress,
        frame,
        coefficient=coefficient,
        setup=setup,
    )


def _of_snapshots(
    emission: Any,
    camera: Camera,
    shape: Sequence[int] | int,
    exposure: Exposure,
    options: Mapping[str, Any],
    others: Mapping[str, Any],
) -> Rendering:
    """The mean of many images of cameras that do not move."""
    refuse_options(options)
    own = {"tolerance", "max_evaluations", "exposure"}
    given = {key: value for key, value in options.items() if value is not None and key not in own}
    bounds = options["bounds"]
    shapes = [*([] if bounds is None else [bounds]), *options["occulters"], *options["edges"]]
    tolerance = options["tolerance"]

    def rendered(emission: Any, camera: Camera, **limits: Any) -> Rendering:
        return render(emission, camera, shape, **{**given, **others, **limits})

    return mean_of_snapshots(
        emission,
        camera,
        exposure,
        length_unit_of(camera, shapes),
        0.01 if tolerance is None else tolerance,
        options["max_evaluations"],
        rendered,
    )


def rendered_from(
    start: _native.Mesh,
    is_fixed: bool,
    setup: Setup,
    emission: Any,
    *,
    max_evaluations: int | None = None,
    executor: Any = None,
    progress: _progress.Progress = False,
) -> Rendering:
    """A rendering that starts from the functions of a mesh.

    start: the mesh of another emission with the same setup.
    is_fixed: whether the points are those of the mesh, and some samples that estimate the error;
        if not, the rendering begins anew where these do not suffice.
    setup, emission, executor, progress: as of the mesh's rendering, and of `render`.
    max_evaluations: instead of that of the setup.
    """
    options = dict(setup.options)
    if max_evaluations is not None:
        options["max_evaluations"] = max_evaluations
    scene = scene_of_camera(emission, setup.camera, setup.shape, options)
    function = function_in(emission, scene, setup.unit, setup.quantities)
    return _rendered(
        scene,
        function,
        executor,
        setup.batch_size,
        setup.threads,
        None,
        progress,
        None,
        setup=setup,
        start=start,
        is_fixed=is_fixed,
    )


def rendered_with_lines(
    emission: Any, camera: Camera, shape: Sequence[int], places: Floats, options: Mapping[str, Any]
) -> Any:
    """The rendering of a function, with radiances along lines of sight of the image.

    places: (n, 2), x and y from 0 to 1 over the image.
    options: those of `render`.
    Returns the `Rendering`, or `Components`, of which each `_found.line_values()` has the radiances
    (n,) and their errors (n,), which are infinite where a radiance is not known.
    """
    setup = Setup(camera, shape, options, False, None, None)
    scene = scene_of_camera(emission, camera, shape, setup.options)
    function = function_in(emission, scene, None, False, takes_components=True)
    return _rendered(
        scene, function, None, None, None, None, False, None, setup=setup, places=places
    )


def _rendered(
    scene: _native.Scene,
    function: Function | None,
    executor: Any,
    batch_size: int | None,
    threads: int | None,
    cache: str | os.PathLike[str] | None,
    progress: _progress.Progress,
    frame: Callable[..., Any] | None,
    *,
    coefficient: Function | None = None,
    setup: Setup | None = None,
    start: _native.Mesh | None = None,
    is_fixed: bool = False,
    places: Floats | None = None,
) -> Rendering:
    threads = _options.threads(threads)
    if frame is not None and scene.method != "vol":
        raise _native.SceneError(
            f"`frame` or `progressive` is used, and method `{scene.method}` has no intermediate "
            "images: expected neither, or method `vol`"
        )
    with ExitStack() as stack:
        evaluate = evaluator(stack, scene, function, executor, cache)
        components = scene.components()
        if components is not None:
            hook = stack.enter_context(_progress.hook(progress))
            options = {"batch_size": batch_size, "threads": threads, "progress": hook}
            return _of_components(components, options, frame)
        columns = Columns(evaluate.rates) if evaluate is not None else None
        render_scene = scene.render
        if start is not None:
            render_scene = partial(scene.render, start=start, is_fixed=is_fixed)
        elif places is not None:
            render_scene = partial(scene.render, places=places)
        hook = stack.enter_context(_progress.hook(progress))
        if evaluate is not None:
            hook = evaluate.progress(hook)

        def rendering() -> Rendering:
            found = render_scene(
                function=columns,
                absorption=coefficient,
                batch_size=batch_size_of(batch_size, function or coefficient),
                threads=threads,
                progress=hook,
                frame=frame,
            )
            report = json.loads(found.report())
            if evaluate is not None:
                report.update(evaluate.report)
            return Rendering(found, report, setup)

        first = rendering()
        if columns is None:
            return first
        given = None if function is None else function.function
        names = given.names if isinstance(given, Several) else None
        return of_all(columns, first, rendering, names)


def _of_components(
    components: Sequence[tuple[str, _native.Scene]],
    options: Mapping[str, Any],
    frame: Callable[..., Any] | None,
) -> Any:
    """The renderings of a scene file with `expressions`."""
    if frame is not None:
        raise _native.SceneError(
            "`frame` is used, and the scene has several `expressions`: expected no `frame`, or a "
            "single `expression`"
        )
    renderings = []
    for _, scene in components:
        found = scene.render(**options)
        renderings.append(Rendering(found, json.loads(found.report())))
    evaluations = components[0][1].component_evaluations or 0
    return Components(tuple(renderings), evaluations, tuple(name for name, _ in components))
