"""A quantity as a coloured map over a part: at the points that the cases hit, and between."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.build import build
from contiga.io.out.files import atomic_write
from contiga.io.units import with_unit
from contiga.records import FloatArray, IntArray
from contiga.rendering.shading import sharp_mesh
from contiga.report.lines import BUTTONS, FONT
from contiga.report.space import dots, mesh_trace, space_axis, xyz
from contiga.report.style import BODY, INK, PAPER
from contiga.report.view import View
from contiga.rigid.frames import to_world
from contiga.studies.cases import case_of
from contiga.studies.one_case import Base, parts_of_process
from contiga.studies.row import DONE, Row
from contiga.studies.shades import Shades
from contiga.studies.spec import StudySpec
from contiga.triangles.trimesh import TriMesh

_SIZE, _DPI = (11.0, 6.4), 110
_SIDEWAYS = np.array([-0.6, 0.8, 0.0])
_MAX_EDGE = 1.0 / 90.0
"""Longest edge of the coloured triangles, over the size of the part."""
_REACH_RATIO = 0.75
"""Reach of a target, over the longest distance from a target to its nearest one."""
_BETWEEN = {
    "linear": "colours between them are linear",
    "nearest": "colours about them are those of the nearest",
}
_TRIANGLE_TOL = 3e-4
"""Largest departure of the triangles from the part, relative to its size."""
_MAX_TRIANGLES = 400_000
"""Largest number of triangles."""
_CAMERA_DISTANCE = 0.75
"""Additional distance of the camera of a figure, over the longest side of the part.

