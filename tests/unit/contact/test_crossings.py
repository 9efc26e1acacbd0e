"""Steps that cross the surface: short ones, and long ones that cross it several times.

What is left after the last crossing of a step counts: a point that went out of one wall and into
another is in contact with the other, by the side it came in by.
"""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg

UNIT = cg.PenaltyLaw(1.0)
WIDTH = 0.1
Master = cg.Body | cg.TriMesh


def _prism(corners: dict[str, tuple[float, float]], quads: list[str], outline: str) -> cg.Body:
    """A solid over −0.5 ≤ y ≤ 0.5: quadrilaterals in (x, z) at its ends, walls along `outline`.

    Corners run clockwise as seen from −y towards +y, so that normals point outward.
    """

    def at(name: str, y: float) -> list[float]:
        x, z = corners[name]
        return [x, y, z]

    patches = []
    for a, b, c, d in quads:
        patches.append(cg.shapes.bilinear(*(at(k, -0.5) for k in (a, b, d, c))))
        patches.append(cg.shapes.bilinear(*(at(k, 0.5) for k in (a, d, b, c))))
    for a, b in zip(outline, outline[1:] + outline[0], strict=True):
        patches.append(cg.shapes.bilinear(at(a, -0.5), at(a, 0.5), at(b, -0.5), at(b, 0.5)))
    return cg.Body(patches)


def slot(wall: float = 0.45) -> cg.Body:
    """A block with a slot of width 0.1 from above, between walls `wall` thick."""
    half = 0.5 * WIDTH
    x = half + wall
    corners = {
        "a": (-x, -0.5), "b": (x, -0.5), "c": (x, 0.5), "d": (half, 0.5),
        "e": (half, -0.2), "f": (-half, -0.2), "g": (-half, 0.5), "h": (-x, 0.5),
    }  # fmt: skip
    return _prism(corners, ["abef", "afgh", "bcde"], "abcdefgh")


def walls(thickness: float = 0.02) -> cg.Body:
    """Two plates across x, at 0 and at 0.1, without a joint."""
    patches: list[cg.NurbsSurface] = []
    for x in (0.0, WIDTH):
        a, b = x, x + thickness
        corners = {"a": (a, -0.5), "b": (b, -0.5), "c": (b, 0.5), "d": (a, 0.5)}
        patches += _prism(corners, ["abcd"], "abcd").patches
    return cg.Body(patches)


def follow(master: Master, path: list[list[float]], **options: object) -> list[cg.State]:
    """The states of one point along `path`."""
    points = np.array(path)
    contact = cg.Contact(master, cg.Slave(points[:1], area=[1.0]), law=UNIT, **options)  # type: ignore[arg-type]
    states = [contact.start(points[:1])]
    for point in points[1:]:
        states.append(contact.step(states[-1], point[None, :]))
    return states


def made(kind: str, body: cg.Body) -> Master:
    """The body itself, or its triangles."""
    return body if kind == "exact" else body.tessellate(0.1)


def assert_touches(state: cg.State, depth: float, normal: list[float]) -> None:
    assert state.in_contact.all(), state.status
    assert state.penetration[0] == pytest.approx(depth, abs=1e-12)
    np.testing.assert_allclose(state.normal[0], normal, rtol=0, atol=1e-12)
    np.testing.assert_allclose(state.force[0], depth * np.array(normal), rtol=0, atol=1e-12)


def test_the_solids_of_these_tests_are_what_they_say() -> None:
    assert slot().volume() == pytest.approx(1.0 - WIDTH * 0.7, abs=1e-12)
    assert walls(0.02).volume() == pytest.approx(0.04, abs=1e-12)


kinds = pytest.mark.parametrize("kind", ["exact", "mesh"])
searches = pytest.mark.parametrize("search", ["intersection", "penetration"])


@kinds
@searches
def test_out_of_one_wall_of_a_slot_and_into_the_other_within_a_step(kind: str, search: str) -> None:
    path = [[0.0, 0.0, 0.1], [0.07, 0.0, 0.1], [-0.08, 0.0, 0.1], [-0.09, 0.0, 0.1]]
    states = follow(made(kind, slot()), path, search=search)
    assert_touches(states[1], 0.02, [-1.0, 0.0, 0.0])
    assert_touches(states[2], 0.03, [1.0, 0.0, 0.0])
    assert_touches(states[3], 0.04, [1.0, 0.0, 0.0])


@kinds
def test_a_point_that_has_changed_walls_is_released_where_it_comes_out(kind: str) -> None:
    path = [[0.0, 0.0, 0.1], [0.07, 0.0, 0.1], [-0.08, 0.0, 0.1], [-0.01, 0.0, 0.1]]
    states = follow(made(kind, slot()), path)
    assert states[3].status[0] == cg.ContactStatus.RELEASED
    assert not states[3].total_force.any()


@kinds
def test_to_and_fro_between_walls_in_every_step(kind: str) -> None:
    x = [0.0] + [(-1.0) ** k * (0.05 + 0.002 * k) for k in range(1, 12)]
    states = follow(made(kind, slot()), [[value, 0.1, 0.2] for value in x])
    for value, state in zip(x[1:], states[1:], strict=True):
        assert_touches(state, abs(value) - 0.05, [-np.sign(value), 0.0, 0.0])


@kinds
def test_out_of_a_wall_and_into_the_floor_of_a_slot(kind: str) -> None:
    path = [[0.0, 0.0, -0.15], [0.06, 0.0, -0.15], [0.0, 0.0, -0.21]]
    assert_touches(follow(made(kind, slot()), path)[2], 0.01, [0.0, 0.0, 1.0])


