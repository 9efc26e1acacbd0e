"""The interactive figures: what happened over time, and the scene at the peak to turn about."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.report.peak import Peak
from contiga.report.run_folder import Run, Units
from contiga.report.scene import outside_direction, upwards
from contiga.report.shown import Shown, fields_of, region_colours
from contiga.report.style import BODY, GRID, INK, LINES, MUTED, REGIONS, SCALE, SLAVE

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
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


_ENERGIES = (
    ("energy_stored", "stored"),
    ("energy_hysteresis", "hysteresis"),
    ("energy_damping", "damping"),
    ("energy_friction", "friction"),
)


def history_figures(run: Run, peak_time: float | None) -> list[Any]:
    """Force, penetration, area and count over time, a figure each, one line a contact; and where
    the work done on all contacts went."""
    energies = [figure] if (figure := _energies(run, peak_time)) is not None else []
    return [_panel(run, peak_time, *panel) for panel in _PANELS] + energies


def _energies(run: Run, peak_time: float | None) -> Any | None:
    """What is stored and lost, stacked, under the line of the work; None without work.

    What is between the stack and the line is the error.
    """
    import plotly.graph_objects as go

    def whole(column: str) -> Any:
        none = np.zeros(len(run.times))
        return sum((columns.get(column, none) for columns in run.contacts.values()), none)

    work = whole("work")
    if not np.nanmax(np.abs(work), initial=0.0) > 0.0:
        return None
    figure, unit = go.Figure(), run.units.moment
    for i, (column, name) in enumerate(_ENERGIES):
        values = whole(column)
        if np.nanmax(np.abs(values), initial=0.0) > 0.0:
            figure.add_trace(
                go.Scatter(
                    x=run.times,
                    y=values,
                    name=name,
                    stackgroup="energy",
                    mode="lines",
                    line={"color": LINES[i % len(LINES)], "width": 0.8},
                    hovertemplate=f"%{{y:.5g}} {unit}<extra>{name}</extra>",
                )
            )
    figure.add_trace(
        go.Scatter(
            x=run.times,
            y=work,
            name="work",
            mode="lines",
            line={"color": INK, "width": 1.6, "dash": "dash"},
            hovertemplate=f"%{{y:.5g}} {unit}<extra>work</extra>",
        )
    )
    _axes(figure, run, with_unit("Energy of contact", unit), peak_time)
    return figure


def _axes(figure: Any, run: Run, label: str, peak_time: float | None) -> None:
    """Axes of a figure over time, and the peak on it."""
    figure.update_yaxes(title_text=label, rangemode="tozero")
    figure.update_xaxes(title_text=with_unit("Time", run.units.time))
    if peak_time is not None:
        figure.add_vline(x=peak_time, line={"color": "#9aa3ad", "width": 1, "dash": "dot"})
    _plain(figure, 310)


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
                    connectgaps=True,  # areas are measured at the written steps
                    line={"color": LINES[i % len(LINES)], "width": 2.2},
                    hovertemplate=f"%{{y:.5g}} {unit}<extra>{name}</extra>",
                )
            )
    _axes(figure, run, with_unit(label, unit), peak_time)
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


def view_figure(peak: Peak, units: Units) -> Any:
    """Body, slave, contact and its outlines at the peak, to be turned about.

    Traces are the body, the slave, its points in contact, and a line a region. What the colours
    may show beside the field shown first is kept in the figure's ``meta``, for `restyle`.
    """
    import plotly.graph_objects as go

    figure = go.Figure()
    figure.add_trace(_mesh(peak.body_points, peak.body_triangles, "body", BODY, GLASS))
    fields = fields_of(peak, units)
    first = "pressure" if "pressure" in fields else "penetration"
    looks = {name: _look(peak, shown) for name, shown in fields.items()}
    if peak.cluster is not None and peak.cluster.max(initial=-1) > 0:
        looks["cluster"] = _cluster_look(peak)
    slave, contact = looks[first]
    figure.add_trace(_slave_trace(peak, slave))
    marker = {**contact, "line": {"width": 0.5, "color": INK}}
    figure.add_trace(_dots(peak.slave_points[peak.in_contact], "in contact", 3.2, marker))
    for key, colour in region_colours(peak.outlines).items():
        figure.add_trace(_outline(peak, key, colour))
    _in_space(figure, peak, units)
    if len(looks) > 1:
        facets = len(peak.slave_triangles) > 0
        figure.update_layout(meta={"first": first, "looks": _restyles(looks, facets)})
    return figure


def _in_space(figure: Any, peak: Peak, units: Units) -> None:
    """Axes in one scale, seen from outside of the body."""
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
            **{f"{a}axis": _axis(with_unit(a, units.length)) for a in "xyz"},
        },
    )


def _slave_trace(peak: Peak, look: dict[str, Any]) -> Any:
    """The slave's facets as `look` colours them, or the points of a cloud that touch nothing."""
    if not len(peak.slave_triangles):
        return _dots(peak.slave_points[~peak.in_contact], "slave", 2.0, {"color": MUTED})
    trace = _mesh(peak.slave_points, peak.slave_triangles, "slave", SLAVE, 1.0)
    trace.update(showscale=False, **look)
    return trace


