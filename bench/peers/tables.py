"""The rows as tables of Markdown."""

from collections.abc import Sequence

from .row import Row

#: The levels of error, by their names.
LEVELS = {"6 %": 0.06, "1 %": 0.01, "0.1 %": 1e-3, "1e-4": 1e-4, "1e-6": 1e-6}
OURS = "emitree"
NONE = "-"
#: The levels for users.
USERS = ("1 %", "0.1 %")
#: Behind a number that another random start does not confirm.
LUCK = "\\*"


def cheapest(rows: Sequence[Row], error: float) -> Row | None:
    """The row with the fewest evaluations whose error is at most `error`."""
    within = (row for row in rows if row.found and row.error <= error)
    return min(within, key=lambda row: row.evaluations, default=None)


def is_luck(chosen: Row, rows: Sequence[Row], error: float) -> bool:
    """Whether the same setting misses that error from another random start."""
    same = (row for row in rows if row.repeated == chosen.repeated)
    return any(not row.found or row.error > error for row in same)


def of(rows: Sequence[Row], contestant: str) -> list[Row]:
    """The rows of one contestant."""
    return [row for row in rows if row.contestant == contestant]


def levels(rows: Sequence[Row], contestants: Sequence[str]) -> str:
    """The evaluations of each contestant in one scene for each level."""
    lines = []
    for name in contestants:
        own = of(rows, name)
        cells = [_cell(own, rows, error) for error in LEVELS.values()]
        lines.append([name, *cells, _best(own), *_cost(cheapest(own, LEVELS["1 %"]))])
    heads = ["", *LEVELS, "smallest error (evaluations)", "s for 1 %", "MiB for 1 %"]
    return table(heads, lines)


def against(rows: Sequence[Row], scenes: Sequence[str]) -> str:
    """Ours against the best of the others, for each scene and level."""
    lines = []
    for scene in scenes:
        here = [row for row in rows if row.scene == scene]
        others = [row for row in here if row.contestant != OURS]
        for name, error in LEVELS.items():
            ours, best = cheapest(of(here, OURS), error), cheapest(others, error)
            asked = _asked_for(here, error)
            if ours is None and best is None:
                continue
            other = NONE if best is None else f"{_marked(best, here, error)} ({best.contestant})"
            lines.append([scene, name, _count(asked), _count(ours), other, _outcome(ours, best)])
    heads = ["scene", "error", f"{OURS}, asked for it", OURS, "best of the others", "outcome"]
    return table(heads, lines)


def users(rows: Sequence[Row], contestants: Sequence[str], scenes: Sequence[str]) -> str:
    """The cost of each contestant and of ours, in the scenes and for the errors of users.

    Ours is the setting with that tolerance, of the others the cheapest with that error or, where
    none has it, the one that comes closest.
    """
    lines = []
    for scene in scenes:
        here = [row for row in rows if row.scene == scene]
        for level in USERS:
            ours = _asked_for(here, LEVELS[level])
            for name in contestants:
                own = of(here, name)
                row = ours if name == OURS else cheapest(own, LEVELS[level])
                said = NONE if name == OURS else _compared(ours, row)
                if row is None:
                    row, said = _closest(own), _missed(own)
                lines.append([scene, level, name, *_measured(row), said])
    heads = ["scene", "error", "", "setting", "evaluations", "error reached", "s", "MiB"]
    return table([*heads, f"{OURS} takes"], lines, texts=4)


def _asked_for(rows: Sequence[Row], error: float) -> Row | None:
    """The row of ours with that tolerance."""
    return next((row for row in of(rows, OURS) if row.found and _asked(row) == error), None)


def _closest(rows: Sequence[Row]) -> Row | None:
    """The row with the smallest error, of equal ones the cheapest."""
    found = (row for row in rows if row.found)
    return min(found, key=lambda row: (row.error, row.evaluations), default=None)


def _missed(rows: Sequence[Row]) -> str:
    """The text for rows none of which reaches the error."""
    if not rows:
        return "not measured"
    failed = [row for row in rows if not row.found]
    return "; ".join(["missed", *(f"{row.setting} {row.note}" for row in failed[-1:])])


def _measured(row: Row | None) -> list[str]:
    """Setting, evaluations, error, seconds and memory of a row."""
    if row is None:
        return [NONE] * 5
    return [row.setting, _count(row), f"{row.error:.1e}", *_cost(row)]


def _compared(ours: Row | None, row: Row | None) -> str:
    """What ours takes of the evaluations, seconds and memory of a row; bold what is more."""
    if ours is None or row is None:
        return NONE
    ratios = {
        "evaluations": ours.evaluations / row.evaluations,
        "s": ours.seconds / row.seconds,
        "MiB": ours.peak_mib / row.peak_mib,
    }
    return ", ".join(_times(ratio, of_what) for of_what, ratio in ratios.items())


def _times(ratio: float, of_what: str) -> str:
    return f"**{ratio:.2g} x {of_what}**" if ratio > 1 else f"{ratio:.2g} x {of_what}"


def tolerances_met(rows: Sequence[Row]) -> str:
    """The tolerances of ours in one scene, and the errors reached.

    Where several tolerances give the same image, the tightest stands for them.
    """
    tightest = {row.evaluations: row for row in of(rows, OURS) if row.found}
    lines = [
        [
            f"{_asked(row):g}",
            _count(row),
            f"{row.estimated_error:.1e}",
            f"{row.error:.1e}",
            "yes" if row.error <= _asked(row) else "**no**",
            f"{row.seconds:.2f}",
        ]
        for row in tightest.values()
    ]
    return table(["asked for", "evaluations", "estimated", "measured", "kept", "s"], lines)


def table(heads: Sequence[str], lines: Sequence[Sequence[str]], texts: int = 1) -> str:
    """A table, its first columns (texts) to the left and the others to the right."""
    rule = ["---"] * texts + ["--:"] * (len(heads) - texts)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (heads, rule, *lines))


def _asked(row: Row) -> float:
    return float(row.setting.removeprefix("tolerance="))


def _count(row: Row | None) -> str:
    return NONE if row is None else f"{row.evaluations:,}"


def _marked(row: Row, rows: Sequence[Row], error: float) -> str:
    return _count(row) + (LUCK if is_luck(row, rows, error) else "")


def _cell(own: Sequence[Row], rows: Sequence[Row], error: float) -> str:
    """The fewest evaluations of one contestant, bold if they are the fewest of all."""
    row = cheapest(own, error)
    if row is None:
        return NONE
    marked = _marked(row, own, error)
    is_fewest = row.evaluations == cheapest(rows, error).evaluations
    return f"**{marked}**" if is_fewest else marked


def _best(rows: Sequence[Row]) -> str:
    best = _closest(rows)
    return NONE if best is None else f"{best.error:.1e} ({_count(best)})"


def _cost(row: Row | None) -> list[str]:
    return [NONE, NONE] if row is None else [f"{row.seconds:.3g}", f"{row.peak_mib:.0f}"]


def _outcome(ours: Row | None, best: Row | None) -> str:
    if ours is None:
        return "not reached"
    if best is None:
        return "alone"
    ratio = ours.evaluations / best.evaluations
    return f"loses, {ratio:.2g} x" if ratio > 1 else f"wins, {1 / ratio:.2g} x fewer"
