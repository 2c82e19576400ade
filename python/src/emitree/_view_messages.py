"""What a view says of its rendering."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from emitree._progressive import Frame
from emitree._result import Rendering
from emitree._view_picture import band_of, error_of
from emitree._view_work import Update

#: After the button that stops.
STOPPING = "Stopping, after the call that is under way."

#: Why a rendering ended that has not converged, by `ending` of its report.
_ENDINGS = {
    "budget": "the limit `max_evaluations` was reached",
    "time": "the limit `max_seconds` was reached",
    "deepest level": "the finest level was reached",
}


def goal_of(options: Mapping[str, Any]) -> dict[str, Any] | None:
    """The name and the value of the tolerance of a rendering, if it has one that is a number.

    options: keywords of `render`, or the report of a rendering.

    >>> goal_of({"rtol": 0.05}), goal_of({"method": "paper"})
    ({'name': 'rtol', 'value': 0.05}, None)
    """
    for name in ("tolerance", "rtol"):
        if options.get(name) is not None:
            return {"name": name, "value": float(options[name])}
    has_other = any(options.get(name) is not None for name in ("atol", "steps", "evaluations"))
    if has_other or options.get("method") == "paper":
        return None
    return {"name": "tolerance", "value": 0.01}


def message_of(update: Update) -> str:
    """One or two sentences about an update."""
    if update.phase == "failed":
        return f"The rendering failed. {_reason(update.error)}"
    if update.phase == "done" and isinstance(update.latest, Rendering):
        return ended_message(update.latest, goal_of(update.target.options))
    state = "Rendering" if update.phase == "running" else "Stopped"
    if update.evaluations == 0 and update.latest is None:
        return f"{state}: no evaluations yet."
    numbers = f"{state}: {_counted(update.evaluations)}"
    if update.latest is None:
        return f"{numbers}, no image yet."
    goal = goal_of(update.target.options)
    aim = "" if goal is None else f" ({goal['name']} {goal['value']:g})"
    return f"{numbers}, {_error_text(error_so_far(update.latest))}{aim}."


def ended_message(rendering: Rendering, goal: Mapping[str, Any] | None) -> str:
    """Two sentences about a rendering that has ended."""
    text = f"{_counted(rendering.evaluations)}, {_error_text(rendering.estimated_error)}."
    aim = "The tolerance" if goal is None else f"The {goal['name']} {goal['value']:g}"
    if rendering.error is None:
        return text
    if rendering.converged:
        return f"{text} {aim} is met."
    ending = rendering.report["ending"]
    return f"{text} {aim} is not met: {_ENDINGS.get(ending, f'its end is {ending!r}')}."


def error_so_far(found: Rendering | Frame) -> float | None:
    """The largest estimated error over the largest |pixel|, or None."""
    if isinstance(found, Rendering):
        return found.estimated_error
    error = error_of(found)
    largest = float(np.nanmax(np.abs(band_of(found)), initial=0.0))
    return None if error is None or largest == 0 else float(np.nanmax(error)) / largest


def _counted(evaluations: int) -> str:
    return f"{evaluations:,} evaluation{'' if evaluations == 1 else 's'}"


def _error_text(error: float | None) -> str:
    if error is None:
        return "error not estimated"
    return f"estimated error {error:.1e} of the largest pixel"


def _reason(error: BaseException | None) -> str:
    """An exception with the first note that was added to it."""
    lines = [f"{type(error).__name__}: {error}", *getattr(error, "__notes__", [])[:1]]
    return " ".join(line.strip() for line in lines)
