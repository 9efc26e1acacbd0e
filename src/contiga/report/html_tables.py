"""Key figures and tables of the report as HTML."""

from __future__ import annotations

from html import escape
from typing import Any

from contiga.report.run_folder import Run
from contiga.report.style import number, span_of

STAGES = {
    "import": "Loading packages",
    "build": "Reading files, building tables",
    "checks": "Checking the model",
    "compile": "Compiling kernels (first run on a machine only)",
    "motion": "Moving bodies and slaves",
    "search": "Search",
    "area": "Contact area",
    "forces": "Forces",
    "output": "Writing output",
}
"""Labels of the stages of a run."""
_MAX_CRITERIA = 6
"""Largest number of key figures that are criteria; a table has all."""
_COMPILING = ("compile",)
"""Stages that are unrelated to the method and are shown apart."""


def _tile(value: str, unit: str, label: str, when: str = "") -> str:
    return (
        f'<div><div class="value">{value} <small>{escape(unit)}</small></div>'
        f'<div class="label">{escape(label)}</div><div class="when">{escape(when)}</div></div>'
    )


def key_figures(run: Run) -> str:
    """Return the tiles of large numbers under the title: peaks of contacts, criteria, steps, time.

    Peaks are over all contacts; at most six criteria of sensors are among them.
    """
    tiles = []
    of_contacts = (
        ("force", run.units.force, "Peak force"),
        ("max_penetration", run.units.length, "Deepest penetration"),
        ("area", run.units.area, "Largest contact area"),
        ("n_contact", "", "Most nodes in contact"),
    )
    for column, unit, label in of_contacts if run.contacts else ():
        value, when = run.greatest(column)
        at = f"at t = {number(when)} {run.units.time}".strip() if value > 0.0 else "no contact"
        tiles.append(_tile(number(value), unit, label, at))
    tiles += [
        _tile(
            number(result["value"]),
            str(result.get("unit", "")),
            f"{criterion} of {sensor}",
            f"t = {span_of(result)} {run.units.time}".strip(),
        )
        for sensor, facts in run.summary_part("sensors").items()
        for criterion, result in (facts.get("criteria") or {}).items()
    ][:_MAX_CRITERIA]
    tiles.append(_tile(number(float(run.summary.get("steps") or len(run.times) - 1)), "", "Steps"))
    total = run.summary_part("timings").get("total")
    if total is not None:
        tiles.append(_tile(number(float(total), 3), "s", "Wall time"))
    return f'<div class="figures">{"".join(tiles)}</div>'


def inputs_table(run: Run) -> str:
    """Return the table of bodies and slaves with their counts, and totals; empty without any."""
    rows = []
    for name, facts in run.summary_part("inputs").items():
        kind = escape(str(facts.get("kind", "")))
        counts = [
            f"{escape(key.removeprefix('n_').replace('_', ' '))} {escape(_as_text(value))}"
            + (f" {escape(run.units.length)}" if key == "size" else "")
            for key, value in facts.items()
            if key != "kind"
        ]
        cells = f"<td>{escape(name)}</td><td>{kind}</td><td>{' · '.join(counts)}</td>"
        rows.append(f"<tr>{cells}</tr>")
    for key, label in (("n_points", "points in all"), ("n_elements", "elements in all")):
        if run.summary.get(key) is not None:
            count = number(float(run.summary[key]), 9)
            rows.append(f'<tr class="total"><td>{label}</td><td></td><td>{count}</td></tr>')
    if not rows:
        return ""
    head = "<thead><tr><th>Name</th><th>Kind</th><th>Counts</th></tr></thead>"
    return f"<table>{head}{''.join(rows)}</table>"


def _as_text(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return number(float(value), 9 if isinstance(value, int) else 5)
    if isinstance(value, list | tuple):
        return ", ".join(_as_text(v) for v in value)
    return str(value)


def status_table(run: Run) -> str:
    """Return the table of points by status and contact, summed over steps, with their meanings.

    The table is empty for a run without contacts.
    """
    statuses = run.summary_part("statuses")
    if not statuses:
        return ""
    advice = run.summary_part("advice")
    names = list(dict.fromkeys(name for counts in statuses.values() for name in counts))
    head = "".join(f'<th class="number">{escape(contact)}</th>' for contact in statuses)
    rows = "".join(
        f"<tr><td>{escape(name.lower().replace('_', ' '))}</td>"
        + "".join(
            f'<td class="number">{number(float(counts.get(name, 0)), 9)}</td>'
            for counts in statuses.values()
        )
        + f"<td>{escape(str(advice.get(name, '')))}</td></tr>"
        for name in names
    )
    return f"<table><thead><tr><th>Status</th>{head}<th>Meaning</th></tr></thead>{rows}</table>"


def timings_table(run: Run) -> str:
    """Return the table of seconds by stage; empty without timings.

    A last row has what no stage accounts for, if it is more than 0.5 % of the total. The total is
    also given without compiling.
    """
    timings = {k: float(v) for k, v in run.summary_part("timings").items()}
    total = timings.pop("total", sum(timings.values()))
    if not timings or total <= 0.0:
        return ""
    remainder = total - sum(timings.values())
    rows = [
        _timing_row(STAGES.get(key, key.replace("_", " ")), value, total, key in _COMPILING)
        for key, value in timings.items()
    ]
    if remainder > 0.005 * total:
        rows.append(_timing_row("Everything else", remainder, total, False))
    compiling = sum(timings.get(key, 0.0) for key in _COMPILING)
    rows.append(
        f'<tr class="total"><td>Total</td><td class="number">{number(total, 3)} s</td>'
        f'<td class="share">{number(total - compiling, 3)} s without compiling</td></tr>'
    )
    return (
        '<table><thead><tr><th>Stage</th><th class="number">Time</th><th></th></tr></thead>'
        f"{''.join(rows)}</table>"
    )


def _timing_row(label: str, value: float, total: float, is_apart: bool) -> str:
    kind = ' class="apart"' if is_apart else ""
    width = 100.0 * min(max(value / total, 0.0), 1.0)
    return (
        f'<tr{kind}><td>{escape(label)}</td><td class="number">{number(value, 3)} s</td>'
        f'<td class="share"><span class="bar" style="width:{width:.2f}%"></span></td></tr>'
    )


def named_row(first: str, second: str, cells: list[str]) -> str:
    """Return a row of two names, which are escaped, and of cells of HTML, which are not."""
    numbers = "".join(f'<td class="number">{cell.strip()}</td>' for cell in cells)
    return f"<tr><td>{escape(first)}</td><td>{escape(second)}</td>{numbers}</tr>"


def named_table(heads: tuple[str, ...], rows: list[str]) -> str:
    """Return a table whose columns after the second hold numbers; empty without rows."""
    if not rows:
        return ""
    cells = "".join(f"<th>{head}</th>" for head in heads[:2])
    cells += "".join(f'<th class="number">{head}</th>' for head in heads[2:])
    return f"<table><thead><tr>{cells}</tr></thead>{''.join(rows)}</table>"
