"""The suite of closed forms: run all cases, write their page and numbers."""

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
from contiga_validation.closed_forms.catalogue import selected
from contiga_validation.closed_forms.page import SIZE, CaseResult, page
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Picture
from contiga_validation.engine.suite import Progress, reading, results_folder, with_progress
from contiga_validation.engine.table_files import machine, plain

PAGE, JSON = "verification.html", "verification.json"


def verify(
    out: str | Path, *, only: Sequence[str] | None = None, progress: Progress | None = None
) -> Path:
    """Run the cases of the suite and write their results to the folder `out`.

    Parameters
    ----------
    out : folder for ``verification.html`` and ``verification.json``
    only : keys of cases, or their first words; all of them if omitted
    progress : called with the number done, the total, and the title of the next one

    Returns
    -------
    Path
        The page. Nothing is written before all cases are done; files are written atomically, the
        page last.

    Raises
    ------
    InputError
        The case is unknown, or the folder cannot be written or holds other files.
    MissingPackageError
        A package of the pictures is not installed.
    RunError
        A case failed.
    """
    require("a verification", "matplotlib")
    cases = selected(only)
    with results_folder(out, (JSON,), "verification") as folder:
        results = [_run(case) for case in with_progress(cases, progress, lambda case: case.title)]
        facts = machine()
        files.write_json(folder / JSON, {**facts, "cases": [_entry(entry) for entry in results]})
        files.write_text(folder / PAGE, page(results, facts))
        return folder / PAGE


def broken_cases(folder: str | Path) -> list[str]:
    """Return the cases that did not hold in the verification in `folder`, one line each.

    Raises
    ------
    FileError
        The folder holds no verification.
    """
    with reading(Path(folder) / JSON, "the numbers of a verification") as content:
        lines = []
        for case in content["cases"]:
            if case["holds"]:
                continue
            parts = [
                f"{check['what']} {check['error']} > {check['tolerance']:g}"
                for check in case["checks"]
                if not check["holds"]
            ]
            order = case["order"]
            if order is not None and not order["holds"]:
                parts.append(f"order {order['observed']}")
            lines.append(f"{case['key']} ({', '.join(parts)})")
        return lines


def _run(case: Case) -> CaseResult:
    """Run a case and draw its picture; any error becomes a RunError that names the case."""
    start = perf_counter()
    try:
        answer = case.run()
        picture = png(Picture(case.key, case.title, answer.draw, SIZE))
    except Exception as error:
        raise RunError(f"case {case.key}: {type(error).__name__}: {error}") from error
    return CaseResult(case, answer, picture, perf_counter() - start)


def _entry(entry: CaseResult) -> dict[str, Any]:
    """Return the results of a case for JSON."""
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
