"""The still picture of a preview: the whole scene, and close-ups of the smallest gaps."""

from __future__ import annotations

from itertools import product
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from contiga.previewing.stage import CONTACT_SIDE, Drawn, Gap, Stage
from contiga.previewing.words import gap_text, gap_with_approach_text, legend, span_text
from contiga.records import FloatArray
from contiga.rendering.camera import unit
from contiga.rendering.shading import free_edges
from contiga.report.labels import spread
from contiga.report.style import INK, LINES, MUTED, TIES
from contiga.report.view import View
from contiga.triangles.trimesh import TriMesh

RED = LINES[1]
_SIZE, _DPI = (14.4, 8.8), 100
_SCENE_BOX, _CLOSEUP_BOX = (0.01, 0.17, 0.6, 0.73), (0.63, 0.17, 0.36, 0.73)
_MAX_NAME = 32
"""Largest number of characters of a contact's name over its picture."""
_MAX_CLOSEUPS = 3
"""Largest number of close-ups of gaps."""
_MAX_SPRINGS = 12
"""Largest number of springs that are named in the picture."""
_MIN_SPRING = 12.0
"""Smallest length of a named spring, pixels: names of shorter ones would hide their ends."""
_MAX_DOTS = 4000
"""Largest number of points of a part that are drawn or used for the frame."""
_FAINT = "#c9ced4"
_CHARACTER = np.array([6.6, 14.5])
"""Width and height of a character of the labels, pixels."""
_SIDEWAYS = np.array([-0.55, 0.75, -0.45])
_FRONT = np.array([0.0, 0.0, -1.0])


