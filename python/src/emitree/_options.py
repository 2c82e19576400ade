"""Options that are no part of a scene, checked: an error names the option and what was expected."""

from __future__ import annotations

import operator
from typing import Any

from emitree._native import SceneError

#: As many threads as the command allows: more are a slip, and take memory without being of use.
MOST_THREADS = 1024

#: Options of a scene's `[render]` by the methods that use them, where not all do.
_METHODS = {
    "tolerance": "`vol` and `los`",
    "rtol": "`vol`",
    "atol": "`vol`",
    "floor": "`vol`",
    "weights": "`vol`",
    "mask": "`vol`",
    "per_band": "`vol`",
    "sums": "`vol`",
    "base_level": "`vol` and `paper`",
    "order": "`paper`",
    "finest_level": "`paper`",
    "rule": "`paper`",
    "threshold": "`paper`",
    "lines": "`los`",
    "steps": "`los`",
    "seeds": "`vol`",
    "smallest_feature": "`vol`",
    "minimize": "`vol`",
}


def count(name: str, value: Any, expected: str, most: int | None = None) -> int | None:
    """A whole number from 1 to `most`, or None.

    >>> count("threads", 4, "a number of threads")
    4
    """
    if value is None:
        return None
    try:
        number = operator.index(value)
    except TypeError:
        number = 0
    if isinstance(value, bool) or number < 1 or (most is not None and number > most):
        limit = "1 or more" if most is None else f"1 to {most}"
        raise SceneError(f"`{name}` is {value!r}: expected {expected}, {limit}")
    return number


def threads(value: Any) -> int | None:
    """A number of threads."""
    return count("threads", value, "a number of threads", MOST_THREADS)


def batch_size(value: Any) -> int | None:
    """A number of points in a batch."""
    return count("batch_size", value, "a number of points")


def refuse_unused(method: str, ignored: list[str], given: set[str]) -> None:
    """Refuses options without effect.

    ignored: options of the scene that its method does not use; given: options given by keyword.
    """
    for key in ignored:
        name = "seeds" if key == "seed" else key
        if name in given:
            raise SceneError(
                f"`{name}` is given, and method `{method}` does not use it: expected none, or "
                f"method {_METHODS.get(name, 'another one')}"
            )
