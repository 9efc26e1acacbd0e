"""The still picture of a preview: the whole scene, and close-ups of the smallest gaps."""

from __future__ import annotations

from itertools import product
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from contiga.previewing.stage import CONTACT_SIDE, Drawn, Gap, Stage
from contiga.previewing.words import gap_text, legend, span_text, way_in_text
from contiga.records import FloatArray
from contiga.rendering.camera import unit
from contiga.rendering.shading import free_edges
from contiga.report.labels import spread
from contiga.report.style import INK, LINES, MUTED, TIES
from contiga.report.view import View
from contiga.triangles.trimesh import TriMesh

RED = LINES[1]
_SIZE, _DPI = (14.4, 8.8), 100
_WHOLE, _NEAR = (0.01, 0.17, 0.6, 0.73), (0.63, 0.17, 0.36, 0.73)
_NAME = 32
"""Largest number of characters of a contact's name over its picture."""
_NEAREST = 3
"""Largest number of close-ups of gaps."""
_SPRINGS = 12
"""Largest number of springs that are named in the picture."""
_LONG = 12.0
"""Smallest length of a named spring, pixels: names of shorter ones would hide what they join."""
_DOTS = 4000
"""Largest number of points of a part that are drawn or used for the frame."""
_FAINT = "#c9ced4"
_CHARACTER = np.array([6.6, 14.5])
"""Width and height of a character of the labels, pixels."""
_SIDEWAYS = np.array([-0.55, 0.75, -0.45])
_FRONT = np.array([0.0, 0.0, -1.0])