def draw_still(stage: Stage, file: BinaryIO | str) -> None:
    """Write `stage` as PNG: the scene, close-ups of up to three smallest gaps, and a legend."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    figure.text(0.015, 0.955, stage.title[:90], fontsize=15, color=INK, va="center")
    _draw_scene(figure.add_axes(_SCENE_BOX if stage.gaps else (0.01, 0.17, 0.98, 0.73)), stage)
    smallest = sorted(stage.gaps, key=lambda gap: gap.value)[:_MAX_CLOSEUPS]
    x, y, width, height = _CLOSEUP_BOX
    for k, gap in enumerate(smallest):
        share = height / len(smallest)
        box = (x, y + height - (k + 1) * share, width, share - (0.035 if k else 0.0))
        _draw_closeup(figure.add_axes(box), stage, gap)
    _draw_legend(figure.add_axes((0.015, 0.01, 0.97, 0.14)), stage)
    figure.savefig(file, format="png")


def _pixels(axes: Any) -> tuple[int, int]:
    box = axes.get_position()
    return round(box.width * _SIZE[0] * _DPI), round(box.height * _SIZE[1] * _DPI)


def _subsample(points: FloatArray) -> FloatArray:
    return points[:: len(points) // _MAX_DOTS + 1]


def _draw_scene(axes: Any, stage: Stage) -> None:
    """Draw all parts, with normals, paths, velocities, springs, joints and gaps, and label them.

    Normals that are hidden, or point away from the eye, are left out. A plane problem is seen along
    −z, its bodies as lines.
    """
    corners = np.array(list(product(*stage.box.T)))
    frame = [_subsample(part.points[part.active]) for part in stage.parts]
    frame += [corners, stage.velocity_ends.reshape(-1, 3)]
    towards, size = _FRONT if stage.plane else _SIDEWAYS, _pixels(axes)
    # Space for the lengths along the edges, outside the box.
    middle = stage.box.mean(axis=0)
    view = View(axes, middle + 1.12 * (np.concatenate(frame) - middle), towards=towards, shape=size)
    for part in sorted(stage.parts, key=lambda part: part.is_body):
        if stage.plane and part.is_body:
            _draw_profile(axes, view, part)
        else:
            _draw_part(view, part)
    for arrow in stage.normals:
        length = 0.13 * float(np.linalg.norm(np.ptp(stage.part(arrow.name).box, axis=0)))
        tip = arrow.at + length * arrow.vector
        if arrow.vector @ unit(towards) < 0.2 and view.sees([arrow.at]).all():
            view.arrow(arrow.at, tip, color=LINES[0], lw=0.9, mutation_scale=8)
    for k, path in enumerate(stage.paths):
        for line in path.lines:
            _draw_path(axes, view.placed(line), LINES[k % len(LINES)])
    for ends in stage.velocity_ends:
        view.arrow(*ends, color=INK, lw=2.0)
    for tie in stage.ties:
        view.lines(tie.ends, color=TIES[tie.kind], lw=2.2)
    for gap in stage.gaps:
        axes.plot(*view.placed(gap.ends).T, "o-", color=RED, ms=4.0, mew=0.0, lw=1.6, zorder=6)
    lengths = _draw_box_edges(view, stage)
    _draw_labels(axes, view, stage, lengths)
    view.show()


def _draw_part(view: View, part: Drawn, opacity: float = 1.0, *, nodes: bool = False) -> None:
    """Draw a part: shaded triangles, or points of a cloud; inactive points are faint.

    With `nodes`, a slave with triangles has its active points drawn, too. Only an opaque part hides
    what is behind it.
    """
    if len(part.triangles):
        mesh = TriMesh(part.points, part.triangles)
        back = CONTACT_SIDE if part.is_body else None
        view.surface(mesh, part.colour, opacity, hides=opacity == 1.0, back=back)
    if part.is_body:
        return
    if not len(part.triangles) or nodes:
        view.dots(_subsample(part.points[part.active]), color=MUTED, ms=2.4)
    if not part.active.all():
        view.dots(_subsample(part.points[~part.active]), color=_FAINT, ms=1.6)


def _draw_profile(axes: Any, view: View, part: Drawn) -> None:
    """Draw a body of a plane problem as a line: its border edges in its plane of largest z."""
    from matplotlib.collections import LineCollection

    ends = part.points[free_edges(part.triangles)]
    depth = part.box[1, 2] - 1e-9 * float(np.ptp(part.box))
    front = ends[ends[:, :, 2].min(axis=1) >= depth]
    lines = view.placed(front.reshape(-1, 3)).reshape(-1, 2, 2)
    axes.add_collection(LineCollection(list(lines), colors=part.colour, linewidths=3.0))


def _draw_path(axes: Any, line: FloatArray, colour: str) -> None:
    """Draw a dashed line (n, 2), pixels, with a head at its last point inside the picture.

    A line that leads nowhere inside it, more than a pixel from its start, has no head.
    """
    axes.plot(*line.T, color=colour, lw=1.4, ls=(0, (4, 2)), zorder=5)
    border = np.array([axes.get_xlim()[1], axes.get_ylim()[0]])
    is_inside: NDArray[np.bool_] = np.asarray(((line >= 0.0) & (line <= border)).all(axis=1))
    is_away = np.linalg.norm(line[1:] - line[0], axis=1) > 1.0
    rows = np.flatnonzero(is_inside[1:] & is_away)
    if len(rows):
        head = {"arrowstyle": "-|>", "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
        tip = int(rows[-1]) + 1
        back = tip - 1
        while back and np.linalg.norm(line[tip] - line[back]) < 3.0:
            back -= 1
        axes.annotate("", line[tip], line[back], arrowprops=head, zorder=5)


def _draw_box_edges(view: View, stage: Stage) -> list[tuple[str, FloatArray]]:
    """Draw an edge of the box around all parts along each axis.

    Return the texts of their lengths, and the places (2,) of the texts, pixels. Axes without extent
    and edges that are seen end on are skipped.
    """
    box, labels = stage.box, []
    extent = np.ptp(box, axis=0)
    centre = view.placed([box.mean(axis=0)])[0]
    for axis in range(3):
        if (stage.plane and axis == 2) or extent[axis] <= 1e-9 * float(extent.max()):
            continue
        # The lowest edge, or the one farthest to the left: nothing else is in the picture there.
        downwards = np.array([-1.0, 0.2] if axis == 2 and not stage.plane else [0.0, 1.0])
        edge, edge_offset = None, -np.inf
        for rows in product((0, 1), repeat=2):
            ends = box.copy()
            for k, row in zip([k for k in range(3) if k != axis], rows, strict=True):
                ends[:, k] = box[row, k]
            offset = (view.placed([ends.mean(axis=0)])[0] - centre) @ downwards
            if offset > edge_offset:
                edge, edge_offset = ends, offset
        assert edge is not None
        a, b = view.placed(edge)
        if np.linalg.norm(a - b) < 12.0:  # seen end on
            continue
        view.lines(edge, color=MUTED, lw=0.8)
        outwards = unit(0.5 * (a + b) - centre) * [62.0, 26.0]
        labels.append((span_text(axis, box, stage.units), 0.5 * (a + b) + outwards))
    return labels


def _draw_labels(
    axes: Any, view: View, stage: Stage, lengths: list[tuple[str, FloatArray]]
) -> None:
    """Write names of parts, gaps, `lengths` and names of springs, spread so as not to overlap.

    A thin line leads from its place to a text that was moved by more than 24 pixels. At most 12
    springs are named, none shorter than 12 pixels.
    """
    texts = [(text, at, MUTED) for text, at in lengths]
    for part in stage.parts:
        # A name stands over the highest visible point of its part.
        points = _subsample(part.points[part.active] if part.active.any() else part.points)
        is_visible = view.sees(points)
        points = points[is_visible] if is_visible.any() else points
        top = points[view.placed(points)[:, 1].argmin()]
        texts.append((part.name, view.placed([top])[0] - [0.0, 12.0], INK))
    for gap in stage.gaps:
        at = view.placed([gap.ends.mean(axis=0)])[0]
        texts.append((gap_text(gap, stage.units), at + np.array([0.0, 16.0]), RED))
    springs = [tie for tie in stage.ties if tie.kind == "spring"]
    long = [tie for tie in springs if np.ptp(view.placed(tie.ends), axis=0).max() > _MIN_SPRING]
    for tie in long[:_MAX_SPRINGS]:
        texts.append((tie.name, view.placed([tie.ends.mean(axis=0)])[0], TIES[tie.kind]))
    places = np.array([at for _, at, _ in texts])
    lines = [text.split("\n") for text, _, _ in texts]
    sizes = np.array([[max(map(len, rows)), len(rows)] for rows in lines]) * _CHARACTER
    middles = spread(places, sizes, np.array(_pixels(axes), float))
    for (text, at, colour), middle in zip(texts, middles, strict=True):
        if np.linalg.norm(middle - at) > 24.0:
            axes.plot(*np.array([at, middle]).T, color=colour, lw=0.6, alpha=0.6, zorder=7)
        style = {"ha": "center", "va": "center", "fontsize": 9, "color": colour, "zorder": 8}
        pad = {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.75}
        axes.text(*middle, text, bbox=pad, linespacing=1.15, **style)


def _draw_closeup(axes: Any, stage: Stage, gap: Gap) -> None:
    """Draw the closest pair of a contact, seen nearly across the line between them.

    The frame reaches 0.9 of the gap, or 0.16 of the smaller part if that is more, from its middle.
    """
    master, slave = stage.part(gap.master), stage.part(gap.slave)
    extents = [float(np.linalg.norm(np.ptp(part.box, axis=0))) for part in (master, slave)]
    min_reach = 0.16 * min((size for size in extents if size > 0.0), default=1.0)
    reach = max(0.9 * abs(gap.value), min_reach)
    middle = gap.ends.mean(axis=0)
    octahedron = np.concatenate([np.eye(3), -np.eye(3)])
    view_direction = _FRONT if stage.plane else _SIDEWAYS
    line = unit(gap.ends[0] - gap.ends[1])
    across = view_direction - (view_direction @ line) * line
    if np.linalg.norm(across) < 0.1:
        across = np.cross(line, np.roll(line, 1) + 0.1)
    # Not exactly across the line, so that a sheet is not seen edge on.
    towards = unit(across) + 0.35 * unit(view_direction)
    view = View(axes, middle + reach * octahedron, towards=towards, shape=_pixels(axes))
    _draw_part(view, slave, 0.6, nodes=True)
    if stage.plane:
        _draw_profile(axes, view, master)
    else:
        _draw_part(view, master, 0.45)
    view.arrow(*gap.ends, color=RED, lw=1.6, arrowstyle="<->", mutation_scale=8)
    view.dots(gap.ends, color=RED, ms=4.5, zorder=6)
    name = gap.contact
    if len(name) > _MAX_NAME:
        name = name[: _MAX_NAME - 1] + "…"
    title = f"{name}: {gap_with_approach_text(gap, stage.units)}"
    axes.set_title(title, fontsize=11, color=RED, loc="left")
    view.show()


def _draw_legend(axes: Any, stage: Stage) -> None:
    """Draw colours and descriptions of the parts in three columns of five; say how many more."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(1.0, 0.0)
    entries = [*legend(stage), ("contact side of a body; arrows: to its free side", CONTACT_SIDE)]
    n_rows, n_columns = 5, 3
    max_entries = n_rows * n_columns
    if len(entries) > max_entries:
        n_omitted = len(entries) - max_entries + 1
        entries = [*entries[: max_entries - 1], (f"and {n_omitted} more", "white")]
    for k, (text, colour) in enumerate(entries):
        x, y = (k // n_rows) / n_columns, (k % n_rows + 0.5) / n_rows
        axes.plot([x + 0.006], [y], "s", color=colour, ms=8, clip_on=False)
        axes.text(x + 0.016, y, text[:62], fontsize=9.5, color=INK, va="center")
