"""Automatic steps, as a strip over time: the reason for each, and its frequency."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray
from contiga.report.figure import Figure, embedded
from contiga.report.lines import PLOT_CONFIG, finish
from contiga.report.run_folder import Run
from contiga.report.style import LINES, number

LANE = 24
"""Height of a lane, pixels."""
PIXEL = 5e-4
"""Gap between two stretches, as a share of the time, below which they are drawn as one."""


def steps_section(run: Run, peak_time: float | None) -> str:
    """Return the strip and the table of reasons; empty for given steps."""
    reasons = run.summary_part("step_reasons")
    if not reasons or not run.steps:
        return ""
    figure = steps_figure(run, reasons, peak_time)
    drawn = embedded(figure, "steps", PLOT_CONFIG)
    count, unit = sum(one["steps"] for one in reasons["reasons"]), escape(run.units.time)
    said = (
        f"Which reason had the last word on each of {count} steps, and when. The shortest is "
        f"{number(reasons['least'])} {unit} at t = {number(reasons['when'])}; "
        f"{number(reasons['tries'] / count, 2)} attempts were made for each step."
    )
    if reasons["let_pass"]:
        said += f" {reasons['let_pass']} have an energy balance error that shorter ones would not"
        said += " reduce."
    return (
        f'<h2>Steps</h2><div class="frame">{drawn}</div><p class="caption">{said}</p>'
        f'<div class="wide">{_table(reasons, run)}</div>'
    )


def steps_figure(run: Run, step_reasons: dict[str, Any], peak_time: float | None) -> Figure:
    """Return a lane for each reason, the most frequent at the top, with its number in the table."""
    figure, lanes = Figure(), step_reasons["reasons"]
    reasons, of = run.steps["reason"][1:], run.steps["of"][1:]
    for k, one in enumerate(lanes):
        reason, who = one["number"]
        x = _stretches(run.times, (reasons == reason) & (of == who))
        y, colour = np.full(len(x), float(len(lanes) - k)), LINES[k % len(LINES)]
        line = {"color": colour, "width": 0.5 * LANE}
        look = {"mode": "lines", "line": line, "name": one["told"], "hoverinfo": "name+x"}
        figure.data.append({"type": "scatter", "x": x, "y": y, **look})
    finish(figure, run, "", peak_time, height=140 + LANE * len(lanes))
    figure.layout |= {"showlegend": False, "hovermode": "closest"}
    figure.layout["margin"]["t"] = 16
    figure.layout["yaxis"] |= {
        "tickvals": list(range(len(lanes), 0, -1)),
        "ticktext": [str(k) for k in range(1, len(lanes) + 1)],
        "range": [0.4, len(lanes) + 0.6],
    }
    return figure


def _stretches(times: FloatArray, mask: NDArray[np.bool_]) -> FloatArray:
    """Return begin, end, NaN (3 k,) of each stretch of the steps in a mask (n − 1,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    begins, ends = times[edges[::2]], times[edges[1::2]]
    apart = begins[1:] - ends[:-1] > PIXEL * (times[-1] - times[0])
    begins, ends = begins[np.append(True, apart)], ends[np.append(apart, True)]
    return np.column_stack([begins, ends, np.full(len(begins), np.nan)]).ravel()


def _table(reasons: dict[str, Any], run: Run) -> str:
    """Return the table of reasons with their steps and durations."""
    rows = "".join(
        f"<tr><td>{k} · {escape(one['told'])}</td>"
        f'<td class="number">{one["steps"]}</td><td class="number">{number(one["time"])}</td></tr>'
        for k, one in enumerate(reasons["reasons"], start=1)
    )
    unit = f" [{escape(run.units.time)}]" if run.units.time else ""
    return (
        '<table><thead><tr><th>What set the step</th><th class="number">Steps</th>'
        f'<th class="number">Time{unit}</th></tr></thead>{rows}</table>'
    )
