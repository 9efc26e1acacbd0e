"""Section 5.2, second part: feet that are followed from step to step, in the plane and in space."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from contiga import ContactStatus
from contiga.report.view import View
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, MUTED, draw_curve, plane
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.play import SceneRun, run_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from contiga import NurbsCurve

EXPERIMENTS = Experiments()

CONTACT, FREE, OTHER = LINES[1], LINES[0], LINES[2]


def _closest(run: SceneRun) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return closest points (n, 3) and depths by them (n,), by step; 0 without contact."""
    points, depths = [], []
    for k, state in enumerate(run.states):
        feet = run.body.project(run.places[k])
        points.append(feet.point)
        depths.append(np.where(state.in_contact, np.maximum(-feet.gap, 0.0), 0.0))
    return points, depths


def _leaps(run: SceneRun) -> tuple[float, float, float]:
    """Return the largest changes of depth, foot and closest point in a step, over the displacement.

    Only nodes that are in contact before and after the step count.
    """
    closest, _ = _closest(run)
    worst = np.zeros(3)
    for k, (last, state) in enumerate(pairwise(run.states), start=1):
        in_contact = state.in_contact & last.in_contact
        displacement = np.linalg.norm(run.places[k] - run.places[k - 1], axis=1)[in_contact]
        changes = (
            np.abs(state.penetration - last.penetration)[in_contact],
            np.linalg.norm(state.foot - last.foot, axis=1)[in_contact],
            np.linalg.norm(closest[k] - closest[k - 1], axis=1)[in_contact],
        )
        worst = np.maximum(worst, [(change / displacement).max(initial=0.0) for change in changes])
    return float(worst[0]), float(worst[1]), float(worst[2])


def _count_facing_away(run: SceneRun) -> list[int]:
    """Return, by step, the number of points in contact whose closest point faces the other way.

    The normal there has a negative product with the normal at the foot.
    """
    out = []
    for k, state in enumerate(run.states):
        normal = run.body.project(run.places[k]).normal
        away = (normal * state.normal).sum(axis=1) < 0.0
        out.append(int((away & state.in_contact).sum()))
    return out


SequenceRow = tuple[int, int, int, int, int, float, float]
"""Step; points in contact, new, released, closest to the other branch; depth followed, and by
closest points."""


@EXPERIMENTS.add(
    "5.2.2-curve",
    "Nodes through a curve: local against global minimum",
    "Section 5.2.2, Fig. 5.14–5.17",
    "No contact in the first two steps; then two nodes penetrate, then another. Where global "
    "and local minimum differ (Fig. 5.16) the local one is taken, as the force would leap "
    "otherwise. From t = 7 the nodes go down and some are released.",
)
def _curve_sequence() -> Outcome:
    run = run_scene("curve_sequence")
    n_facing_away = _count_facing_away(run)
    _, closest = _closest(run)
    rows = tuple(
        (
            k,
            state.n_contact,
            int((state.status == ContactStatus.NEW).sum()),
            int((state.status == ContactStatus.RELEASED).sum()),
            n_facing_away[k],
            float(state.max_penetration),
            float(closest[k].max()),
        )
        for k, state in enumerate(run.states)
    )
    return Outcome(
        tables=(
            Table(
                "5.2.2 sequence",
                "Five nodes through the curve, step by step.",
                (
                    "t",
                    "in contact",
                    "new",
                    "released",
                    "closest to the other branch",
                    "deepest, followed",
                    "deepest, by closest points",
                ),
                rows,
            ),
        ),
        pictures=(
            Picture(
                "5.14",
                "The sequence. Red nodes are in contact, lines lead to their feet. At t = 6 the "
                "closest points of some (green) are on the other branch; the feet stay "
                "where they came in. At t = 7 the nodes go back.",
                lambda figure: _draw_sequence(figure, (1, 2, 3, 4, 6, 7)),
                (8.4, 6.6),
            ),
            Picture(
                "5.16",
                "Depth of the third node: followed from step to step, and by the closest point, "
                "which at t = 6 is on the other branch.",
                _draw_depths,
                (6.4, 2.9),
            ),
        ),
        claims=(*_sequence_claims(rows), *_following_claims(run)),
        difference=(
            "The curve is designed: it turns back like a hairpin. The thesis says that with the "
            "global minimum the penetration would grow dramatically. A closest point is never "
            "farther than another foot, so the penetration falls instead; what leaps is the foot, "
            "and with it the direction of the force."
        ),
    )


