"""A run of the comparison: where, from what and how rows were measured."""

import os
import platform
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path

UNKNOWN = "unknown"


@dataclass(frozen=True)
class Run:
    """One call of the command.

    machine: processor, cores, memory and system. commit: of the sources, "-dirty" where files were
        changed since. command: what was called. date: when, in UTC.
    """

    machine: str = UNKNOWN
    commit: str = UNKNOWN
    command: str = UNKNOWN
    date: str = UNKNOWN

    def spelled(self, number: int) -> str:
        """Lines of comments for a file."""
        lines = [("run", number), *asdict(self).items()]
        return "".join(f"# {name}: {value}\n" for name, value in lines)


#: Of rows without an entry.
SOME_RUN = Run()


def now(command: Sequence[str], folder: Path) -> Run:
    """The run that is going on, of the sources in a folder."""
    date = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    words = (f'"{word}"' if " " in word else word for word in command)
    return Run(machine(), commit(folder), " ".join(words), date)


def parsed(lines: Sequence[str]) -> dict[int, Run]:
    """The runs of a file, from its comments."""
    found: list[dict[str, str]] = []
    for line in lines:
        name, _, value = line.removeprefix("# ").rstrip("\n").partition(": ")
        if name == "run":
            found.append({})
        found[-1][name] = value
    names = [field.name for field in fields(Run)]
    return {int(run["run"]): Run(*(run[name] for name in names)) for run in found}


def machine() -> str:
    """Processor, cores, memory and system of this machine."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    system = f"{platform.system()}, Python {platform.python_version()}"
    return f"{_processor()}, {os.cpu_count()} cores, {memory:.0f} GiB, {system}"


def commit(folder: Path) -> str:
    """The commit that is checked out in a folder; "unknown" without git."""
    head = _git(folder, "rev-parse", "HEAD")
    if head is None:
        return UNKNOWN
    return head + ("-dirty" if _git(folder, "status", "--porcelain") else "")


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        found = subprocess.run(
            ["git", *arguments], cwd=folder, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return found.stdout.strip()


def _processor() -> str:
    named = dict(_of_linux(Path("/proc/cpuinfo")))
    return named.get("model name") or platform.processor() or platform.machine() or UNKNOWN


def _of_linux(path: Path) -> Iterator[tuple[str, str]]:
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            name, _, value = line.partition(":")
            yield name.strip(), value.strip()
