"""The page itself: plain HTML with everything it needs inside, so that it reads offline."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from typing import Any

from contiga.report.html_tables import (
    inputs_table,
    key_figures,
    status_table,
    timings_table,
)
from contiga.report.plots import PLOT_CONFIG, VIEW_CONFIG
from contiga.report.run_folder import Run
from contiga.report.style import number
from contiga.report.style import page as styled

_BODY_BUTTONS = """
<div class="choice" role="group" aria-label="How the body is drawn" data-what="body">
<button data-opacity="1" aria-pressed="false">Solid body</button>
<button data-opacity="0.25" aria-pressed="true">Glass</button>
<button data-opacity="0" aria-pressed="false">Hidden</button></div>
"""
_CHOOSING = """
<script>
document.querySelectorAll(".choice button").forEach(function (button) {
  button.addEventListener("click", function () {
    var group = button.parentElement;
    if (group.dataset.what === "body") {
      var opacity = Number(button.dataset.opacity);
      Plotly.restyle("view", {opacity: opacity, visible: opacity > 0}, [0]);
    } else {
      var looks = document.getElementById("view").layout.meta.looks[button.dataset.field];
      Plotly.restyle("view", looks[0], [1]);
      Plotly.restyle("view", looks[1], [2]);
    }
    group.querySelectorAll("button").forEach(function (other) {
      other.setAttribute("aria-pressed", String(other === button));
    });
  });
});
</script>
"""


def page(
    run: Run, *, still: bytes | None, view: Any, history: list[Any], peak_time: float | None
) -> str:
    """The whole report as one text.

    Parameters
    ----------
    still : the picture of the peak as PNG, None where the run wrote no fields
    view : plotly figure, None where the run wrote no fields
    history : plotly figures
    peak_time : the recorded time the pictures show
    """
    from plotly.offline import get_plotlyjs

    title = str(run.summary.get("title") or "Contact run")
    parts = [
        _heading(run, escape(title)),
        key_figures(run),
        _pictures(run, still, view, peak_time),
        "<h2>Over time</h2>",
        _histories(history),
        _peak_note(peak_time),
        _tables(run),
        _warnings(run),
        _case(run),
    ]
    return styled(title, "\n".join(parts), script=get_plotlyjs())


def _heading(run: Run, title: str) -> str:
    version = escape(str(run.summary.get("version") or ""))
    facts = []
    if len(run.times):
        span = f"t = {number(run.times[0])} to {number(run.times[-1])} {escape(run.units.time)}"
        facts.append(span.strip())
    if run.units.length:
        units = (run.units.length, run.units.mass, run.units.time, run.units.force)
        facts.append("units " + ", ".join(escape(u) for u in units))
    for key, label in (("finished", "finished"), ("threads", "threads")):
        if run.summary.get(key):
            facts.append(f"{label} {escape(str(run.summary[key]))}")
    return (
        f'<div class="maker"><b>contiga</b> {version} · contact report</div>'
        f'<h1>{title}</h1><p class="under">{" · ".join(facts)}</p>'
    )


def _pictures(run: Run, still: bytes | None, view: Any, peak_time: float | None) -> str:
    if still is None or view is None:
        return (
            "<h2>Pictures</h2><p>This run wrote no fields, so there is nothing to draw. "
            'Add <code>"vtkhdf"</code> to <code>formats</code> in <code>[output]</code> '
            "of the case for pictures.</p>"
        )
    when = f"{peak_time:g} {escape(run.units.time)}".strip() if peak_time is not None else ""
    image = b64encode(still).decode("ascii")
    return (
        f"<h2>The peak, at t = {when}</h2>"
        f'<figure><img alt="Body, slave and contact at the peak" '
        f'src="data:image/png;base64,{image}">'
        '<figcaption class="caption">The recorded time of greatest force. Slave points are drawn '
        "where they are, so those in contact lie inside the body. "
        f"{_still_note(view)}</figcaption></figure>"
        "<h2>Turn it about</h2>"
        f"{_BODY_BUTTONS}{_field_buttons(view)}"
        f'<div class="frame">{_figure(view, "view", VIEW_CONFIG)}</div>{_CHOOSING}'
        '<p class="caption">Drag to turn, scroll to come closer; the house goes back.</p>'
    )


def _still_note(view: Any) -> str:
    """What the still picture shows of the contact."""
    bar = escape(view.data[2].marker.colorbar.title.text or "")
    lines = len(view.data) > 3
    marks = "lines go around the regions of contact" if lines else "dots mark the points"
    return f"Colour is {bar[:1].lower()}{bar[1:]}; {marks}."


def _field_buttons(view: Any) -> str:
    """A choice of what the colours show, where there is one."""
    meta = view.layout.meta
    if not meta:
        return ""
    buttons = "".join(
        f'<button data-field="{name}" aria-pressed="{str(name == meta["first"]).lower()}">'
        f"{name.capitalize()}</button>"
        for name in meta["looks"]
    )
    group = 'class="choice" role="group" aria-label="What the colours show" data-what="field"'
    return f"<div {group}>{buttons}</div>"


def _histories(figures: list[Any]) -> str:
    panels = "".join(
        f'<div class="frame">{_figure(figure, f"history-{k}", PLOT_CONFIG)}</div>'
        for k, figure in enumerate(figures)
    )
    return f'<div class="panels">{panels}</div>'


def _figure(figure: Any, name: str, config: dict[str, Any]) -> str:
    return str(figure.to_html(full_html=False, include_plotlyjs=False, div_id=name, config=config))


def _peak_note(peak_time: float | None) -> str:
    if peak_time is None:
        return ""
    return '<p class="caption">The dotted line marks the time the pictures show.</p>'


def _tables(run: Run) -> str:
    return "".join(
        f'<h2>{title}</h2><div class="wide">{table}</div>'
        for title, table in (
            ("What went in", inputs_table(run)),
            ("Statuses, points counted over all steps", status_table(run)),
            ("Where the time went", timings_table(run)),
        )
        if table
    )


def _warnings(run: Run) -> str:
    warnings = [str(text) for text in run.summary.get("warnings") or []]
    if not warnings:
        return "<h2>Warnings</h2><p>None.</p>"
    rows = "".join(f"<li>{escape(text)}</li>" for text in warnings)
    return f'<h2>Warnings</h2><ul class="warnings">{rows}</ul>'


def _case(run: Run) -> str:
    if not run.case_text:
        return ""
    return (
        "<h2>The case</h2><details><summary>case.toml as it was run, defaults filled in</summary>"
        f"<pre>{escape(run.case_text)}</pre></details>"
    )
