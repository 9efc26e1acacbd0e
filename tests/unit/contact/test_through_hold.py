"""Points that tunnelled are held by the wall they came in by, where they are to be."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from tests.sample import full
from tests.scenes import box

import contiga as cg
from contiga.errors import InputError
from contiga.records import ContactStatus as Is

UNIT = cg.PenaltyLaw(1.0)
THICK = 0.02
FLAGGED = (Is.LOST, Is.FOUND, Is.REACQUIRED)
Master = cg.Body | cg.TriMesh


@cache
def _master(name: str) -> Master:
    """The plate's top and the sheet's upper face lie in z = 0."""
    if name == "plate":
        return box((0.0, 0.0, -THICK), (1.0, 1.0, 0.0))
    if name == "plate of triangles":
        return box((0.0, 0.0, -THICK), (1.0, 1.0, 0.0)).tessellate(0.1)
    if name == "two plates":
        upper, lower = (0.0, 0.0, -THICK), (0.0, 0.0, -0.2)
        patches = [*box(upper, (1.0, 1.0, 0.0)).patches, *box(lower, (1.5, 1.0, -0.15)).patches]
        return cg.Body(patches)
    if name == "sheet":
        return cg.Body(box((0.0, 0.0, -THICK), (1.0, 1.0, 0.0)).patches[:2])
    if name == "ball":
        return cg.Body([cg.shapes.sphere()])
    if name == "tablet":
        wall = cg.shapes.cylinder(radius=1.0, height=0.1, centre=(0.0, 0.0, -0.05))
        top = cg.shapes.disc(radius=1.0)
        bottom = cg.shapes.disc(radius=1.0, centre=(0.0, 0.0, -0.1), axis=(0.0, 0.0, -1.0))
        return cg.Body([wall, top, bottom])
    body = cg.Body([cg.shapes.ellipsoid(axes=(2.0, 2.0, 0.25))])
    return body if name == "disc" else body.tessellate(1e-2)


def _contact(master: Master, n: int = 1, **options: object) -> cg.Contact:
    options = {"through": "hold", **options}
    return cg.Contact(master, cg.Slave(np.zeros((n, 3)), area=np.ones(n)), law=UNIT, **options)  # type: ignore[arg-type]


def _walk(name: str, path: np.ndarray, **options: object) -> list[cg.State]:
    """One point along `path` (k, 3)."""
    contact = _contact(_master(name), **options)
    states = [contact.start(path[:1])]
    for point in path[1:]:
        states.append(contact.step(states[-1], point[None, :]))
    return states


def _at(heights: np.ndarray | list[float], x: float = 0.3) -> np.ndarray:
    return np.array([[x, 0.4, z] for z in heights])


def _names(states: list[cg.State]) -> list[str]:
    return [Is(int(state.status[0])).name for state in states]


def test_the_bodies_of_these_tests_are_what_they_say() -> None:
    assert _master("plate").volume() == pytest.approx(THICK, abs=1e-15)  # type: ignore[union-attr]
    assert _master("two plates").volume() == pytest.approx(0.095, abs=1e-15)  # type: ignore[union-attr]
    assert _master("tablet").volume() == pytest.approx(0.1 * np.pi, abs=1e-3)  # type: ignore[union-attr]
    closed = {name: _master(name).closed for name in ("plate", "tablet", "disc", "sheet")}
    assert closed == {"plate": True, "tablet": True, "disc": True, "sheet": False}


@pytest.mark.parametrize("length", [0.003, 0.01, 0.05, 1.0])
@pytest.mark.parametrize("name", ["plate", "plate of triangles", "sheet"])
def test_it_is_pushed_back_to_where_it_came_from_until_it_is_there(
    name: str, length: float
) -> None:
    deepest = -max(0.1003, 0.9 * length)
    down = np.append(np.arange(0.0053, deepest, -length), deepest)
    heights = np.append(down, np.append(np.arange(deepest + length, 0.0, length), [0.0047, 0.1]))
    states = _walk(name, _at(heights))
    for state, z in zip(states, heights, strict=True):
        inside = -THICK < z < 0.0 or (name == "sheet" and z < 0.0)
        assert state.in_contact[0] == (z < 0.0)
        assert (state.status[0] == Is.THROUGH) == (z < 0.0 and not inside)
        np.testing.assert_allclose(state.force, [[0.0, 0.0, max(-z, 0.0)]], rtol=0, atol=1e-15)
        np.testing.assert_array_equal(state.normal, [[0.0, 0.0, 1.0 if z < 0.0 else 0.0]])
    assert _names(states)[-2:] == ["RELEASED", "FREE"]


def test_back_over_the_whole_plate_in_one_step_is_back() -> None:
    """Going up, the path comes in from below and leaves by the wall that held it."""
    states = _walk("plate", _at([0.1, -0.3, 0.1, -0.01, 0.1]))
    assert _names(states) == ["FREE", "THROUGH", "RELEASED", "NEW", "RELEASED"]
    # And on: out by the wall that held it, and through another.
    stack = _walk("two plates", np.array([[0.3, 0.4, -0.01], [0.3, 0.4, 0.1]]) - [0.0, 0.0, 0.06])
    assert _names(stack) == ["FREE", "THROUGH"]
    assert stack[1].normal[0].tolist() == [0.0, 0.0, -1.0]
    assert stack[1].penetration[0] == pytest.approx(0.06, abs=1e-15)


def test_from_below_it_is_held_below() -> None:
    states = _walk("plate", _at([-0.1, 0.05, -0.01, -0.1]))
    assert _names(states) == ["FREE", "THROUGH", "OLD", "RELEASED"]
    assert [state.force[0, 2] for state in states] == pytest.approx([0.0, -0.07, -0.01, 0.0])


def test_the_first_of_several_walls_holds_it() -> None:
    states = _walk("two plates", _at([0.1, -0.1, -0.18, -0.5, 0.1]))
    assert _names(states) == ["FREE", "THROUGH", "OLD", "THROUGH", "RELEASED"]
    assert [state.penetration[0] for state in states] == pytest.approx([0.0, 0.1, 0.18, 0.5, 0.0])


def test_out_of_one_plate_and_right_through_the_next_in_one_step() -> None:
    """A point in contact with the lower plate's top goes up, through the upper plate."""
    states = _walk("two plates", _at([-0.1, -0.16, 0.05]))
    assert _names(states) == ["FREE", "NEW", "THROUGH"]
    assert states[1].normal[0, 2] == 1.0
    assert states[2].normal[0, 2] == -1.0
    assert states[2].penetration[0] == pytest.approx(0.05 + THICK, abs=1e-15)


