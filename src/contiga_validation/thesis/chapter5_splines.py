"""Section 5.1: the curves, surfaces and clouds of the thesis."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from contiga import NurbsCurve, NurbsSurface
from contiga import knots as kv
from contiga.report.view import View
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, draw_curve, draw_polygon, plane
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.chapter2 import cox_de_boor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

UNIFORM = np.array([0, 0, 0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1, 1, 1])
"""The knots of 5.1.1, as printed."""
TEN = np.array(
    [
        [0.0, 0.0], [0.5, 2.4], [1.7, 0.6], [2.6, 1.6], [3.1, -0.9],
        [4.2, -1.2], [4.4, 1.1], [5.3, 2.3], [6.3, 0.9], [6.9, -0.6],
    ]
)  # fmt: skip
"""Ten control points; the thesis shows its own in Fig. 5.1 without numbers."""
NON_UNIFORM = np.array([0, 0, 0, 0.125, 0.3, 0.375, 0.5, 0.6, 0.7, 0.875, 1, 1, 1])
"""The knots of 5.1.2, as printed."""
_FINE = np.linspace(0.0, 1.0, 2001)


# ---------------------------------------------------------------- B-spline curve (5.1.1)


@EXPERIMENTS.add(
    "5.1.1-curve",
    "A B-spline curve with ten control points",
    "Section 5.1.1, Fig. 5.1–5.3",
    "A quadratic curve on a uniform open knot vector with ten control points: its ends are "
    "interpolated, and its polygon is tangent to it there.",
)
def _bspline_curve() -> Outcome:
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
        claims=_bspline_curve_claims(),
        difference=(
            "The text calls the basis of Fig. 5.2 cubic. Its knot vector has 13 entries for 10 "
            "points, so it is quadratic, as the same section says of the curve. The control "
            "points are chosen here; the thesis shows them without numbers."
        ),
    )


def _bspline_curve_claims() -> tuple[Claim, ...]:
    curve = NurbsCurve(2, UNIFORM, TEN)
    ends = np.abs(curve.evaluate([0.0, 1.0]) - curve.control_points[[0, -1]]).max()
    slopes = curve.derivatives([0.0, 1.0], 1)[:, 1]
    legs = curve.control_points[[1, -1]] - curve.control_points[[0, -2]]
    tangent = np.abs(np.cross(slopes, legs)[:, 2]).max()
    by_recursion = cox_de_boor(UNIFORM, 2, _FINE) @ curve.control_points
    same = np.abs(curve.evaluate(_FINE) - by_recursion).max()
    jumps = _jumps(UNIFORM)
    return (
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
    )


def _jumps(knots: np.ndarray) -> tuple[float, float]:
    """Return the largest jump of a first derivative of the quadratic basis at an inner knot.

    The second number is the smallest, over the knots, of the largest jump of a second derivative.
    """
    inner, step = np.unique(knots)[1:-1], 1e-9
    gap = np.abs(kv.basis(knots, 2, inner, 2) - kv.basis(knots, 2, inner - step, 2)).max(axis=2)
    return float(gap[:, 1].max()), float(gap[:, 2].min())


def draw_basis(figure: Figure, knots: np.ndarray, order: int) -> None:
    """Draw basis functions of degree 2 and their derivatives up to `order`, one row each."""
    names = ("$B_{i,2}(u)$", "$B'_{i,2}(u)$", "$B''_{i,2}(u)$")
    breaks, panels = np.unique(knots), figure.subplots(order + 1, 1, sharex=True)
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


# ---------------------------------------------------------------- NURBS curve (5.1.2)


def weighted(second: float | None) -> NurbsCurve:
    """Return the curve of Fig. 5.6 and 5.7 with the weight `second` of its second point.

    The fifth and the eighth point have the weight 1.5; for None all weights are 1.
    """
    weights = np.ones(10)
    if second is not None:
        weights[[1, 4, 7]] = second, 1.5, 1.5
    return NurbsCurve(2, NON_UNIFORM, TEN, weights)


@EXPERIMENTS.add(
    "5.1.2-weights",
    "Weights pull a NURBS curve",
    "Section 5.1.2, Fig. 5.5–5.7",
    "With weights 2, 1.5 and 1.5 the curve is pulled to three of its control points; raising "
    "the second weight from 2 to 5 pulls it further.",
)
def _weights() -> Outcome:
    plain_curve = NurbsCurve(2, NON_UNIFORM, TEN)
    one, two, five = (weighted(w).evaluate(_FINE) for w in (None, 2.0, 5.0))
    corner = plain_curve.control_points[1]
    reach = [float(np.linalg.norm(c - corner, axis=1).min()) for c in (one, two, five)]
    return Outcome(
        tables=(
            Table(
                "5.1.2 weights",
                "How close the curve comes to its second control point.",
                ("weight of the second point", "least distance"),
                tuple(zip((1, 2, 5), reach, strict=True)),
            ),
        ),
        pictures=(
            Picture(
                "5.5",
                "The quadratic basis on the printed non-uniform knots and its first derivative.",
                lambda figure: draw_basis(figure, NON_UNIFORM, 1),
                (7.4, 3.8),
            ),
            Picture(
                "5.6",
                "All weights 1 (left), and 2, 1.5, 1.5 at the second, fifth and eighth point "
                "(right): the curve is pulled towards them.",
                lambda figure: _draw_weights(figure, (None, 2.0)),
                (8.2, 3.2),
            ),
            Picture(
                "5.7",
                "The second weight raised from 2 (left) to 5 (right).",
                lambda figure: _draw_weights(figure, (2.0, 5.0)),
                (8.2, 3.2),
            ),
        ),
        claims=(*_weights_claims(plain_curve, one, reach), *_pull_claims(plain_curve, two, five)),
        difference=(
            "The thesis shows its control points without numbers and three raised weights (2, "
            "1.5, 1.5); points, and which of them carry the 1.5, are chosen here."
        ),
    )


def _weights_claims(
    plain_curve: NurbsCurve, one: FloatArray, reach: list[float]
) -> tuple[Claim, ...]:
    same = np.abs(one - plain_curve.evaluate(_FINE)).max()
    return (
        Claim(
            "With all weights 1 the NURBS curve is the B-spline curve.",
            same <= 1e-15,
            f"largest difference {same:.1e}",
        ),
        Claim(
            "A higher weight pulls the curve to its control point: 1, 2, 5 come ever closer.",
            reach[0] > reach[1] > reach[2],
            f"least distance {reach[0]:.3f}, {reach[1]:.3f}, {reach[2]:.3f}",
        ),
    )


def _pull_claims(plain_curve: NurbsCurve, two: FloatArray, five: FloatArray) -> tuple[Claim, ...]:
    """Return the claims on the second weight, raised from 2 to 5."""
    pull, to_point = five - two, plain_curve.control_points[1] - two
    miss = np.linalg.norm(np.cross(pull, to_point), axis=1).max()
    towards = (pull * to_point).sum(axis=1).min()
    moved_rows = np.flatnonzero(np.linalg.norm(pull, axis=1) > 1e-14)
    span = float(_FINE[moved_rows[0]]), float(_FINE[moved_rows[-1]])
    share = _pulled(plain_curve, 5.0)
    return (
        Claim(
            "Every point is pulled straight towards the control point.",
            miss <= 1e-14 and towards >= -1e-15,
            f"cross product {miss:.1e}",
        ),
        Claim(
            "It is moved by the share (w' − w) N / (w + (w' − w) N) of the way.",
            share <= 1e-14,
            f"largest difference {share:.1e}",
        ),
        Claim(
            "Only the part over the second function's knots 0 to 0.3 moves.",
            span[0] > 0.0 and span[1] < 0.3,
            f"from {span[0]:g} to {span[1]:g}",
        ),
    )


def _pulled(curve: NurbsCurve, weight: float) -> float:
    """Return the largest error of the closed form for raising the second weight from 1."""
    weights = np.ones(10)
    weights[1] = weight
    raised = NurbsCurve(2, curve.knots, curve.control_points, weights).evaluate(_FINE)
    function = kv.basis(curve.knots, 2, _FINE)[:, 0, 1][:, None]
    share = (weight - 1.0) * function / (1.0 + (weight - 1.0) * function)
    start = curve.evaluate(_FINE)
    return float(np.abs(raised - (start + share * (curve.control_points[1] - start))).max())


def _draw_weights(figure: Figure, seconds: tuple[float | None, float | None]) -> None:
    for axes, second in zip(figure.subplots(1, 2), seconds, strict=True):
        plane(axes)
        curve = weighted(second)
        if second is not None:
            draw_curve(axes, weighted(seconds[0]), color="#b9c0c8", label="curve on the left")
        draw_polygon(axes, curve)
        draw_curve(axes, curve)
        weights = np.ones(10) if curve.weights is None else curve.weights
        axes.set_title("all weights 1" if second is None else f"second weight {second:g}")
        for (x, y), w in zip(TEN, weights, strict=True):
            heavy = {"fontweight": "bold"} if w > 1.0 else {"color": "#6a737d"}
            axes.annotate(
                f"{w:g}", (x, y), xytext=(4, 4), textcoords="offset points", fontsize=8, **heavy
            )


# ---------------------------------------------------------------- surfaces (Fig. 5.4 and 5.8)


def net_surface(*, weighted_points: bool = False) -> NurbsSurface:
    """Return the surface on the printed knots: 5 × 4 control points, cubic in both directions.

    `weighted_points` gives two of them the weights 3 and 4.
    """
    x, y = np.meshgrid(np.linspace(0.0, 4.0, 5), np.linspace(0.0, 3.0, 4), indexing="ij")
    z = np.array(
        [[0.0, 0.4, 0.2, -0.2], [0.5, 1.5, 1.2, 0.1], [0.1, 1.0, 1.9, 0.7],
         [-0.3, 0.2, 1.0, 0.9], [0.0, -0.4, 0.1, 0.3]]
    )  # fmt: skip
    weights = np.ones((5, 4))
    weights[1, 1], weights[2, 2] = 3.0, 4.0
    U, V = [0, 0, 0, 0, 0.5, 1, 1, 1, 1], [0, 0, 0, 0, 1, 1, 1, 1]
    net = np.stack([x, y, z], axis=-1)
    return NurbsSurface((3, 3), (U, V), net, weights if weighted_points else None)


@EXPERIMENTS.add(
    "5.1.2-surfaces",
    "A B-spline and a NURBS surface with their nets",
    "Sections 5.1.1 and 5.1.2, Fig. 5.4 and 5.8",
    "Twenty control points on U = 0 0 0 0 0.5 1 1 1 1 and V = 0 0 0 0 1 1 1 1, without and "
    "with weights.",
)
def _surfaces() -> Outcome:
    return Outcome(
        pictures=(
            Picture(
                "5.4",
                "The net of 5 × 4 control points (left) and its B-spline surface (right).",
                lambda figure: _draw_surface(figure, net_surface()),
                (8.4, 3.4),
            ),
            Picture(
                "5.8",
                "The same net with weights 3 and 4 on its two highest points, and its NURBS "
                "surface.",
                lambda figure: _draw_surface(figure, net_surface(weighted_points=True)),
                (8.4, 3.4),
            ),
        ),
        claims=_surfaces_claims(),
        difference=(
            "Knots and the number of control points are the thesis'; it does not give the points "
            "or weights. Its Algorithm 1 would not reproduce the surface: it overwrites the sum it "
            "should add to and divides by a weight it never collects."
        ),
    )


def _surfaces_claims() -> tuple[Claim, ...]:
    flat, heavy = net_surface(), net_surface(weighted_points=True)
    uv = np.stack(np.meshgrid(_FINE[::50], _FINE[::50], indexing="ij"), -1).reshape(-1, 2)
    bases = [cox_de_boor(knots, 3, t) for knots, t in zip(flat.knots, uv.T, strict=True)]
    product = np.einsum("ki,kj->kij", *bases)
    by_hand = np.einsum("kij,ijc->kc", product, flat.control_points)
    same = np.abs(flat.evaluate(uv) - by_hand).max()
    factor = product * heavy.weights
    rational = np.einsum("kij,ijc->kc", factor, heavy.control_points) / factor.sum((1, 2))[:, None]
    same_heavy = np.abs(heavy.evaluate(uv) - rational).max()
    unity = np.abs((factor / factor.sum((1, 2))[:, None, None]).sum((1, 2)) - 1.0).max()
    top = [float(s.evaluate(uv)[:, 2].max()) for s in (flat, heavy)]
    return (
        Claim(
            "The B-spline surface is the tensor product of Eq. 2.7.",
            same <= 1e-14,
            f"largest difference {same:.1e}",
        ),
        Claim(
            "The NURBS surface is that of Eq. 2.9 and 2.11, whose functions add up to 1.",
            same_heavy <= 1e-14 and unity <= 1e-15,
            f"largest difference {same_heavy:.1e}, sums within {unity:.1e}",
        ),
        Claim(
            "Higher weights pull the surface up to the two points.",
            top[1] > top[0] + 0.2,
            f"highest point {top[0]:.3f} without, {top[1]:.3f} with weights",
        ),
    )


def _draw_surface(figure: Figure, surface: NurbsSurface) -> None:
    left, right = figure.subplots(1, 2)
    corners = surface.control_points.reshape(-1, 3)
    names = ("control points", "surface")
    for axes, name in ((left, names[0]), (right, names[1])):
        view = View(axes, corners, shape=(600, 474))
        if name == "surface":
            view.surface(surface).iso_lines(surface)
        else:
            view.net(surface)
            if surface.weights is not None:
                for i, j in np.argwhere(surface.weights > 1.0):
                    at = surface.control_points[i, j]
                    view.text(at, f"w = {surface.weights[i, j]:g}")
        view.show()
        axes.set_title(name)