def _sequence_claims(rows: tuple[SequenceRow, ...]) -> tuple[Claim, ...]:
    _, counts, _, released, n_facing_away, *_ = zip(*rows, strict=True)
    return (
        Claim(
            "No contact in the first steps, then two nodes, then a third.",
            counts[:5] == (0, 0, 0, 2, 3),
            f"in contact at t = 0 … 9: {', '.join(map(str, counts))}",
        ),
        Claim(
            "Going back from t = 7, nodes are released.",
            counts[7] < counts[6] and released[7] == counts[6] - counts[7],
            f"{released[7]} released at t = 7",
        ),
        Claim(
            "At t = 6 local and global minimum differ, at t = 7 they are the same again.",
            n_facing_away[6] > 0 and n_facing_away[7] == 0,
            f"{n_facing_away[6]} nodes closest to the other branch at t = 6, "
            f"{n_facing_away[7]} at t = 7",
        ),
    )


def _following_claims(run: SceneRun) -> tuple[Claim, ...]:
    leap, shift, jump = _leaps(run)
    # Largest excess of a followed depth over the depth by the closest point.
    _, closest = _closest(run)
    drop = max(
        float((state.penetration - depth).max())
        for state, depth in zip(run.states, closest, strict=True)
    )
    upwards = all((state.normal[state.in_contact, 1] < 0.0).all() for state in run.states)
    return (
        Claim(
            "Following the local minimum, depth changes by no more than a node moves.",
            leap <= 1.0 + 1e-9 and upwards,
            f"at most {leap:.3f} of the way gone, and no normal turns round",
        ),
        Claim(
            "The followed feet move little; the closest points leap to the other branch, and "
            "the force would turn round.",
            shift < 0.5 < 2.0 < jump and drop > 0.1,
            f"a foot moves by at most {shift:.2f} of the way its node goes, a closest point by "
            f"{jump:.1f} of it; by the closest point a node would be {drop:.3f} less deep",
        ),
    )


def _draw_sequence(figure: Figure, steps: tuple[int, ...]) -> None:
    run = run_scene("curve_sequence")
    closest, _ = _closest(run)
    curve = run.patches[0].isocurve(v=0.0)
    plots = figure.subplots(3, 2).flat
    for axes, k in zip(plots, steps, strict=True):
        _draw_nodes(plane(axes), run, k, curve, closest[k])
    looks = (("o", FREE, "free"), ("o", CONTACT, "in contact, and its foot"),
             ("s", OTHER, "closest point, where it is another"))  # fmt: skip
    for marker, colour, name in looks:
        plots[0].plot([], [], marker, color=colour, label=name)
    figure.legend(*plots[0].get_legend_handles_labels(), ncols=4, loc="outside upper center")


def _draw_nodes(axes: Axes, run: SceneRun, k: int, curve: NurbsCurve, closest: FloatArray) -> None:
    state, points = run.states[k], run.places[k]
    on = state.in_contact
    draw_curve(axes, curve, color=MUTED, label="curve")
    for i in np.flatnonzero(on):
        if np.linalg.norm(closest[i] - state.foot[i]) > 1e-6:
            path = np.array([points[i], closest[i]])[:, :2]
            axes.plot(*path.T, color=OTHER, lw=1.2, ls=(0, (2, 1)))
            axes.plot(*path[1], "s", color=OTHER, ms=3.5)
        axes.plot(*np.array([points[i], state.foot[i]])[:, :2].T, color=CONTACT, lw=1.0)
    axes.plot(*state.foot[on][:, :2].T, "o", ms=3.0, color=CONTACT)
    axes.plot(*points[~on][:, :2].T, "o", color=FREE)
    axes.plot(*points[on][:, :2].T, "o", color=CONTACT)
    axes.set_title(f"t = {k}, {int(on.sum())} in contact")


