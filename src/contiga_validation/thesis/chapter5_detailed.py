"""Sections 5.2.3 and 5.3: clouds through a flat and a bumpy master, borders, sideways sliding."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contiga import ContactStatus, State
from contiga.report.view import View
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, plane
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.play import SceneRun, run_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

CONTACT, FREE, BEYOND = LINES[1], LINES[0], "#9aa3ad"
TABLE_5_1 = (20, 60, 80, 100, 100, 100, 100, 60, 40)
"""Points in contact at steps 6 to 14, as the thesis counts them."""


def foot_errors(run: SceneRun) -> tuple[float, float]:
    """Return the largest tangential miss of feet and the largest error of penetrations in contact.

    Both are over the size of the master.
    """
    miss = length = 0.0
    for k, state in enumerate(run.states):
        on = state.in_contact
        offset = (state.foot - run.places[k])[on]
        depth = state.penetration[on]
        tangential = offset - (offset * state.normal[on]).sum(axis=1)[:, None] * state.normal[on]
        miss = max(miss, float(np.abs(tangential).max(initial=0.0)))
        length = max(length, float(np.abs(np.linalg.norm(offset, axis=1) - depth).max(initial=0.0)))
    return miss / run.body.size, length / run.body.size


# ---------------------------------------------------------------- flat master (5.2.3)


@EXPERIMENTS.add(
    "5.2.3-flat",
    "A cylinder of points through a flat master",
    "Section 5.2.3, Fig. 5.19, the counts of Table 5.1",
    "No point is in contact up to t = 5; then 20, 60, 80, 100, 100, 100, 100, 60 and 40 are, "
    "at steps 6 to 14. Points that move up again are released.",
)
def _flat() -> Outcome:
    run = run_scene("cylinder_flat")
    counts = [int(n) for n in run.history["n_contact"]]
    miss = 0.0
    for k, state in enumerate(run.states):
        below = np.maximum(-run.places[k][:, 2], 0.0)
        miss = max(miss, float(np.abs(state.penetration - below).max()))
    released = [int((s.status == ContactStatus.RELEASED).sum()) for s in run.states]
    rows = tuple(
        (t, count, counts[t], float(run.states[t].max_penetration), released[t])
        for t, count in enumerate(TABLE_5_1, start=6)
    )
    return Outcome(
        tables=(
            Table(
                "5.1 counts",
                "Points in contact, the first column of Table 5.1.",
                ("t", "thesis", "contiga", "deepest", "released in the step"),
                rows,
            ),
        ),
        pictures=(
            Picture(
                "5.19",
                "A cylinder of points goes down through a flat master (cut off here) and comes "
                "back. Red points are in contact.",
                lambda figure: _panels(figure, "cylinder_flat", (5, 6, 7, 8, 9, 11, 13, 14)),
                (9.0, 4.6),
            ),
        ),
        claims=(
            Claim(
                "Points in contact at steps 6 to 14: 20, 60, 80, 100, 100, 100, 100, 60, 40.",
                tuple(counts[6:15]) == TABLE_5_1 and sum(counts) == sum(TABLE_5_1),
                ", ".join(map(str, counts[6:15])) + ", and none before and after",
            ),
            Claim(
                "Each is as deep as it is below the plane.",
                miss <= 1e-14,
                f"largest difference {miss:.1e}",
            ),
            Claim(
                "Points that move up to the free side are released (Eq. 4.7, Fig. 5.19 h and i).",
                released[13] == 40 and released[14] == 20 and released[15] == 40,
                f"{released[13]}, {released[14]} and {released[15]} at steps 13, 14 and 15",
            ),
        ),
        difference=(
            "The thesis gives the counts but not the cylinder or its path; rows of twenty points "
            "and a path that lets as many through are chosen here. Areas and forces of the same "
            "scene are under 5.4."
        ),
    )


# ---------------------------------------------------------------- bumpy master (5.3)


def _beyond(points: FloatArray) -> NDArray[np.bool_]:
    """Return a mask (n,) of the points that are not over the master 0 ≤ x ≤ 4, 0 ≤ y ≤ 3."""
    x, y, _ = points.T
    return np.asarray((x < 0.0) | (x > 4.0) | (y < 0.0) | (y > 3.0))


def _side(state: State) -> NDArray[np.float64]:
    """Return −1 for a foot on the left bump, 1 on the right one, 0 without contact, (n,)."""
    return np.where(state.in_contact, np.sign(state.foot[:, 0] - 2.0), 0.0)


BumpyRow = tuple[int, int, int, int, float, int]
"""Step; points in contact, on the left bump, on the right one; depth; points beyond and low."""


@EXPERIMENTS.add(
    "5.3-bumpy",
    "A bumpy master, and points out of its boundary",
    "Section 5.3, Fig. 5.20",
    "From t = 10 the projections are clearly separate and none shifts from the left to the "
    "right. Some points are outside the boundary, have no projection and are not in contact.",
)
def _bumpy() -> Outcome:
    run = run_scene("out_of_boundary")
    states = run.states
    beyond = [_beyond(run.places[k]) for k in range(len(states))]
    n_beyond_in_contact = sum(
        int((s.in_contact & b).sum()) for s, b in zip(states, beyond, strict=True)
    )
    low = [int((b & (run.places[k][:, 2] < 0.35)).sum()) for k, b in enumerate(beyond)]
    rows = tuple(
        (
            k,
            state.n_contact,
            int((_side(state) < 0.0).sum()),
            int((_side(state) > 0.0).sum()),
            float(state.max_penetration),
            low[k],
        )
        for k, state in enumerate(states)
    )
    return Outcome(
        tables=(
            Table(
                "5.3 bumpy",
                "Points in contact with each bump, and points beyond the ends of the master that "
                "are as low as its bumps.",
                ("t", "in contact", "left bump", "right bump", "deepest", "beyond and low"),
                rows,
            ),
        ),
        pictures=(
            Picture(
                "5.20",
                "The cylinder, longer than the master, goes down between two bumps. Red points "
                "are in contact, grey ones beyond the border: they have no projection.",
                lambda figure: _panels(figure, "out_of_boundary", (4, 6, 8, 9, 10, 11)),
                (9.0, 5.4),
            ),
            Picture(
                "5.20-feet",
                "Feet at the lowest position, seen from above: two groups, one on each bump.",
                _draw_feet,
                (5.6, 3.8),
            ),
        ),
        claims=_bumpy_claims(run, rows, n_beyond_in_contact),
        difference=(
            "The thesis gives the knots and the number of control points of its master, not their "
            "heights; two bumps are designed here."
        ),
    )


def _bumpy_claims(
    run: SceneRun, rows: tuple[BumpyRow, ...], n_beyond_in_contact: int
) -> tuple[Claim, ...]:
    states = run.states
    changed = sum(int((_side(a) * _side(b) < 0.0).sum()) for a, b in pairwise(states))
    miss, length = foot_errors(run)
    peak = int(np.argmax(run.history["n_contact"]))
    _, _, left, right, _, low = rows[peak]
    # Gap in x between the feet on the two bumps.
    x = states[peak].foot[states[peak].in_contact, 0]
    between = float(x[x > 2.0].min() - x[x < 2.0].max())
    return (
        Claim(
            "Points beyond the border have no projection and are never in contact.",
            n_beyond_in_contact == 0 and low > 100,
            f"{n_beyond_in_contact} in contact, of {low} that are low enough at t = {peak}",
        ),
        Claim(
            "The projections fall into two separate groups.",
            min(left, right) > 50 and between > 0.2,
            f"{left} and {right} feet, {between:.2f} apart",
        ),
        Claim(
            "No foot goes over from the left bump to the right one.",
            changed == 0,
            f"{changed} do over {len(states)} steps",
        ),
        Claim(
            "Every foot is orthogonal, and the penetration is its distance.",
            miss <= 1e-11 and length <= 1e-14,
            f"within {miss:.1e} and {length:.1e} of the master's size",
        ),
    )


def _draw_feet(figure: Figure) -> None:
    run = run_scene("out_of_boundary")
    k = int(np.argmax(run.history["n_contact"]))
    state, points = run.states[k], run.places[k]
    axes = plane(figure.subplots())
    axes.add_patch(_frame((0.0, 0.0), 4.0, 3.0))
    free = ~state.in_contact
    beyond = _beyond(points)
    axes.plot(*points[free & beyond, :2].T, ".", color=BEYOND, ms=3.0, label="beyond the border")
    axes.plot(*points[free & ~beyond, :2].T, ".", color=FREE, ms=3.0, label="not in contact")
    axes.plot(*state.foot[~free, :2].T, "o", color=CONTACT, ms=2.6, label="feet")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _frame(corner: tuple[float, float], width: float, height: float) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle(corner, width, height, fc="#eef1f5", ec="#6a737d", lw=1.0, zorder=0)


# ---------------------------------------------------------------- sideways sliding (5.3.1)


@EXPERIMENTS.add(
    "5.3.1-sliding",
    "Sideways sliding over a border",
    "Section 5.3.1, Fig. 5.21",
    "All slave points move north-west. At t = 13 there are 68 in contact; at t = 14 two have "
    "no projection within the master any more and 66 are left.",
)
def _sliding() -> Outcome:
    run = run_scene("sideways_sliding")
    counts = [int(n) for n in run.history["n_contact"]]
    n_slid_off = [int((s.status == ContactStatus.SLID_OFF).sum()) for s in run.states]
    force = run.history["force"]
    rows = tuple((t, counts[t], n_slid_off[t], float(force[t])) for t in range(12, 17))
    return Outcome(
        tables=(
            Table(
                "5.3.1 sliding",
                "Points in contact while they slide north-west.",
                ("t", "in contact", "slid off", "force"),
                rows,
            ),
        ),
        pictures=(
            Picture(
                "5.21",
                "The points from above at t = 13 and t = 14: the two in squares leave the master "
                "over its border.",
                _draw_sliding,
                (8.4, 3.2),
            ),
        ),
        claims=_sliding_claims(counts, force, run),
        difference="The scene is designed: two rows of 34 points over a flat master.",
    )


def _sliding_claims(counts: list[int], force: FloatArray, run: SceneRun) -> tuple[Claim, ...]:
    slid_off = np.flatnonzero(run.states[14].status == ContactStatus.SLID_OFF)
    still = run.places[14][slid_off]
    over = bool((still[:, 0] < -1.0).all() and (still[:, 2] < 0.0).all())
    return (
        Claim(
            "68 points are in contact at t = 13, 66 at t = 14.",
            (counts[13], counts[14]) == (68, 66),
            f"{counts[13]} and {counts[14]}",
        ),
        Claim(
            "The two that leave have slid over the border; they are as deep as before.",
            len(slid_off) == 2 and over,
            f"x = {', '.join(f'{x:.3f}' for x in still[:, 0])}, the border is at −1",
        ),
        Claim(
            "The total force does not depend on how many points carry it (Eq. 3.1).",
            float(np.ptp(force[12:17])) <= 1e-15,
            f"{force[13]:g} before and {force[14]:g} after",
        ),
    )


def _draw_sliding(figure: Figure) -> None:
    run = run_scene("sideways_sliding")
    slid_off = run.states[14].status == ContactStatus.SLID_OFF
    for axes, k in zip(figure.subplots(1, 2), (13, 14), strict=True):
        plane(axes, equal=False)
        axes.set_aspect("equal")
        axes.add_patch(_frame((-1.0, -0.5), 2.0, 1.0))
        points, on = run.places[k], run.states[k].in_contact
        axes.plot(*points[on, :2].T, "o", color=CONTACT, ms=2.6)
        axes.plot(*points[~on, :2].T, "o", color=FREE, ms=2.6)
        axes.plot(*points[slid_off, :2].T, "s", ms=9.0, mfc="none", mec="#21262d", mew=1.0)
        axes.annotate(
            "", (-0.15, 0.4), (0.05, 0.3), arrowprops={"arrowstyle": "-|>", "color": "#21262d"}
        )
        axes.set_title(f"t = {k}, {int(on.sum())} in contact")
        axes.set(xlim=(-1.15, 0.55), ylim=(-0.55, 0.55))


# ---------------------------------------------------------------- pictures in space


def _panels(figure: Figure, name: str, steps: Sequence[int]) -> None:
    """Run the scene `name` and draw it at some steps, in two rows of panels."""
    run = run_scene(name)
    flat = name == "cylinder_flat"
    towards = (-0.5, 0.8, -0.28) if flat else (-0.35, 0.75, -0.55)
    everywhere = [run.places[k] for k in steps]
    mesh = run.body.tessellate(1e-3 * run.body.size)
    scene = np.vstack([(0.62 if flat else 1.0) * mesh.vertices, *everywhere])
    for axes, k in zip(figure.subplots(2, len(steps) // 2).flat, steps, strict=True):
        points, on = run.places[k], run.states[k].in_contact
        view = View(axes, scene, towards=towards, shape=(420, 350))
        view.surface(mesh, "#cfd8e2", 0.75, hides=False)
        beyond = ~on & (_beyond(points) if name == "out_of_boundary" else False)
        size = 1.6 if len(points) > 500 else 2.4
        for part, colour in ((beyond, BEYOND), (~on & ~beyond, FREE), (on, CONTACT)):
            view.dots(points[part], color=colour, ms=size)
        view.show(triad=k == steps[0])
        axes.set_title(f"t = {k}, {int(on.sum())} in contact")
