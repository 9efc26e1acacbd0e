"""Pieces of a body that touch, cross or lie within one another, or do not."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import GeometryError

MOVED = cg.motion.pose.compose(
    cg.motion.pose.translation([300.0, -20.0, 7.0]),
    cg.motion.pose.rotation([1.0, 2.0, -0.5], 0.7, [0.0, 0.0, 0.0]),
)


def box(low: tuple[float, ...], high: tuple[float, ...]) -> list[cg.NurbsSurface]:
    """Six rectangles, outward."""
    return [_side(np.array([low, high], float), k, top) for k in range(3) for top in (0, 1)]


def _side(corner: np.ndarray, axis: int, top: int) -> cg.NurbsSurface:
    i, j = (axis + 1) % 3, (axis + 2) % 3

    def at(p: int, q: int) -> np.ndarray:
        x = np.empty(3)
        x[axis], x[i], x[j] = corner[top, axis], corner[p, i], corner[q, j]
        return x

    patch = cg.shapes.bilinear(at(0, 0), at(1, 0), at(0, 1), at(1, 1))
    return patch if top else patch.flipped()


def rod(radius: float, low: float, high: float) -> list[cg.NurbsSurface]:
    """A round bar along z."""
    wall = cg.shapes.cylinder(radius=radius, height=high - low, centre=(0, 0, 0.5 * (low + high)))
    top = cg.shapes.disc(radius=radius, centre=(0.0, 0.0, high))
    return [wall, top, cg.shapes.disc(radius=radius, centre=(0.0, 0.0, low)).flipped()]


def ball(radius: float, *centre: float) -> list[cg.NurbsSurface]:
    return [cg.shapes.sphere(radius=radius, centre=centre or (0.0, 0.0, 0.0))]


def cavity(patches: list[cg.NurbsSurface]) -> list[cg.NurbsSurface]:
    return [patch.flipped() for patch in patches]


UNIT = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
APART = {
    "boxes of boxes overlap": ball(1.0) + ball(1.0, 1.5, 1.5, 0.0),
    "balls that touch in a point": ball(1.0) + ball(1.0, 2.0, 0.0, 0.0),
    "edge to edge": box(*UNIT) + box((1, 1, 0), (2, 2, 1)),
    "corner to corner": box(*UNIT) + box((1, 1, 1), (2, 2, 2)),
    "a ball on a box": box(*UNIT) + ball(0.4, 0.5, 0.5, 1.4),
    "a cavity": ball(3.0) + cavity(ball(1.0, 0.5, 0.0, 0.0)),
    "a ball in a cavity": ball(3.0) + cavity(ball(2.0)) + ball(1.9),
    "a pin with play": rod(3.0, 0, 2) + cavity(rod(1.001, 0.5, 1.5)) + rod(1.0, 0.501, 1.499),
}
MEET = {
    "balls that cross": (ball(1.0) + ball(1.0, 1.5, 0.3, 0.0), "overlap"),
    "balls that hardly cross": (ball(1.0) + ball(1.0, 1.998, 0.0, 0.0), "overlap"),
    "a ball in a ball": (ball(3.0) + ball(1.0, 0.5, 0.0, 0.0), "overlap"),
    "boxes face to face": (box(*UNIT) + box((1, 0.2, 0), (2, 0.7, 1)), "coincide"),
    "a corner in a box": (box(*UNIT) + box((0.99, 0.99, 0.99), (2, 2, 2)), "overlap"),
    "the same twice": (box(*UNIT) + box(*UNIT), "coincide"),
    "a pin without play": (
        rod(3.0, 0, 2) + cavity(rod(1.0, 0.5, 1.5)) + rod(1.0, 0.7, 1.3),
        "coincide",
    ),
    "a cavity that leaves its ball": (ball(2.0) + cavity(ball(1.0, 1.5, 0.0, 0.0)), "overlap"),
}


@pytest.mark.parametrize("factor", [1.0, 1e-5])
@pytest.mark.parametrize("name", APART)
def test_pieces_that_are_apart_or_meet_in_a_line_are_closed(name: str, factor: float) -> None:
    body = cg.Body(APART[name]).scaled(factor).transformed(MOVED)
    assert (body.closed, body.flaws) == (True, [])


@pytest.mark.parametrize("name", MEET)
@pytest.mark.parametrize("moved", [False, True])
def test_pieces_that_meet_are_told_with_the_place_and_are_not_closed(
    name: str, moved: bool
) -> None:
    patches, how = MEET[name]
    body = cg.Body(patches)
    if moved:
        body = body.transformed(MOVED)
    assert not body.closed
    (flaw,) = body.flaws
    assert flaw.startswith("pieces that touch or overlap: patches ")
    meeting = body.openings.meetings[0]
    assert f" {how} at " in flaw
    assert meeting.overlap == (how == "overlap")
    # It lies on the first of the two faces.
    alone = cg.Body([body.patches[meeting.patches[0]]])
    assert abs(alone.project([meeting.point]).gap[0]) < 1e-9 * body.size
    with pytest.raises(GeometryError, match="touch or overlap"):
        body.mass_properties(1.0)
