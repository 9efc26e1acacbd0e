"""The table of goals: what was measured, what is wanted, and whether it is reached."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple


class Row(NamedTuple):
    """One goal."""

    work: str
    unit: str
    goal: float
    value: float | None
    """None where it was not measured."""
    at_least: bool = False
    """Whether the goal is a lower bound; else it is an upper one."""
    note: str = ""
    """What the value is made of, or why there is none."""
    detail: dict[str, Any] = {}  # noqa: RUF012 (never changed)
    """Numbers behind it, for the file."""

    @property
    def passed(self) -> bool | None:
        """Whether the goal is reached; None where nothing was measured."""
        if self.value is None:
            return None
        return self.value >= self.goal if self.at_least else self.value <= self.goal

    def as_json(self) -> dict[str, Any]:
        """All of it, `passed` included."""
        return self._asdict() | {"passed": self.passed}


def not_measured(row: Row, why: object) -> Row:
    """The row of a goal whose measurement cannot be made here."""
    return row._replace(value=None, note=f"not measured: {why}")


def lines_of(rows: Iterable[Row]) -> list[str]:
    """The table as text.

    >>> print(*lines_of([Row("free nodes", "ns", 5.0, 3.21, note="each")]), sep="\\n")
    work        measured  goal    result  note
    free nodes   3.21 ns  ≤ 5 ns  pass    each
    """
    cells = [("work", "measured", "goal", "result", "note")]
    for row in rows:
        value = "–" if row.value is None else f"{_number(row.value)} {row.unit}".strip()
        goal = f"{'≥' if row.at_least else '≤'} {row.goal:g} {row.unit}".strip()
        result = {True: "pass", False: "FAIL", None: "–"}[row.passed]
        cells.append((row.work, value, goal, result, row.note))
    wide = [max(len(line[k]) for line in cells) for k in range(4)]
    return [
        f"{a:{wide[0]}}  {b:>{wide[1]}}  {c:{wide[2]}}  {d:{wide[3]}}  {e}".rstrip()
        for a, b, c, d, e in cells
    ]


def _number(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"
