"""Measures contestants and writes what was found: `python -m peers [CONTESTANT ...]`.

Without names all contestants are measured; with names these are, and the rows of the others stay.
"""

import sys
import time
from pathlib import Path

from . import document, harness, row
from .contestants import CONTESTANTS
from .scenes import SCENES

FOLDER = Path(__file__).resolve().parent
RESULTS = FOLDER / "results.csv"
DOCS = FOLDER.parent.parent / "docs"


def main(names: list[str]) -> str | None:
    """Returns what was wrong with the names, if anything was."""
    unknown = [name for name in names if name not in CONTESTANTS]
    if unknown:
        return f"unknown contestants {unknown}: expected some of {list(CONTESTANTS)}"
    wanted = [CONTESTANTS[name] for name in names or CONTESTANTS]
    rows = measure(wanted)
    fresh = {contestant.name for contestant in wanted}
    rows += [old for old in row.read(RESULTS) if old.contestant not in fresh]
    # Of contestants that are there no more, nothing is kept.
    order = list(CONTESTANTS)
    rows = [one for one in rows if one.contestant in order]
    rows.sort(key=lambda one: (order.index(one.contestant), list(SCENES).index(one.scene)))
    row.write(RESULTS, rows)
    document.write(DOCS, rows, list(CONTESTANTS.values()), list(SCENES.values()))
    return None


def measure(contestants) -> list[row.Row]:
    """The rows of all scenes, said as they come."""
    rows, start = [], time.monotonic()
    for scene in SCENES.values():
        exact, disagreement = scene.verified_image()
        say(f"{scene.name}: the exact images agree to {disagreement:.1e} of the largest pixel")
        for contestant in contestants:
            for measured in harness.sweep(contestant, scene, exact):
                rows.append(measured)
                say(line(measured))
    say(f"{len(rows)} settings in {time.monotonic() - start:.0f} s")
    return rows


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
