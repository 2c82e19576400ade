"""What was measured with one setting, and the file of all such rows."""

import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path


@dataclass(frozen=True)
class Row:
    """One contestant with one setting in one scene; None where it found no image.

    error, estimated_error: relative to the largest pixel. peak_mib: of the whole process, the
        interpreter and its libraries included.
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
    with path.open(newline="", encoding="utf-8") as file:
        return [_parsed(row) for row in csv.DictReader(file)]


def write(path: Path, rows: list[Row]) -> None:
    """Writes all rows to a file, which is replaced when it is whole."""
    partial = path.with_suffix(".partial")
    with partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, NAMES, lineterminator="\n")
        writer.writeheader()
        writer.writerows(_spelled(row) for row in rows)
    partial.replace(path)


def _spelled(row: Row) -> dict[str, str]:
    values = {name: "" if value is None else value for name, value in asdict(row).items()}
    return {
        name: format(values[name], FORMATS.get(name, "") if values[name] != "" else "")
        for name in NAMES
    }


def _parsed(values: dict[str, str]) -> Row:
    numbers = {"evaluations": int} | dict.fromkeys(FORMATS, float)
    read = {
        name: number(values[name]) if values[name] else None for name, number in numbers.items()
    }
    return Row(**(values | read))
