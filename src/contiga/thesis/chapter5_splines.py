"""Section 5.1: the curves, surfaces and clouds of the thesis."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from contiga.geometry import knots as kv
from contiga.geometry.curve import NurbsCurve
from contiga.thesis.chapter2 import cox_de_boor
from contiga.thesis.drawing import LINES, draw_curve, draw_polygon, plane
from contiga.thesis.records import Claim, Experiment, Outcome, Picture, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNIFORM = np.array([0, 0, 0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1, 1, 1])
"""The knots of 5.1.1, as printed."""
TEN = np.array(
    [
        [0.0, 0.0], [0.6, 1.5], [1.6, 1.9], [2.3, 0.7], [3.1, -0.4],
        [4.1, -0.2], [4.6, 1.1], [5.5, 1.8], [6.4, 1.0], [6.9, -0.3],
    ]
)  # fmt: skip
"""Ten control points; the thesis shows its own in Fig. 5.1 without numbers."""
_FINE = np.linspace(0.0, 1.0, 2001)


# ---------------------------------------------------------------- B-spline curve (5.1.1)


def _bspline_curve() -> Outcome:
    curve = NurbsCurve(2, UNIFORM, TEN)
    ends = np.abs(curve.evaluate([0.0, 1.0]) - curve.control_points[[0, -1]]).max()
    slopes = curve.derivatives([0.0, 1.0], 1)[:, 1]
    legs = curve.control_points[[1, -1]] - curve.control_points[[0, -2]]
    tangent = np.abs(np.cross(slopes, legs)[:, 2]).max()
    by_recursion = cox_de_boor(UNIFORM, 2, _FINE) @ curve.control_points
    same = np.abs(curve.evaluate(_FINE) - by_recursion).max()
    jumps = _jumps(UNIFORM)
    return Outcome(
        tables=(
            Table(
                "5.1.1 knots",
                "13 knots and 10 control points can only be of degree 2 (knots = points + degree "
                "+ 1).",
                ("degree", "control points it would need", "fits the ten of Fig. 5.1"),
                tuple((p, 13 - p - 1, "yes" if 13 - p - 1 == 10 else "no") for p in (1, 2, 3)),
            ),
        ),
        pictures=(
            Picture("5.1", "Ten control points and their polygon.", _draw_net, (6.4, 3.0)),
            Picture(
                "5.2",
                "The quadratic basis on the printed knots with its first and second derivatives. "
                "The slopes are continuous with kinks at the knots; the second derivatives jump.",
                lambda figure: draw_basis(figure, UNIFORM, 2),
                (7.4, 5.2),
            ),
            Picture(
                "5.3",
                "The B-spline curve with its control points and polygon: it starts and ends in "
                "the end points, along the first and last leg.",
                _draw_bspline,
                (6.4, 3.0),
            ),
        ),
        claims=(
            Claim("The ends are interpolated.", ends == 0.0, f"largest miss {ends:.1e}"),
            Claim(
                "The curve leaves along the first and last leg of the polygon.",
                tangent <= 1e-13,
                f"cross product {tangent:.1e}",
            ),
            Claim(
                "The curve is the sum of its control points, weighted by the basis (Eq. 2.5).",
                same <= 1e-14,
                f"largest difference {same:.1e}",
            ),
            Claim(
                "The basis of Fig. 5.2 is quadratic: first derivatives are continuous, second "
                "ones jump at every knot.",
                jumps[0] <= 1e-6 and jumps[1] >= 1.0,
                f"jumps {jumps[0]:.1e} and at least {jumps[1]:.0f}",
            ),
        ),
        difference=(
            "The text calls the basis of Fig. 5.2 cubic. Its knot vector has 13 entries for 10 "
            "points, so it is quadratic, as the same section says of the curve. The control "
            "points are chosen here; the thesis shows them without numbers."
        ),
    )


def _jumps(knots: np.ndarray) -> tuple[float, float]:
    """Largest jump of a first, least (over the knots) largest jump of a second derivative."""
    inner, step = np.unique(knots)[1:-1], 1e-9
    right = kv.basis(knots, 2, inner, 2)
    left = kv.basis(knots, 2, inner - step, 2)
    gap = np.abs(right - left).max(axis=2)
    return float(gap[:, 1].max()), float(gap[:, 2].min())


def draw_basis(figure: Figure, knots: np.ndarray, order: int) -> None:
    """Basis functions of degree 2 and their derivatives up to `order`, one row each."""
    names = ("$B_{i,2}(u)$", "$B'_{i,2}(u)$", "$B''_{i,2}(u)$")
    breaks = np.unique(knots)
    panels = figure.subplots(order + 1, 1, sharex=True)
    for k, axes in enumerate(panels):
        for low, high in pairwise(breaks):
            u = np.linspace(low, high, 41)
            # the last parameter belongs to the piece on its right: stay inside this one
            inside = np.clip(u, low, high - 1e-12 * (high - low))
            values = kv.basis(knots, 2, inside, order)[:, k]
            for i in np.flatnonzero(np.abs(values).max(axis=0) > 0.0):
                axes.plot(u, values[:, i], color=LINES[i % len(LINES)], lw=1.4)
        plane(axes, equal=False, labels=("u" if k == order else "", names[k]))
        axes.set_xlim(0.0, 1.0)
        axes.set_xticks(breaks, [f"{value:g}" for value in breaks])
    figure.align_ylabels(list(panels))


def _draw_net(figure: Figure) -> None:
    axes = plane(figure.subplots())
    draw_polygon(axes, NurbsCurve(2, UNIFORM, TEN))
    for i, (x, y) in enumerate(TEN):
        axes.annotate(f"$P_{i}$", (x, y), xytext=(4, 4), textcoords="offset points", fontsize=8)


def _draw_bspline(figure: Figure) -> None:
    axes = plane(figure.subplots())
    curve = NurbsCurve(2, UNIFORM, TEN)
    draw_polygon(axes, curve)
    draw_curve(axes, curve)
    axes.legend(loc="upper right")


EXPERIMENTS: tuple[Experiment, ...] = (
    Experiment(
        "5.1.1-curve",
        5,
        "A B-spline curve with ten control points",
        "Section 5.1.1, Fig. 5.1–5.3",
        _bspline_curve,
        "A quadratic curve on a uniform open knot vector with ten control points: its ends are "
        "interpolated, and its polygon is tangent to it there.",
    ),
)
