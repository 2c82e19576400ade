"""Docstrings of the package as reStructuredText.

They are plain text for `help`: names in backticks, paragraphs `names: text` for parameters,
examples with `>>>`. Here marks of reStructuredText in them are escaped, parameters become lists of
definitions, and names of the public interface become links.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

import emitree

PARAMETERS = re.compile(r"^([a-z_0-9]+(?:, [a-z_0-9]+)*): (.*)$")
CODE = re.compile(r"`([^`]+)`")
CALL = re.compile(r"^(?:emitree\.)?([A-Za-z_]\w*(?:\.\w+)*)(\(.*\))?$")


def public_name(name: str, of: str) -> str | None:
    """The full name of what a text in backticks is of the public interface, in the text of `of`."""
    match = CALL.match(name)
    if match is None:
        return None
    parts = match.group(1).split(".")
    if parts[0] in emitree.__all__:
        return ".".join(["emitree", *parts]) if has(parts) else None
    # A member of the class that the text belongs to.
    owner = of.split(".")[1:2]
    if owner and len(parts) == 1 and inspect.isclass(getattr(emitree, owner[0], None)):
        member = inspect.getattr_static(getattr(emitree, owner[0]), parts[0], None)
        if callable(member) or hasattr(member, "__get__"):
            return ".".join(["emitree", owner[0], parts[0]])
    return None


def has(parts: list[str]) -> bool:
    """Whether the package has a public name with these parts, and documents it."""
    value: Any = emitree
    for part in parts:
        if part.startswith("_"):
            return False
        try:
            value = inspect.getattr_static(value, part)
        except AttributeError:
            return False
    return bool(getattr(value, "__doc__", None))


def prose(text: str, of: str) -> str:
    """A line, with code as code or as links, and all else as it stands."""
    made = []
    for number, part in enumerate(CODE.split(text)):
        if number % 2:
            full = public_name(part, of)
            made.append(f":py:obj:`{part} <{full}>`" if full and full != of else f"``{part}``")
            continue
        # A role ends before a blank: "`Sphere`s".
        end = "\\ " if number and part[:1].isalnum() else ""
        made.append(end + re.sub(r"([*|_])", r"\\\1", part))
    return "".join(made)


def restructured(lines: list[str], of: str) -> list[str]:
    """The lines of a docstring as reStructuredText."""
    made: list[str] = []
    is_start, is_parameter, is_example = True, False, False
    for line in lines:
        stripped = line.strip()
        if stripped.startswith(">>>"):
            if not is_example and made and made[-1]:
                made.append("")
            is_example = True
        if is_example:
            made.append(line)
            is_example = bool(stripped)
            is_start = not stripped
            continue
        match = PARAMETERS.match(line) if is_start or is_parameter else None
        if match:
            if made and made[-1]:
                made.append("")
            names = ", ".join(f"**{name}**" for name in match.group(1).split(", "))
            made += [names, f"    {prose(match.group(2), of)}"]
            is_parameter, is_start = True, False
            continue
        bullet = re.match(r"^( *)\* (.*)$", line)
        if bullet:
            indent, text = bullet.groups()
            if made and made[-1] and not made[-1].startswith((f"{indent}* ", f"{indent}  ")):
                made.append("")
            made.append(f"{indent}* {prose(text, of)}")
        else:
            made.append(prose(line, of))
        if is_parameter and stripped and not line.startswith(" "):
            # The first line of a paragraph below the parameters.
            made.insert(-1, "")
            is_parameter = False
        is_start = not stripped
    return made


def is_made_by_users(lines: str) -> bool:
    """Whether the docstring of a class has parameters: others are results."""
    return any(PARAMETERS.match(line) for line in lines.splitlines())


def setup(app: Any) -> dict[str, bool]:
    """Registers the conversion."""

    def process(
        _app: Any, _what: str, name: str, _object: Any, _options: Any, lines: list[str]
    ) -> None:
        lines[:] = restructured(lines, name)

    def signature(
        _app: Any, what: str, _name: str, described: Any, *_: Any
    ) -> tuple[str, None] | None:
        is_result = what == "class" and not is_made_by_users(inspect.getdoc(described) or "")
        return ("", None) if is_result else None

    app.connect("autodoc-process-docstring", process)
    app.connect("autodoc-process-signature", signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
