"""The wall that pushes a point inside of a closed body, and what gives way on open ones."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.errors import InputError
from contiga.records import ContactStatus as Is

POSE = cg.motion.pose.translation
UNIT = cg.PenaltyLaw(1.0)


def contact_of(master: cg.Body | cg.TriMesh, n: int = 1, **options: object) -> cg.Contact:
    slave = cg.Slave(np.zeros((n, 3)), area=np.ones(n))
    return cg.Contact(master, slave, law=UNIT, **options)  # type: ignore[arg-type]


def gone(master: cg.Body | cg.TriMesh, way: np.ndarray, **options: object) -> list[cg.State]:
    """The states of a point that goes `way` (k, 3)."""
    contact = contact_of(master, **options)
    states = [contact.start(way[:1])]
    for point in way[1:]:
        states.append(contact.step(states[-1], point[None]))
    return states


def along(*corners: list[float], steps: int = 50) -> np.ndarray:
    """Places on the way from corner to corner."""
    share = np.linspace(0.0, 1.0, steps + 1)[1:, None]
    ends = np.array(corners)
    return np.concatenate([ends[:1], *(a + share * (b - a) for a, b in pairwise(ends))])


@pytest.mark.parametrize("kind", ["patches", "triangles"])
@pytest.mark.parametrize("depth", [0.3, 0.5, 0.9])
def test_a_point_deep_in_a_plate_never_leaves_by_the_other_side(kind: str, depth: float) -> None:
    plate: cg.Body | cg.TriMesh = box((0.0, 0.0, 0.0), (10.0, 10.0, 1.0))
    plate = plate if kind == "patches" else plate.tessellate(0.1)
    way = along([5.0, 5.3, 1.2], [5.0, 5.3, 1.0 - depth], [10.05, 5.3, 1.0 - depth])
    states = gone(plate, way)
    actual = np.array([state.penetration[0] for state in states])
    normals = np.array([state.normal_B[0] for state in states])
    inside = (way[:, 2] < 1.0) & (way[:, 0] < 10.0)
    wanted = np.where(inside, np.minimum(1.0 - way[:, 2], 10.0 - way[:, 0]), 0.0)
    np.testing.assert_allclose(actual, np.maximum(wanted, 0.0), rtol=0, atol=1e-12)
    assert (normals[:, 2] >= 0.0).all()
    assert all(state.n_unproved == 0 for state in states)


def test_the_guard_is_kept_while_the_nearest_wall_is_opposite() -> None:
    plate = box((0.0, 0.0, 0.0), (10.0, 10.0, 1.0))
    states = gone(
        plate, along([5, 5, 1.2], [5, 5, 0.7], [5, 5, 0.2], [9.9, 5, 0.2], [9.9, 5, 0.6], steps=20)
    )
    guards = [state.guard_B[0].tolist() for state in states]
    assert guards[20] == [0, 0, 0]  # the top is the nearest
    assert guards[40] == guards[50] == [0, 0, 1]
    assert states[50].penetration[0] == pytest.approx(0.8)
    assert guards[80] == [0, 0, 0]  # by the end
    assert states[80].penetration[0] == pytest.approx(0.1)


@pytest.mark.parametrize("steps", [1, 3, 40])
def test_a_long_step_ends_where_short_ones_do(steps: int) -> None:
    # In by the front, over the bottom, to the rear, which is opposite to the front.
    block = box((0.0, 0.0, 0.0), (40.0, 40.0, 20.0))
    state = gone(block, along([-1.0, 21.3, 2.0], [39.2, 21.3, 2.0], steps=steps))[-1]
    assert state.penetration[0] == pytest.approx(0.8)
    np.testing.assert_allclose(state.normal_B[0], [1, 0, 0], rtol=0, atol=1e-12)


@pytest.mark.full
def test_without_another_wall_the_opposite_one_takes_over_and_says_so() -> None:
    # Past the middle of a flat ellipsoid and on to its rim, where no foot is left above.
    disc = cg.Body([cg.shapes.ellipsoid(axes=(5.0, 5.0, 0.5))])
    way = along([0.0, 0.0, 0.6], [0.0, 0.0, -0.2], [4.95, 0.3, -0.02], steps=400)
    states = gone(disc, way)
    assert states[400].penetration[0] == pytest.approx(0.7)
    assert [int(state.status[0]) for state in states].count(Is.REACQUIRED) == 1
    assert states[-1].penetration[0] == pytest.approx(-disc.project(way[-1:]).gap[0])
    # But for that, depth goes on: the underside does not take over where it is no more opposite.
    depth = np.array([state.penetration[0] for state in states])
    jumps = np.abs(np.diff(depth)) > np.linalg.norm(np.diff(way, axis=0), axis=1) + 1e-9
    assert jumps.sum() == 1


def test_out_by_one_wall_and_in_by_the_opposite_one_is_new() -> None:
    slot = cg.Body([*box((0, 0, 0), (9, 9, 1)).patches, *box((0, 0, 2), (9, 9, 3)).patches])
    states = gone(slot, np.array([[4.5, 4.5, -0.1], [4.5, 4.5, 0.9], [4.5, 4.5, 2.2]]))
    assert [state.status[0] for state in states] == [Is.FREE, Is.NEW, Is.NEW]
    np.testing.assert_allclose(states[1].normal_B[0], [0, 0, -1], rtol=0, atol=1e-12)
    assert states[1].penetration[0] == pytest.approx(0.9)
    np.testing.assert_allclose(states[2].normal_B[0], [0, 0, -1], rtol=0, atol=1e-12)
    assert states[2].penetration[0] == pytest.approx(0.2)


@pytest.mark.parametrize("search", ["intersection", "penetration"])
@pytest.mark.parametrize("kind", ["closed", "open", "triangles", "open triangles"])
def test_a_block_is_not_pushed_back_by_what_its_front_has_run_over(kind: str, search: str) -> None:
    block: cg.Body | cg.TriMesh = box((-20.0, -20.0, 0.0), (20.0, 20.0, 20.0))
    if "open" in kind:  # without its top
        lids = [patch.evaluate([[0.5, 0.5]])[0, 2] > 19.0 for patch in block.patches]
        block = cg.Body([p for p, lid in zip(block.patches, lids, strict=True) if not lid])
    block = block.tessellate(1.0) if "triangles" in kind else block
    x, y = np.meshgrid(np.arange(-29.0, 40.0, 2.0), np.arange(-17.0, 18.0, 4.0))
    bed = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    contact = cg.Contact(block, cg.Slave(bed, area=np.ones(len(bed))), law=UNIT, search=search)
    state = contact.start(bed, POSE([0.0, 0.0, 0.5]))
    for d in np.linspace(0.0, 12.5, 26):
        state = contact.step(state, bed, POSE([d, 0.0, -0.2]))
    under = int((np.abs(x - 12.5) < 20.0).sum())
    np.testing.assert_allclose(state.total_force, [0, 0, -0.2 * under], rtol=0, atol=1e-9)
    assert state.max_penetration == pytest.approx(0.2)


def test_a_followed_foot_does_not_give_way_to_a_sheet_that_was_nearer_before() -> None:
    # Down through the upper of two joined sheets, and through the lower one.
    corners = np.array([[0, 2], [4, 2], [4, 0], [0, 0]], dtype=float)
    outline = cg.NurbsCurve(1, [0, 0, 1, 2, 3, 3], np.column_stack([corners, np.zeros(4)]))
    shell = cg.Body.from_profile(outline).flipped()
    states = gone(shell, along([1.0, 2.1, 0.0], [1.0, -0.3, 0.0], steps=24))
    depth = np.array([state.penetration[0] for state in states])
    step = 2.4 / 24
    assert (np.abs(np.diff(depth)) <= step + 1e-12).all()
    assert depth[-1] == pytest.approx(2.3)


def test_states_made_by_hand_keep_their_guards() -> None:
    plate = box((0.0, 0.0, 0.0), (10.0, 10.0, 1.0))
    contact = contact_of(plate, 2)
    way = np.array([[5.0, 5.0, 1.2], [5.0, 5.0, 0.4], [5.0, 5.0, 0.2]])
    state = contact.start(np.stack([way[0], way[0]]))
    for point in way[1:]:
        state = contact.step(state, np.stack([point, way[0]]))
    again = cg.State(**state.arrays, of=contact)
    end = np.array([[5.1, 5.0, 0.1], [5.0, 5.0, 1.1]])
    for one in (state, again):
        assert contact.step(one, end).penetration.tolist() == pytest.approx([0.9, 0.0])
    assert contact.step(state, end).guard_B.tolist() == contact.step(again, end).guard_B.tolist()


def test_an_unknown_foot_is_refused() -> None:
    with pytest.raises(InputError, match="foot"):
        contact_of(box((0, 0, 0), (1, 1, 1)), foot="closest")