All of the part is then visible in a figure that is no wider than high.
"""


class ColourMap(NamedTuple):
    """The data of a coloured map."""

    body: str
    label: str
    """Label of the quantity."""
    vertices: FloatArray
    """(n, 3) vertices of the part."""
    triangles: IntArray
    values: FloatArray
    """(n,) values between the targets; NaN outside of them."""
    targets: FloatArray
    """(k, 3) targets."""
    hit: FloatArray
    """(k,) values at the targets; NaN for failed cases."""
    cases: list[int]
    """Numbers of the cases."""
    shades: Shades
    between: str
    """Interpolation between the targets, in words."""

    @property
    def colours(self) -> FloatArray:
        """Red, green and blue (n, 3) of the vertices; those without a value are plain."""
        from matplotlib.colors import to_rgb

        rgb = self.shades.colours(self.values)
        return np.where(np.isnan(self.values)[:, None], to_rgb(BODY), rgb)

    @property
    def towards(self) -> FloatArray:
        """The viewing direction (3,) onto the side that has values, a little from its front."""
        p = self.vertices[self.triangles]
        facets = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        has_values = np.isfinite(self.values)[self.triangles].all(axis=1)
        normal = facets[has_values].sum(axis=0) if has_values.any() else np.array([0.0, 0.0, 1.0])
        normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
        horizontal = -normal * [1.0, 1.0, 0.0]
        size = float(np.linalg.norm(horizontal))
        front = horizontal / size if size > 0.05 else _SIDEWAYS
        return np.asarray(0.62 * front - 0.75 * normal + 0.25 * np.cross([0.0, 0.0, 1.0], front))


def map_of(study: StudySpec, base: Base, rows: tuple[Row, ...]) -> ColourMap | None:
    """Return the map of a study; None if the study has none, or no case gave a value.

    The body is that of the first complete case, at its start, in triangles of `_MAX_EDGE`. If
    several cases hit one point, the greatest of their values is drawn.
    """
    spec = study.map
    if spec is None:
        return None
    label = spec.colour or next(iter(base.quantities))
    best: dict[tuple[float, ...], Row] = {}
    for row in rows:
        target = tuple(float(row.values[name]) for name in spec.at)
        if target not in best or not best[target].collected[label] >= row.collected[label]:
            best[target] = row
    hit = np.array([row.collected[label] for row in best.values()])
    if not np.isfinite(hit).any():
        return None
    first = next(row for row in rows if row.status == DONE)
    simulation = build(
        base.case(case_of(study, first.number, first.values).settings), parts=parts_of_process()
    )
    body = simulation.bodies[spec.body].body
    coarse = body.tessellate(_TRIANGLE_TOL * body.size)
    vertices, triangles = refined(coarse.vertices, coarse.triangles, _MAX_EDGE * body.size)
    vertices = to_world(simulation.origins[simulation.mechanism.index[spec.body]], vertices)
    targets = np.array(list(best))
    low, high = spec.limits or (float(np.nanmin(hit)), float(np.nanmax(hit)))
    interpolate = nearest if spec.between == "nearest" else between
    return ColourMap(
        spec.body,
        with_unit(label, base.units.get(label, "")),
        vertices,
        triangles,
        interpolate(targets, hit, vertices),
        targets,
        hit,
        [row.number for row in best.values()],
        Shades((low, high), tuple(spec.bands or ())),
        _BETWEEN[spec.between],
    )


def nearest(targets: FloatArray, hit: FloatArray, points: FloatArray) -> FloatArray:
    """Return values (n,) at points: of the nearest target (k, 3), NaN out of reach (`_reach`).

    Targets with a NaN do not count; with fewer than two others all values are NaN.

    >>> row = np.array([[0.0, 0, 0], [2, 0, 0]])
    >>> nearest(row, np.array([1.0, 3.0]), np.array([[0.9, 0, 0], [1.1, 1, 0], [0, 1.6, 0]]))
    array([ 1.,  3., nan])
    """
    from scipy.spatial import cKDTree

    has_value = np.isfinite(hit)
    if has_value.sum() < 2:
        return np.full(len(points), np.nan)
    distances, rows = cKDTree(targets[has_value]).query(points)
    return np.where(distances <= _reach(targets[has_value]), hit[has_value][rows], np.nan)


def _reach(targets: FloatArray) -> float:
    """Return the distance from targets (k, 3) up to which their values count, length.

    It is three quarters of the longest distance from a target to its nearest one: the squares of a
    grid are whole, and reach beyond its border by three quarters of a spacing.
    """
    from scipy.spatial import cKDTree

    return _REACH_RATIO * float(cKDTree(targets).query(targets, k=2)[0][:, 1].max())


def between(targets: FloatArray, hit: FloatArray, points: FloatArray) -> FloatArray:
    """Return values (n,) at points, linear between targets (k, 3) along their common normal.

    The normal is that of the plane fitted to the targets with a value. The value is NaN outside
    their convex hull, and everywhere if they are on one line or fewer than three. It is NaN on the
    far side of the part, too: where a point is farther from the surface through the targets than
    the nearest point by more than their reach.

    >>> corners = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    >>> places = np.array([[1.0, 0, 1], [0, 1, 0], [0, 1, 5], [9, 9, 0]])
    >>> between(corners, np.array([0.0, 2.0, 4.0]), places)
    array([ 1.,  2., nan, nan])
    """
    from scipy.interpolate import LinearNDInterpolator

    has_value = np.isfinite(hit)
    values, targets = hit[has_value], targets[has_value]
    centre = targets.mean(axis=0)
    _, sizes, axes = np.linalg.svd(targets - centre, full_matrices=True)
    if len(targets) < 3 or sizes[1] <= 1e-9 * sizes[0]:
        return np.full(len(points), np.nan)
    local_targets, local_points = (targets - centre) @ axes.T, (points - centre) @ axes.T
    linear = LinearNDInterpolator(
        local_targets[:, :2], np.column_stack([values, local_targets[:, 2]])
    )
    interpolated, heights = linear(local_points[:, :2]).T
    distances = np.abs(local_points[:, 2] - heights)
    nearest_distance = np.fmin.reduce(distances, initial=np.inf)
    is_near = distances <= nearest_distance + _reach(targets)
    return np.asarray(np.where(is_near, interpolated, np.nan), dtype=np.float64)


def refined(points: FloatArray, triangles: IntArray, longest: float) -> tuple[FloatArray, IntArray]:
    """Return points and triangles whose edges are at most `longest`, as `_MAX_TRIANGLES` allows.

    Long edges are halved, in both of their triangles, so that the mesh gets no gaps; this is
    repeated until none is left, or there are `_MAX_TRIANGLES` / 4 or more. New points follow the
    given ones.
    """
    while len(triangles) < _MAX_TRIANGLES // 4:
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, row_of_edge = np.unique(edges, axis=0, return_inverse=True)
        is_long = np.linalg.norm(points[unique[:, 0]] - points[unique[:, 1]], axis=1) > longest
        if not is_long.any():
            break
        middle = np.full(len(unique), -1)
        middle[is_long] = len(points) + np.arange(is_long.sum())
        points = np.concatenate([points, points[unique[is_long]].mean(axis=1)])
        triangles = _split(triangles, middle[row_of_edge.reshape(-1, 3)])
    return points, triangles


def _split(triangles: IntArray, middle: IntArray) -> IntArray:
    """Return triangles (m, 3) split at the middles (m, 3) of their edges; −1 is no middle."""
    children = []
    cut = middle >= 0
    for k in range(4):
        rows = cut.sum(axis=1) == k
        t, m, c = triangles[rows], middle[rows], cut[rows]
        if k in (1, 2) and len(t):  # rotated, so that the edge that is cut, or not cut, comes first
            turn = np.argmax(c if k == 1 else ~c, axis=1)[:, None]
            order = (turn + np.arange(3)) % 3
            t, m = np.take_along_axis(t, order, 1), np.take_along_axis(m, order, 1)
        (a, b, c_), (p, q, r) = t.T, m.T
        children += {
            0: [(a, b, c_)],
            1: [(a, p, c_), (p, b, c_)],
            2: [(a, b, q), (a, q, r), (r, q, c_)],
            3: [(a, p, r), (p, b, q), (r, q, c_), (p, q, r)],
        }[k]
    return np.concatenate([np.stack(child, axis=1) for child in children])


def draw_map(colour_map: ColourMap, title: str, path: Path) -> None:
    """Write the map as PNG to `path`, with its colour bar and the targets as dots.

    The dots of failed cases are white; a title is cut after 90 characters.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    figure.text(0.02, 0.955, title[:90], fontsize=14, color=INK, va="center")
    figure.text(0.02, 0.02, f"Dots are targets; {colour_map.between}", fontsize=10, color=INK)
    place = (0.01, 0.02, 0.88, 0.9)
    shape = round(place[2] * _SIZE[0] * _DPI), round(place[3] * _SIZE[1] * _DPI)
    view = View(
        figure.add_axes(place), colour_map.vertices, towards=colour_map.towards, shape=shape
    )
    view.surface(TriMesh(colour_map.vertices, colour_map.triangles), colours=colour_map.colours)
    inner = colour_map.shades.colours(colour_map.hit)
    for at, value, colour in zip(colour_map.targets, colour_map.hit, inner, strict=True):
        inside = "white" if np.isnan(value) else tuple(colour)
        view.dots([at], color=inside, ms=6.5, mew=0.8, mec="white" if value == value else INK)
    view.show()
    bar = figure.add_axes((0.915, 0.2, 0.014, 0.5))
    if colour_map.shades.bands:
        places, texts = colour_map.shades.marks
        figure.colorbar(colour_map.shades.mappable(), cax=bar, ticks=places)
        bar.set_yticklabels(texts)
    else:
        low, high = colour_map.shades.limits
        is_beyond = bool(np.nanmin(colour_map.hit) < low), bool(np.nanmax(colour_map.hit) > high)
        extend = {
            (False, False): "neither",
            (True, False): "min",
            (False, True): "max",
            (True, True): "both",
        }[is_beyond]
        figure.colorbar(colour_map.shades.mappable(), cax=bar, extend=extend)
    bar.set_title(colour_map.label, fontsize=11, color=INK, loc="center", pad=12)
    bar.tick_params(labelsize=10, length=3)
    for spine in bar.spines.values():
        spine.set_visible(False)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png")


