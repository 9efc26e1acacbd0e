"""The 3D view, at the peak first and at other recorded steps on request."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.io.units import with_unit
from contiga.records import FloatArray
from contiga.rendering.shading import sharp_mesh
from contiga.report.coloured import ColouredField, fields_of, region_colours
from contiga.report.figure import Figure, Trace
from contiga.report.frames import Frames, closed, packed, parted
from contiga.report.lines import CONFIG, FONT
from contiga.report.peak import Peak
from contiga.report.places import Ties
from contiga.report.run_folder import Units
from contiga.report.scene import outside_direction, upwards
from contiga.report.style import (
    BODY,
    GRID,
    INK,
    MUTED,
    PAPER,
    REGIONS,
    SCALE,
    SLAVE,
    TIES,
)

VIEW_CONFIG = {
    **CONFIG,
    "scrollZoom": True,
    "modeBarButtons": [["toImage", "orbitRotation", "pan3d", "resetCameraDefault3d"]],
}
"""Buttons are named one by one: the standard set has some that send data elsewhere."""
GLASS = 0.25
"""Initial opacity of the body."""

Look = tuple[dict[str, Any], dict[str, Any]]
"""Attributes of the slave's mesh and of the markers in contact."""


class View(NamedTuple):
    """The scene at the peak, and the data with which its page shows other steps."""

    figure: Figure
    """Its traces are the body, the slave, its points in contact, and a line for each region."""
    data: dict[str, Any]
    """Data for the script of the page: steps, and the styles of the fields."""
    steps: int
    """Number of steps that can be shown."""
    recorded: int
    """Number of recorded steps."""
    note: str
    """Label of the colours that are shown first."""
    outlined: bool
    """Whether the peak has lines around its regions."""
    touches: bool
    """Whether a point is in contact at the peak."""


def view_of(peak: Peak, frames: Frames, units: Units, ties: Ties = ()) -> View:
    """Return the 3D view of the peak: body, slave, contact, outlines, springs and joints.

    Its data has the other steps of `frames`, and the styles of all fields and, with several regions
    of contact, of the clusters; fields of the inside are left out for a slave without facets. The
    first colours are the pressure if it is positive anywhere; else the penetration; without a point
    in contact the von Mises stress, if the slave has facets and this field.
    """
    figure = Figure()
    figure.data.append(mesh_trace(peak.body_points, peak.body_triangles, "body", BODY, GLASS))
    fields = {
        name: field._replace(top=frames.tops[name])
        for name, field in fields_of(peak, units).items()
        # fields of the inside need facets: a cloud shows none
        if len(peak.slave_triangles) or not field.everywhere
    }
    touches = bool(peak.in_contact.any())
    first = "penetration" if touches or "von_mises" not in fields else "von_mises"
    first = "pressure" if "pressure" in fields else first
    looks = {name: _look(peak, field) for name, field in fields.items()}
    if frames.n_clusters > 1:
        looks["cluster"] = _cluster_look(peak, frames.n_clusters)
    slave, contact = looks[first]
    figure.data.append(_slave_trace(peak, slave))
    marker = {**contact, "line": {"width": 0.5, "color": INK}}
    figure.data.append(dots(peak.slave_points[peak.in_contact], "in contact", 3.2, marker))
    several = len({line.contact for line in frames.regions}) > 1
    for key, colour in region_colours(frames.regions).items():
        lines = [closed(o.points) for o in peak.outlines if (o.contact, o.cluster) == key]
        name = f"cluster {key[0]}.{key[1]}" if several else f"cluster {key[1]}"
        points = np.concatenate([*lines, np.zeros((0, 3))])
        figure.data.append(line_in_space(name, points, {"color": colour, "width": 5}))
    if ties:
        # Three points a line: its ends, and the break behind them.
        text = [tie.name for tie in ties for _ in range(3)]
        style = {"color": [TIES[tie.kind] for tie in ties for _ in range(3)], "width": 5}
        name, points = "springs and joints", parted(peak.ties)
        figure.data.append(line_in_space(name, points, style, text=text, hoverinfo="text"))
    up = upwards(peak)
    camera = {
        "eye": xyz(-2.1 * outside_direction(peak)),
        "center": xyz(-0.12 * up),  # room for the labels under the scene
        "up": xyz(up),
        "projection": {"type": "perspective"},
    }
    figure.layout = space_layout(units.length, frames.spans, camera, height=620)
    data = packed(frames, peak, units)
    data |= {
        "ties": bool(ties),
        "field": first,
        # attributes except the values, in the names of `Plotly.restyle`
        "looks": {
            name: {
                "mesh": {key: value for key, value in mesh.items() if key != "intensity"},
                "marker": {f"marker.{k}": value for k, value in dot.items() if k != "color"},
            }
            for name, (mesh, dot) in looks.items()
        },
        "names": {name: fields[name].label if name in fields else "Cluster" for name in looks},
    }
    if peak.focus is not None and frames.touching_spans != frames.spans:
        data["spans"] = {"all": frames.spans, "near": frames.touching_spans}
    return View(
        figure=figure,
        data=data,
        steps=len(frames.frames),
        recorded=frames.recorded,
        note=with_unit(fields[first].label, fields[first].unit),
        outlined=bool(peak.outlines),
        touches=touches,
    )


