"""Renders one scene with each kind of tolerance: errors.py PROGRAM SCENES FOLDER PICTURES.

Pictures go to PICTURES, everything else to FOLDER; the rows of the tables are printed.
"""

import json
import math
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, LogNorm
from PIL import Image

#: What a map of relative errors has one colour for each of.
STEPS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0)
LABELS = ("0.0001 %", "0.001 %", "0.01 %", "0.1 %", "1 %", "10 %", "100 %")
#: How many colours a picture has.
PALETTE = 256
#: Half the width of the corona's image, in solar radii.
HALF_WIDTH = 12.0
#: The corona: factors and exponents of its powers of the distance.
POWERS = ((2.99, 16), (1.55, 6), (0.0001, 2))
#: Lines along each side of a pixel, and of one that the limb crosses.
LINES, LIMB_LINES = 5, 150
#: The sources: amplitude, sharpness, centre along x, and energy [keV].
SOURCES = ((1.0, 20.0, 0.5, 1.0), (0.002, 200.0, 0.4, 5.0))
#: The energies of the bins [keV].
LOWEST, HIGHEST, BINS = 0.5, 8.0, 15


@dataclass
class Choice:
    """A kind of tolerance, its options, and the pixels that count."""

    title: str
    options: tuple[str, ...]
    counts: np.ndarray


@dataclass
class Outcome:
    """What a rendering gave."""

    values: np.ndarray
    evaluations: int


def main(program: str, scenes: str, folder: str, pictures: str) -> None:
    """Writes the pictures, and prints the tables."""
    command = Command(program, Path(folder))
    corona(command, Path(scenes) / "corona.toml", Path(pictures) / "errors-corona.png")
    bands(command, Path(scenes) / "sources.toml", Path(pictures) / "errors-bands.png")


@dataclass
class Command:
    """The command line, and a folder for what it writes."""

    program: str
    folder: Path

    def render(self, scene: Path, options: tuple[str, ...]) -> Outcome:
        """Renders a scene."""
        image, report = self.folder / "image.npy", self.folder / "report.json"
        words = [self.program, "render", scene, "-o", image, "--report", report, "--quiet"]
        subprocess.run([*words, *options], check=True)
        found = json.loads(report.read_text())
        return Outcome(np.load(image), found["evaluations"])


def corona(command: Command, scene: Path, picture: Path) -> None:
    """Maps of the error of each pixel, relative to it, and their table."""
    exact = exact_corona(200)
    distance = distances(exact.shape)
    mask, weights = command.folder / "mask.npy", command.folder / "weights.npy"
    everywhere = np.ones_like(exact, dtype=bool)
    ring = (distance > 4.0) & (distance < 8.0)
    np.save(mask, np.where(ring, 1.0, 0.0))
    np.save(weights, np.maximum(distance, 1.0) ** 3)
    choices = [
        Choice("tolerance = 0.01", ("--tolerance=0.01",), everywhere),
        Choice("rtol = 0.01, floor = 1e-3", ("--rtol=0.01", "--floor=1e-3"), everywhere),
        Choice("rtol = 0.01, floor = 1e-5", ("--rtol=0.01", "--floor=1e-5"), everywhere),
        Choice("rtol = 0.01, atol = 1e-3", ("--rtol=0.01", "--atol=1e-3"), everywhere),
        Choice("rtol = 0.01, mask of a ring", ("--rtol=0.01", f"--mask={mask}"), ring),
        Choice(
            "tolerance = 0.01, weights r³", ("--tolerance=0.01", f"--weights={weights}"), everywhere
        ),
    ]
    outcomes = [command.render(scene, choice.options) for choice in choices]
    print("# table: corona")
    rows = []
    for choice, outcome in zip(choices, outcomes, strict=True):
        rows.append(
            [choice.title, f"{outcome.evaluations:,}", *summary(outcome, exact, choice.counts)]
        )
    print_table(
        ["", "evaluations", "of the brightest", "to 1e-3", "to 1e-5", "pixels off by 1 %"], rows
    )
    draw_corona(picture, exact, choices, outcomes)


