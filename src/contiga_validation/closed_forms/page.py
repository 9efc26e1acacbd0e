"""The page of the suite: a table of all cases, then each with its picture and numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from itertools import groupby
from typing import Any, NamedTuple

from contiga.report import style
from contiga_validation.closed_forms.case import LEAST_ORDER, Answer, Case, Check, Order
from contiga_validation.engine.page import heading, image

_TITLE = "contiga against closed forms"
_ABOUT = (
    "Bodies that move by the forces on them, and the numbers made of their motion, set beside "
    "formulas of mechanics. Each case runs through the same interface that users have; where steps "
    "are automatic (<code>step = &quot;auto&quot;</code>) they are so here. A case holds when "
    "all its errors are within their tolerances and, where an order of convergence is measured, "
    f"it is at least {LEAST_ORDER}. Errors are relative unless the formula gives zero."
)
SIZE = (5.4, 3.1)
"""Width and height of a picture, inch."""


class CaseResult(NamedTuple):
    """A case with its answer and picture."""

    case: Case
    answer: Answer
    picture: bytes
    """PNG."""
    seconds: float


def page(results: Sequence[CaseResult], facts: dict[str, Any]) -> str:
    """Return the page as one text of HTML, which reads offline.

    Parameters
    ----------
    results : of the cases, in the order of the page
    facts : version and machine, from `contiga_validation.engine.table_files.machine`
    """
    run_time = f" · {style.number(sum(entry.seconds for entry in results), 3)} s"
    head = heading("verification", _TITLE, _ABOUT, facts, run_time)
    parts = [head + _verdict(results), _summary(results)]
    for group, entries in groupby(results, lambda entry: entry.case.group):
        parts.append(f"<h2>{escape(group)}</h2>")
        parts += [_section(entry) for entry in entries]
    css = "".join(
        files(package).joinpath("style.css").read_text(encoding="utf-8")
        for package in ("contiga_validation.engine", "contiga_validation.closed_forms")
    )
    return style.page(_TITLE, "\n".join(parts), css=css)


def _verdict(results: Sequence[CaseResult]) -> str:
    """Return the line that says that all cases hold, or links to those that do not."""
    broken = [entry for entry in results if not entry.answer.holds]
    if not broken:
        return f'<p class="verdict">✓ All {len(results)} cases hold.</p>'
    names = ", ".join(_link(entry.case) for entry in broken)
    return (
        f'<p class="verdict bad">✗ {len(broken)} of {len(results)} cases do not hold: {names}</p>'
    )


def _link(case: Case) -> str:
    return f'<a href="#{escape(case.key)}">{escape(case.title)}</a>'


def worst(answer: Answer) -> Check:
    """Return the first check with the largest error over its tolerance; NaN counts as infinite."""

    def share(check: Check) -> float:
        if math.isnan(check.error):
            return math.inf
        if check.tolerance == 0.0:
            return math.inf if check.error > 0.0 else 0.0
        return check.error / check.tolerance

    return max(answer.checks, key=share)


def _summary(results: Sequence[CaseResult]) -> str:
    """Return the table of cases with their worst checks and orders of convergence."""
    rows = []
    for entry in results:
        check, order = worst(entry.answer), entry.answer.order
        rows.append(
            f"<tr{_broken(entry.answer.holds)}><td>{_mark(entry.answer.holds)}</td>"
            f"<td>{_link(entry.case)}</td><td>{escape(entry.case.group)}</td>"
            f'<td class="number">{_error(check.error)}</td>'
            f'<td class="number">{style.number(check.tolerance, 2)}</td>'
            f'<td class="number">{"" if order is None else f"{order.observed:.2f}"}</td></tr>'
        )
    head = (
        "<th></th><th>Case</th><th>Group</th>"
        '<th class="number">Error</th><th class="number">Tolerance</th>'
        '<th class="number">Order</th>'
    )
    return (
        '<div class="wide"><table class="summary"><caption>The number of each case that is '
        "nearest to its tolerance, and the order of convergence in the step or the mesh.</caption>"
        f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _section(entry: CaseResult) -> str:
    """Return the section of a case: formula, scene, picture, checks and order."""
    case, answer = entry.case, entry.answer
    rows = "".join(_check_row(check) for check in answer.checks)
    parts = [
        f'<section id="{escape(case.key)}">',
        f'<h3 class="title">{_mark(answer.holds)} {escape(case.title)}</h3>',
        f'<p class="formula">{escape(case.formula)}</p><p>{escape(case.scene)}</p>',
        f"<figure>{image(case.title, SIZE[0], entry.picture)}</figure>",
        '<div class="wide"><table><thead><tr><th></th><th>Number</th>'
        '<th class="number">Measured</th><th class="number">Formula</th>'
        '<th class="number">Error</th><th class="number">Tolerance</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>",
        "" if answer.order is None else _order_table(answer.order),
    ]
    return "".join([*parts, "</section>"])


def _check_row(check: Check) -> str:
    return (
        f"<tr{_broken(check.holds)}><td>{_mark(check.holds)}</td><td>{escape(check.what)}</td>"
        f'<td class="number">{style.number(check.measured, 8)}</td>'
        f'<td class="number">{style.number(check.expected, 8)}</td>'
        f'<td class="number">{_error(check.error)}</td>'
        f'<td class="number">{style.number(check.tolerance, 2)}</td></tr>'
    )


def _order_table(order: Order) -> str:
    steps = "".join(f'<td class="number">{style.number(step, 4)}</td>' for step in order.steps)
    errors = "".join(f'<td class="number">{_error(error)}</td>' for error in order.errors)
    return (
        f'<div class="wide"><table><caption>{_mark(order.holds)} Order of convergence '
        f"<b>{order.observed:.3f}</b>: {escape(order.of)}.</caption><tbody>"
        f"<tr><th>Step or size</th>{steps}</tr><tr><th>Error</th>{errors}</tr>"
        "</tbody></table></div>"
    )


def _error(value: float) -> str:
    return "0" if value == 0.0 else f"{value:.1e}"


def _mark(holds: bool) -> str:
    return '<span class="mark">✓</span>' if holds else '<span class="mark bad">✗</span>'


def _broken(holds: bool) -> str:
    return "" if holds else ' class="broken"'
