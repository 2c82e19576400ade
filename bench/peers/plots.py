"""Error against evaluations of all contestants in a scene, as a picture."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from . import tables
from .row import Row
from .scene import Scene

#: Distinct for the colour-blind too (Okabe and Ito, Tol), dark enough for thin lines on white.
COLOURS = ("#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255", "#999933", "#44aa99")
OURS_COLOUR = "#d1260f"
STYLES = ("-", "--", ":")
MARKERS = ("o", "s", "^")
#: What is in the picture.
EVALUATIONS = (1e2, 3e7)
ERRORS = (3e-8, 1.0)
#: And in those of scenes where everything costs more.
OF_CAMERAS = {
    "smile": {"xlim": (1e4, 1e9), "ylim": (1e-4, 1.0)},
    "zodi": {"xlim": (2e3, 3e7), "ylim": (1e-5, 1.0)},
}
#: How many colours a picture has.
PALETTE = 96
#: Where a name stands beside the last point of its curve.
PLACES = {
    "below": {"xytext": (0, -9), "ha": "center", "va": "top", "fontweight": "bold"},
    "left": {"xytext": (-7, 0), "ha": "right", "va": "center"},
    "right": {"xytext": (7, 0), "ha": "left", "va": "center"},
}


def draw(path: Path, scene: Scene, rows: Sequence[Row], contestants: Sequence[str]) -> None:
    """Draws one scene: a dot for each setting, a line through those that are not bettered.

    The names of ours, and of all that need fewest evaluations of the others, stand in it.
    """
    figure, axes = plt.subplots(figsize=(9.5, 5.8), dpi=110, layout="constrained")
    winners, (height, width) = _winners(rows), scene.shape
    for at, name in enumerate(contestants):
        own = [row for row in tables.of(rows, name) if row.found and row.error > 0]
        if not own:
            continue
        look = _look(at, name)
        _curve(axes, own, look)
        if name == tables.OURS or name in winners:
            _label(axes, _end(own), look["color"], rows)
    axes.set(
        xscale="log",
        yscale="log",
        xlabel=f"evaluations of g for {height} x {width} pixels",
        ylabel="largest error / largest pixel",
        title=f"{scene.name}: {scene.title}",
        **OF_CAMERAS.get(scene.name, {"xlim": EVALUATIONS, "ylim": ERRORS}),
    )
    for level in tables.LEVELS.values():
        axes.axhline(level, color="0.88", linewidth=0.8, zorder=0)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=9)
    _save(figure, path)
    plt.close(figure)


def frontier(rows: Sequence[Row]) -> list[Row]:
    """The rows that no row with as few evaluations betters, from the cheapest on."""
    best: list[Row] = []
    for row in sorted(rows, key=lambda row: (row.evaluations, row.error)):
        if not best or row.error < best[-1].error:
            best.append(row)
    return best


def _winners(rows: Sequence[Row]) -> set[str]:
    """Those that need fewest evaluations for some level, ours left aside."""
    others = [row for row in rows if row.contestant != tables.OURS]
    best = (tables.cheapest(others, error) for error in tables.LEVELS.values())
    return {row.contestant for row in best if row is not None}


def _look(at: int, name: str) -> dict:
    if name == tables.OURS:
        return {"color": OURS_COLOUR, "linewidth": 3.6, "marker": "o", "markersize": 6, "zorder": 5}
    turn, colour = divmod(at - 1, len(COLOURS))
    return {
        "color": COLOURS[colour],
        "linestyle": STYLES[turn],
        "linewidth": 1.4,
        "marker": MARKERS[turn],
        "markersize": 4,
        "zorder": 3,
    }


def _curve(axes, rows: Sequence[Row], look: dict) -> None:
    best = frontier(rows)
    name = rows[0].contestant
    axes.plot(_evaluations(best), [row.error for row in best], label=name, **look)
    others = [row for row in rows if row not in best]
    faint = {"color": look["color"], "alpha": 0.45, "linewidths": 0, "zorder": 2}
    axes.scatter(_evaluations(others), [row.error for row in others], s=9, **faint)


def _evaluations(rows: Sequence[Row]) -> list[int]:
    return [row.evaluations for row in rows]


def _end(rows: Sequence[Row]) -> Row:
    """The last point of a curve that is well within the picture."""
    best = frontier(rows)
    return ([row for row in best if row.error > 2 * ERRORS[0]] or best)[-1]


def _label(axes, end: Row, colour: str, rows: Sequence[Row]) -> None:
    """A name at the end of its curve, on the side away from ours."""
    ours = tables.cheapest(tables.of(rows, tables.OURS), end.error)
    if end.contestant == tables.OURS:
        place = "below"
    else:
        place = "right" if ours is not None and ours.evaluations < end.evaluations else "left"
    axes.annotate(
        end.contestant,
        (end.evaluations, end.error),
        textcoords="offset points",
        color=colour,
        fontsize=10,
        bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7},
        zorder=6,
        **PLACES[place],
    )


def _save(figure, path: Path) -> None:
    """Writes a PNG with a palette: a third of the size, without a visible difference."""
    figure.canvas.draw()
    picture = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    picture.quantize(PALETTE, dither=Image.Dither.NONE).save(path, optimize=True)
