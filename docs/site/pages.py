"""The source pages of the documentation site, from the documents of the repository.

    python docs/site/pages.py FOLDER

writes the pages to FOLDER. A page `docs/site/NAME.md` has a few lines of its own, and comments that
stand for text of documents:

    <!-- include docs/guide.md#units -->             a section with its subsections, by its anchor
    <!-- include docs/theory.md titled Formulas -->  a whole document, with another heading
    <!-- omit README.md#tests -->                    a section that is on no page
    <!-- gallery docs/gallery.md -->                 a document with a card for each picture
    <!-- examples -->                                all scene files

Each section is on one page: one that a page includes by its own anchor is left out where a larger
one is included. Links between documents become links between pages, and links to other files become
downloads. Whatever is missing is an error: a section on no page, a link to nothing, an anchor
without a heading.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from markdown import Section, anchors, parsed, with_links

ROOT = Path(__file__).resolve().parents[2]
SITE = Path(__file__).resolve().parent

COMMAND = re.compile(r"<!-- (include|gallery|omit|examples) ?(\S*?)(?: titled (.*))? -->\n")
NOTEBOOKS = {
    "python/docs/tutorial.ipynb": "tutorials/tutorial",
    "python/docs/fitting.ipynb": "tutorials/fitting",
    "python/docs/surfaces.ipynb": "tutorials/surfaces",
    "python/docs/tomography.ipynb": "tutorials/tomography",
    "python/docs/corona.ipynb": "tutorials/corona",
    "python/docs/exosphere.ipynb": "tutorials/exosphere",
    "python/docs/magnetosphere.ipynb": "tutorials/magnetosphere",
    "python/docs/cluster.ipynb": "tutorials/cluster",
    "python/docs/zodiacal.ipynb": "tutorials/zodiacal",
    "python/docs/darkmatter.ipynb": "tutorials/darkmatter",
    "python/docs/bolometer.ipynb": "tutorials/bolometer",
}
#: Where pages of the site have the pictures and other files of the repository.
FILES = "files"
EXAMPLES = "all-examples"


@dataclass
class Site:
    """The pages in the making."""

    root: Path
    documents: dict[str, Section] = field(default_factory=dict)
    #: The page of each section that is included by its own anchor, None if it is omitted.
    claims: dict[tuple[str, str], str | None] = field(default_factory=dict)
    #: Files of the repository that pages show or link to.
    files: set[str] = field(default_factory=set)
    defects: list[str] = field(default_factory=list)

    def document(self, path: str) -> Section:
        """A document of the repository."""
        if path not in self.documents:
            self.documents[path] = parsed((self.root / path).read_text(encoding="utf-8"))
        return self.documents[path]

    def section(self, target: str) -> tuple[str, Section] | None:
        """The document and the section of `docs/guide.md#units`."""
        path, _, anchor = target.partition("#")
        if not (self.root / path).is_file():
            self.defects.append(f"{target}: there is no such document")
            return None
        document = self.document(path)
        for section in document.all():
            if section.anchor == (anchor or document.anchor):
                return path, section
        self.defects.append(f"{target}: there is no such section")
        return None

    def claim(self, page: str, text: str) -> None:
        """Notes what a page includes and omits."""
        for command, target, _ in COMMAND.findall(text):
            found = self.section(target) if command != "examples" else None
            if found is None:
                continue
            key = (found[0], found[1].anchor)
            if key in self.claims:
                self.defects.append(f"{page}: {target} is on two pages")
            self.claims[key] = None if command == "omit" else page

    def page_of(self, path: str, anchor: str) -> str | None:
        """The page that has a section; None if no page has it."""
        for section in reversed(self.document(path).path_to(anchor)):
            if (path, section.anchor) in self.claims:
                return self.claims[path, section.anchor]
        return None

    def target(self, path: str, link: str) -> str | None:
        """What a link of a document becomes on the site; None for text without a link."""
        if re.match(r"[a-z]+:", link):
            return link
        file, _, anchor = link.partition("#")
        name = self.place(path, file) if file else path
        place = self.root / name
        if name in NOTEBOOKS:
            return f"/{NOTEBOOKS[name]}.ipynb"
        if name == "examples" or (
            name.startswith("examples/") and name.endswith(".toml") and place.is_file()
        ):
            return f"#{example_target(name)}"
        if place.is_dir():
            return None
        if not place.is_file():
            self.defects.append(f"{path}: the link to {link} leads to nothing")
            return None
        if name not in self.documents:
            self.files.add(name)
            return f"/{FILES}/{name}"
        anchor = anchor or self.documents[name].anchor
        if anchor not in anchors(self.documents[name]):
            self.defects.append(f"{path}: the link to {link} leads to no heading")
        elif self.page_of(name, anchor) is None:
            self.defects.append(f"{path}: the link to {link} leads to a section that is on no page")
        return f"#{heading_target(name, anchor)}"

    def place(self, path: str, file: str) -> str:
        """The path in the repository of a file that a document links to."""
        return os.path.normpath(PurePosixPath(path).parent / file).replace(os.sep, "/")

    def words(self, path: str, words: str, link: str) -> str:
        """The text of a link: the title of a document in place of the name of its file."""
        document = self.documents.get(self.place(path, link.partition("#")[0]))
        return document.title if document and words.endswith(".md") else words

    def included(self, target: str, title: str, level: int, has_cards: bool = False) -> str:
        """A section as it stands on a page, with its heading on this level."""
        found = self.section(target)
        if found is None:
            return ""
        path, top = found
        lines = []

        def add(section: Section, level: int) -> None:
            text = title if section is top and title else section.title
            lines.append(
                f"({heading_target(path, section.anchor)})=\n{'#' * min(level, 6)} {text}\n"
            )
            lines.append(
                with_links(
                    section.body,
                    lambda link: self.target(path, link),
                    lambda words, link: self.words(path, words, link),
                )
            )
            if section is top and has_cards:
                lines.append(self.cards(path))
            for child in section.children:
                if (path, child.anchor) not in self.claims:
                    add(child, level + 1)

        add(top, level)
        return "\n".join(lines)

    def page(self, text: str) -> str:
        """A page with all that its comments stand for."""

        def replaced(match: re.Match[str]) -> str:
            command, target, title = match.groups()
            if command in ("include", "gallery"):
                before = re.findall(r"^(#+) ", text[: match.start()], re.MULTILINE)
                is_first = "<!-- include" not in text[: match.start()]
                level = len(before[-1]) + 1 if before else 1 if is_first else 2
                return self.included(target, title or "", level, command == "gallery")
            return self.examples() if command == "examples" else ""

        return COMMAND.sub(replaced, text)

    def cards(self, path: str) -> str:
        """A card for each section of a document that has a picture."""
        cards = ["::::{grid} 2 3 4 4", ":gutter: 2", ":class-container: gallery", ""]
        for section in self.document(path).children:
            picture = re.search(r"!\[[^]]*\]\(([^)]*)\)", section.body)
            if picture is None:
                continue
            link = self.target(path, picture.group(1))
            cost = re.search(r"([\d,]+) evaluations", section.body)
            cards += [
                f":::{{grid-item-card}} {section.title}",
                f":img-top: {link}",
                f":img-alt: {section.title.replace('`', '')}",
                f":link: {heading_target(path, section.anchor)}",
                ":link-type: ref",
                ":text-align: center",
                "",
                f"{cost.group(1)} evaluations" if cost else "",
                ":::",
            ]
        return "\n".join([*cards, "::::", ""])

    def examples(self) -> str:
        """All scene files, with targets for links."""
        lines = []
        for file in sorted((self.root / "examples").glob("*.toml")):
            name = f"examples/{file.name}"
            self.files.add(name)
            lines += [
                f"({example_target(name)})=",
                f"## `{file.name}`\n",
                f"[Download](/{FILES}/{name})\n",
                f"```{{literalinclude}} /{FILES}/{name}\n:language: toml\n```\n",
            ]
        return "\n".join(lines)


def heading_target(path: str, anchor: str) -> str:
    """The name of a heading that is unique on the site."""
    return (
        re.sub(r"[^a-z0-9]+", "-", path.removeprefix("docs/").removesuffix(".md").lower())
        + "--"
        + anchor
    )


def example_target(name: str) -> str:
    """The target of a scene file, or of all."""
    return EXAMPLES if name == "examples" else "example-" + Path(name).stem.replace("_", "-")


def write(root: Path, site_folder: Path, folder: Path) -> list[str]:
    """Writes all pages to a folder; returns what is wrong with them."""
    site = Site(root)
    texts = {
        str(file.relative_to(site_folder).with_suffix("").as_posix()): file.read_text(
            encoding="utf-8"
        )
        for file in sorted(site_folder.rglob("*.md"))
    }
    for page, text in texts.items():
        site.claim(page, text)
    for path, document in site.documents.items():
        for section in document.all():
            is_placed = any(
                (path, part.anchor) in site.claims for part in document.path_to(section.anchor)
            )
            if section is not document and not is_placed:
                site.defects.append(f"{path}#{section.anchor} is on no page")
    pages = {page: site.page(text) for page, text in texts.items()}
    if folder.exists():
        shutil.rmtree(folder)
    for page, text in pages.items():
        place = folder / f"{page}.md"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
    copies = {f"{FILES}/{name}": name for name in site.files}
    copies |= {f"{page}.ipynb": name for name, page in NOTEBOOKS.items()}
    for place, name in copies.items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(root / name, folder / place)
    return list(dict.fromkeys(site.defects))


if __name__ == "__main__":
    found = write(ROOT, SITE, Path(sys.argv[1]))
    for defect in found:
        print(defect, file=sys.stderr)
    sys.exit(bool(found))
