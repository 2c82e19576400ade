"""What was measured with one setting, and the file of all such rows."""

import csv
from dataclasses import dataclass, fields
from pathlib import Path

from . import runs
from .runs import Run


@dataclass(frozen=True)
class Row:
    """One contestant with one setting in one scene; None where it found no image.

    error, estimated_error: relative to the largest pixel. peak_mib: of the whole process, the
        interpreter and its libraries included. run: when it was measured.
    """

    contestant: str
    version: str
    scene: str
    setting: str
    evaluations: int | None = None
    error: float | None = None
    estimated_error: float | None = None
    seconds: float | None = None
    peak_mib: float | None = None
    note: str = ""
    run: Run = runs.SOME_RUN

    @property
    def repeated(self) -> tuple[str, str, str]:
        """What rows have in common that differ in nothing but their random start."""
        words = [word for word in self.setting.split() if not word.startswith("seed=")]
        return self.contestant, self.scene, " ".join(words)

    @property
    def found(self) -> bool:
        """Whether there is an image, with numbers in all its pixels."""
        return self.error is not None and self.error == self.error


NAMES = [field.name for field in fields(Row)]
#: How numbers are written: digits that mean something, so that files can be compared.
FORMATS = {"error": ".4e", "estimated_error": ".4e", "seconds": ".4f", "peak_mib": ".0f"}


def read(path: Path) -> list[Row]:
    """The rows of a file; none if there is no file."""
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    comments = [line for line in lines if line.startswith("# ")]
    known = runs.parsed(comments)
    return [_parsed(values, known) for values in csv.DictReader(lines[len(comments) :])]


def write(path: Path, rows: list[Row]) -> None:
    """Writes all rows to a file, which is replaced when it is whole: runs first, then a table."""
    # Runs of which no row is left are not there any more.
    numbers: dict[Run, int] = {}
    for row in sorted(rows, key=lambda row: row.run.date):
        numbers.setdefault(row.run, len(numbers) + 1)
    partial = path.with_suffix(".partial")
    with partial.open("w", newline="", encoding="utf-8") as file:
        file.writelines(run.spelled(number) for run, number in numbers.items())
        writer = csv.DictWriter(file, NAMES, lineterminator="\n")
        writer.writeheader()
        writer.writerows(_spelled(row, numbers) for row in rows)
    partial.replace(path)


def _spelled(row: Row, numbers: dict[Run, int]) -> dict[str, str]:
    values = {name: getattr(row, name) for name in NAMES} | {"run": numbers[row.run]}
    return {
        name: "" if value is None else format(value, FORMATS.get(name, ""))
        for name, value in values.items()
    }


def _parsed(values: dict[str, str], known: dict[int, Run]) -> Row:
    numbers = {"evaluations": int} | dict.fromkeys(FORMATS, float)
    read = {
        name: number(values[name]) if values[name] else None for name, number in numbers.items()
    }
    return Row(**(values | read | {"run": known[int(values["run"])]}))
