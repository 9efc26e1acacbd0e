"""Draw the pictures of the page on the search: ``python docs/draw_search.py [FOLDER]``."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import contiga as cg
from contiga.records import ContactStatus

INK, PALE, GOOD, BAD, SKY = "#22303c", "#d8dee4", "#1a7f5a", "#c0392b", "#2c6fbb"


def _section(ax: Axes, outline: np.ndarray) -> None:
    ax.fill(*outline[:, :2].T, facecolor=PALE, edgecolor=INK, linewidth=1.4, zorder=0)
    ax.set_aspect("equal")
    ax.axis("off")


def slotted() -> np.ndarray:
    """Corners of a block with a slot, counter-clockwise, the first one again at the end."""
    corners = [(0, 0), (3, 0), (3, 1.6), (1.7, 1.6), (1.7, 0.5), (1.3, 0.5), (1.3, 1.6), (0, 1.6)]
    return np.array([(*corner, 0.0) for corner in [*corners, corners[0]]], dtype=float)


def crossings(ax: Axes) -> None:
    """Paths through a block with a slot; the crossing that counts is marked."""
    outline = slotted()
    curve = cg.NurbsCurve(1, np.r_[0, np.arange(9), 8].astype(float), outline)
    block = cg.Body.from_profile(curve)
    _section(ax, outline)
    ax.set(xlim=(-0.1, 5.2), ylim=(-0.1, 2.2))
    paths = [
        ("1  from outside: NEW", (0.4, 2.0), (0.4, 1.2)),
        ("2  in and out again: FREE", (0.95, 2.0), (1.42, 1.2)),
        ("3  into the slot: FREE", (1.55, 2.0), (1.55, 1.0)),
        ("4  out of one wall and into the other: NEW", (1.15, 0.85), (2.15, 0.7)),
    ]
    for k, (text, a, b) in enumerate(paths):
        start, end = np.array([[*a, 0.0]]), np.array([[*b, 0.0]])
        contact = cg.Contact(block, cg.Slave(start, area=[1.0]), law=cg.PenaltyLaw(1.0))
        state = contact.step(contact.start(start), end)
        touching = state.status[0] == ContactStatus.NEW
        assert touching == ("NEW" in text), text
        colour = GOOD if touching else SKY
        ax.annotate("", b, a, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.6})
        ax.text(a[0] - 0.04, a[1] + 0.05, text[0], fontsize=9, color=colour)
        ax.text(3.15, 1.5 - 0.2 * k, text, fontsize=9, color=colour)
        if touching:
            foot = state.foot[0]
            ax.plot(*foot[:2], "o", color=GOOD, markersize=5)
            ax.plot([b[0], foot[0]], [b[1], foot[1]], ":", color=GOOD)


def ball(ax: Axes) -> None:
    """The touching ball at a foot, as the tables of the body have it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    axes = (1.6, 0.9)
    body = cg.Body([cg.shapes.ellipsoid(axes=(*axes, 0.9))])
    _section(ax, np.column_stack([axes[0] * np.cos(angle), axes[1] * np.sin(angle)]))

    point = np.array([[0.55, 0.6, 0.0]])
    foot = body.project(point)
    row, inside = np.zeros(1, np.int32), np.zeros(1, np.int8)
    radius = float(body.surface.touching_ball(foot.patch, foot.uv, row, inside)[0])
    centre = foot.point[0] - radius * foot.normal[0]
    ax.add_patch(plt.Circle(centre[:2], radius, facecolor="#2c6fbb22", edgecolor=SKY))
    ax.plot(*point[0, :2], "o", color=INK, markersize=5)
    ax.plot(*foot.point[0, :2], "o", color=GOOD, markersize=5)
    ax.plot(*np.array([foot.point[0], centre])[:, :2].T, "--", color=SKY, linewidth=1)
    ax.text(*(foot.point[0, :2] + [0.06, 0.03]), "foot Q", color=GOOD, fontsize=9)
    ax.text(*(point[0, :2] + [-0.3, 0.0]), "point P", color=INK, fontsize=9)
    ax.text(
        centre[0] - 0.45, centre[1] - 0.4, f"ball of radius ρ = {radius:.2f}", color=SKY, fontsize=9
    )


