"""Images and cubes larger than memory, which are written to FITS files row by row."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from emitree import _options, _progress, _units
from emitree._cameras import Camera
from emitree._evaluator import batch_size_of, evaluator
from emitree._session import SESSION_OPTIONS, refuse_unknown
from emitree._setup import before_camera, function_in, scene_of_camera, with_own
from emitree._several import Several
from emitree._wcs_camera import WcsCamera


def render_to_fits(
    emission: Any,
    camera: Camera,
    shape: Sequence[int] | int,
    path: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    executor: Any = None,
    cache: str | os.PathLike[str] | None = None,
    batch_size: int | None = None,
    threads: int | None = None,
    progress: _progress.Progress = False,
    **options: Any,
) -> dict[str, Any]:
    """Renders an image or a cube that is larger than memory, and writes it to a FITS file.

    The file has the values, the extension `ERROR`, and the table `ENERGIES` of a cube. It is
    compressed if its name ends in `.gz`. Memory does not grow with the number of pixels.

    emission, camera, shape, executor, cache, batch_size, threads, progress: as of `render`; one
    emission, and no scene file.
    path: the FITS file.
    overwrite: whether a file that is there may be replaced.
    options: other keywords of `render`, as of a `Session`, but no instrument.

    Returns `Rendering.report` of the image: its cost and its error.

    Raises `RenderError` if the image can't be made row by row, with the reason: an emission without
    a low-rank approximation, a singularity, errors by pixel, a cube in a view that bodies, bounds
    or ellipsoidal edges divide. Raises `FileExistsError`, and `OSError` if the disk has no room for
    the file, before anything is evaluated.

    >>> import emitree, os, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "image.fits")
    ...     report = emitree.render_to_fits("exp(-x)", emitree.Canonical(), (2000, 3000), path)
    ...     os.path.getsize(path) > 2 * 8 * 2000 * 3000
    True
    >>> report["converged"]
    True
    """
    refuse_unknown(options, SESSION_OPTIONS - {"instrument"})
    if not overwrite and os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), os.fspath(path))
    if Several.of(emission) is not None or isinstance(camera, WcsCamera):
        what = "a `WcsCamera`" if isinstance(camera, WcsCamera) else "several emissions"
        raise TypeError(f"{what}: expected one emission and a camera of rows of pixels")
    bounds = options.get("bounds")
    shapes = [] if bounds is None else [bounds]
    for name in ("occulters", "edges", "singularities"):
        shapes.extend(options.get(name, ()))
    emission = before_camera(emission, camera, shapes)
    scene = scene_of_camera(emission, camera, shape, with_own(emission, options))
    function = function_in(emission, scene, _units.to_text(options.get("unit")), False)
    with ExitStack() as stack:
        evaluate = evaluator(stack, scene, function, executor, cache)
        hook = stack.enter_context(_progress.hook(progress))
        report = scene.write_large(
            path,
            function=None if evaluate is None else evaluate.rates,
            batch_size=batch_size_of(batch_size, function),
            threads=_options.threads(threads),
            progress=hook if evaluate is None else evaluate.progress(hook),
        )
        found: dict[str, Any] = json.loads(report)
        if evaluate is not None:
            found.update(evaluate.report)
    return found
