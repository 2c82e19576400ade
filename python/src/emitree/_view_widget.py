"""The widget of a view: its state, which the browser has too, and the messages between both."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import anywidget
import numpy as np
import traitlets

from emitree._cameras import Camera
from emitree._progressive import Frame
from emitree._result import Rendering
from emitree._view_messages import STOPPING, ended_message, goal_of, message_of
from emitree._view_picture import picture_of, size_of, spectrum_at
from emitree._view_turn import can_turn, turned
from emitree._view_work import Target, Update, Work

_HERE = Path(__file__).parent

#: How many bytes of pictures a view sends in a second: servers of notebooks drop more than 1 MB/s.
_BYTES_PER_S = 400_000

#: While the camera is turned: the tolerance, and the longer side of the image [pixels].
_COARSE_TOLERANCE = 0.1
_COARSE_SIDE = 48

#: Which errors are allowed where: keywords that coarse pictures do not have.
_OF_ERRORS = ("rtol", "atol", "floor", "weights", "mask", "per_band", "sums")


class View(anywidget.AnyWidget, metaclass=traitlets.MetaHasTraits):
    """An image in a notebook, which sharpens while it is rendered; `view` makes it.

    The traits are what a saved notebook has: the last picture, what it shows, and the message.
    """

    # One module: a widget has no others that it could import without a network.
    _esm = "".join(
        (_HERE / name).read_text(encoding="utf-8") for name in ("_view_drawing.js", "_view.js")
    )
    _css = (_HERE / "_view.css").read_text(encoding="utf-8")

    #: As of `picture_of`; empty before the first image.
    picture = traitlets.Dict().tag(sync=True)
    #: phase of the rendering; message; goal, the tolerance; can_turn, can_resume.
    status = traitlets.Dict().tag(sync=True)
    #: Where the pixel is whose values are shown, as fractions of the width and of the height from
    #: the lower left; empty without one.
    cursor = traitlets.List(traitlets.Float()).tag(sync=True)
    #: As of `spectrum_at`, for the pixel at the cursor; empty without energies.
    spectrum = traitlets.Dict().tag(sync=True)
    #: The name of the picture for readers without widgets.
    still = traitlets.Unicode().tag(sync=True)
    #: How values become colours.
    stretch = traitlets.Enum(["linear", "log"], "linear").tag(sync=True)
    #: The map beside the image.
    beside = traitlets.Enum(["error", "evaluations"], "error").tag(sync=True)

    def __init__(self, rendering: Rendering | None = None, **traits: Any) -> None:
        self._rendering: Rendering | None = None
        self._work: Work | None = None
        self._target: Target | None = None
        self._changing = threading.RLock()
        self._is_sky = False
        self._is_displayed = False
        super().__init__(still=uuid.uuid4().hex, **traits)
        self.on_msg(self._on_message)
        self.observe(self._on_cursor, "cursor")
        if rendering is not None:
            goal = goal_of(rendering.report)
            self._show(rendering, is_whole_sky(rendering))
            self._tell("done", ended_message(rendering, goal))

    @classmethod
    def of_emission(cls, emission: Any, target: Target, calls: Mapping[str, Any]) -> View:
        """A view that renders."""
        view = cls()
        view._work = Work(emission, calls, view._on_update)
        view._target = target
        view._start([target])
        return view

    @property
    def rendering(self) -> Rendering | None:
        """The latest rendering that has ended, or intermediate one of a function; None before.

        An intermediate one has not converged.
        """
        return self._rendering

    @property
    def camera(self) -> Camera | None:
        """The camera as it was turned; None of the view of a finished rendering."""
        return None if self._target is None else self._target.camera

    def stop(self) -> None:
        """Ends the rendering, after the call of a function that is under way."""
        if self._work is not None:
            with self._changing:
                if self.status["phase"] == "running":
                    self._tell("running", STOPPING)
            self._work.stop()

    def resume(self, **options: Any) -> None:
        """Continues after a stop, or to a tighter tolerance.

        No point of a function is evaluated twice. Formulas, models and grids are rendered anew.

        options: those of the method and its limits, as of `Session.resume`, such as `tolerance`.

        Raises `SceneError` if one is wrong, `ValueError` of the view of a finished rendering.
        """
        from emitree._view import checked

        former = self._needed()
        target = Target(former.camera, former.shape, {**former.options, **options})
        checked(self._emission(), target)
        self._target = target
        self._start([target])

    def turn(self, right: float, up: float, *, is_final: bool = True) -> None:
        """Turns the camera as a drag over the image does, and renders the image from there.

        right, up: fractions of the width and of the height of the image. A perspective or parallel
            camera goes around its target, by 180 degrees for the whole image, and keeps its
            distance; others stay where they are, and turn by their field of view.
        is_final: if not, only a coarse picture is rendered.

        Raises `ValueError` if the camera has no direction, or has the coordinates of a WCS.
        """
        target = self._needed()
        if not can_turn(target.camera):
            raise ValueError(f"{type(target.camera).__name__} cannot be turned: expected a camera "
                             "with a target, and without the coordinates of a WCS")  # fmt: skip
        if right or up:
            camera = turned(target.camera, right, up)
            target = self._target = Target(camera, target.shape, target.options)
        coarse = _coarse(target)
        self._start([coarse, target] if is_final else [coarse])

    def wait(self, timeout: float | None = None) -> Rendering | None:
        """Waits until the rendering has ended, and returns it.

        timeout: how long to wait at most [s]; then the latest rendering is returned.

        Raises what ended the rendering, such as an exception of the function.
        """
        if self._work is not None:
            self._work.wait(timeout)
        return self._rendering

    def close(self) -> None:
        """Ends the rendering, and removes the view from the notebook."""
        self.stop()
        super().close()

    def __repr__(self) -> str:
        return f"<emitree.View: {self.status.get('phase', 'running')}>"

    def _ipython_display_(self) -> None:
        from IPython.display import display

        data, metadata = self._repr_mimebundle_()
        # The text stays as it is.
        data["text/plain"] = "<emitree.View>"
        display(data, metadata=metadata, raw=True)
        self._is_displayed = True
        display(self._still(), raw=True, display_id=self.still)

    def _still(self) -> dict[str, Any]:
        """The picture of the rendering for readers of notebooks that show no widgets."""
        data: dict[str, Any] = {"text/plain": repr(self)}
        of_rendering = ""
        if self._rendering is not None:
            data["image/png"] = self._rendering._repr_png_()
            of_rendering = self._rendering._repr_html_()
        data["text/html"] = f'<div class="emitree-still-{self.still}">{of_rendering}</div>'
        return data

    def _replace_still(self) -> None:
        """Replaces that picture in the outputs where the view is shown."""
        if self._is_displayed:
            from IPython.display import update_display

            update_display(self._still(), raw=True, display_id=self.still)

    def _needed(self) -> Target:
        if self._target is None:
            raise ValueError(
                "the view is that of a finished rendering: expected one of `emitree.view`, which "
                "has the emission"
            )
        return self._target

    def _emission(self) -> Any:
        assert self._work is not None, "a view with a target renders"
        return self._work.emission

    def _start(self, targets: Sequence[Target]) -> None:
        assert self._work is not None, "a view with a target renders"
        # The first image may take long.
        self._tell("running", message_of(Update("running", targets[0], None, 0)))
        self._work.start(targets)

    def _on_update(self, update: Update) -> float:
        pause_s = 0.0
        if update.latest is not None:
            pause_s = self._show(update.latest, update.target.camera._is_sky) / _BYTES_PER_S
        with self._changing:
            self._tell(update.phase, message_of(update))
        if update.phase == "stopped" or (update.phase == "done" and update.target is self._target):
            self._replace_still()
        return pause_s

    def _show(self, found: Rendering | Frame, is_sky: bool) -> int:
        """Shows an image, and returns how many bytes that takes."""
        state = picture_of(found, is_sky)
        with self._changing:
            if isinstance(found, Rendering):
                self._rendering = found
            if state != self.picture:
                self.picture = state
            self._is_sky = is_sky
            self._choose_spectrum()
        return size_of(state)

    def _tell(self, phase: str, message: str) -> None:
        self.status = {
            "phase": phase,
            "message": message,
            "goal": None if self._target is None else goal_of(self._target.options),
            "can_turn": can_turn(self.camera),
            "can_resume": self._target is not None,
        }

    def _choose_spectrum(self) -> None:
        """The spectrum at the cursor, of the latest rendering if the picture is of it."""
        found, picture = self._rendering, self.picture
        spectrum = None
        if found is not None and len(self.cursor) == 2 and picture.get("evaluations") is not None:
            sides = np.array([picture["width"], picture["height"]])
            column, row = np.clip(np.floor(self.cursor * sides), 0, sides - 1).astype(int).tolist()
            spectrum = spectrum_at(found, row, column, picture["block"], self._is_sky)
        self.spectrum = spectrum or {}

    def _on_cursor(self, change: Any) -> None:
        with self._changing:
            self._choose_spectrum()

    def _on_message(self, widget: Any, content: Any, buffers: Any) -> None:
        """Does what the browser asks for; what is wrong is told in the view."""
        try:
            kind = content.get("kind")
            if kind == "hello":
                self.send({"kind": "hello"})
            elif kind == "stop":
                self.stop()
            elif kind == "resume":
                self.resume(**content.get("options", {}))
            elif kind == "turn":
                right, up = float(content["right"]), float(content["up"])
                self.turn(right, up, is_final=bool(content.get("is_final")))
        except Exception as error:
            self._tell("failed", f"{type(error).__name__}: {error}")


def is_whole_sky(rendering: Rendering) -> bool:
    """Whether the image of a rendering is that of a HEALPix sky."""
    return not rendering._found.axes()


def _coarse(target: Target) -> Target:
    """The same image with fewer pixels and, by method "vol", a larger error."""
    options = dict(target.options)
    if options.get("method") in (None, "vol"):
        options = {key: value for key, value in options.items() if key not in _OF_ERRORS}
        options["tolerance"] = max(_COARSE_TOLERANCE, target.options.get("tolerance") or 0.0)
    height, width = np.broadcast_to(np.asarray(target.shape), (2,)).tolist()
    share = min(1.0, _COARSE_SIDE / max(height, width))
    shape = (max(1, round(height * share)), max(1, round(width * share)))
    return Target(target.camera, shape, options)