def draw_still(stage: Stage, file: BinaryIO | str) -> None:
    """Write the picture of `stage` as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    figure.text(0.015, 0.955, stage.title[:90], fontsize=15, color=INK, va="center")
    _whole(figure.add_axes(_WHOLE if stage.gaps else (0.01, 0.17, 0.98, 0.73)), stage)
    near = sorted(stage.gaps, key=lambda gap: gap.value)[:_NEAREST]
    left, low, wide, high = _NEAR
    for k, gap in enumerate(near):
        each = high / len(near)
        rows = (left, low + high - (k + 1) * each, wide, each - (0.035 if k else 0.0))
        _near(figure.add_axes(rows), stage, gap)
    _legend(figure.add_axes((0.015, 0.01, 0.97, 0.14)), stage)
    figure.savefig(file, format="png")


def _pixels(axes: Any) -> tuple[int, int]:
    box = axes.get_position()
    return round(box.width * _SIZE[0] * _DPI), round(box.height * _SIZE[1] * _DPI)


def _few(points: FloatArray) -> FloatArray:
    return points[:: len(points) // _DOTS + 1]


def _whole(axes: Any, stage: Stage) -> None:
    """Draw all parts, with normals, paths, velocities and gaps."""
    corners = np.array(list(product(*stage.box.T)))
    framed = [_few(part.points[part.active]) for part in stage.parts]
    framed += [corners, stage.velocity_ends.reshape(-1, 3)]
    towards, size = _FRONT if stage.plane else _SIDEWAYS, _pixels(axes)
    # Space for the lengths along the edges, outside the box.
    middle = stage.box.mean(axis=0)
    view = View(
        axes, middle + 1.12 * (np.concatenate(framed) - middle), towards=towards, shape=size
    )
    for part in sorted(stage.parts, key=lambda part: part.is_body):
        if stage.plane and part.is_body:
            _profile(axes, view, part)
        else:
            _draw(view, part)
    _arrows(view, stage, towards)
    for k, way in enumerate(stage.ways):
        for line in way.lines:
            _way(axes, view.placed(line), LINES[k % len(LINES)])
    for ends in stage.velocity_ends:
        view.arrow(*ends, color=INK, lw=2.0)
    for tie in stage.ties:
        view.lines(tie.ends, color=TIES[tie.kind], lw=2.2)
    for gap in stage.gaps:
        axes.plot(*view.placed(gap.ends).T, "o-", color=RED, ms=4.0, mew=0.0, lw=1.6, zorder=6)
    edges = _edges(view, stage)
    _labels(axes, view, stage, edges)
    view.show()


def _draw(view: View, part: Drawn, opacity: float = 1.0, *, nodes: bool = False) -> None:
    """Draw a part: shaded triangles, or points of a cloud; inactive points are faint."""
    if len(part.triangles):
        mesh = TriMesh(part.points, part.triangles)
        back = CONTACT_SIDE if part.is_body else None
        view.surface(mesh, part.colour, opacity, hides=opacity == 1.0, back=back)
    if part.is_body:
        return
    if not len(part.triangles) or nodes:
        view.dots(_few(part.points[part.active]), color=MUTED, ms=2.4)
    if not part.active.all():
        view.dots(_few(part.points[~part.active]), color=_FAINT, ms=1.6)


def _profile(axes: Any, view: View, part: Drawn) -> None:
    """Draw the line of a body of a plane problem, seen from the front."""
    from matplotlib.collections import LineCollection

    ends = part.points[free_edges(part.triangles)]
    depth = part.box[1, 2] - 1e-9 * float(np.ptp(part.box))
    front = ends[ends[:, :, 2].min(axis=1) >= depth]
    lines = view.placed(front.reshape(-1, 3)).reshape(-1, 2, 2)
    axes.add_collection(LineCollection(list(lines), colors=part.colour, linewidths=3.0))


def _arrows(view: View, stage: Stage, towards: FloatArray) -> None:
    """Draw visible normals that do not point away from the eye."""
    for arrow in stage.normals:
        part = stage.part(arrow.name)
        length = 0.13 * float(np.linalg.norm(np.ptp(part.box, axis=0)))
        tip = arrow.at + length * arrow.vector
        if arrow.vector @ unit(towards) < 0.2 and view.sees([arrow.at]).all():
            view.arrow(arrow.at, tip, color=LINES[0], lw=0.9, mutation_scale=8)


def _way(axes: Any, line: FloatArray, colour: str) -> None:
    """Draw a dashed line over everything, with a head at its end or at the picture's border."""
    axes.plot(*line.T, color=colour, lw=1.4, ls=(0, (4, 2)), zorder=5)
    room = np.array([axes.get_xlim()[1], axes.get_ylim()[0]])
    inside: NDArray[np.bool_] = np.asarray(((line >= 0.0) & (line <= room)).all(axis=1))
    long = np.linalg.norm(line[1:] - line[0], axis=1) > 1.0
    last = np.flatnonzero(inside[1:] & long)
    if len(last):
        head = {"arrowstyle": "-|>", "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
        tip = int(last[-1]) + 1
        back = tip - 1
        while back and np.linalg.norm(line[tip] - line[back]) < 3.0:
            back -= 1
        axes.annotate("", line[tip], line[back], arrowprops=head, zorder=5)


def _edges(view: View, stage: Stage) -> list[tuple[str, FloatArray]]:
    """Draw three edges of the box around all parts; return the texts of their lengths."""
    box, edges = stage.box, []
    centre = view.placed([box.mean(axis=0)])[0]
    for axis in range(3):
        if (stage.plane and axis == 2) or np.ptp(box[:, axis]) <= 1e-9 * float(
            np.ptp(box, axis=0).max()
        ):
            continue
        others = [k for k in range(3) if k != axis]
        best, most = None, -np.inf
        for low_or_high in product((0, 1), repeat=2):
            ends = box.copy()
            for k, which in zip(others, low_or_high, strict=True):
                ends[:, k] = box[which, k]
            off = view.placed([ends.mean(axis=0)])[0] - centre
            # Below and to the left there is nothing else in the picture.
            side = off @ ([-1.0, 0.2] if axis == 2 and not stage.plane else [0.0, 1.0])
            if side > most:
                best, most = ends, side
        assert best is not None
        a, b = view.placed(best)
        if np.linalg.norm(a - b) < 12.0:  # seen end on
            continue
        view.lines(best, color=MUTED, lw=0.8)
        out = unit(0.5 * (a + b) - centre) * [62.0, 26.0]
        edges.append((span_text(axis, box, stage.units), 0.5 * (a + b) + out))
    return edges


def _labels(axes: Any, view: View, stage: Stage, edges: list[tuple[str, FloatArray]]) -> None:
    """Write names, gaps and lengths apart from each other; a thin line leads to moved ones."""
    texts = [(text, at, MUTED) for text, at in edges]
    for part in stage.parts:
        texts.append((part.name, view.placed([_top(view, part)])[0] - [0.0, 12.0], INK))
    for gap in stage.gaps:
        at = view.placed([gap.ends.mean(axis=0)])[0]
        texts.append((gap_text(gap, stage.units), at + np.array([0.0, 16.0]), RED))
    springs = [tie for tie in stage.ties if tie.kind == "spring"]
    long = [tie for tie in springs if np.ptp(view.placed(tie.ends), axis=0).max() > _LONG]
    for tie in long[:_SPRINGS]:
        texts.append((tie.name, view.placed([tie.ends.mean(axis=0)])[0], TIES[tie.kind]))
    wanted = np.array([at for _, at, _ in texts])
    lines = [text.split("\n") for text, _, _ in texts]
    sizes = np.array([[max(map(len, rows)), len(rows)] for rows in lines]) * _CHARACTER
    for (text, at, colour), middle in zip(
        texts, spread(wanted, sizes, np.array(_pixels(axes), float)), strict=True
    ):
        if np.linalg.norm(middle - at) > 24.0:
            axes.plot(*np.array([at, middle]).T, color=colour, lw=0.6, alpha=0.6, zorder=7)
        look = {"ha": "center", "va": "center", "fontsize": 9, "color": colour, "zorder": 8}
        pad = {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.75}
        axes.text(*middle, text, bbox=pad, linespacing=1.15, **look)


def _top(view: View, part: Drawn) -> FloatArray:
    """Return the visible point of a part that is highest in the picture."""
    points = _few(part.points[part.active] if part.active.any() else part.points)
    seen = view.sees(points)
    points = points[seen] if seen.any() else points
    return np.asarray(points[view.placed(points)[:, 1].argmin()])


def _near(axes: Any, stage: Stage, gap: Gap) -> None:
    """Draw the closest pair of a contact, seen from the side of the line between them."""
    master, slave = stage.part(gap.master), stage.part(gap.slave)
    extents = [float(np.linalg.norm(np.ptp(part.box, axis=0))) for part in (master, slave)]
    least = 0.16 * min((size for size in extents if size > 0.0), default=1.0)
    reach = max(0.9 * abs(gap.value), least)
    middle = gap.ends.mean(axis=0)
    octahedron = np.concatenate([np.eye(3), -np.eye(3)])
    towards = _square_to(gap.ends[0] - gap.ends[1], _FRONT if stage.plane else _SIDEWAYS)
    view = View(axes, middle + reach * octahedron, towards=towards, shape=_pixels(axes))
    _draw(view, slave, 0.6, nodes=True)
    if stage.plane:
        _profile(axes, view, master)
    else:
        _draw(view, master, 0.45)
    view.arrow(*gap.ends, color=RED, lw=1.6, arrowstyle="<->", mutation_scale=8)
    view.dots(gap.ends, color=RED, ms=4.5, zorder=6)
    axes.set_title(
        f"{_short(gap.contact)}: {way_in_text(gap, stage.units)}",
        fontsize=11,
        color=RED,
        loc="left",
    )
    view.show()


def _short(name: str) -> str:
    return name if len(name) <= _NAME else name[: _NAME - 1] + "…"


def _square_to(line: FloatArray, towards: FloatArray) -> FloatArray:
    """Return a direction near `towards` that sees `line` from its side."""
    along = unit(line)
    square = towards - (towards @ along) * along
    if np.linalg.norm(square) < 0.1:
        square = np.cross(along, np.roll(along, 1) + 0.1)
    # Not exactly, so that a sheet is not seen edge on.
    return unit(square) + 0.35 * unit(towards)


def _legend(axes: Any, stage: Stage) -> None:
    """Draw the parts' colours and descriptions in columns."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(1.0, 0.0)
    rows = [*legend(stage), ("contact side of a body; arrows: to its free side", CONTACT_SIDE)]
    deep, columns = 5, 3
    if len(rows) > deep * columns:
        left = len(rows) - deep * columns + 1
        rows = [*rows[: deep * columns - 1], (f"and {left} more", "white")]
    for k, (text, colour) in enumerate(rows):
        x, y = (k // deep) / columns, (k % deep + 0.5) / deep
        axes.plot([x + 0.006], [y], "s", color=colour, ms=8, clip_on=False)
        axes.text(x + 0.016, y, text[:62], fontsize=9.5, color=INK, va="center")