def exact_corona(pixels: int) -> np.ndarray:
    """The means of the radiance over pixels, by lines whose integrals are known."""
    image = means(pixels, LINES)
    side = 2.0 * HALF_WIDTH / pixels
    # A pixel that the limb crosses has its centre within half of its diagonal of the limb.
    limb = np.argwhere(np.abs(distances((pixels, pixels)) - 1.0) < 0.71 * side)
    offsets = ((np.arange(LIMB_LINES) + 0.5) / LIMB_LINES) * side
    for row, column in limb:
        x = column * side - HALF_WIDTH + offsets
        y = row * side - HALF_WIDTH + offsets
        image[row, column] = radiance(np.hypot(x[None, :], y[:, None])).mean()
    return image


def means(pixels: int, lines: int) -> np.ndarray:
    """The means over pixels that the limb does not cross, by a Gauss-Legendre rule."""
    nodes, weights = np.polynomial.legendre.leggauss(lines)
    side = 2.0 * HALF_WIDTH / pixels
    places = ((np.arange(pixels)[:, None] + 0.5 + 0.5 * nodes) * side - HALF_WIDTH).ravel()
    values = radiance(np.hypot(places[None, :], places[:, None]))
    values = values.reshape(pixels, lines, pixels, lines)
    return np.einsum("iajb,a,b->ij", values, weights / 2.0, weights / 2.0)


def radiance(b: np.ndarray) -> np.ndarray:
    """Of lines at distances b from the centre; those with b < 1 end at the Sun.

    With z = b tan(a) the power r^-n has b^(1 - n) times the integral of cos(a)^(n - 2).
    """
    nodes, weights = np.polynomial.legendre.leggauss(40)
    start = np.where(b < 1.0, np.arccos(np.minimum(b, 1.0)), -0.5 * np.pi)
    half = 0.25 * np.pi - 0.5 * start
    total = np.zeros_like(b)
    # Close to the centre b^(1 - n) and the integral are a large and a small number.
    for node, weight in zip(nodes, weights, strict=True):
        angle = start + half * (1.0 + node)
        r = np.maximum(b, 1e-9) / np.cos(angle)
        path = r / np.cos(angle)
        total += weight * half * path * sum(a * r**-n for a, n in POWERS)
    return total


def distances(shape: tuple[int, int]) -> np.ndarray:
    """Of the pixels' centres from that of the Sun, in solar radii."""
    height, width = shape
    y = HALF_WIDTH * ((np.arange(height) + 0.5) / height * 2.0 - 1.0)
    x = HALF_WIDTH * ((np.arange(width) + 0.5) / width * 2.0 - 1.0)
    return np.hypot(x[None, :], y[:, None])


def summary(outcome: Outcome, exact: np.ndarray, counts: np.ndarray) -> list[str]:
    """The largest errors, and how many pixels are off by more than 1 % of themselves."""
    largest = exact.max()
    error = np.abs(outcome.values - exact)[counts]
    exact = exact[counts]
    relative = error / exact
    above = [relative[exact >= floor * largest] for floor in (1e-3, 1e-5)]
    off = np.count_nonzero(relative > 0.01) / relative.size
    cells = [percent(part.max()) if part.size else "" for part in above]
    return [percent(error.max() / largest), *cells, percent(off)]


def percent(fraction: float) -> str:
    """A fraction in per cent with two digits."""
    value = 100.0 * fraction
    return f"{value:.0f} %" if value >= 10.0 else f"{value:.2g} %"


def print_table(head: list[str], rows: list[list[str]]) -> None:
    """A table in Markdown: texts on the left, numbers on the right."""
    print(f"| {' | '.join(head)} |")
    print(f"| --- {'| --: ' * (len(head) - 1)}|")
    for row in rows:
        print(f"| {' | '.join(row)} |")


