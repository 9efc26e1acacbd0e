"""The suite of closed forms: every case run, its page and its numbers written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from contiga.errors import RunError
from contiga.extras import require
from contiga.io.out import files
from contiga_validation.closed_forms.case import Case
from contiga_validation.closed_forms.catalogue import chosen
from contiga_validation.closed_forms.page import SIZE, Shown, page
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Picture
from contiga_validation.engine.suite import Progress, in_turn, opened, told_in
from contiga_validation.engine.table_files import machine, plain

PAGE, JSON = "verification.html", "verification.json"


def verify(
    out: str | Path, *, only: Sequence[str] | None = None, progress: Progress | None = None
) -> Path:
    """Run the cases of the suite and write what they find into the folder `out`.

    Parameters
    ----------
    out : folder for ``verification.html`` and ``verification.json``
    only : keys of cases, or their first words; all of them if omitted
    progress : called with what is done, how much there is, and what comes next

    Returns
    -------
    Path
        The page. Nothing is written before all cases are done; each file is written under another
        name and renamed whole, the page last.

    Raises
    ------
    InputError
        An unknown case, or a folder that cannot be written or is somebody else's.
    MissingPackageError
        A package that pictures need is not installed.
    RunError
        A case could not be carried through.
    """
    require("a verification", "matplotlib")
    wanted = chosen(only)
    with opened(out, (JSON,), "verification") as folder:
        shown = [_run(case) for case in in_turn(wanted, progress, lambda case: case.title)]
        facts = machine()
        files.write_json(folder / JSON, {**facts, "cases": [_entry(entry) for entry in shown]})
        files.write_text(folder / PAGE, page(shown, facts))
        return folder / PAGE


def broken_cases(folder: str | Path) -> list[str]:
    """Cases that did not hold in the verification left in `folder`, a line each.

    Raises
    ------
    FileError
        The folder holds no verification.
    """
    with told_in(Path(folder) / JSON, "the numbers of a verification") as content:
        return [_said(case) for case in content["cases"] if not case["holds"]]


def _said(case: dict[str, Any]) -> str:
    """What is broken about a case."""
    parts = [
        f"{check['what']} {check['error']} > {check['tolerance']:g}"
        for check in case["checks"]
        if not check["holds"]
    ]
    order = case["order"]
    if order is not None and not order["holds"]:
        parts.append(f"order {order['observed']}")
    return f"{case['key']} ({', '.join(parts)})"


def _run(case: Case) -> Shown:
    start = perf_counter()
    try:
        answer = case.run()
        picture = png(Picture(case.key, case.title, answer.draw, SIZE))
    except Exception as error:
        raise RunError(f"case {case.key}: {type(error).__name__}: {error}") from error
    return Shown(case, answer, picture, perf_counter() - start)


def _entry(entry: Shown) -> dict[str, Any]:
    case, answer = entry.case, entry.answer
    order = answer.order
    return {
        "key": case.key,
        "group": case.group,
        "title": case.title,
        "formula": case.formula,
        "scene": case.scene,
        "holds": answer.holds,
        "seconds": round(entry.seconds, 3),
        "checks": [
            {
                **{name: plain(value) for name, value in check._asdict().items()},
                "holds": check.holds,
            }
            for check in answer.checks
        ],
        "order": None
        if order is None
        else {
            "of": order.of,
            "steps": list(order.steps),
            "errors": [plain(error) for error in order.errors],
            "observed": None if math.isnan(order.observed) else order.observed,
            "holds": order.holds,
        },
    }