@pytest.mark.parametrize("steps", [1, 40])
@pytest.mark.parametrize("name", ["plate", "plate of triangles", "sheet"])
def test_beside_the_wall_it_is_let_go(name: str, steps: int) -> None:
    """A point held below goes out beside the plate, and up past it."""
    corners = np.array([[0.7, 0.4, 0.1], [0.7, 0.4, -0.1], [1.2, 0.4, -0.1], [1.2, 0.4, 0.1]])
    s = np.arange(1, steps + 1)[:, None] / steps
    path = np.concatenate((corners[:1], *(a + (b - a) * s for a, b in pairwise(corners))))
    states = _walk(name, path)
    for state, (x, _, z) in zip(states, path, strict=True):
        if abs(x - 1.0) < 1e-9 or abs(z) < 1e-9:
            continue
        assert state.in_contact[0] == (z < 0.0 and x < 1.0)
        assert state.max_penetration == pytest.approx(-z if z < 0.0 and x < 1.0 else 0.0)
    assert {Is.RELEASED, Is.SLID_OFF} & {Is(int(state.status[0])) for state in states}


def test_a_corner_that_is_cut_holds_nothing() -> None:
    """In by a side face, out by the top: on the free side of what it came in by, at the end."""
    states = _walk("plate", np.array([[1.1, 0.4, -0.015], [0.8, 0.4, 0.03], [0.8, 0.4, -0.5]]))
    assert _names(states) == ["FREE", "FREE", "THROUGH"]


def test_past_a_corner_of_one_plate_and_right_through_the_next() -> None:
    """In by the upper plate's top and out by its side, where the top lets go of it."""
    states = _walk("two plates", np.array([[0.94, 0.4, 0.05], [1.29, 0.4, -0.3]]))
    assert _names(states) == ["FREE", "THROUGH"]
    assert states[1].penetration[0] == pytest.approx(0.15, abs=1e-15)
    np.testing.assert_allclose(states[1].foot, [[1.29, 0.4, -0.15]], rtol=0, atol=1e-15)


def test_round_bodies_let_go_where_the_point_comes_out() -> None:
    """The foot goes round with the point: there is no wall that it is behind for ever."""
    path = np.array([[0.3, 0.0, z] for z in np.linspace(1.1, -1.1, 201)])
    states = _walk("ball", path)
    distance = np.sqrt(np.square(path).sum(axis=1))
    assert [bool(state.in_contact[0]) for state in states] == (distance < 1.0).tolist()
    depth = [state.max_penetration for state in states]
    np.testing.assert_allclose(depth, np.maximum(1.0 - distance, 0.0), rtol=0, atol=1e-12)
    assert np.abs(np.diff(depth)).max() < 0.012
    one = _walk("ball", path[[0, -1]])
    assert _names(one) == ["FREE", "FREE"]


