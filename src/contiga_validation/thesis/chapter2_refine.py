"""Section 2.4: knot insertion, degree elevation and k-refinement do not change the shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contiga import NurbsCurve
from contiga import knots as kv
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, MUTED, draw_curve, draw_polygon, plane
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

CUBIC = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], [[0.0, 0.0], [0.6, 1.6], [2.0, 1.9], [3.0, 0.2]])
"""On the knots of the thesis' example; it gives no control points."""
SEVERAL = (0.2, 0.4, 0.6, 0.8)
_U = np.linspace(0.0, 1.0, 2001)


def boehm(curve: NurbsCurve, t: float, *, as_printed: bool = False) -> NurbsCurve:
    """Return `curve` with the knot `t` inserted by Boehm's formula.

    `as_printed` swaps the two weights, as the thesis has them. Weights of control points are
    dropped.
    """
    p, knots, points = curve.degree, curve.knots, curve.control_points
    k = int(np.searchsorted(knots, t, side="right")) - 1
    new = np.empty((len(points) + 1, 3))
    new[: k - p + 1] = points[: k - p + 1]
    new[k + 1 :] = points[k:]
    for i in range(k - p + 1, k + 1):
        a = (t - knots[i]) / (knots[i + p] - knots[i])
        if as_printed:
            a = 1.0 - a
        new[i] = a * points[i] + (1.0 - a) * points[i - 1]
    return NurbsCurve(p, np.insert(knots, k + 1, t), new)


def _distance(curve: NurbsCurve, other: NurbsCurve) -> float:
    """Return the largest distance of two curves at 2001 common parameters from 0 to 1."""
    return float(np.linalg.norm(curve.evaluate(_U) - other.evaluate(_U), axis=1).max())


@EXPERIMENTS.add(
    "2.4-insertion",
    "Knot insertion: 0.5, and several knots",
    "Section 2.4, Fig. 2.4 and 2.5",
    "Inserting knots adds basis functions and control points and changes neither the curve "
    "nor its parameters. Its example is the cubic knot vector 0 0 0 0 1 1 1 1 with 0.5.",
)
def _insertion() -> Outcome:
    inserted, several = CUBIC.insert_knots(0.5), CUBIC.insert_knots(SEVERAL)
    through = CUBIC.insert_knots([0.5, 0.5, 0.5])
    rows = [
        ("0.5", len(inserted.control_points), _distance(inserted, CUBIC)),
        (", ".join(map(str, SEVERAL)), len(several.control_points), _distance(several, CUBIC)),
        ("0.5 three times", len(through.control_points), _distance(through, CUBIC)),
    ]
    return Outcome(
        tables=(
            Table(
                "2.4 insertion",
                "Knots inserted into 0 0 0 0 1 1 1 1 (degree 3, 4 control points).",
                ("inserted", "control points after", "the curve moves by"),
                tuple(rows),
            ),
            Table(
                "2.4 new points",
                "Control points of the curve before and after 0.5 is inserted.",
                ("point", "before, x", "before, y", "after, x", "after, y"),
                _point_rows(CUBIC, inserted),
            ),
        ),
        pictures=(
            Picture(
                "2.4",
                "Knot 0.5 inserted: one control point more, the same curve. Below, the basis "
                "before and after.",
                lambda figure: _draw_insertion(figure, CUBIC.insert_knots(0.5), "0.5 inserted"),
                (7.4, 4.4),
            ),
            Picture(
                "2.5",
                "Knots 0.2, 0.4, 0.6 and 0.8 inserted: the polygon comes closer to the curve.",
                lambda figure: _draw_insertion(
                    figure, CUBIC.insert_knots(SEVERAL), "four knots inserted"
                ),
                (7.4, 4.4),
            ),
        ),
        claims=_insertion_claims(inserted, rows, through),
        difference=(
            "The thesis shows pictures only. Its steps are garbled (weights swapped, a "
            "denominator of p + 1 knots, ranges that overlap, span 4 for 3, the worked formula "
            "cut off); contiga inserts any number of knots at once by the Oslo algorithm, and "
            "Boehm's formula is what it is checked against here."
        ),
    )


def _insertion_claims(
    inserted: NurbsCurve, rows: list[tuple[str, int, float]], through: NurbsCurve
) -> tuple[Claim, ...]:
    on_curve = np.abs(through.control_points[3] - CUBIC.evaluate(0.5)[0]).max()
    by_hand = np.abs(inserted.control_points - boehm(CUBIC, 0.5).control_points).max()
    printed = _distance(boehm(CUBIC, 0.25, as_printed=True), CUBIC)
    right = _distance(boehm(CUBIC, 0.25), CUBIC)
    worst = max(row[2] for row in rows)
    return (
        Claim("The shape stays.", worst <= 1e-15, f"it moves by at most {worst:.1e}"),
        Claim(
            "The new control points are those of Boehm's formula.",
            by_hand <= 1e-15,
            f"largest difference {by_hand:.1e}",
        ),
        Claim(
            "A knot inserted as often as the degree brings a control point onto the curve.",
            on_curve <= 1e-15,
            f"it is {on_curve:.1e} from C(0.5)",
        ),
        Claim(
            "With the two weights as printed in 2.4 (swapped) the curve would change.",
            right <= 1e-15 and printed > 0.1,
            f"knot 0.25: moved by {printed:.2f} as printed, by {right:.1e} as it should be",
        ),
    )


