"""Measures contestants and writes what was found: `python -m peers [NAME ...]`.

A name is that of a contestant or a scene, or `users`: what users would pick, in the scenes of their
table. Without names all is measured; with names the rows of the others stay.
"""

import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from . import document, harness, row, runs
from .contestant import Contestant
from .contestants import CONTESTANTS
from .scene import Scene
from .scenes import SCENES, USERS

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
RESULTS = ROOT / "bench" / "runs" / "peers.csv"
DOCS = ROOT / "docs"
COMMAND = ("cargo", "xtask", "compare-peers")


def main(names: list[str]) -> str | None:
    """Returns what was wrong with the names, if anything was."""
    try:
        contestants, scenes = selected(names)
    except ValueError as error:
        return str(error)
    run = runs.now([*COMMAND, *names], ROOT)
    rows = list(measure(contestants, scenes, run))
    fresh = {(contestant.name, scene.name) for contestant in contestants for scene in scenes}
    rows += [old for old in row.read(RESULTS) if (old.contestant, old.scene) not in fresh]
    # Of contestants and scenes that are there no more, nothing is kept.
    order, places = list(CONTESTANTS), list(SCENES)
    rows = [one for one in rows if one.contestant in order and one.scene in places]
    rows.sort(key=lambda one: (order.index(one.contestant), places.index(one.scene)))
    RESULTS.parent.mkdir(exist_ok=True)
    row.write(RESULTS, rows)
    document.write(DOCS, rows, list(CONTESTANTS.values()), list(SCENES.values()))
    return None


def selected(names: Sequence[str]) -> tuple[list[Contestant], list[Scene]]:
    """The contestants and the scenes that are named; all, where none is.

    Raises ValueError for names of neither.
    """
    known = [*CONTESTANTS, *SCENES, "users"]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"unknown contestants or scenes {unknown}: expected some of {known}")
    contestants = [
        one
        for one in CONTESTANTS.values()
        if one.name in names or ("users" in names and one.for_users)
    ]
    scenes = [
        one
        for one in SCENES.values()
        if one.name in names or ("users" in names and one.name in USERS)
    ]
    return contestants or list(CONTESTANTS.values()), scenes or list(SCENES.values())


def measure(
    contestants: Sequence[Contestant], scenes: Sequence[Scene], run: runs.Run
) -> Iterator[row.Row]:
    """The rows of contestants in scenes, printed as they come."""
    start, count = time.monotonic(), 0
    for scene in scenes:
        exact, disagreement = scene.verified_image()
        say(f"{scene.name}: the exact images agree to {disagreement:.1e} of the largest pixel")
        for contestant in contestants:
            for measured in harness.sweep(contestant, scene, exact, run):
                count += 1
                say(line(measured))
                yield measured
    say(f"{count} settings in {time.monotonic() - start:.0f} s")


def line(measured: row.Row) -> str:
    """One row to read."""
    head = f"{measured.scene:5}  {measured.contestant:20}  {measured.setting:40}"
    if not measured.found:
        return f"{head}  {measured.note}"
    cost = f"{measured.evaluations:>12,}  {measured.error:.2e}  {measured.seconds:8.3f} s"
    return f"{head}  {cost}  {measured.peak_mib:6.0f} MiB"


def say(text: str) -> None:
    """Prints at once, also into a pipe."""
    print(text, flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