@kinds
def test_right_through_a_lip_and_into_the_wall_behind_it(kind: str) -> None:
    master = made(kind, slot(wall=0.05))
    path = [[0.2, 0.0, 0.1], [-0.06, 0.0, 0.1]]
    # Free before, and in contact with the lip before: the far wall is what it is in now.
    assert_touches(follow(master, path)[1], 0.01, [1.0, 0.0, 0.0])
    path = [[0.2, 0.0, 0.1], [0.08, 0.0, 0.1], [-0.06, 0.0, 0.1]]
    states = follow(master, path)
    assert_touches(states[1], 0.02, [1.0, 0.0, 0.0])
    assert_touches(states[2], 0.01, [1.0, 0.0, 0.0])


@kinds
def test_through_a_lip_and_out_again_is_free(kind: str) -> None:
    master = made(kind, slot(wall=0.05))
    path = [[0.2, 0.0, 0.1], [0.08, 0.0, 0.1], [0.01, 0.0, 0.1], [0.06, 0.0, 0.1]]
    states = follow(master, path)
    assert states[2].status[0] == cg.ContactStatus.RELEASED
    assert_touches(states[3], 0.01, [-1.0, 0.0, 0.0])


@kinds
def test_two_thin_walls_in_one_step(kind: str) -> None:
    master = made(kind, walls(0.02))
    beyond = follow(master, [[-0.1, 0.0, 0.0], [0.3, 0.0, 0.0], [0.11, 0.0, 0.0]])
    assert beyond[1].status[0] == cg.ContactStatus.FREE
    assert_touches(beyond[2], 0.01, [1.0, 0.0, 0.0])
    within = follow(master, [[-0.1, 0.0, 0.0], [0.115, 0.0, 0.0]])
    assert_touches(within[1], 0.015, [-1.0, 0.0, 0.0])
    from_one = follow(master, [[-0.1, 0.0, 0.0], [0.005, 0.0, 0.0], [0.115, 0.0, 0.0]])
    assert_touches(from_one[1], 0.005, [-1.0, 0.0, 0.0])
    assert_touches(from_one[2], 0.015, [-1.0, 0.0, 0.0])


@kinds
def test_a_point_that_begins_inside_counts_once_it_has_come_in_elsewhere(kind: str) -> None:
    path = [[0.07, 0.0, 0.1], [0.08, 0.0, 0.1], [-0.08, 0.0, 0.1]]
    states = follow(made(kind, slot()), path)
    assert states[1].n_contact == 0
    assert_touches(states[2], 0.03, [1.0, 0.0, 0.0])


@kinds
def test_a_moving_slot_takes_a_point_from_wall_to_wall(kind: str) -> None:
    point = np.array([[0.0, 0.0, 0.1]])
    contact = cg.Contact(made(kind, slot()), cg.Slave(point, area=[1.0]), law=UNIT)
    state = contact.start(point)
    for x in (-0.07, 0.08):
        state = contact.step(state, point, cg.motion.pose.translation([x, 0.0, 0.0]))
    assert_touches(state, 0.03, [1.0, 0.0, 0.0])


@kinds
def test_random_jumps_about_a_slot_are_in_contact_where_they_are_inside(kind: str) -> None:
    rng = np.random.default_rng(3)

    def inside(p: np.ndarray) -> np.ndarray:
        block = (np.abs(p) < 0.5).all(axis=1)
        return block & ~((np.abs(p[:, 0]) < 0.05) & (p[:, 2] > -0.2))

    points = rng.uniform([-0.05, -0.4, -0.2], [0.05, 0.4, 0.6], (400, 3))
    contact = cg.Contact(made(kind, slot()), cg.Slave(points, area=np.ones(400)), law=UNIT)
    state = contact.start(points)
    crossed = 0
    for _ in range(40):
        before, last = points, state
        points = rng.uniform([-0.12, -0.45, -0.3], [0.12, 0.45, 0.6], (400, 3))
        state = contact.step(last, points)
        np.testing.assert_array_equal(state.in_contact, inside(points))
        other = (np.sign(before[:, 0]) != np.sign(points[:, 0])) & inside(before)
        crossed += int((other & state.in_contact).sum())
    assert crossed > 500


@pytest.mark.parametrize("step", [1e-3, 1e-4, 1e-5, 3e-6])
def test_a_ball_lowered_on_a_sheet_has_all_of_its_force_however_small_the_step(step: float) -> None:
    """Of its radius, 1. The sheet lies in z = 0; the closed form is the sum over the points."""
    ball = cg.Body([cg.shapes.sphere()])
    steps = 40
    reach = 1.5 * np.sqrt(2.0 * steps * step)
    x, y = np.meshgrid(*2 * [np.linspace(-reach, reach, 41)])
    sheet = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    contact = cg.Contact(ball, cg.Slave(sheet, area=np.ones(len(sheet))), law=UNIT)
    for start in (1.0, 1.0 + 0.37 * step):
        height = start
        state = contact.start(sheet, cg.motion.pose.translation([0.0, 0.0, height + step]))
        for k in range(steps + 1):
            height = start - k * step
            state = contact.step(state, sheet, cg.motion.pose.translation([0.0, 0.0, height]))
        distance = np.linalg.norm(sheet - [0.0, 0.0, height], axis=1)
        depth = np.maximum(1.0 - distance, 0.0)
        clear = np.abs(1.0 - distance) > 1e-13
        np.testing.assert_array_equal(state.in_contact[clear], (depth > 0.0)[clear])
        np.testing.assert_allclose(state.penetration, depth, rtol=0, atol=1e-13)
        assert state.total_force[2] == pytest.approx(-(depth * height / distance).sum(), rel=1e-9)
