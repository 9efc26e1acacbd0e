"""The page of a study: one file that reads offline, beside the reports of its cases."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from contiga.io.out.files import write_text
from contiga.report.figure import as_json, plotly_script
from contiga.report.lines import CONFIG, FONT
from contiga.report.style import GRID, INK, LINES, MUTED, PAPER, SCALE, number
from contiga.report.style import page as styled
from contiga.studies import convergence
from contiga.studies.curves import curves_section
from contiga.studies.folder import MAP, PAGE
from contiga.studies.maps import draw_map, map_figure, map_of
from contiga.studies.one_case import CASES, Base
from contiga.studies.optimise import best_of, excesses
from contiga.studies.row import DONE, Row
from contiga.studies.spec import StudySpec
from contiga.studies.table import Table

_DIGITS = 7
"""Digits of numbers on the page; the table has all."""
_FAINT = "#c9ced4"
_SCALE = SCALE[1:]
"""Colours of points and lines, without the palest, which is too close to white."""
_SELECT = '<label>{words} <select id="{name}"></select></label>'
_CASES_TABLE = (
    '<h2>Cases</h2><div id="rows"><table><thead><tr id="rows-head"></tr></thead>'
    '<tbody class="space"><tr><td><div id="rows-above"></div></td></tr></tbody>'
    '<tbody id="rows-body"></tbody>'
    '<tbody class="space"><tr><td><div id="rows-below"></div></td></tr></tbody></table></div>'
    '<p id="compare">Click rows to compare them, up to 20.</p><p class="caption">A click '
    "on a head sorts. Numbers of cases lead to their reports; the line that compares them is "
    "for the folder of this page, where table.h5 and table.csv have all digits.</p>"
)


def write_page(study: StudySpec, base: Base, table: Table, rows: tuple[Row, ...]) -> None:
    """Write the page, and the picture of the map if there is one; an old picture is removed."""
    folder = Path(base.folder)
    data = page_data(study, base, table, rows)
    colour_map = map_of(study, base, rows)
    picture = b""
    (folder / MAP).unlink(missing_ok=True)
    if colour_map is not None:
        draw_map(colour_map, study.title, folder / MAP)
        picture = (folder / MAP).read_bytes()
        data["map"] = map_figure(colour_map, {row.number: k for k, row in enumerate(rows)})
        data["between"] = colour_map.between
    curves = curves_section(folder, rows, study.variable[0].label)
    write_text(folder / PAGE, page_of(study, data, rows, picture, curves))


def page_data(study: StudySpec, base: Base, table: Table, rows: Sequence[Row]) -> dict[str, Any]:
    """Return the data for the script of the page: plain lists, and numbers of seven digits.

    A case without a report is linked to its folder.
    """
    names = [f"{CASES}/{row.number:04d}" for row in rows]
    reports = [(Path(base.folder) / name / "report.html").is_file() for name in names]
    data = {
        "count": len(rows),
        "columns": [_column(study, base, table, name) for name in table.columns],
        "links": [
            f"{name}/report.html" if has_report else f"{name}/"
            for name, has_report in zip(names, reports, strict=True)
        ],
        "folders": names,
        "config": {**CONFIG, "modeBarButtons": [["toImage"]]},
        "look": {
            "font": FONT,
            "ink": INK,
            "muted": MUTED,
            "grid": GRID,
            "paper": PAPER,
            "faint": _FAINT,
            "lines": LINES,
            "scale": [[k / (len(_SCALE) - 1), colour] for k, colour in enumerate(_SCALE)],
        },
    }
    if (goal := study.goal) is not None:
        within = [
            row.status == DONE and max(excesses(goal, row), default=0.0) <= 0.0 for row in rows
        ]
        # The best value after each case within the limits, and after the last case.
        x, y = [], []
        for k, row in enumerate(rows):
            best = best_of(goal, rows[: k + 1]) if within[k] or k == len(rows) - 1 else None
            if best is not None:
                x.append(row.number)
                y.append(_short(best.collected[goal.quantity]))
        data["goal"] = {"quantity": goal.quantity, "within": within, "best": {"x": x, "y": y}}
    if convergence.refined_variable(study) is not None:
        data["convergence"] = _convergence(study, base, list(rows))
    return data


def _column(study: StudySpec, base: Base, table: Table, name: str) -> dict[str, Any]:
    """Return a column as name, role, unit and values; for text, values are indices into `texts`."""
    role = "other"
    if name in table.variables:
        role = "variable"
    elif name in table.quantities:
        role = "quantity"
    units = base.units | {variable.label: variable.unit for variable in study.variable}
    column: dict[str, Any] = {"name": name, "role": role, "unit": units.get(name, "")}
    values = table.columns[name]
    if all(isinstance(value, int | float) for value in values):
        return column | {"values": [_short(value) for value in values]}
    texts = list(dict.fromkeys(str(value) for value in values))
    places = {text: k for k, text in enumerate(texts)}
    return column | {"texts": texts, "values": [places[str(value)] for value in values]}


def _short(value: float) -> float | int | None:
    if isinstance(value, int):
        return value
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None


def _convergence(study: StudySpec, base: Base, rows: list[Row]) -> dict[str, Any]:
    """Return name, levels and sizes of the refined variable, and the lines of each quantity."""
    refined = convergence.refined_variable(study)
    levels = [float(value) for value in refined.values]
    place = {row.number: k for k, row in enumerate(rows)}
    lines = {
        name: [
            {
                "label": line.label,
                "values": [_short(value) for value in line.values],
                "errors": [_short(value) for value in line.errors],
                "rows": [place[row] for row in line.rows],
                "said": convergence.line_in_words(line),
            }
            for line in convergence.lines_of(study, rows, name)
        ]
        for name in base.quantities
    }
    return {
        "name": refined.label,
        "levels": [number(level) for level in levels],
        "sizes": convergence.sizes_of(levels),
        "lines": lines,
    }


def page_of(
    study: StudySpec,
    data: dict[str, Any],
    rows: Sequence[Row],
    picture: bytes,
    curves: str = "",
) -> str:
    """Return the page as one text; `picture` is the map as PNG, `curves` the section of curves."""
    room = files("contiga.studies")
    script = room.joinpath("page.js").read_text(encoding="utf-8")
    css = room.joinpath("page.css").read_text(encoding="utf-8")
    failed = sum(row.status != DONE for row in rows)
    base = "" if study.base is None else f" of {escape(Path(study.base).name)}"
    counts = [f"{len(rows)} cases{base}", *([f"{failed} failed"] if failed else [])]
    tiles = [(number(len(rows)), "Cases", ""), (number(failed), "Failed", "")]
    if rows:
        seconds = sum(row.seconds for row in rows)
        tiles.append((f"{number(seconds / len(rows), 3)} <small>s</small>", "A case, mean", ""))
    if study.goal is not None:
        best = best_of(study.goal, rows)
        value = "–" if best is None else number(best.collected[study.goal.quantity])
        place = "no case is within the limits" if best is None else f"case {best.number}"
        tiles.append((value, f"Best {study.goal.quantity}", place))
    large_numbers = "".join(
        f'<div><div class="value">{value}</div><div class="label">{escape(label)}</div>'
        f'<div class="when">{escape(note)}</div></div>'
        for value, label, note in tiles
    )
    parts = [
        '<div class="maker"><b>contiga</b> · study</div>'
        f'<h1>{escape(study.title)}</h1><p class="under">{" · ".join(counts)}</p>',
        f'<div class="figures">{large_numbers}</div>',
        *_charts(study, data, picture),
        curves,
        _CASES_TABLE,
        f'<script type="application/json" id="study-data">{as_json(data)}</script>'
        f"<script>{script}</script>",
    ]
    return styled(study.title, "\n".join(parts), css=css, script=plotly_script())


def _charts(study: StudySpec, data: dict[str, Any], picture: bytes) -> list[str]:
    """Return the sections of map, goal, parallel axes, response and convergence; some are empty."""
    colour_map = course = levels = ""
    if "map" in data:
        image = b64encode(picture).decode("ascii")
        colour_map = (
            f'<h2>Over the part</h2><figure><img alt="Map over the part" '
            f'src="data:image/png;base64,{image}"></figure><h3>3D view</h3>'
            '<div class="frame"><div id="map"></div></div><p class="caption">Dots are the points '
            "that were hit; a click on one opens the report of its case. Of the rest, "
            f"{data['between']}; white dots are cases without a value.</p>"
        )
    if study.goal is not None:
        limits = "".join(f", {escape(text)}" for text in study.goal.subject_to)
        extreme = "least" if study.goal.minimise is not None else "greatest"
        course = (
            '<h2>How it was found</h2><div class="frame"><div id="course"></div></div>'
            f'<p class="caption">{escape(study.goal.quantity)} case after case, the {extreme} so '
            f"far as a line{limits}. Pale cases are beyond a limit.</p>"
        )
    parallel = (
        f"<h2>All at once</h2>{_choices(parallel_colour='Colour')}"
        '<div class="frame"><div id="parallel"></div></div><p class="caption">A line is a case. '
        "Drag along an axis to keep those that pass there; drag an axis to another place.</p>"
    )
    choices = _choices(response_y="Quantity", response_x="over", response_colour="colour")
    response = f'<h2>Response</h2>{choices}<div class="frame"><div id="response"></div></div>'
    if sum(column["role"] == "variable" for column in data["columns"]) > 1:
        choices = _choices(surface_z="Quantity", surface_x="over", surface_y="and")
        response += (
            f'<h3>Over two variables</h3>{choices}<div class="frame"><div id="surface"></div></div>'
        )
    response += '<p class="caption">A click on a point opens the report of its case.</p>'
    if "convergence" in data:
        levels = (
            f"<h2>Convergence</h2>{_choices(convergence_y='Quantity')}"
            '<div class="panels"><div class="frame"><div id="convergence"></div></div>'
            '<div class="frame"><div id="errors"></div></div></div>'
            '<p class="caption" id="orders"></p>'
        )
    return [colour_map, course, parallel, response, levels]


def _choices(**words: str) -> str:
    """Return selection lists with words before them, by their names in the script."""
    lists = (_SELECT.format(words=w, name=n.replace("_", "-")) for n, w in words.items())
    return f'<div class="choices">{"".join(lists)}</div>'
