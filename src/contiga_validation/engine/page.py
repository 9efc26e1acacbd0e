"""The page of the reproduction: one HTML file that needs no network."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Sequence
from html import escape
from importlib.resources import files
from itertools import groupby
from typing import Any

from contiga.report import style
from contiga_validation.engine.experiment import Cell, ExperimentResult, Table
from contiga_validation.engine.table_files import plain

_TITLE = "The thesis, reproduced"
_ABOUT = (
    "Every experiment of the thesis the method comes from (<i>A New Contact Method for Simcenter "
    "Madymo</i>), run anew with contiga and set beside the thesis&#8217; own numbers. Its figures "
    "are drawn again from computed data; where its text gives no geometry, a scene was designed "
    "that shows the same behaviour, and the entry says so. A tick means that the statement held in "
    "this run."
)


def page(
    results: Sequence[ExperimentResult], facts: dict[str, Any], heading_of: Callable[[int], str]
) -> str:
    """Return the page as one text of HTML.

    Parameters
    ----------
    results : of the experiments, by chapter
    facts : version and machine, from `contiga_validation.engine.table_files.machine`
    heading_of : returns the heading of a chapter number
    """
    groups = groupby(results, lambda f: f.experiment.chapter)
    chapters = [(heading_of(k), list(group)) for k, group in groups]
    head = heading("reproduction", _TITLE, _ABOUT, facts)
    parts = [head + _verdict(results), _contents(chapters)]
    for chapter, entries in chapters:
        parts.append(f"<h2>{escape(chapter)}</h2>")
        parts += [_section(entry) for entry in entries]
    parts.append(_timings(results))
    css = files("contiga_validation.engine").joinpath("style.css").read_text(encoding="utf-8")
    return style.page(_TITLE, "\n".join(parts), css=css)


def heading(kind: str, title: str, about: str, facts: dict[str, Any], more: str = "") -> str:
    """Return the head of a page: its kind, title, date, machine and subject.

    `title` and `about` are HTML; `more` follows the facts of the machine.
    """
    machine_line = (
        f"finished {facts['finished']} · {facts['processor']}, {facts['threads']} threads · "
        f"{facts['system']} · Python {facts['python']}, NumPy {facts['numpy']}, "
        f"Numba {facts['numba']}{more}"
    )
    return (
        f'<div class="maker"><b>contiga</b> {escape(facts["version"])} · {kind}</div>'
        f'<h1>{title}</h1><p class="under">{escape(machine_line)}</p><p>{about}</p>'
    )


def image(alt: str, width: float, content: bytes) -> str:
    """Return an image of a page from a PNG, shown at 132 pixels per inch of `width`."""
    data = b64encode(content).decode("ascii")
    return (
        f'<img alt="{escape(alt)}" width="{round(132 * width)}" src="data:image/png;base64,{data}">'
    )


def _verdict(results: Sequence[ExperimentResult]) -> str:
    """Return the line that says that all claims held, and a list of those that did not."""
    claims = [(e.experiment.key, claim) for e in results for claim in e.outcome.claims]
    broken = [(key, claim) for key, claim in claims if not claim.holds]
    if not broken:
        return f'<p class="verdict">✓ All {len(claims)} statements held.</p>'
    rows = "".join(
        f'<li><a href="#{escape(key)}">{escape(key)}</a> {escape(claim.text)}</li>'
        for key, claim in broken
    )
    text = f"✗ {len(broken)} of {len(claims)} statements did not hold:"
    return f'<p class="verdict bad">{text}</p><ul class="warnings">{rows}</ul>'


def _contents(chapters: Sequence[tuple[str, list[ExperimentResult]]]) -> str:
    """Return the table of contents, with links to the experiments of each chapter."""
    parts = []
    for chapter, entries in chapters:
        parts.append(f"<h3>{escape(chapter)}</h3>")
        for entry in entries:
            key, title = escape(entry.experiment.key), escape(entry.experiment.title)
            # the key of an experiment is its section and a name
            section = key.partition("-")[0]
            parts.append(f'<a href="#{key}"><span class="key">{section}</span>{title}</a>')
    return f'<nav aria-label="Contents">{"".join(parts)}</nav>'


def _section(entry: ExperimentResult) -> str:
    """Return the section of an experiment: pictures, tables, claims and differences."""
    experiment, outcome = entry.experiment, entry.outcome
    parts = [
        f'<section id="{escape(experiment.key)}">',
        f'<h3 class="title">{escape(experiment.title)}</h3>',
        f'<p class="under">{escape(experiment.where)}</p>',
    ]
    if experiment.thesis:
        parts.append(f'<p class="thesis"><b>The thesis.</b> {escape(experiment.thesis)}</p>')
    for picture, content in zip(outcome.pictures, entry.pictures, strict=True):
        is_of_thesis = picture.key.replace(".", "").isdigit()  # named after a figure, such as 5.14
        label = f"Fig. {picture.key}." if is_of_thesis else ""
        caption = f"<b>{escape(label)}</b> {escape(picture.caption)}"
        img = image(picture.caption, picture.size[0], content)
        parts.append(f"<figure>{img}<figcaption>{caption}</figcaption></figure>")
    parts += [_table(table) for table in outcome.tables]
    claims = "".join(
        f'<li{"" if claim.holds else " class=broken"}><span class="mark">'
        f"{'✓' if claim.holds else '✗'}</span><span>{escape(claim.text)} "
        f'<span class="measured">{escape(claim.measured)}</span></span></li>'
        for claim in outcome.claims
    )
    parts.append(f'<ul class="claims">{claims}</ul>' if claims else "")
    if outcome.difference:
        parts.append(f'<p class="why"><b>Why it differs.</b> {escape(outcome.difference)}</p>')
    return "".join([*parts, "</section>"])


def _table(table: Table) -> str:
    """Return a table; columns without texts are aligned as numbers."""
    numeric = [
        all(not isinstance(plain(row[k]), str) for row in table.rows)
        for k in range(len(table.columns))
    ]
    kinds = [' class="number"' if is_number else "" for is_number in numeric]
    head = "".join(
        f"<th{kind}>{escape(name)}</th>" for name, kind in zip(table.columns, kinds, strict=True)
    )
    rows = "".join(
        "<tr>"
        + "".join(f"<td{kind}>{_cell(v)}</td>" for v, kind in zip(row, kinds, strict=True))
        + "</tr>"
        for row in table.rows
    )
    return (
        f'<div class="wide"><table><caption><b>{escape(table.key)}</b> {escape(table.title)}'
        f"</caption><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _cell(value: Cell) -> str:
    """Return a value as text: a dash for None and NaN, integers in full."""
    cell = plain(value)
    if cell is None:
        return "–"
    if isinstance(cell, int):
        return style.number(float(cell), 12)
    return style.number(cell) if isinstance(cell, float) else escape(cell)


def _timings(results: Sequence[ExperimentResult]) -> str:
    """Return the table of run times, with the compiling of kernels apart."""
    rows = "".join(
        f'<tr><td><a href="#{escape(e.experiment.key)}">{escape(e.experiment.key)}</a></td>'
        f'<td class="number">{style.number(e.seconds - e.compiled, 3)} s</td>'
        f'<td class="number">{style.number(e.compiled, 3)} s</td></tr>'
        for e in results
    )
    total, compiling = sum(e.seconds for e in results), sum(e.compiled for e in results)
    return (
        '<h2>Where the time went</h2><p class="under">Experiments with their pictures. Kernels are '
        "compiled once on a machine, in the experiment that first needs them; some of them ahead, "
        "by a second process.</p>"
        '<div class="wide"><table><thead><tr><th>Experiment</th><th class="number">Time</th>'
        f'<th class="number">Compiling, apart</th></tr></thead><tbody>{rows}<tr class="total">'
        f'<td>Total</td><td class="number">{style.number(total - compiling, 3)} s</td>'
        f'<td class="number">{style.number(compiling, 3)} s</td></tr></tbody></table></div>'
    )