@pytest.mark.parametrize("length", [0.04, 0.5])
def test_a_flat_cylinder_holds_by_its_end(length: float) -> None:
    heights = np.append(np.arange(0.03, -0.5, -length), [-0.25, 0.01])
    states = _walk("tablet", _at(heights))
    depth = [state.max_penetration for state in states]
    np.testing.assert_allclose(depth, np.maximum(-heights, 0.0), rtol=0, atol=1e-14)
    assert "THROUGH" in _names(states)
    assert _names(states)[-1] == "RELEASED"


def test_without_being_asked_nothing_is_held() -> None:
    path = _at([0.1, -0.01, -0.3, 0.1, -0.3, -0.01])
    plain, asked = (_walk("plate", path, **own) for own in ({"through": "release"}, {}))
    assert _names(plain) == ["FREE", "NEW", "RELEASED", "FREE", "FREE", "NEW"]
    assert _names(asked) == ["FREE", "NEW", "THROUGH", "RELEASED", "THROUGH", "OLD"]
    contact = cg.Contact(_master("plate"), cg.Slave(path[:1], area=[1.0]), law=UNIT)
    assert contact.through == "release"


def test_what_lies_inside_since_the_start_may_leave() -> None:
    states = _walk("plate", _at([-0.01, -0.3, 0.1, -0.3]))
    assert _names(states) == ["FREE", "FREE", "THROUGH", "RELEASED"]


@pytest.mark.parametrize(
    "name",
    ["plate", "plate of triangles", "sheet", "ball", "tablet", *full("two plates", "disc")],
)
def test_one_long_step_is_many_short_ones(name: str) -> None:
    """Random walks through and about: where no foot was lost on the way, the ends are the same."""
    master = _master(name)
    (low, high), size = master.bounds(), master.size
    rng = np.random.default_rng(3)
    points = rng.uniform(low - 0.15 * size, high + 0.15 * size, (200, 3))
    if master.closed:
        points = points[~master.contains(points)]
    contact = _contact(master, len(points))
    state = contact.start(points)
    compared = touched = 0
    for _ in range(4):
        end = points + rng.normal(0.0, 0.15 * size, points.shape)
        long = contact.step(state, end)
        flagged = np.zeros(len(points), dtype=bool)
        for s in np.linspace(0.0, 1.0, 61)[1:]:
            state = contact.step(state, points + s * (end - points) if s < 1.0 else end)
            flagged |= np.isin(state.status, FLAGGED)
        clear = ~flagged
        np.testing.assert_array_equal(long.in_contact[clear], state.in_contact[clear])
        np.testing.assert_allclose(
            long.penetration[clear], state.penetration[clear], rtol=0, atol=1e-9 * size
        )
        if master.closed:
            out = ~np.asarray(master.contains(end))
            np.testing.assert_array_equal(
                (state.status == Is.THROUGH)[clear], (state.in_contact & out)[clear]
            )
            assert state.in_contact[~out].all()
        compared += int(clear.sum())
        touched += int(state.n_contact)
        points = end
    assert compared > 500
    assert touched > 20


@pytest.mark.parametrize(("through", "comes_back"), [("hold", True), ("release", False)])
def test_a_mass_thrown_at_a_thin_plate(through: str, comes_back: bool) -> None:
    """It goes 0.1 a step, five times the plate; the spring would stop it 0.1 below the top."""
    mass, dt, spring = 1.0, 0.1, cg.PenaltyLaw(100.0)
    slave = cg.Slave([[0.3, 0.4, 0.055]], area=[1.0])
    contact = cg.Contact(_master("plate"), slave, law=spring, through=through)
    place, speed = slave.points.copy(), np.array([[0.0, 0.0, -1.0]])
    state = contact.start(place)
    for _ in range(12):
        speed = speed + dt * state.force / mass
        place = place + dt * speed
        state = contact.step(state, place, dt=dt)
    assert (place[0, 2] > 0.1) == comes_back
    assert speed[0, 2] == pytest.approx(1.0 if comes_back else -1.0, abs=0.5)


def test_a_search_by_penetration_cannot_hold() -> None:
    with pytest.raises(InputError, match="does not know where points enter") as error:
        _contact(_master("plate"), search="penetration")
    assert error.value.where == "through"
    with pytest.raises(InputError, match="unknown through") as error:
        _contact(_master("plate"), through="keep")
    assert error.value.allowed == "'release', 'hold'"
