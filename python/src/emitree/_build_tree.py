"""Trees of emissions, built once for many views."""

from __future__ import annotations

import os
from contextlib import ExitStack
from typing import Any

from emitree import _native, _options, _progress, _units
from emitree._cameras import Canonical
from emitree._emissions import Tree
from emitree._evaluator import batch_size_of, evaluator
from emitree._scene import compose
from emitree._setup import function_in


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
    executor: Any = None,
    batch_size: int | None = None,
    threads: int | None = None,
    cache: str | os.PathLike[str] | None = None,
    progress: _progress.Progress = False,
) -> Tree:
    """Builds a tree of an emission that is the same in all directions, once for many views.

    emission: as of `render`; path: the file that the tree is saved in, FITS.
    bounds: the `Box` that it fills; outside of it the emission is 0.
    tolerance: details below this fraction of the largest rate are dropped; 0.001 by default.
    base_level, order, finest_level, max_evaluations: as in the table `[build]` of a scene.
    length_unit, unit: of the box and of the rates; the others as of `render`.

    The file is whole or absent: until the tree is complete, one of that name stays as it is.

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
    function = function_in(emission, scene, unit, False)
    threads = _options.threads(threads)
    with ExitStack() as stack:
        evaluate = evaluator(stack, scene, function, executor, cache)
        hook = stack.enter_context(_progress.hook(progress))
        output = stack.enter_context(_native.OutputFile(path))
        encoded, report = scene.build_tree(
            function=None if evaluate is None else evaluate.rates,
            batch_size=batch_size_of(batch_size, function),
            threads=threads,
            progress=hook if evaluate is None else evaluate.progress(hook),
        )
        output.commit(encoded)
    return Tree(path, report)
