"""Pictures as PNG, drawn by matplotlib in one style."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from contiga.report import style
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.experiment import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from contiga import NurbsCurve

BODY, GRID, INK, MUTED = style.BODY, style.GRID, style.INK, style.MUTED
LINES = style.LINES

DPI = 170
STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#9aa3ad",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.titlecolor": INK,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


def png(picture: Picture) -> bytes:
    """Draw a picture in the common style and return it as PNG."""
    import matplotlib as mpl
    from cycler import cycler
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    with mpl.rc_context({**STYLE, "axes.prop_cycle": cycler(color=LINES)}):
        layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06)
        figure = Figure(figsize=picture.size, dpi=DPI, layout=layout)
        FigureCanvasAgg(figure)
        picture.draw(figure)
        content = io.BytesIO()
        figure.savefig(content, format="png", metadata={"Software": None})
    return content.getvalue()


def plane(axes: Axes, *, equal: bool = True, labels: tuple[str, str] = ("x", "y")) -> Axes:
    """Label axes of a figure in the plane and return them; `equal` gives both the same scale."""
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    if equal:
        axes.set_aspect("equal", adjustable="datalim")
    return axes


def curve_points(curve: NurbsCurve, count: int = 400) -> FloatArray:
    """Return (count, 3) points along a curve, for drawing."""
    return curve.evaluate(np.linspace(*curve.domain, count))


def draw_curve(axes: Axes, curve: NurbsCurve, **style: Any) -> None:
    """Draw a curve, seen along z."""
    points = curve_points(curve)
    axes.plot(points[:, 0], points[:, 1], **{"color": LINES[0], "label": "curve", **style})


def draw_polygon(axes: Axes, curve: NurbsCurve, **style: Any) -> None:
    """Draw the control polygon of a curve, seen along z."""
    points = curve.control_points
    defaults = {"color": LINES[1], "ls": (0, (4, 3)), "lw": 1.0, "marker": "o", "ms": 4.5}
    axes.plot(points[:, 0], points[:, 1], **{**defaults, "label": "control polygon", **style})
