"""The page of a report: plain HTML that contains all it needs, so that it reads offline."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from importlib.resources import files

from contiga.report.curves import curve_figure, curves_of
from contiga.report.figure import Figure, as_json, embedded, plotly_script, side_by_side
from contiga.report.gas import gas_figures, gas_table
from contiga.report.html_tables import inputs_table, key_figures, status_table, timings_table
from contiga.report.joints import joint_table
from contiga.report.lines import PLOT_CONFIG
from contiga.report.motion import body_figures, criteria_table, extremes_table, sensor_figures
from contiga.report.plots import energy_figure, has_contact, history_figures
from contiga.report.references import rated, ratings_table, references_of
from contiga.report.run_folder import Run
from contiga.report.runs import Named
from contiga.report.space import VIEW_CONFIG, View
from contiga.report.springs import (
    device_table,
    slip_ring_table,
    spring_figures,
    spring_table,
)
from contiga.report.steps import steps_section
from contiga.report.still import halves
from contiga.report.style import number
from contiga.report.style import page as styled

_NARROW = ' style="max-width: 640px"'
_BODY_BUTTONS = """
<div class="choice" role="group" aria-label="How the body is drawn" data-what="body">
<button data-opacity="1" aria-pressed="false">Solid body</button>
<button data-opacity="0.25" aria-pressed="true">Glass</button>
<button data-opacity="0" aria-pressed="false">Hidden</button></div>
"""
_FRAME_BUTTONS = """
<div class="choice" role="group" aria-label="What is in the frame" data-what="frame">
<button data-frame="all" aria-pressed="true">All bodies</button>
<button data-frame="near" aria-pressed="false">What touches</button></div>
"""
_PLAYING = """
<div class="time"><button id="play">Play</button>
<input id="step" type="range" min="0" max="{last}" value="{first}" aria-label="Recorded step"
aria-valuetext="{label}, the peak">
<output id="step-time" for="step">{label}, the peak</output></div>
"""


def page(run: Run, *, still: bytes | None, view: View | None, peak_time: float | None) -> str:
    """Return the whole report as one text of HTML; sections without data are left out.

    Parameters
    ----------
    run : the run
    still : the picture of the peak as PNG, None where the run wrote no fields
    view : the 3D view, None where the run wrote no fields
    peak_time : the recorded time the pictures show
    """
    title = str(run.summary.get("title") or "Contact run")
    curves, ratings = curves_of(run), [rated(run, test) for test in references_of(run)]
    tests = [rating.reference for rating in ratings]
    curve_figures = [curve_figure([Named(run, "")], curve, tests, peak_time) for curve in curves]
    spring_tables = f"{spring_table(run)}{device_table(run)}{slip_ring_table(run)}"
    parts = [
        _heading(run, escape(title)),
        key_figures(run),
        _pictures(run, still, view, peak_time),
        _contacts(run, peak_time),
        f"<h2>Curves</h2>{_panels(curve_figures, 'curve')}{ratings_table(ratings, run.units.time)}"
        if curves
        else "",
        steps_section(run, peak_time),
        _energy(run, peak_time),
        _section(
            "Motion of free bodies",
            extremes_table(run),
            _panels_by_owner({b: body_figures(run, b, peak_time) for b in run.bodies}, "body"),
        ),
        _section(
            "Sensors",
            criteria_table(run),
            _panels_by_owner(
                {sensor: sensor_figures(run, sensor, peak_time) for sensor in run.sensors}, "sensor"
            ),
        ),
        _section("Springs", spring_tables, _panels(spring_figures(run, peak_time), "spring")),
        _section("Joints", joint_table(run)),
        _section("Gas", gas_table(run), _panels(gas_figures(run, peak_time), "gas")),
        _section("What went in", inputs_table(run))
        + _section("Statuses, points counted over all steps", status_table(run))
        + _section("Where the time went", timings_table(run)),
    ]
    warnings = "".join(
        f"<li>{escape(str(text))}</li>" for text in run.summary.get("warnings") or []
    )
    warnings = f'<ul class="warnings">{warnings}</ul>' if warnings else "<p>None.</p>"
    parts.append(f"<h2>Warnings</h2>{warnings}")
    details = "<details><summary>case.toml as it was run, defaults filled in</summary>"
    text = f"<h2>The case</h2>{details}<pre>{escape(run.case_text)}</pre></details>"
    parts.append(text if run.case_text else "")
    return styled(title, "\n".join(parts), script=plotly_script())


def _section(title: str, table: str, panels: str = "") -> str:
    """Return a heading, a table and figures; empty without table and figures."""
    if not table and not panels:
        return ""
    return f'<h2>{title}</h2><div class="wide">{table}</div>{panels}'


def _panels(figures: list[Figure], name: str) -> str:
    """Return figures side by side; empty without figures."""
    if not figures:
        return ""
    return side_by_side(
        embedded(figure, f"{name}-{k}", PLOT_CONFIG) for k, figure in enumerate(figures)
    )


def _panels_by_owner(figures_by_owner: dict[str, list[Figure]], kind: str) -> str:
    """Return the figures of each body or sensor under its name."""
    return "".join(
        f"<h3>{escape(owner)}</h3>{_panels(figures, f'{kind}-{k}')}"
        for k, (owner, figures) in enumerate(figures_by_owner.items())
        if figures
    )


def _heading(run: Run, title: str) -> str:
    """Return title and version, and what is known of time span, units, end and threads."""
    version = escape(str(run.summary.get("version") or ""))
    facts = []
    if len(run.times):
        span = f"t = {number(run.times[0])} to {number(run.times[-1])} {escape(run.units.time)}"
        facts.append(span.strip())
    if run.units.length:
        units = (run.units.length, run.units.mass, run.units.time, run.units.force)
        facts.append("units " + ", ".join(escape(u) for u in units))
    if not run.finished:
        facts.append("<b>unfinished</b>")
    for key, label in (("finished", "finished"), ("threads", "threads")):
        if run.summary.get(key):
            facts.append(f"{label} {escape(str(run.summary[key]))}")
    return (
        f'<div class="maker"><b>contiga</b> {version} · contact report</div>'
        f'<h1>{title}</h1><p class="under">{" · ".join(facts)}</p>'
    )


def _pictures(run: Run, still: bytes | None, view: View | None, peak_time: float | None) -> str:
    """Return the still picture and the 3D view; without fields, a sentence on how to get them."""
    if still is None or view is None:
        return (
            "<h2>Pictures</h2><p>This run wrote no fields, so there is nothing to draw. "
            'Add <code>"vtkhdf"</code> to <code>formats</code> in <code>[output]</code> '
            "of the case for pictures.</p>"
        )
    time = f"{number(peak_time)} {escape(run.units.time)}".strip() if peak_time is not None else ""
    if view.touches:
        head = f"The peak, at t = {time}"
        # both views as images of their own, which can stand one over the other
        names = ("Body, slave and contact at the peak", "The contact, seen through the body")
        images = "".join(map(_image, halves(still), names))
        picture = f'<div class="halves">{images}</div>'
        marks = "lines go around the regions of contact"
        if not view.outlined:
            marks = "dots mark the points"
        stress = "the von Mises stress of what deforms, in the second picture "
        stress = stress if "von_mises" in view.data["looks"] else ""
        caption = (
            "The recorded time of greatest force, framed around the parts that touch. Slave points "
            "are drawn at their positions: points in contact lie inside the body. "
            f"Colour is {stress}{escape(view.note[:1].lower() + view.note[1:])}; {marks}."
        )
    else:
        head = f"The scene, at t = {time}"
        picture = _image(still, "Body and slave", _NARROW)
        caption = "At no recorded time is a point in contact." if run.contacts else "No contacts."
    return (
        f"<h2>{head}</h2><figure>{picture}"
        f'<figcaption class="caption">{caption}</figcaption></figure>'
        f"<h2>3D view</h2>{_view(view)}"
    )


def _image(picture: bytes, name: str, style: str = "") -> str:
    data = b64encode(picture).decode("ascii")
    return f'<img alt="{name}"{style} src="data:image/png;base64,{data}">'


def _view(view: View) -> str:
    """Return the scene, its buttons and slider as far as it has a use for them, and its script."""
    script = files("contiga.report").joinpath("view.js").read_text(encoding="utf-8")
    slider = steps = field_buttons = ""
    if view.steps > 1:
        first = view.data["first"]
        label = escape(view.data["labels"][first])
        slider = _PLAYING.format(last=view.steps - 1, first=first, label=label)
        count = f"{view.steps} of the {view.recorded}"
        if view.steps == view.recorded:
            count = f"all {view.steps}"
        steps = f" It shows {count} recorded steps; Play shows them at their times, in six seconds."
    if len(view.data["looks"]) > 1:
        buttons = "".join(
            f'<button data-field="{name}" aria-pressed="{str(name == view.data["field"]).lower()}">'
            f"{view.data['names'][name]}</button>"
            for name in view.data["looks"]
        )
        group = 'class="choice" role="group" aria-label="What the colours show" data-what="field"'
        field_buttons = f"<div {group}>{buttons}</div>"
    return (
        f"{_BODY_BUTTONS}{_FRAME_BUTTONS if 'spans' in view.data else ''}{field_buttons}"
        f'<div class="frame">{embedded(view.figure, "view", VIEW_CONFIG)}{slider}</div>'
        f'<script type="application/json" id="view-data">{as_json(view.data)}</script>'
        f"<script>{script}</script>"
        '<p class="caption">Drag to turn, scroll to zoom; the house button resets the view.'
        f"{steps}</p>"
    )


def _energy(run: Run, peak_time: float | None) -> str:
    """Return the energies of the system and the error of their balance; empty without energies."""
    figure = energy_figure(run, peak_time)
    if figure is None:
        return ""
    energy = run.summary_part("energy")
    share = (
        f" The energy balance error is at most {number(100.0 * energy['relative'], 2)} % of the "
        f"largest energy, {number(energy['most'])} {escape(run.units.energy)}."
        if energy
        else ""
    )
    return (
        f'<h2>Energy</h2><div class="frame">{embedded(figure, "energy", PLOT_CONFIG)}</div>'
        '<p class="caption">Stacked, where the energy is and what has been lost; dashed, what was '
        f"there at the start and came in from outside since.{share}</p>"
    )


def _contacts(run: Run, peak_time: float | None) -> str:
    """Return the figures of the contacts over time; a sentence names contacts that never touch."""
    if not run.contacts:
        return ""
    panels = _panels(history_figures(run, peak_time), "history")
    if panels and peak_time is not None:
        panels += '<p class="caption">The dotted line marks the time that the scene shows.</p>'
    idle = [name for name in run.contacts if not has_contact(run, name)]
    note = ""
    if len(idle) == len(run.contacts):
        note = "<p>No point came into contact: force, penetration and area are zero throughout.</p>"
    elif idle:
        note = f"<p>No point came into contact in {escape(', '.join(idle))}.</p>"
    return f"<h2>Over time</h2>{panels}{note}" if panels or note else ""
