"""Sections and links of Markdown documents, as far as the documents of the repository use them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

HEADING = re.compile(r"^(#{1,6}) (.*)$")
FENCE = re.compile(r"^ *(`{3,}|~{3,})")
LINK = re.compile(r"(!?)\[((?:`[^`]*`|[^\[\]`]|\[[^\[\]]*\])*)\]\(([^()\s]+)\)")
#: Pictures of README.md that have a size.
PICTURE = re.compile(r'<img src="([^"]*)" height="(\d+)"\s+alt="([^"]*)">')


@dataclass
class Section:
    """A heading, the text below it, and its subsections."""

    title: str
    level: int
    anchor: str
    body: str = ""
    children: list[Section] = field(default_factory=list)

    def all(self) -> Iterator[Section]:
        """This section and all below it."""
        yield self
        for child in self.children:
            yield from child.all()

    def path_to(self, anchor: str) -> list[Section]:
        """The sections from this one down to that of an anchor; none if it is not below."""
        if self.anchor == anchor:
            return [self]
        for child in self.children:
            if path := child.path_to(anchor):
                return [self, *path]
        return []


def slug(title: str) -> str:
    """The anchor of a heading, as code hosts make it."""
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", title).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchors(document: Section) -> set[str]:
    """All anchors of a document."""
    return {section.anchor for section in document.all()}


def parsed(text: str) -> Section:
    """The sections of a document, whose first line is its only heading of the first level."""
    stack: list[Section] = []
    seen: dict[str, int] = {}
    fence = ""
    for line in text.splitlines(keepends=True):
        mark = FENCE.match(line)
        if mark and (not fence or line.strip() == fence):
            fence = "" if fence else mark.group(1)
        heading = None if fence or mark else HEADING.match(line)
        if heading is None:
            if not stack:
                if line.strip():
                    raise ValueError(f"{line!r}: expected a heading")
                continue
            stack[-1].body += line
            continue
        title = heading.group(2).strip()
        anchor = slug(title)
        seen[anchor] = seen.get(anchor, -1) + 1
        anchor += f"-{seen[anchor]}" if seen[anchor] else ""
        section = Section(title, len(heading.group(1)), anchor)
        while stack and stack[-1].level >= section.level:
            if len(stack) == 1:
                raise ValueError(f"{title!r}: a document has one heading of the first level")
            stack.pop()
        if stack:
            stack[-1].children.append(section)
        stack.append(section)
    if not stack:
        raise ValueError("expected a heading, found an empty document")
    return stack[0]


def outside_of_code(text: str, change: Callable[[str], str]) -> str:
    """Text with the parts changed that are in no fenced block."""
    parts: list[str] = []
    prose: list[str] = []
    fence = ""
    for line in text.splitlines(keepends=True):
        mark = FENCE.match(line)
        opens = bool(mark) and not fence
        closes = bool(mark) and bool(fence) and line.strip() == fence
        if opens and mark:
            parts.append(change("".join(prose)))
            prose = []
            fence = mark.group(1)
        if fence:
            parts.append(line)
        else:
            prose.append(line)
        if closes:
            fence = ""
    return "".join([*parts, change("".join(prose))])


def with_links(
    text: str,
    target: Callable[[str], str | None],
    renamed: Callable[[str, str], str] = lambda words, _: words,
) -> str:
    """Text with other links, and their texts renamed; where there is no link, its text remains."""

    def link(match: re.Match[str]) -> str:
        mark, words, old = match.groups()
        new = target(old)
        return words if new is None else f"{mark}[{renamed(words, old)}]({new})"

    def picture(match: re.Match[str]) -> str:
        old, height, words = match.groups()
        return f"![{' '.join(words.split())}]({target(old)}){{height={height}px}}"

    def prose(part: str) -> str:
        part = LINK.sub(link, part)
        return re.sub(r"</?p>\n", "", PICTURE.sub(picture, part))

    return outside_of_code(text, prose)