def branch(ax: Axes) -> None:
    """A point over a trough: its foot is proved until its minimum vanishes at the focal curve."""
    control = np.array([[-1.2, 1.2, 0.0], [0.0, -1.2, 0.0], [1.2, 1.2, 0.0]])
    curve = cg.NurbsCurve(2, [0, 0, 0, 1, 1, 1], control)  # a parabola
    curve = curve.insert_knots(np.linspace(0.0, 1.0, 33)[1:-1])
    trough = cg.Body.from_profile(curve)
    s = np.linspace(0.0, 1.0, 300)
    shown = curve.evaluate(s)
    ax.plot(*shown[:, :2].T, color=INK, linewidth=2)
    d = curve.derivatives(s, 2)
    first, second = d[:, 1], d[:, 2]
    turn = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])[:, None]
    speed = (first**2).sum(axis=1)[:, None]
    normal = np.column_stack([-first[:, 1], first[:, 0]])
    focal = shown[:, :2] + normal * speed / turn
    seen = (focal[:, 1] < 2.2) & (np.abs(focal[:, 0]) < 1.4)
    ax.plot(*focal[seen].T, "--", color=BAD, linewidth=1)
    ax.text(0.25, 1.9, "focal curve", color=BAD, fontsize=9)
    path = np.column_stack([np.linspace(-0.7, 0.75, 30), np.full(30, 1.25), np.zeros(30)])
    feet = trough.project(path[:1])
    for k, point in enumerate(path):
        feet = trough.project(point[None], start=feet, mode="track") if k else feet
        proved = not k or feet.certified[0] == 1
        colour, width = (SKY, 0.6) if proved else (BAD, 1.6)
        ax.plot(*np.array([point, feet.point[0]])[:, :2].T, color=colour, lw=width)
        if not proved:
            at = point
    ax.text(at[0] + 0.1, at[1] + 0.06, "not proved", color=BAD, fontsize=9)
    ax.plot(*path[:, :2].T, ".", color=INK, markersize=3)
    ax.set_aspect("equal")
    ax.axis("off")


def _slide(foot: str, way: np.ndarray, depth: float) -> list[cg.State]:
    """A block of 40 × 20, pressed into a row of points and slid along it."""
    corners = np.array([(-20, 0), (20, 0), (20, 20), (-20, 20), (-20, 0)], dtype=float)
    outline = np.column_stack([corners, np.zeros(5)])
    block = cg.Body.from_profile(cg.NurbsCurve(1, [0, 0, 1, 2, 3, 4, 4], outline))
    row = np.column_stack([np.arange(-29.0, 60.0, 2.0), np.zeros(45), np.zeros(45)])
    law = cg.PenaltyLaw(1.0)
    contact = cg.Contact(block, cg.Slave(row, area=np.ones(45)), law=law, foot=foot)
    move = cg.motion.pose.translation
    state = contact.start(row, move([0.0, 0.5, 0.0]))
    return [state := contact.step(state, row, move([x, -depth, 0.0])) for x in way]


def sharp_edges(ax: Axes) -> None:
    """Forces on a block with sharp edges that slides over points, by two rules."""
    ax.axis("off")
    depth, way = 2.0, np.linspace(0.0, 12.0, 241)
    for k, (foot, colour) in enumerate((("tracked", BAD), ("nearest", GOOD))):
        states = _slide(foot, way, depth)
        last, side = states[-1], ax.inset_axes((0.52 * k, 0.46, 0.48, 0.5))
        side.fill([-8, 32, 32, -8], np.array([0, 0, 9, 9]) - depth, facecolor=PALE, edgecolor=INK)
        touching = last.penetration > 0.0
        points = last.points_B[:, :2] + np.array([way[-1], -depth])
        side.plot(*points.T, ".", color=INK, markersize=4)
        pushed = last.normal_B[:, :2] * last.normal_force[:, None]
        for a, b in zip(points[touching], (points + pushed)[touching], strict=True):
            side.plot([a[0], b[0]], [a[1], b[1]], color=colour, linewidth=1.5)
        title = (
            "the wall it came in by" if foot == "tracked" else "the nearest that is not opposite"
        )
        side.set(xlim=(-10, 46), ylim=(-6, 8), title=f'foot = "{foot}": {title}')
        side.title.set(fontsize=9)
        side.set_aspect("equal")
        side.axis("off")
        force = -np.array([state.total_force for state in states])
        plot = ax.inset_axes((0.08 + 0.5 * k, 0.0, 0.4, 0.42))
        plot.plot(way, force[:, 1], color=SKY, label="up")
        plot.plot(way, force[:, 0], color=colour, label="along its way")
        plot.set(ylim=(-45, 50))
        plot.set_xlabel("way slid, mm", fontsize=9)
        plot.legend(fontsize=8, frameon=False, loc="lower left")
        plot.tick_params(labelsize=8)
        if k == 0:
            plot.set_ylabel("force on the block, N", fontsize=9)


PICTURES = {
    "sharp_edges": sharp_edges,
    "search_crossings": crossings,
    "search_ball": ball,
    "search_branch": branch,
}


def main(folder: Path) -> None:
    """Write the pictures into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in PICTURES.items():
        figure, ax = plt.subplots(figsize=(9.0, 4.4) if name == "sharp_edges" else (7.0, 3.6))
        draw(ax)
        figure.savefig(folder / f"{name}.png", dpi=130, bbox_inches="tight")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images")
