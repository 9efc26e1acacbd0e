"""The suite of closed forms: every case run, its page and its numbers written."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from contiga import files
from contiga.errors import FileError, RunError
from contiga.extras import require
from contiga_validation.closed_forms.case import Case
from contiga_validation.closed_forms.catalogue import chosen
from contiga_validation.closed_forms.page import SIZE, Shown, page
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Picture
from contiga_validation.engine.table_files import machine, plain

PAGE, JSON = "verification.html", "verification.json"

Progress = Callable[[int, int, str], None]
"""Called with how many cases are done, how many there are, and which comes next."""


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
    folder = Path(out)
    made = files.open_folder(folder, (JSON,), "verification")
    try:
        shown = []
        for done, case in enumerate(wanted):
            if progress is not None:
                progress(done, len(wanted), case.title)
            shown.append(_run(case))
        if progress is not None:
            progress(len(wanted), len(wanted), "done")
        facts = machine()
        files.write_json(folder / JSON, {**facts, "cases": [_entry(entry) for entry in shown]})
        files.write_text(folder / PAGE, page(shown, facts))
        return folder / PAGE
    except BaseException:
        if made and not any(folder.iterdir()):
            folder.rmdir()
        raise


def broken_cases(folder: str | Path) -> list[str]:
    """Cases that did not hold in the verification left in `folder`, a line each.

    Raises
    ------
    FileError
        The folder holds no verification.
    """
    path = Path(folder) / JSON
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return [_said(case) for case in content["cases"] if not case["holds"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FileError("not the numbers of a verification", where=str(path)) from error


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
