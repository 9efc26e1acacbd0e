"""Sections 5.1.3 and 5.1.4: the torus, clouds of slave points, moving shapes, named shapes."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from contiga import NurbsCurve, NurbsSurface, clouds, shapes
from contiga.report.view import View
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.chapter5_splines import net_surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

MAJOR, MINOR = 2.0, 0.7
TORUS = shapes.torus(major=MAJOR, minor=MINOR)
_PALE = "#dfe5ec"


# ---------------------------------------------------------------- shapes with a name


def _catalogue() -> list[tuple[str, NurbsSurface]]:
    wave = NurbsCurve(
        2, [0, 0, 0, 0.5, 1, 1, 1], np.array([[0, 0, 0], [1, 0, 1.4], [2, 0, -1], [3, 0, 0.5]])
    )
    return [
        ("bilinear", shapes.bilinear((0, 0, 0), (2, 0, 0.8), (0, 2, 0.8), (2, 2, 0))),
        ("extruded", shapes.extruded(wave, (0, 2.5, 0))),
        (
            "ruled",
            shapes.ruled(
                shapes.arc(radius=1.2, start=0.0, end=pi),
                shapes.line((1.2, 0, 2), (-1.2, 0.6, 2)),
            ),
        ),
        ("cylinder", shapes.cylinder(radius=1.0, height=2.4)),
    ]


@EXPERIMENTS.add(
    "5.1-shapes",
    "Bilinear, extruded, ruled and cylindrical surfaces",
    "Section 5.1 and Fig. 8.1",
    "Surfaces are made from control nets; the outlook builds parts from named shapes.",
)
def _shapes() -> Outcome:
    from scipy.integrate import dblquad

    bilinear, extruded, ruled, cylinder = (surface for _, surface in _catalogue())
    wave = NurbsCurve(2, extruded.knots[0], extruded.control_points[:, 0])

    def area_element(v: float, u: float) -> float:
        # z = 0.8 (u + v − 2uv) with x = 2u, y = 2v
        slopes = 0.4 * (1.0 - 2.0 * v), 0.4 * (1.0 - 2.0 * u)
        return float(np.hypot(np.hypot(*slopes), 1.0) * 4.0)

    flat = dblquad(area_element, 0, 1, 0, 1, epsabs=1e-12)
    rows = (
        ("bilinear", bilinear.area(), float(flat[0])),
        ("extruded", extruded.area(), wave.length() * 2.5),
        ("cylinder", cylinder.area(), 2.0 * pi * 2.4),
    )
    worst = max(abs(measured / true - 1.0) for _, measured, true in rows)
    return Outcome(
        tables=(
            Table(
                "5.1 shapes", "Areas against closed forms.", ("shape", "area", "should be"), rows
            ),
        ),
        pictures=(
            Picture(
                "5.1-shapes",
                "A bilinear, an extruded and a ruled surface, and a cylinder, with iso-lines.",
                _draw_shapes,
                (8.4, 6.0),
            ),
        ),
        claims=_shapes_claims(cylinder, ruled, worst),
        difference=(
            "The thesis shows such shapes without measures; these are chosen so that closed forms "
            "are known."
        ),
    )


def _shapes_claims(cylinder: NurbsSurface, ruled: NurbsSurface, worst: float) -> tuple[Claim, ...]:
    t = np.linspace(0.0, 1.0, 501)
    first = ruled.evaluate(np.column_stack([t, np.zeros(501)]))
    on_arc = float(np.abs(np.hypot(first[:, 0], first[:, 1]) - 1.2).max())
    straight = ruled.evaluate(np.column_stack([t, np.full(501, 0.5)]))
    last = ruled.evaluate(np.column_stack([t, np.ones(501)]))
    # where on its line a point of v = 0.5 lies depends on the weights, that it does not
    aside = float(np.linalg.norm(np.cross(straight - first, last - first), axis=1).max())
    uv = np.random.default_rng(5).random((5000, 2))
    round_ = float(np.abs(np.hypot(*cylinder.evaluate(uv)[:, :2].T) - 1.0).max())
    return (
        Claim(
            "Their areas are right (bilinear: integral of the closed form; extruded: arc "
            "length times height; cylinder: 2πrh).",
            worst <= 1e-9,
            f"largest relative difference {worst:.1e}",
        ),
        Claim(
            "The ruled surface runs straight from an exact arc to a line.",
            on_arc <= 1e-14 and aside <= 1e-14,
            f"arc within {on_arc:.1e}, cross product of the rulings {aside:.1e}",
        ),
        Claim("The cylinder is round.", round_ <= 1e-14, f"radius within {round_:.1e} of 1"),
    )


def _draw_shapes(figure: Figure) -> None:
    for axes, (name, surface) in zip(figure.subplots(2, 2).flat, _catalogue(), strict=True):
        view = View(axes, surface.control_points, shape=(600, 442))
        view.surface(surface).iso_lines(surface, 9).show()
        axes.set_title(name)


# ---------------------------------------------------------------- clouds (5.1.3)


def _off_torus(points: FloatArray) -> float:
    """Return the largest distance of points (n, 3) from the torus, in closed form."""
    ring = np.hypot(points[:, 0], points[:, 1]) - MAJOR
    return float(np.abs(np.hypot(ring, points[:, 2]) - MINOR).max())


@EXPERIMENTS.add(
    "5.1.3-torus",
    "A torus, and the slave points sampled from it",
    "Section 5.1.3, Fig. 5.9 and 5.10",
    "Ten knots in u times ten in v of a NURBS torus give a cloud of slave points.",
)
def _torus() -> Outcome:
    rng = np.random.default_rng(1)
    fine = _off_torus(TORUS.evaluate(rng.random((20000, 2))))
    area = 4.0 * pi**2 * MAJOR * MINOR
    miss = abs(TORUS.area() / area - 1.0)
    cloud = clouds.sample(TORUS, 10, 10)
    n_distinct = len(np.unique(np.round(cloud, 9), axis=0))
    on = _off_torus(cloud)
    return Outcome(
        pictures=(
            Picture("5.9", "The torus as a NURBS surface, exact.", _draw_torus, (5.2, 3.2)),
            Picture(
                "5.10",
                "Slave points at 10 × 10 parameters of the torus.",
                lambda figure: _draw_cloud(figure, clouds.sample(TORUS, 10, 10)),
                (5.2, 3.2),
            ),
        ),
        claims=(
            Claim(
                "The NURBS torus is a torus, which no B-spline is.",
                fine <= 1e-14,
                f"20 000 points are within {fine:.1e} of it",
            ),
            Claim("Its area is 4π²Rr.", miss <= 1e-10, f"relative difference {miss:.1e}"),
            Claim(
                "Ten parameters in u times ten in v are 100 slave points on the torus.",
                len(cloud) == 100 and on <= 1e-14,
                f"{len(cloud)} points within {on:.1e}; {n_distinct} places, as the two seams are "
                "sampled from both sides",
            ),
        ),
        difference=(
            "The radii are chosen here (2 and 0.7). The tensor product takes the end parameters "
            "0 and 1, which on a closed surface are one place: 81 of the 100 points differ."
        ),
    )


def _draw_torus(figure: Figure) -> None:
    view = View(figure.subplots(), TORUS.control_points, towards=(-0.5, 0.7, -0.6))
    view.surface(TORUS).iso_lines(TORUS, 17).show()


def _draw_cloud(figure: Figure, points: FloatArray, **style: Any) -> None:
    view = View(figure.subplots(), TORUS.control_points, towards=(-0.5, 0.7, -0.6))
    view.surface(TORUS, _PALE, 0.55).dots(points, **{"ms": 4.0, **style}).show()


@EXPERIMENTS.add(
    "5.1.3-random", "Random clouds", "Section 5.1.3", "Slave points can also be drawn at random."
)
def _random() -> Outcome:
    n = 20000
    on = clouds.random_on(TORUS, n, seed=4)
    outside = float((np.hypot(on[:, 0], on[:, 1]) > MAJOR).mean())
    # the outer half of the tube has the share 1/2 + r/(πR) of the area
    share = 0.5 + MINOR / (pi * MAJOR)
    spread = (share * (1.0 - share) / n) ** 0.5
    by_parameter = TORUS.evaluate(np.random.default_rng(4).random((n, 2)))
    plain = float((np.hypot(by_parameter[:, 0], by_parameter[:, 1]) > MAJOR).mean())
    box = clouds.random_in_box((-1.0, 0.0, 2.0), (1.0, 3.0, 2.5), n, seed=4)
    centre = np.abs((box.mean(axis=0) - (0.0, 1.5, 2.25)) / (2.0, 3.0, 0.5)).max()
    within = bool(((box >= (-1.0, 0.0, 2.0)) & (box <= (1.0, 3.0, 2.5))).all())
    again = np.array_equal(on, clouds.random_on(TORUS, n, seed=4))
    return Outcome(
        pictures=(
            Picture(
                "5.1.3-random",
                "2000 random slave points, uniform in the area of the torus.",
                lambda figure: _draw_cloud(figure, clouds.random_on(TORUS, 2000, seed=4), ms=1.8),
                (5.2, 3.2),
            ),
        ),
        claims=(
            Claim(
                "Random points lie on the surface and are uniform in its area: the outer half of "
                "the tube gets its share 1/2 + r/πR.",
                _off_torus(on) <= 1e-14 and abs(outside - share) <= 4.0 * spread,
                f"{outside:.4f} against {share:.4f} ± {spread:.4f}; random parameters instead "
                f"would give {plain:.4f}",
            ),
            Claim(
                "Random points in a box fill it evenly.",
                within and centre <= 4.0 / (12.0 * n) ** 0.5,
                f"their mean is {centre:.4f} of the sides from the centre",
            ),
            Claim("The same seed gives the same cloud.", again, "bit for bit"),
        ),
        difference="Named in the thesis without a picture.",
    )


# ---------------------------------------------------------------- transformations (5.1.4)

_MOVES: tuple[tuple[str, str], ...] = (
    ("translated", "translated by (2.5, 2, 1)"),
    ("x", "turned by 60° about x"),
    ("y", "turned by 60° about y"),
    ("z", "turned by 60° about z"),
    ("scaled", "scaled by 0.5"),
)


def _moved(surface: NurbsSurface, how: str) -> NurbsSurface:
    """Return a surface translated, scaled, or rotated by 60° about the axis `how`."""
    if how == "translated":
        return surface.translated((2.5, 2.0, 1.0))
    if how == "scaled":
        return surface.scaled(0.5)
    return surface.rotated(how, pi / 3.0)


def _by_hand(points: FloatArray, how: str) -> FloatArray:
    """Return points (n, 3) moved as by `_moved`, with the transformation written out."""
    if how == "translated":
        return points + np.array([2.5, 2.0, 1.0])
    if how == "scaled":
        return 0.5 * points
    c, s = np.cos(pi / 3.0), np.sin(pi / 3.0)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[how]
    out = points.copy()
    out[:, i], out[:, j] = c * points[:, i] - s * points[:, j], s * points[:, i] + c * points[:, j]
    return out


@EXPERIMENTS.add(
    "5.1.4-moves",
    "Translation, rotation about x, y and z, and scaling",
    "Section 5.1.4, Fig. 5.11",
    "Curves and surfaces keep their shape under translation, rotation and scaling of their "
    "control points.",
)
def _moves() -> Outcome:
    surface = net_surface(weighted_points=True)
    uv = np.random.default_rng(2).random((2000, 2))
    before = surface.evaluate(uv)
    area = surface.area()
    rows = []
    for how, name in _MOVES:
        after = _moved(surface, how)
        miss = float(np.abs(after.evaluate(uv) - _by_hand(before, how)).max())
        rows.append((name, miss, after.area() / area))
    worst = max(row[1] for row in rows)
    area_error = max(
        abs(row[2] - (0.25 if how == "scaled" else 1.0))
        for row, (how, _) in zip(rows, _MOVES, strict=True)
    )
    return Outcome(
        tables=(
            Table(
                "5.1.4",
                "The NURBS surface of Fig. 5.8, its control points moved.",
                ("move", "largest difference to its points moved", "area after / before"),
                tuple(rows),
            ),
        ),
        pictures=(
            Picture(
                "5.11",
                "The surface (grey) translated, and turned by 60° about x, y and z.",
                _draw_moves,
                (8.4, 6.2),
            ),
        ),
        claims=(
            Claim(
                "Moving the control points moves the surface alike.",
                worst <= 1e-14,
                f"largest difference {worst:.1e}",
            ),
            Claim(
                "Its shape stays: translation and rotation keep the area, scaling by s gives s² of "
                "it.",
                area_error <= 1e-10,
                f"largest relative difference {area_error:.1e}",
            ),
        ),
        difference="The thesis gives neither distances nor angles.",
    )


def _draw_moves(figure: Figure) -> None:
    surface = net_surface(weighted_points=True)
    reach = np.linalg.norm(surface.control_points, axis=-1).max()
    for axes, (how, name) in zip(figure.subplots(2, 2).flat, _MOVES[:4], strict=True):
        after = _moved(surface, how)
        scene = np.concatenate([s.control_points.reshape(-1, 3) for s in (surface, after)])
        view = View(axes, np.vstack([scene, np.zeros((1, 3))]))
        view.surface(surface, "#c9ced5").surface(after, "#6f9bbd").iso_lines(after)
        if how in "xyz":
            tip = 0.9 * reach * np.eye(3)["xyz".index(how)]
            view.lines([-0.25 * tip, tip], color=LINES[1], lw=1.2).text(tip, how, color=LINES[1])
        view.show()
        axes.set_title(name)