def map_figure(colour_map: ColourMap, rows: dict[int, int]) -> dict[str, Any]:
    """Return the map as a 3D view for plotly.js; `rows` maps the number of a case to its row.

    In addition to `data` and `layout` it has `back`: the factor of the camera distance on a narrow
    page.
    """
    mesh = mesh_trace(colour_map.vertices, colour_map.triangles, colour_map.body, BODY, 1.0)
    rows_of_mesh = sharp_mesh(colour_map.vertices, colour_map.triangles).rows
    tints = np.round(255.0 * colour_map.colours[rows_of_mesh]).astype(int)
    mesh |= {
        "vertexcolor": [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in tints.tolist()],
        "hoverinfo": "skip",
    }
    marker = colour_map.shades.marker(colour_map.hit, colour_map.label)
    points = dots(colour_map.targets, "targets", 5.0, marker)
    points |= {
        "customdata": [rows[number] for number in colour_map.cases],
        "text": [f"case {number}" for number in colour_map.cases],
        "hovertemplate": f"%{{text}}<br>{colour_map.label} %{{hovertext}}<extra></extra>",
        "hovertext": [f"{value:.5g}" for value in colour_map.hit],
    }
    eye = xyz(-1.9 * colour_map.towards / np.linalg.norm(colour_map.towards))
    layout = {
        "height": 620,
        "margin": {"l": 0, "r": 0, "t": BUTTONS, "b": 0},
        "font": {"family": FONT, "size": 12, "color": INK},
        "paper_bgcolor": PAPER,
        "showlegend": False,
        "scene": {
            **{f"{axis}axis": space_axis(axis) for axis in "xyz"},
            "aspectmode": "data",
            "camera": {"eye": eye},
        },
    }
    # Plotly draws boxes at a volume of one.
    sides = np.maximum(
        np.ptp(colour_map.vertices, axis=0), 1e-3 * np.ptp(colour_map.vertices, axis=0).max()
    )
    back = max(1.1, _CAMERA_DISTANCE * float(sides.max() / np.cbrt(sides.prod())))
    return {"data": [mesh, points], "layout": layout, "back": back}