def _draw_depths(figure: Figure) -> None:
    run = run_scene("curve_sequence")
    _, closest = _closest(run)
    axes = plane(figure.subplots(), equal=False, labels=("t", "depth of the third node"))
    t = np.arange(len(run.states))
    axes.plot(t, [depth[2] for depth in closest], "s--", color=OTHER, label="by the closest point")
    axes.plot(t, [s.penetration[2] for s in run.states], "o-", color=CONTACT, label="followed")
    axes.legend(loc="upper left")


@EXPERIMENTS.add(
    "5.2.3-space",
    "A point into a body: local against global minimum in space",
    "Section 5.2.3, Fig. 5.18",
    "A point goes up through the master surface; of two projections the one with the smaller "
    "shift is taken.",
)
def _space() -> Outcome:
    run = run_scene("point_in_space")
    n_facing_away = _count_facing_away(run)
    _, closest = _closest(run)
    rows = tuple(
        (
            k,
            float(run.places[k][0, 2]),
            float(state.max_penetration),
            float(closest[k][0]),
            "top" if n_facing_away[k] else ("bottom" if state.n_contact else "–"),
        )
        for k, state in enumerate(run.states)
    )
    return Outcome(
        tables=(
            Table(
                "5.2.3 space",
                "The point on its way up.",
                (
                    "t",
                    "z of the point",
                    "depth, followed",
                    "depth, by closest point",
                    "closest side",
                ),
                rows,
            ),
        ),
        pictures=(
            Picture(
                "5.18",
                "A point past the middle of a flat body: the foot before (yellow), the foot that "
                "continues it (red) and the closest point (green), which is on the other side.",
                _draw_space,
                (6.2, 3.0),
            ),
        ),
        claims=_space_claims(run, n_facing_away),
        difference="The body is designed: an ellipsoid with half axes 2, 1.4 and 0.4.",
    )


def _space_claims(run: SceneRun, n_facing_away: list[int]) -> tuple[Claim, ...]:
    leap, _, jump = _leaps(run)
    inside = [k for k, state in enumerate(run.states) if state.n_contact]
    below = all(run.states[k].normal[0, 2] < -0.9 for k in inside)
    x, y, z = np.array([run.states[k].foot[0] for k in inside]).T
    on = float(np.abs((x / 2.0) ** 2 + (y / 1.4) ** 2 + (z / 0.4) ** 2 - 1.0).max())
    first = n_facing_away.index(1)
    return (
        Claim(
            "The foot stays on the side the point came in by, when the closest point no "
            "longer does.",
            below and first > inside[0] and all(n_facing_away[first:]),
            f"in contact from t = {inside[0]}, closest to the top from t = {first}",
        ),
        Claim(
            "Its depth changes by no more than the point moves.",
            leap <= 1.0 + 1e-9,
            f"at most {leap:.3f} of the way; its closest point moves by up to {jump:.1f} of it",
        ),
        Claim("The feet are on the ellipsoid.", on <= 1e-12, f"within {on:.1e}"),
    )


def _draw_space(figure: Figure) -> None:
    run = run_scene("point_in_space")
    k = _count_facing_away(run).index(1) + 1
    state, point = run.states[k], run.places[k][0]
    before, foot = run.states[k - 1].foot[0], state.foot[0]
    closest = run.body.project(point[None]).point[0]
    scene = np.vstack([run.patches[0].control_points.reshape(-1, 3), run.places[0]])
    view = View(figure.subplots(), scene, towards=(-0.2, 0.95, 0.16), shape=(900, 400))
    view.surface(run.body, "#cfd8e2", 0.6, hides=False)
    view.lines([run.places[0][0], point], color=FREE, lw=1.0)
    view.lines([point, foot], color=CONTACT, ls="--", lw=1.4)
    view.lines([point, closest], color=OTHER, ls="--", lw=1.4)
    view.lines([before, foot], color=LINES[4], lw=3.0)
    for at, colour, name in (
        (before, LINES[4], "foot before"),
        (point, FREE, "point"),
        (foot, CONTACT, "foot"),
        (closest, OTHER, "closest point"),
    ):
        view.dots(at, color=colour, ms=6.0, label=name)
    view.show()
    figure.legend(loc="upper center", ncols=4, handletextpad=0.2)
