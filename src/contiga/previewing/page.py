"""The page of a preview: a 3D view with its numbers, in one file."""

from __future__ import annotations

from html import escape

import numpy as np

from contiga.previewing.stage import CONTACT_SIDE, Drawn, Stage
from contiga.previewing.words import gap_text, gap_with_approach_text, legend, speed_text
from contiga.records import FloatArray
from contiga.report.figure import Figure, Trace, embedded, plotly_script
from contiga.report.space import VIEW_CONFIG, columns, dots, line_in_space, mesh_trace, space_layout
from contiga.report.style import INK, LINES, MUTED, TIES, page, swatch

RED = LINES[1]
_SIDE_OFFSET = 1e-3
"""Distance of the two drawn sides of a surface from it, over the size of the scene."""
_MAX_DOTS = 20_000
_CSS = ".swatch { display: inline-block; width: 12px; height: 12px; margin-right: 8px; }"


def page_of(stage: Stage) -> str:
    """Return the page as HTML that needs no other file: the scene, and tables of gaps and parts."""
    scene = embedded(figure_of(stage), "scene", VIEW_CONFIG)
    gaps = "".join(
        f"<tr><td>{escape(gap.contact)}</td><td>{escape(gap.slave)} against {escape(gap.master)}"
        f"</td><td>{escape(gap_with_approach_text(gap, stage.units))}</td></tr>"
        for gap in stage.gaps
    )
    head = "<thead><tr><th>Contact</th><th>Between</th><th>At the start, and then</th></tr></thead>"
    parts = "".join(
        f"<tr><td>{swatch(colour)}{escape(text)}</td></tr>"
        for text, colour in (*legend(stage), ("the contact side of bodies", CONTACT_SIDE))
    )
    body = (
        '<div class="maker"><b>contiga</b> · preview</div>'
        f'<h1>{escape(stage.title)}</h1><p class="under">Where all stands at the start. '
        "Nothing has been run.</p>"
        f'<div class="frame">{scene}</div>'
        '<p class="caption">Drag to turn, scroll to zoom. Cones point to the free side of '
        "bodies; dashed lines are the ways that motions prescribe, thick ochre ones springs, "
        "purple ones axes of joints.</p>"
        + (f"<h2>Gaps</h2><table>{head}{gaps}</table>" if gaps else "")
        + f"<h2>Parts</h2><table>{parts}</table>"
    )
    return page(stage.title, body, css=_CSS, script=plotly_script())


def figure_of(stage: Stage) -> Figure:
    """Return the scene as a figure of plotly, its frame 8 % wider than the parts.

    It has traces of parts, normals, paths of motions, velocities, springs and joints, and gaps;
    each has the name of what it shows. A plane problem is seen from +z.
    """
    box = np.concatenate([stage.box, stage.velocity_ends.reshape(-1, 3)])
    low, high = box.min(axis=0), box.max(axis=0)
    margin = 0.08 * float((high - low).max())
    spans = np.stack([low - margin, high + margin], axis=1)
    eye = {"x": 0.0, "y": 0.0, "z": 2.1} if stage.plane else {"x": 1.1, "y": -1.5, "z": 0.9}
    up = {"x": 0, "y": 1, "z": 0} if stage.plane else {"x": 0, "y": 0, "z": 1}
    # room for the labels under the scene
    camera = {"eye": eye, "up": up, "center": {name: -0.12 * up[name] for name in "xyz"}}
    figure = Figure(layout=space_layout(stage.units.length, spans.tolist(), camera, height=640))
    size = float(np.linalg.norm(np.ptp(stage.box, axis=0)))
    for part in stage.parts:
        figure.data.extend(_part_traces(part, _SIDE_OFFSET * size))
    for part in stage.parts:
        figure.data.extend(_normal_traces(stage, part))
    for k, path in enumerate(stage.paths):
        style = {"color": LINES[k % len(LINES)], "width": 4, "dash": "dash"}
        figure.data.extend([line_in_space(f"{path.name}: way", p, style) for p in path.lines])
    for arrow, ends in zip(stage.velocities, stage.velocity_ends, strict=True):
        name = f"{arrow.name}: {speed_text(arrow, stage.units)}"
        figure.data.append(line_in_space(name, ends, {"color": INK, "width": 6}))
        figure.data.append(_cones(name, ends[1:], 0.2 * (ends[1:] - ends[:1]), INK))
    for tie in stage.ties:
        style = {"color": TIES[tie.kind], "width": 5}
        figure.data.append(line_in_space(f"{tie.kind} {tie.name}", tie.ends, style))
    for gap in stage.gaps:
        text = f"{gap.contact}: {gap_text(gap, stage.units)}"
        trace = line_in_space(
            text,
            gap.ends,
            {"color": RED, "width": 7},
            mode="lines+markers+text",
            marker={"size": 4, "color": RED},
            text=[text, ""],
            textposition="top center",
            textfont={"color": RED, "size": 12},
        )
        figure.data.append(trace)
    return figure


