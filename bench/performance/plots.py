"""Draws how costs grow: plots.py NUMBERS FOLDER."""

import csv
import sys
from collections.abc import Iterable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

#: Distinct for the colour-blind too (Okabe and Ito), dark enough for thin lines on white.
COLOURS = ("#d1260f", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
MARKERS = ("o", "s", "^", "v", "D", "P")
#: File, table, its column on each axis.
PLOTS = (
    ("performance-tolerance", "Against the tolerance", "tolerance", "evaluations"),
    ("performance-pixels", "Against the pixels", "pixels along", "seconds"),
    ("performance-bins", "Against the bins", "bins", "seconds"),
    ("performance-width", "Against the width of a structure", "width", "evaluations"),
    (
        "performance-growth",
        "Trees of method paper grown to so many evaluations",
        "evaluations",
        "peak MiB",
    ),
)
#: How many colours a picture has.
PALETTE = 64


def main(numbers: str, folder: str) -> None:
    """Draws all plots of the tables in a file of numbers."""
    tables = read(Path(numbers).read_text().splitlines())
    for name, title, across, up in PLOTS:
        if tables.get(title):
            draw(Path(folder) / f"{name}.png", title, tables[title], across, up)


def read(lines: Iterable[str]) -> dict[str, list[dict[str, str]]]:
    """The rows of each table, by its title."""
    texts: dict[str, list[str]] = {}
    title = ""
    for line in lines:
        if line.startswith("# table: "):
            title = line.removeprefix("# table: ")
        elif line and not line.startswith("#"):
            texts.setdefault(title, []).append(line)
    return {title: list(csv.DictReader(text)) for title, text in texts.items()}


def draw(path: Path, title: str, rows: list[dict[str, str]], across: str, up: str) -> None:
    """Draws one table: a line for each series, both axes logarithmic."""
    figure, axes = plt.subplots(figsize=(7.5, 4.6), dpi=110, layout="constrained")
    for at, name in enumerate(dict.fromkeys(row["series"] for row in rows)):
        own = [row for row in rows if row["series"] == name]
        x, y = ([float(row[column]) for row in own] for column in (across, up))
        look = {"color": COLOURS[at % len(COLOURS)], "marker": MARKERS[at % len(MARKERS)]}
        axes.plot(x, y, label=name, linewidth=1.6, markersize=4.5, **look)
    axes.set(xscale="log", yscale="log", xlabel=across, ylabel=up, title=title)
    axes.grid(color="0.9", linewidth=0.7)
    axes.legend(frameon=False, fontsize=9)
    figure.canvas.draw()
    # With a palette: a third of the size, without a visible difference.
    picture = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    picture.quantize(PALETTE, dither=Image.Dither.NONE).save(path, optimize=True)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:])
