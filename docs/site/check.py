"""Checks the built site: it opens without a server and a network.

    python docs/site/check.py FOLDER

Every link to a file leads to one, every anchor exists, no page loads anything from elsewhere, and
none shows a path of the machine that built it.
Pages of rustdoc, in `rust/`, are checked by rustdoc.
"""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

#: The repository.
ROOT = Path(__file__).resolve().parents[2]
#: What a browser loads without being asked to.
LOADED = {
    "script": "src",
    "img": "src",
    "link": "href",
    "iframe": "src",
    "source": "src",
    "video": "src",
}
#: Links of `link` that name a page instead of loading a file.
NAMES = {
    "search",
    "next",
    "prev",
    "index",
    "canonical",
    "author",
    "copyright",
    "up",
    "top",
}


class Page(HTMLParser):
    """The anchors and links of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()
        self.loads: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Notes what a tag has."""
        values = {name: value or "" for name, value in attributes}
        self.anchors |= {values[name] for name in ("id", "name") if name in values}
        if tag == "a" and "href" in values:
            self.links.add(values["href"])
        loaded = LOADED.get(tag)
        if loaded in values and values.get("rel", "") not in NAMES:
            self.loads.add(values[loaded])


def defects(folder: Path) -> list[str]:
    """What is wrong with the pages of a folder."""
    files = sorted(
        file for file in folder.rglob("*.html") if not is_foreign(file.relative_to(folder))
    )
    pages = {file.resolve(): Page(file.read_text(encoding="utf-8")) for file in files}
    found = [] if pages else [f"{folder}: no page"]
    for file, page in pages.items():
        name = file.relative_to(folder.resolve())
        if str(ROOT) in file.read_text(encoding="utf-8"):
            found.append(f"{name}: shows a path in {ROOT}")
        found += [f"{name}: loads {load}" for load in sorted(page.loads) if is_elsewhere(load)]
        for link in sorted(page.links | page.loads):
            if is_elsewhere(link) or urlsplit(link).scheme:
                continue
            place, _, anchor = link.partition("#")
            target = (file.parent / unquote(place.partition("?")[0])).resolve() if place else file
            if target.is_dir():
                target /= "index.html"
            if not target.is_file():
                found.append(f"{name}: {link} leads to nothing")
            elif anchor and target in pages and unquote(anchor) not in pages[target].anchors:
                found.append(f"{name}: {link} leads to no anchor")
    for file in sorted(folder.rglob("*.css")):
        if file.relative_to(folder).parts[0] == "rust":
            continue
        for link in re.findall(r"url\(['\"]?([^)'\"]+)", file.read_text(encoding="utf-8")):
            if is_elsewhere(link):
                found.append(f"{file.relative_to(folder)}: loads {link}")
    return found


def is_foreign(file: Path) -> bool:
    """Whether a file is of rustdoc, or a template of the theme."""
    return file.parts[0] in ("rust", "_static")


def is_elsewhere(link: str) -> bool:
    """Whether a link leads to another machine."""
    return urlsplit(link).scheme in ("http", "https") or link.startswith("//")


if __name__ == "__main__":
    wrong = defects(Path(sys.argv[1]))
    for line in wrong:
        print(line, file=sys.stderr)
    sys.exit(bool(wrong))
