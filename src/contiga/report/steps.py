"""Automatic steps, as a strip over time: the reason for each, and its frequency."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from contiga.report.figure import Figure, embedded
from contiga.report.lines import PLOT_CONFIG, finish
from contiga.report.run_folder import Run
from contiga.report.style import LINES, number

LANE = 24
"""Height of a lane, pixels."""
PIXEL = 5e-4
"""Gap between two stretches, as a share of the time, below which they are drawn as one."""


def steps_section(run: Run, peak_time: float | None) -> str:
    """Return the strip and the table of reasons of automatic steps; empty for given steps."""
    reasons = run.summary_part("step_reasons")
    if not reasons or not run.steps:
        return ""
    figure = embedded(steps_figure(run, reasons, peak_time), "steps", PLOT_CONFIG)
    unit = escape(run.units.time)
    count = sum(reason["steps"] for reason in reasons["reasons"])
    caption = (
        f"Which reason had the last word on each of {count} steps, and when. The shortest is "
        f"{number(reasons['least'])} {unit} at t = {number(reasons['when'])}; "
        f"{number(reasons['tries'] / count, 2)} attempts were made for each step."
    )
    if reasons["let_pass"]:
        caption += f" {reasons['let_pass']} have an energy balance error that shorter ones would"
        caption += " not reduce."
    rows = "".join(
        f'<tr><td>{k} · {escape(reason["told"])}</td><td class="number">{reason["steps"]}</td>'
        f'<td class="number">{number(reason["time"])}</td></tr>'
        for k, reason in enumerate(reasons["reasons"], start=1)
    )
    time = f"Time [{unit}]" if unit else "Time"
    return (
        f'<h2>Steps</h2><div class="frame">{figure}</div><p class="caption">{caption}</p>'
        '<div class="wide"><table><thead><tr><th>What set the step</th>'
        f'<th class="number">Steps</th><th class="number">{time}</th></tr></thead>'
        f"{rows}</table></div>"
    )


def steps_figure(run: Run, step_reasons: dict[str, Any], peak_time: float | None) -> Figure:
    """Return a figure with a numbered lane for each reason of `step_reasons`, the first at the top.

    Stretches of steps for one reason are bars; gaps below `PIXEL` of the duration are not shown.
    """
    figure, lanes = Figure(), step_reasons["reasons"]
    reasons, owners = run.steps["reason"][1:], run.steps["of"][1:]
    for k, lane in enumerate(lanes):
        reason, owner = lane["number"]
        is_lane = (reasons == reason) & (owners == owner)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], is_lane.astype(np.int8), [0]])))
        begins, ends = run.times[edges[::2]], run.times[edges[1::2]]
        is_gap = begins[1:] - ends[:-1] > PIXEL * (run.times[-1] - run.times[0])
        begins, ends = begins[np.append(True, is_gap)], ends[np.append(is_gap, True)]
        x = np.column_stack([begins, ends, np.full(len(begins), np.nan)]).ravel()
        y, colour = np.full(len(x), float(len(lanes) - k)), LINES[k % len(LINES)]
        line = {"color": colour, "width": 0.5 * LANE}
        look = {"mode": "lines", "line": line, "name": lane["told"], "hoverinfo": "name+x"}
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
