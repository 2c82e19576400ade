"""Images in notebooks, which sharpen while they are rendered."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from emitree._cameras import Camera
from emitree._scene import is_scene_file
from emitree._session import SESSION_OPTIONS
from emitree._setup import scene_of_camera, with_own
from emitree._several import Several
from emitree._view_work import CALL_OPTIONS, Target

if TYPE_CHECKING:
    from emitree._result import Rendering
    from emitree._view_widget import View


def view(
    emission: Any,
    camera: Camera,
    shape: Sequence[int] | int | None = None,
    **options: Any,
) -> View:
    """A view of an emission in a notebook: the image as it sharpens, and its error beside it.

    The rendering runs in a thread, which also calls the function; the cell ends at once. The view
    has the value and the error of the pixel at the cursor, of a cube its spectrum, a linear or a
    logarithmic scale of colours, a map of the evaluations, a button that stops, and one that goes
    on to a tighter tolerance. Dragging the image turns the camera, and shows a coarse picture
    first. With the focus on the image, arrows move the cursor, and turn the camera with the shift
    key.

    `view.rendering` is the latest rendering; `wait`, `stop`, `resume` and `turn` are methods.
    A notebook that JupyterLab saves has the last picture.

    emission, camera, shape: as of `render`; no scene file, and no list of emissions.
    options: keywords of `render`, but for `progress`, `frame` and `changes`.

    Raises `ImportError` without anywidget, and for wrong arguments what `render` raises. What ends
    the rendering is told in the view, and raised by `wait`.

    >>> import emitree
    >>> view = emitree.view("1 + x*y", emitree.Canonical(), (16, 16))
    >>> view.wait().converged
    True
    >>> view
    <emitree.View: done>
    """
    widget = _widget()
    if is_scene_file(emission):
        raise TypeError(
            f"the emission is the scene file {str(emission)!r}: expected an emission and a camera, "
            "or `emitree.render(file).view()`"
        )
    if Several.of(emission) is not None:
        raise TypeError("the emission is a list of emissions: expected one")
    for name in options:
        if name not in SESSION_OPTIONS and name not in CALL_OPTIONS:
            known = ", ".join(sorted([*SESSION_OPTIONS, *CALL_OPTIONS]))
            raise TypeError(f"unknown option `{name}`: expected one of {known}")
    if shape is None and camera.sky is not None:
        shape = camera.sky.shape
    if shape is None:
        raise TypeError("expected `shape`, (height, width)")
    calls = {name: options.pop(name) for name in CALL_OPTIONS if name in options}
    target = Target(camera, shape, with_own(emission, options))
    checked(emission, target)
    return widget.View.of_emission(emission, target, calls)


def view_of(rendering: Rendering) -> View:
    """The view of a rendering that has ended: `Rendering.view`."""
    return _widget().View(rendering)


def checked(emission: Any, target: Target) -> None:
    """Raises what is wrong with a target."""
    scene_of_camera(emission, target.camera, target.shape, target.options)


def _widget() -> Any:
    """The module of the widget, which needs anywidget."""
    try:
        return importlib.import_module("emitree._view_widget")
    except ImportError as error:
        raise ImportError(
            "anywidget is missing: expected it for views in notebooks; "
            '`pip install "emitree[notebook]"` installs it'
        ) from error