def _slave_trace(peak: Peak, look: dict[str, Any]) -> Trace:
    """Return the slave's facets in the style of `look`; of a cloud, its free active points."""
    if not len(peak.slave_triangles):
        free = ~peak.in_contact if peak.active is None else peak.active & ~peak.in_contact
        return dots(peak.slave_points[free], "slave", 2.0, {"color": MUTED})
    trace = mesh_trace(peak.slave_points, peak.slave_triangles, "slave", SLAVE, 1.0)
    if look["intensitymode"] == "vertex":
        rows = sharp_mesh(peak.slave_points, peak.slave_triangles).rows
        look = look | {"intensity": look["intensity"][rows]}
    return trace | {"showscale": False} | look


def _look(peak: Peak, field: ColouredField) -> Look:
    """Return the style of the slave's mesh and of the markers in contact, coloured by one field."""
    # two stops so close that they fall into neighbouring entries of a browser's 256 colours
    scale = [[0.0, SLAVE], [0.004, SLAVE], [0.008, SCALE[0]]]
    plain = [[k / (len(SCALE) - 1), c] for k, c in enumerate(SCALE)]
    mesh = {
        "intensity": field.values.astype(np.float32),
        "intensitymode": "vertex",
        "colorscale": scale + plain[1:],
        "cmin": 0.0,
        "cmax": field.top,
    }
    marker = {
        "color": field.values[peak.in_contact].astype(np.float32),
        "colorscale": plain,
        "cmin": 0.0,
        "cmax": field.top,
        "colorbar": _bar(with_unit(field.label, field.unit)),
    }
    return mesh, marker


def _cluster_look(peak: Peak, count: int) -> Look:
    """Return the styles of mesh and markers by region; facets have the least number of a corner."""
    assert peak.cluster is not None
    colours = [REGIONS[k % len(REGIONS)] for k in range(count)]
    stops: list[tuple[float, str]] = [
        ((k + side) / count, colour) for k, colour in enumerate(colours) for side in (0.0, 1.0)
    ]
    facets = peak.cluster[peak.slave_triangles].reshape(-1, 3).min(axis=1)
    mesh_stops = [(0.0, SLAVE), (1.0 / (count + 1), SLAVE)]  # facets without contact: −1
    mesh_stops += [((1.0 + at * count) / (count + 1), colour) for at, colour in stops]
    mesh = {
        "intensity": facets.astype(np.float32),
        "intensitymode": "cell",
        "colorscale": mesh_stops,
        "cmin": -1.5,
        "cmax": count - 0.5,
    }
    marker = {
        "color": peak.cluster[peak.in_contact].astype(np.float32),
        "colorscale": stops,
        "cmin": -0.5,
        "cmax": count - 0.5,
        "colorbar": _bar("Cluster") | {"dtick": max(1, count // 10), "tick0": 0},
    }
    return mesh, marker


def _bar(title: str) -> dict[str, Any]:
    return {
        "title": {"text": title, "side": "right"},
        "thickness": 12,
        "len": 0.6,
        "outlinewidth": 0,
        "exponentformat": "power",
        "minexponent": 4,
    }


def line_in_space(name: str, points: FloatArray, look: dict[str, Any], **more: Any) -> Trace:
    """Return a line through points (n, 3), broken at NaN; `more` overrides its attributes."""
    trace = {"type": "scatter3d", "name": name, "mode": "lines", "line": look, "hoverinfo": "name"}
    return trace | columns(points) | more


def columns(points: FloatArray, names: str = "xyz") -> Trace:
    """Return the columns of (n, 3) points or vectors by name, in single precision."""
    return dict(zip(names, points.astype(np.float32).T, strict=True))


def xyz(vector: Any) -> dict[str, float]:
    return dict(zip("xyz", (float(c) for c in vector), strict=True))


def space_layout(
    unit: str, spans: list[list[float]], camera: dict[str, Any], *, height: int
) -> dict[str, Any]:
    """Return axes of one scale that contain the ranges of x, y and z, and the style."""
    return {
        "height": height,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "font": {"family": FONT, "size": 12, "color": INK},
        "hoverlabel": {"align": "left"},
        "showlegend": False,
        "paper_bgcolor": PAPER,
        "scene": {
            "aspectmode": "data",
            "camera": camera,
            **{
                f"{name}axis": space_axis(with_unit(name, unit)) | {"range": span, "gridwidth": 2}
                for name, span in zip("xyz", spans, strict=True)
            },
        },
    }


def space_axis(title: str) -> dict[str, Any]:
    return {
        "title": {"text": title, "font": {"size": 11}},
        "showbackground": False,
        "gridcolor": GRID,
        "zerolinecolor": GRID,
        "tickfont": {"size": 10, "color": MUTED},
    }


def mesh_trace(points: Any, triangles: Any, name: str, colour: str, opacity: float) -> Trace:
    """Return a mesh with sharp creases: its points are those of `sharp_mesh`.

    Points show their coordinates under the pointer, except on a mesh named "body".
    """
    sharp = sharp_mesh(points, triangles)
    return {
        "type": "mesh3d",
        **columns(points[sharp.rows]),
        **dict(zip("ijk", sharp.triangles.T, strict=True)),
        "name": name,
        "color": colour,
        "opacity": opacity,
        "hoverinfo": "skip" if name == "body" else "x+y+z+text",
        "lighting": {"ambient": 0.55, "diffuse": 0.6, "specular": 0.15, "roughness": 0.6},
        "lightposition": {"x": 1e4, "y": -1e4, "z": 2e4},
        "flatshading": False,
    }


def dots(points: Any, name: str, size: float, marker: dict[str, Any]) -> Trace:
    """Return markers at points (n, 3) of `size` pixels; `marker` overrides their style."""
    marker = {"size": size, "opacity": 1.0, **marker}
    trace = {"type": "scatter3d", "name": name, "mode": "markers", "marker": marker}
    return trace | columns(points)