def _point_rows(before: NurbsCurve, after: NurbsCurve) -> tuple[tuple[float | None, ...], ...]:
    """Return number, x and y of control points before and after; None where it is new."""
    rows = []
    for i, (x, y, _) in enumerate(after.control_points.tolist()):
        old = before.control_points[i, :2].tolist() if i < len(before.control_points) else None
        rows.append((i, *(old or (None, None)), x, y))
    return tuple(rows)


def _draw_insertion(figure: Figure, after: NurbsCurve, title: str) -> None:
    panels = figure.subplots(2, 2, height_ratios=(1.5, 1.0))
    for column, (curve, name) in enumerate(((CUBIC, "before"), (after, title))):
        axes = plane(panels[0, column])
        if column:
            draw_polygon(axes, CUBIC, color="#c5cad0", label="polygon before")
        draw_polygon(axes, curve)
        draw_curve(axes, curve)
        axes.set_title(name)
        axes.legend(loc="lower center")
        below = plane(panels[1, column], equal=False, labels=("u", "basis"))
        draw_basis_functions(below, curve.knots, curve.degree)


def draw_basis_functions(axes: object, knots: FloatArray, degree: int) -> None:
    """Draw all basis functions on `knots`, from 0 to 1, with ticks at the knots."""
    values = kv.basis(knots, degree, _U)[:, 0]
    for i, column in enumerate(values.T):
        axes.plot(_U, column, color=LINES[i % len(LINES)], lw=1.3)  # type: ignore[attr-defined]
    axes.set_xticks(np.unique(knots))  # type: ignore[attr-defined]


@EXPERIMENTS.add(
    "2.4-elevation",
    "Degree elevation, k-refinement and splitting",
    "Section 2.4",
    "There are three refinements: knot insertion, order elevation and k-refinement.",
)
def _elevation() -> Outcome:
    rows = []
    h = CUBIC.insert_knots([0.5]).elevate(1)
    k = CUBIC.k_refined(1, [0.5])
    for name, curve in (
        ("elevated by 1", CUBIC.elevate(1)),
        ("elevated by 2", CUBIC.elevate(2)),
        ("0.5 inserted, then elevated by 1", h),
        ("elevated by 1, then 0.5 inserted (k-refinement)", k),
    ):
        inner = kv.multiplicity(curve.knots, 0.5)
        smooth = f"C{curve.degree - inner}" if inner else "–"
        distance = _distance(curve, CUBIC)
        rows.append((name, curve.degree, len(curve.control_points), smooth, distance))
    return Outcome(
        tables=(
            Table(
                "2.4 elevation",
                "The other refinements of the same cubic.",
                ("refinement", "degree", "control points", "basis at 0.5", "the curve moves by"),
                tuple(rows),
            ),
        ),
        pictures=(
            Picture(
                "2.4-elevation",
                "Degree 3, 4 and 5 of the same curve: each elevation adds a control point and "
                "brings the polygon closer.",
                _draw_elevation,
                (6.4, 3.2),
            ),
        ),
        claims=_elevation_claims(h, k, rows),
        difference="Named in 2.4 but not carried out there: the thesis uses knot insertion only.",
    )


def _elevation_claims(
    h: NurbsCurve, k: NurbsCurve, rows: list[tuple[str, int, int, str, float]]
) -> tuple[Claim, ...]:
    left, right = CUBIC.split(0.3)
    halves = max(
        float(np.abs(part.evaluate(u) - CUBIC.evaluate(u)).max())
        for part in (left, right)
        for u in [np.linspace(*part.domain, 801)]
    )
    worst = max(row[4] for row in rows)
    return (
        Claim("The shape stays.", worst <= 2e-15, f"it moves by at most {worst:.1e}"),
        Claim(
            "Elevating first and inserting then (k-refinement) takes fewer control points "
            "and leaves a smoother basis than the other way round.",
            len(k.control_points) < len(h.control_points) and rows[3][3] > rows[2][3],
            f"{len(k.control_points)} and {rows[3][3]} against {len(h.control_points)} and "
            f"{rows[2][3]}",
        ),
        Claim(
            "The two halves of a split curve are the curve.",
            halves <= 1e-15,
            f"largest difference {halves:.1e}",
        ),
    )


def _draw_elevation(figure: Figure) -> None:
    axes = plane(figure.subplots())
    for t, colour in ((0, MUTED), (1, LINES[1]), (2, LINES[2])):
        curve = CUBIC.elevate(t)
        draw_polygon(axes, curve, color=colour, label=f"polygon at degree {curve.degree}")
    draw_curve(axes, CUBIC)
    axes.legend(loc="lower center")
