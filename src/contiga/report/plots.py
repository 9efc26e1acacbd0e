"""The interactive figures: what happened over time, and the scene at the peak to turn about."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.report.folder import Run
from contiga.report.peak import Peak
from contiga.report.scene import SCALE, outside_direction, upwards

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
INK, MUTED, GRID = "#21262d", "#6a737d", "#e8eaed"
LINES = ("#1f5f8b", "#c4473a", "#3f7f4f", "#8a5a9e", "#b07d1e", "#4b5563")
BODY, SLAVE = "#8f9eb0", "#dedad0"
_CONFIG = {"displaylogo": False, "responsive": True}
PLOT_CONFIG = {
    **_CONFIG,
    "modeBarButtons": [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
}
VIEW_CONFIG = {
    **_CONFIG,
    "scrollZoom": True,
    "modeBarButtons": [["toImage", "orbitRotation", "pan3d", "resetCameraDefault3d"]],
}
"""Buttons are named one by one: the standard set has some that send data elsewhere."""
GLASS = 0.25
"""Opacity of the body at first."""
_PANELS = (
    ("force", "Force", "force"),
    ("max_penetration", "Deepest penetration", "length"),
    ("area", "Contact area", "area"),
    ("n_contact", "Nodes in contact", ""),
)


def with_unit(label: str, unit: str) -> str:
    """``label [unit]``, or the bare label where there is no unit."""
    return f"{label} [{unit}]" if unit else label


def history_figures(run: Run, peak_time: float | None) -> list[Any]:
    """Force, penetration, area and count over time, a figure each, one line a contact."""
    return [_panel(run, peak_time, *panel) for panel in _PANELS]


def _panel(run: Run, peak_time: float | None, column: str, label: str, kind: str) -> Any:
    import plotly.graph_objects as go

    figure = go.Figure()
    unit = getattr(run.units, kind) if kind else ""
    alone = len(run.contacts) == 1
    components = alone and column == "force" and _add_components(figure, run)
    for i, (name, columns) in enumerate(run.contacts.items()):
        if column in columns:
            name = "magnitude" if components else name
            figure.add_trace(
                go.Scatter(
                    x=run.times,
                    y=columns[column],
                    name=name,
                    mode="lines",
                    line={"color": LINES[i % len(LINES)], "width": 2.2},
                    hovertemplate=f"%{{y:.5g}} {unit}<extra>{name}</extra>",
                )
            )
    figure.update_yaxes(title_text=with_unit(label, unit), rangemode="tozero")
    figure.update_xaxes(title_text=with_unit("Time", run.units.time))
    if peak_time is not None:
        figure.add_vline(x=peak_time, line={"color": "#9aa3ad", "width": 1, "dash": "dot"})
    _plain(figure, 310)
    figure.update_layout(showlegend=bool(components) or not alone)
    return figure


def _add_components(figure: Any, run: Run) -> bool:
    """Thin lines of the force along x, y and z where there is any; whether one was drawn."""
    import plotly.graph_objects as go

    (columns,) = run.contacts.values()
    for axis, colour in zip("xyz", ("#d08a80", "#8fb996", "#9db7d4"), strict=True):
        values = columns.get(f"force_{axis}")
        if values is not None and np.nanmax(np.abs(values), initial=0.0) > 0.0:
            figure.add_trace(
                go.Scatter(
                    x=run.times,
                    y=values,
                    name=f"along {axis}",
                    mode="lines",
                    line={"color": colour, "width": 1.3},
                    hovertemplate=f"%{{y:.5g}} {run.units.force}<extra>along {axis}</extra>",
                )
            )
    return bool(figure.data)


def _plain(figure: Any, height: int) -> None:
    figure.update_layout(
        template="none",
        height=height,
        margin={"l": 62, "r": 14, "t": 52, "b": 50},
        font={"family": FONT, "size": 13, "color": INK},
        hovermode="x",
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0, "font": {"size": 12}},
        paper_bgcolor="white",
        plot_bgcolor="white",
    )
    axis = {"gridcolor": GRID, "zerolinecolor": "#c5cad0", "title_standoff": 8}
    figure.update_xaxes(**axis, showgrid=False, linecolor="#c5cad0", ticks="outside", ticklen=4)
    figure.update_yaxes(**axis, exponentformat="power")


def view_figure(peak: Peak, length: str) -> Any:
    """Body, slave and contact at the peak, coloured by penetration, to be turned about."""
    import plotly.graph_objects as go

    figure = go.Figure()
    figure.add_trace(_mesh(peak.body_points, peak.body_triangles, "body", BODY, GLASS))
    deepest = max(float(peak.penetration.max(initial=0.0)), 1e-300)
    # two stops so close that they lie in neighbouring entries of the 256 a browser keeps
    scale = [[0.0, SLAVE], [0.004, SLAVE], [0.008, SCALE[0]]]
    scale += [[k / (len(SCALE) - 1), c] for k, c in enumerate(SCALE)][1:]
    if len(peak.slave_triangles):
        trace = _mesh(peak.slave_points, peak.slave_triangles, "slave", SLAVE, 1.0)
        trace.update(
            intensity=peak.penetration.astype(np.float32),
            colorscale=scale,
            cmin=0.0,
            cmax=deepest,
            showscale=False,
        )
        figure.add_trace(trace)
    else:
        figure.add_trace(_dots(peak.slave_points[~peak.in_contact], "slave", 2.0, {"color": MUTED}))
    marker = {
        "color": peak.penetration[peak.in_contact].astype(np.float32),
        "colorscale": [[k / (len(SCALE) - 1), c] for k, c in enumerate(SCALE)],
        "cmin": 0.0,
        "cmax": deepest,
        "line": {"width": 0.5, "color": INK},
        "colorbar": {
            "title": {"text": with_unit("Penetration", length), "side": "right"},
            "thickness": 12,
            "len": 0.6,
            "outlinewidth": 0,
        },
    }
    figure.add_trace(_dots(peak.slave_points[peak.in_contact], "in contact", 3.2, marker))
    up, eye = upwards(peak), -1.85 * outside_direction(peak)
    figure.update_layout(
        height=620,
        margin={"l": 0, "r": 0, "t": 0, "b": 0},
        font={"family": FONT, "size": 12, "color": INK},
        showlegend=False,
        paper_bgcolor="white",
        scene={
            "aspectmode": "data",
            "camera": {"eye": _xyz(eye), "up": _xyz(up), "projection": {"type": "perspective"}},
            **{f"{a}axis": _axis(with_unit(a, length)) for a in "xyz"},
        },
    )
    return figure


def _xyz(vector: Any) -> dict[str, float]:
    return dict(zip("xyz", (float(c) for c in vector), strict=True))


def _axis(title: str) -> dict[str, Any]:
    return {
        "title": {"text": title, "font": {"size": 11}},
        "showbackground": False,
        "gridcolor": GRID,
        "zerolinecolor": GRID,
        "tickfont": {"size": 10, "color": MUTED},
    }


def _mesh(points: Any, triangles: Any, name: str, colour: str, opacity: float) -> Any:
    import plotly.graph_objects as go

    x, y, z = points.astype(np.float32).T
    i, j, k = triangles.astype(np.int32).T
    return go.Mesh3d(
        x=x,
        y=y,
        z=z,
        i=i,
        j=j,
        k=k,
        name=name,
        color=colour,
        opacity=opacity,
        hoverinfo="skip" if name == "body" else "x+y+z+text",
        lighting={"ambient": 0.55, "diffuse": 0.6, "specular": 0.15, "roughness": 0.6},
        lightposition={"x": 1e4, "y": -1e4, "z": 2e4},
        flatshading=False,
    )


def _dots(points: Any, name: str, size: float, marker: dict[str, Any]) -> Any:
    import plotly.graph_objects as go

    x, y, z = points.astype(np.float32).T
    return go.Scatter3d(
        x=x, y=y, z=z, name=name, mode="markers", marker={"size": size, "opacity": 1.0, **marker}
    )
