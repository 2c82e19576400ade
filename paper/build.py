"""Builds the paper as a PDF, and compares its numbers with those of the documents.

    python paper/build.py FOLDER

writes FOLDER/paper.pdf. A citation that the bibliography does not have is an error, as is a number of
four digits or more that is neither in `docs/results` nor in `docs/peers.md`.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pypandoc
import typst

PAPER = Path(__file__).parent / "paper.md"
DOCUMENTS = PAPER.parents[1] / "docs"
#: Sections that the journal asks for, and the number of words that it allows.
SECTIONS = ["Summary", "Statement of need", "State of the field", "Software design", "References"]
WORDS = range(750, 1751)


def defects(text: str) -> list[str]:
    """What the paper has that the documents have not, and what it lacks."""
    names = [*sorted((DOCUMENTS / "results").glob("*.md")), DOCUMENTS / "peers.md"]
    known = "\n".join(path.read_text(encoding="utf-8") for path in names)
    _, _, body = text.split("---\n", 2)
    numbers = set(re.findall(r"\b\d{1,3}(?:,\d{3})+\b", body))
    found = [f"{number}: no document has it" for number in sorted(numbers) if number not in known]
    headings = re.findall(r"^# (.*)$", body, re.MULTILINE)
    found += [f"there is no section `{name}`" for name in SECTIONS if name not in headings]
    words = len(re.findall(r"\w[\w.,'-]*", body))
    if words not in WORDS:
        found.append(f"{words} words: expected {WORDS.start} to {WORDS.stop - 1}")
    return found


def main() -> None:
    """Checks and builds."""
    folder = Path(sys.argv[1])
    found = defects(PAPER.read_text(encoding="utf-8"))
    if found:
        sys.exit("\n".join(f"{PAPER}: {defect}" for defect in found))
    folder.mkdir(parents=True, exist_ok=True)
    made = folder / "paper.typ"
    pandoc = [pypandoc.get_pandoc_path(), PAPER.name, "--citeproc", "--fail-if-warnings"]
    options = ["--standalone", "--to", "typst", "--output", made.resolve()]
    subprocess.run([*pandoc, *options], cwd=PAPER.parent, check=True)
    typst.compile(made, output=folder / "paper.pdf")


if __name__ == "__main__":
    main()
