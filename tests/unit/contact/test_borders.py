"""Points that slide over borders and into trimmed holes: SLID_OFF and HELD."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import contiga as cg
from contiga.records import ContactStatus as Is

HALF = 0.5


def _slide(master: cg.Body, path: list[list[float]], **options: str) -> list[cg.State]:
    cloud = cg.Slave([path[0]], area=[1.0])
    contact = cg.Contact(master, cloud, law=cg.PenaltyLaw(1.0), **options)  # type: ignore[arg-type]
    states = [contact.start([path[0]])]
    for point in path[1:]:
        states.append(contact.step(states[-1], [point]))
    return states


@pytest.fixture(scope="module")
def plane() -> cg.Body:
    return cg.Body([cg.shapes.plane(width=2 * HALF, length=2 * HALF)])


@pytest.fixture(scope="module")
def holed() -> cg.Body:
    """A square with a round hole of radius 0.2 in the middle."""
    patch = cg.shapes.plane(width=2 * HALF, length=2 * HALF)
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
    pairs = pairwise(corners)
    outer = [cg.shapes.line((*a, 0.0), (*b, 0.0)) for a, b in pairs]
    hole = [cg.shapes.circle(radius=0.2, centre=(0.5, 0.5, 0.0)).reversed()]
    return cg.Body([patch], trims=[[outer, hole]])


SIDEWAYS = [[x, 0.31, -0.1 if x > 0 else 0.1] for x in (0.0, 0.1, 0.3, 0.45, 0.55, 0.7)]


def test_a_point_slides_off_over_a_border(plane: cg.Body) -> None:
    states = _slide(plane, SIDEWAYS)
    statuses = [state.status[0] for state in states]
    assert statuses == [Is.FREE, Is.NEW, Is.OLD, Is.OLD, Is.SLID_OFF, Is.FREE]
    assert not states[4].force.any()
    assert not states[5].force.any()


def test_a_held_point_stays_at_the_closest_point_of_the_border(plane: cg.Body) -> None:
    states = _slide(plane, SIDEWAYS, on_edge="hold")
    statuses = [state.status[0] for state in states]
    assert statuses == [Is.FREE, Is.NEW, Is.OLD, Is.OLD, Is.HELD, Is.HELD]
    for state in states[4:]:
        np.testing.assert_allclose(state.foot, [[HALF, 0.31, 0.0]], rtol=0, atol=1e-14)
        np.testing.assert_allclose(state.normal, [[0.0, 0.0, 1.0]], rtol=0, atol=1e-14)
        assert state.penetration[0] == pytest.approx(0.1, abs=1e-14)
        assert state.in_contact[0]


def test_a_held_point_comes_back_to_the_face_and_is_released_at_its_free_side(
    plane: cg.Body,
) -> None:
    path = [*SIDEWAYS, [0.4, 0.31, -0.1], [0.55, 0.31, -0.05], [0.55, 0.31, 0.05]]
    states = _slide(plane, path, on_edge="hold")
    assert [state.status[0] for state in states[-3:]] == [Is.OLD, Is.HELD, Is.RELEASED]


def test_a_point_that_enters_past_the_border_is_held_or_left(plane: cg.Body) -> None:
    # It crosses the surface inside its border; its foot at the end of the step is outside.
    path = [[0.4, 0.0, 0.1], [0.6, 0.0, -0.1]]
    assert _slide(plane, path)[1].status[0] == Is.FREE
    held = _slide(plane, path, on_edge="hold")[1]
    assert held.status[0] == Is.HELD
    assert held.penetration[0] == pytest.approx(0.1, abs=1e-14)


def test_a_point_beside_the_surface_never_enters(plane: cg.Body) -> None:
    for on_edge in ("release", "hold"):
        states = _slide(
            plane, [[0.51, 0.0, 0.1], [0.51, 0.0, -0.1], [0.3, 0.0, -0.1]], on_edge=on_edge
        )
        assert [state.n_contact for state in states] == [0, 0, 0]


def test_a_point_over_a_trimmed_hole_goes_through(holed: cg.Body) -> None:
    states = _slide(holed, [[0.05, 0.0, 0.1], [0.05, 0.0, -0.1], [0.05, 0.0, -0.3]])
    assert [state.n_contact for state in states] == [0, 0, 0]


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.234, 2.0, 3.7, 5.5])
def test_a_point_slides_off_into_a_trimmed_hole(holed: cg.Body, angle: float) -> None:
    d = np.array([np.cos(angle), np.sin(angle), 0.0])
    radii = [0.4, 0.4, 0.25, 0.2001, 0.1999, 0.1]
    heights = [0.05] + 5 * [-0.05]
    path = [(r * d + [0.0, 0.0, h]).tolist() for r, h in zip(radii, heights, strict=True)]
    statuses = [state.status[0] for state in _slide(holed, path)]
    assert statuses == [Is.FREE, Is.NEW, Is.OLD, Is.OLD, Is.SLID_OFF, Is.FREE]


def test_a_point_is_held_at_the_rim_of_a_hole(holed: cg.Body) -> None:
    path = [[0.4, 0.0, 0.05], [0.3, 0.0, -0.05], [0.12, 0.0, -0.05], [0.12, 0.06, -0.05]]
    states = _slide(holed, path, on_edge="hold")
    assert [state.status[0] for state in states] == [Is.FREE, Is.NEW, Is.HELD, Is.HELD]
    np.testing.assert_allclose(states[2].foot, [[0.2, 0.0, 0.0]], rtol=0, atol=1e-9)
    rim = 0.2 * np.array([0.12, 0.06, 0.0]) / np.hypot(0.12, 0.06)
    np.testing.assert_allclose(states[3].foot, [rim], rtol=0, atol=1e-9)
    assert states[3].penetration[0] == pytest.approx(0.05, abs=1e-12)


def test_a_point_passes_between_joined_patches_without_leaving() -> None:
    left, right = cg.shapes.plane(width=4.0, length=2.0).split(u=0.5)
    body = cg.Body([left, right])
    path = [[-1.0, 0.1, 0.1], *([x, 0.1, -0.1] for x in (-0.9, -0.3, 0.2, -0.01, 0.01, 1.0))]
    states = _slide(body, path)
    assert [state.status[0] for state in states[1:]] == [Is.NEW] + 5 * [Is.OLD]
    assert [state.patch[0] for state in states[1:]] == [0, 0, 1, 0, 1, 1]
    np.testing.assert_allclose([s.penetration[0] for s in states[1:]], 0.1, rtol=0, atol=1e-14)