def _look(peak: Peak, shown: Shown) -> tuple[dict[str, Any], dict[str, Any]]:
    """Of the slave's mesh and of the markers in contact, coloured by one field."""
    # two stops so close that they lie in neighbouring entries of the 256 a browser keeps
    scale = [[0.0, SLAVE], [0.004, SLAVE], [0.008, SCALE[0]]]
    plain = [[k / (len(SCALE) - 1), c] for k, c in enumerate(SCALE)]
    mesh = {
        "intensity": shown.values.astype(np.float32),
        "intensitymode": "vertex",
        "colorscale": scale + plain[1:],
        "cmin": 0.0,
        "cmax": shown.top,
    }
    marker = {
        "color": shown.values[peak.in_contact].astype(np.float32),
        "colorscale": plain,
        "cmin": 0.0,
        "cmax": shown.top,
        "colorbar": _bar(with_unit(shown.label, shown.unit)),
    }
    return mesh, marker


def _cluster_look(peak: Peak) -> tuple[dict[str, Any], dict[str, Any]]:
    """As `_look`, by the number of the region: one colour each, a facet at a time."""
    assert peak.cluster is not None
    count = int(peak.cluster.max()) + 1
    colours = [REGIONS[k % len(REGIONS)] for k in range(count)]
    stops: list[tuple[float, str]] = [
        ((k + side) / count, colour) for k, colour in enumerate(colours) for side in (0.0, 1.0)
    ]
    corners = peak.cluster[peak.slave_triangles].reshape(-1, 3).min(axis=1)
    wide = [(0.0, SLAVE), (1.0 / (count + 1), SLAVE)]
    wide += [((1.0 + at * count) / (count + 1), colour) for at, colour in stops]
    mesh = {
        "intensity": corners.astype(np.float32),
        "intensitymode": "cell",
        "colorscale": wide,
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
    }


def _restyles(
    looks: dict[str, tuple[dict[str, Any], dict[str, Any]]], facets: bool
) -> dict[str, Any]:
    """What a browser's `restyle` is handed for each field: [of the slave, of the markers]."""

    def packed(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
        # one entry a trace; numbers to five digits, for the size of the page
        return {
            prefix + name: [
                [float(f"{v:.5g}") for v in value] if isinstance(value, np.ndarray) else value
            ]
            for name, value in values.items()
        }

    return {
        name: [packed(slave) if facets else {}, packed(marker, "marker.")]
        for name, (slave, marker) in looks.items()
    }


def _outline(peak: Peak, key: tuple[int, int], colour: str) -> Any:
    """All lines around one region; its name has the region's number."""
    import plotly.graph_objects as go

    gap = np.full((1, 3), np.nan)
    lines = [o.points for o in peak.outlines if (o.contact, o.cluster) == key]
    x, y, z = np.concatenate([np.concatenate([p, p[:1], gap]) for p in lines]).T
    several = len({o.contact for o in peak.outlines}) > 1
    name = f"cluster {key[0]}.{key[1]}" if several else f"cluster {key[1]}"
    return go.Scatter3d(
        x=x.astype(np.float32),
        y=y.astype(np.float32),
        z=z.astype(np.float32),
        name=name,
        mode="lines",
        line={"color": colour, "width": 5},
        hoverinfo="name",
    )


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