def draw_corona(
    picture: Path, exact: np.ndarray, choices: list[Choice], outcomes: list[Outcome]
) -> None:
    """The corona, and a map for each choice."""
    figure, axes = plt.subplots(2, 4, figsize=(12.0, 5.8), dpi=100, layout="constrained")
    extent = (-HALF_WIDTH, HALF_WIDTH, -HALF_WIDTH, HALF_WIDTH)
    values = np.where(exact > 0.0, exact, np.nan)
    largest = np.nanmax(values)
    cells = list(axes.flat)
    shown = cells[0].imshow(
        values / largest, origin="lower", extent=extent, cmap="magma", norm=LogNorm(1e-5, 1.0)
    )
    cells[0].set_title("the corona", fontsize=9)
    bar = figure.colorbar(shown, ax=cells[0], location="left", shrink=0.8)
    bar.set_label("of the brightest pixel")
    norm = BoundaryNorm(STEPS, 256)
    colours = mpl.colormaps["viridis"].with_extremes(bad="white")
    places = [1, 2, 3, 5, 6, 7]
    cells[4].axis("off")
    last = None
    for place, choice, outcome in zip(places, choices, outcomes, strict=True):
        relative = np.abs(outcome.values - exact) / values
        relative = np.clip(relative, STEPS[0], 0.999 * STEPS[-1])
        last = cells[place].imshow(relative, origin="lower", extent=extent, cmap=colours, norm=norm)
        cells[place].set_title(f"{choice.title}\n{outcome.evaluations:,} evaluations", fontsize=9)
    for cell in cells:
        cell.tick_params(labelsize=7)
    cells[0].set_xlabel("solar radii", fontsize=8)
    bar = figure.colorbar(last, cax=cells[4].inset_axes((0.35, 0.0, 0.12, 1.0)))
    bar.set_ticks(STEPS, labels=LABELS)
    bar.set_label("|error| of a pixel / |pixel|")
    save(figure, picture)


def bands(command: Command, scene: Path, picture: Path) -> None:
    """The largest error of each band, relative to the largest voxel of it."""
    exact = exact_sources(64)
    everywhere = np.ones_like(exact[0], dtype=bool)
    choices = [
        Choice("tolerance = 0.01", ("--tolerance=0.01",), everywhere),
        Choice("tolerance = 0.01, per_band", ("--tolerance=0.01", "--per-band"), everywhere),
    ]
    outcomes = [command.render(scene, choice.options) for choice in choices]
    energies = np.linspace(LOWEST, HIGHEST, BINS + 1)
    figure, axes = plt.subplots(figsize=(7.0, 3.8), dpi=100, layout="constrained")
    rows = []
    print("# table: bands")
    for choice, outcome, colour in zip(choices, outcomes, ("#d1260f", "#0072b2"), strict=True):
        errors = np.abs(outcome.values - exact).max(axis=(1, 2))
        own = errors / exact.max(axis=(1, 2))
        label = f"{choice.title}: {outcome.evaluations:,} evaluations"
        axes.stairs(own, energies, label=label, color=colour, linewidth=1.8)
        rows.append(
            [
                choice.title,
                f"{outcome.evaluations:,}",
                percent(errors.max() / exact.max()),
                percent(own.max()),
            ]
        )
    print_table(["", "evaluations", "of the cube's brightest", "of the band's brightest"], rows)
    axes.axhline(0.01, color="0.5", linestyle="--", linewidth=1.0)
    axes.set(yscale="log", xlabel="keV")
    axes.set_ylabel("largest error of a band /\nits largest voxel")
    axes.legend(fontsize=8)
    save(figure, picture)


def exact_sources(pixels: int) -> np.ndarray:
    """The means over pixels and bins, in closed form."""
    borders = np.linspace(LOWEST, HIGHEST, BINS + 1)
    cube = np.zeros((BINS, pixels, pixels))
    for amplitude, sharpness, x, energy in SOURCES:
        spectrum = -energy * np.diff(np.exp(-borders / energy)) / np.diff(borders)
        along_x, along_y = (gaussian_means(pixels, sharpness, at) for at in (x, 0.5))
        depth = gaussian_means(1, sharpness, 0.5)[0]
        image = amplitude * depth * along_y[:, None] * along_x[None, :]
        cube += spectrum[:, None, None] * image
    return cube


def gaussian_means(intervals: int, sharpness: float, centre: float) -> np.ndarray:
    """Of exp(-sharpness (t - centre)^2) over equal parts of the unit interval."""
    root = math.sqrt(sharpness)
    borders = (np.arange(intervals + 1) / intervals - centre) * root
    primitive = np.array([math.erf(border) for border in borders])
    return 0.5 * math.sqrt(math.pi) / root * np.diff(primitive) * intervals


def save(figure: plt.Figure, path: Path) -> None:
    """Writes a picture of few colours."""
    figure.savefig(path)
    plt.close(figure)
    picture = Image.open(path).convert("RGB").quantize(PALETTE, dither=Image.Dither.NONE)
    picture.save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