def _part_traces(part: Drawn, offset: float) -> list[Trace]:
    """Return a body's two sides, `offset` off its surface, or a slave's facets or points.

    Inactive points are a faint trace of their own. Of more than 20 000 points every k-th is drawn.
    """
    traces = []
    if len(part.triangles) and part.is_body:
        # mean normals at the points, weighted by area
        corners = part.points[part.triangles]
        crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.zeros_like(part.points)
        for k in range(3):
            np.add.at(normals, part.triangles[:, k], crosses)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        shift = offset * normals
        free, contact = part.points + shift, part.points - shift
        traces.append(mesh_trace(free, part.triangles, part.name, part.colour, 1.0))
        contact_side = mesh_trace(contact, part.triangles, part.name, CONTACT_SIDE, 1.0)
        traces.append(contact_side | {"name": f"{part.name}: contact side"})
    elif len(part.triangles):
        traces.append(mesh_trace(part.points, part.triangles, part.name, part.colour, 1.0))
    elif part.active.any():
        points = part.points[part.active]
        style = {"color": MUTED}
        traces.append(dots(points[:: len(points) // _MAX_DOTS + 1], part.name, 2.2, style))
    if not part.active.all():
        points = part.points[~part.active]
        faint = {"color": MUTED, "opacity": 0.15}
        name = f"{part.name}: inactive"
        traces.append(dots(points[:: len(points) // _MAX_DOTS + 1], name, 1.6, faint))
    return traces


def _normal_traces(stage: Stage, part: Drawn) -> list[Trace]:
    """Return the lines and the cones of a part's normals, 0.13 of its size long; none of slaves."""
    arrows = [arrow for arrow in stage.normals if arrow.name == part.name]
    if not arrows:
        return []
    length = 0.13 * float(np.linalg.norm(np.ptp(part.box, axis=0)))
    starts = np.array([arrow.at for arrow in arrows])
    tips = starts + length * np.array([arrow.vector for arrow in arrows])
    breaks = np.full_like(starts, np.nan)
    path = np.stack([starts, tips, breaks], axis=1).reshape(-1, 3)
    name = f"{part.name}: free side"
    lines = line_in_space(name, path, {"color": LINES[0], "width": 3})
    return [lines, _cones(name, tips, 0.3 * (tips - starts), LINES[0])]


def _cones(name: str, tips: FloatArray, vectors: FloatArray, colour: str) -> Trace:
    """Return cones with their points at `tips`, as long as the `vectors`."""
    return {
        "type": "cone",
        **columns(tips),
        **columns(vectors, "uvw"),
        "name": name,
        "anchor": "tip",
        "sizemode": "raw",
        "sizeref": 1.0,
        "colorscale": [[0.0, colour], [1.0, colour]],
        "showscale": False,
        "hoverinfo": "name",
    }
