"""The wall that holds a point on open shells and meshes, in closed form."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.sample import full
from tests.stress import open_scenes
from tests.stress.open_scenes import block, plate, profile
from tests.stress.shells import Ball, Face, Polygon, Shell

import contiga as cg
from contiga.records import ContactStatus as Is

UNIT = cg.PenaltyLaw(1.0)
STEPS = (1, 2, 7, 50)
Master = cg.Body | cg.TriMesh
KINDS = ("patches", "triangles")


def made(faces: list[Face], kind: str = "patches") -> Master:
    return Shell(faces).body() if kind == "patches" else Shell(faces).mesh()


def gone(
    master: Master, *corners: list[float], steps: int = 1, turn: float = 0.0, **options: str
) -> list[cg.State]:
    """The states of a point at the corners of its way, each leg of it in so many steps."""
    X_WB = cg.motion.pose.rotation([1.0, 2.0, 3.0], turn)
    contact = cg.Contact(master, cg.Slave(np.zeros((1, 3)), area=[1.0]), law=UNIT, **options)  # type: ignore[arg-type]
    states = [contact.start(cg.motion.pose.apply(X_WB, np.array([corners[0]])), X_WB)]
    for a, b in pairwise(np.array(corners, dtype=float)):
        state = states[-1]
        for share in np.arange(1, steps + 1) / steps:
            place = b if share == 1.0 else a + share * (b - a)
            state = contact.step(state, cg.motion.pose.apply(X_WB, place[None]), X_WB)
        states.append(state)
    return states


def depths(states: list[cg.State]) -> list[float]:
    return [float(state.penetration[0]) for state in states]


def statuses(states: list[cg.State]) -> list[Is]:
    return [Is(int(state.status[0])) for state in states]


def is_near(actual: list[float], expected: list[float], size: float = 1.0) -> None:
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-11 * size)


STACK = [*plate(0.0), *plate(-0.5, (-1.0, 3.0), (-1.0, 3.0)), *plate(-1.2, (-1.0, 3.0))]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_through_sheets_that_face_the_same_way_the_depth_of_the_first_goes_on(
    kind: str, steps: int
) -> None:
    way = [[0.9, 1.1, z] for z in (0.2, -0.2, -0.3, -0.7, -1.5, -0.55, -0.45, -0.1, 0.3)]
    states = gone(made(STACK, kind), *way, steps=steps, turn=0.4)
    is_near(depths(states), [0.0, 0.2, 0.3, 0.7, 1.5, 0.55, 0.45, 0.1, 0.0])
    assert statuses(states)[-1] == (Is.RELEASED if steps == 1 else Is.FREE)
    assert all(state.in_contact[0] for state in states[1:-1])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_point_before_a_nearer_sheet_is_not_let_go(kind: str, steps: int) -> None:
    """Held by the upper one, it slides to and fro just above the lower one."""
    way = [[0.9, 1.1, 0.1], [0.9, 1.1, -0.49], [0.1, 0.2, -0.49], [1.9, 1.8, -0.499]]
    states = gone(made(STACK, kind), *way, steps=steps)
    is_near(depths(states), [0.0, 0.49, 0.49, 0.499])
    np.testing.assert_allclose([s.normal_B[0] for s in states[1:]], [[0, 0, 1]] * 3, atol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
@pytest.mark.parametrize("lowest", [-0.3, -0.6, -1.9])
def test_a_step_back_out_through_other_sheets_releases(
    kind: str, steps: int, lowest: float
) -> None:
    way = [[1, 1, 0.1], [1, 1, -0.2], [1, 1.1, lowest], [0.9, 1, 0.1]]
    states = gone(made(STACK, kind), *way, steps=steps)
    is_near(depths(states), [0.0, 0.2, -lowest, 0.0])
    assert not states[-1].in_contact[0]
    if steps == 1:
        assert statuses(states)[-1] == Is.RELEASED


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_wing_that_a_point_comes_under_by_its_border_does_not_take_over(
    kind: str, steps: int
) -> None:
    """The border of the lowest wing is nearer than the middle wing before its foot comes off it."""
    master = made(profile(*open_scenes.Z_FOLD[::-1]), kind)
    normal = np.array([0.5, 1.8, 0.0]) / np.hypot(0.5, 1.8)
    begin, end = np.array([-0.1118, -0.44995, 1.0]), np.array([-0.0906, -0.45665, 1.0])
    states = gone(master, [*(begin + 0.465 * normal)], [*begin], [*end], steps=steps)
    is_near(depths(states), [0.0, -begin @ normal, -end @ normal])


@pytest.mark.parametrize("steps", STEPS)
def test_the_guard_turns_along_a_round_before_another_wall_is_judged_by_it(steps: int) -> None:
    """At 159° with the guard, and at 180° with what the guard turns to within the step."""
    turn = np.radians(21.0)
    normal = np.array([np.sin(turn), np.cos(turn), 0.0])
    begin, end = [1.5031, -0.2419, 1.0], [1.4957, -0.253, 1.0]
    master = made(open_scenes.round_fold(0.5))
    states = gone(master, [*(begin + 0.4 * normal)], begin, end, steps=steps)
    is_near(depths(states), [0.0, 0.25 - np.hypot(0.0031, 0.0081), 0.253])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_sheet_folded_over_itself_holds_by_the_wing_that_a_point_came_in_by(
    kind: str, steps: int
) -> None:
    """Z: the upper and the lower wing face up. The point stays off the walls of the bends."""
    corners = [(9.0, 0.0), (0.0, 0.0), (9.0, -0.5), (0.0, -1.0)]
    master = made(profile(*corners[::-1], ends=(0.0, 9.0)), kind)
    if master.project([[4.0, 0.3, 4.0]]).gap[0] < 0.0:
        master = master.flipped()
    way = [[4.5, y, 4.0] for y in (0.3, -0.1, -0.3, -0.6, -1.3, -0.7, -0.2, 0.2)]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), [0.0, 0.1, 0.3, 0.6, 1.3, 0.7, 0.2, 0.0], 9.0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_u_whose_wings_face_apart_holds_by_the_first(kind: str, steps: int) -> None:
    master = made(profile((0.0, -0.5), (9.0, -0.5), (9.0, 0.0), (0.0, 0.0), ends=(0, 9)), kind)
    way = [[3.0, y, 4.0] for y in (0.3, -0.2, -0.4, -0.9, -2.0, -0.6, -0.45, -0.1, 0.3)]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), [0.0, 0.2, 0.4, 0.9, 2.0, 0.6, 0.45, 0.1, 0.0], 9.0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_where_the_end_of_a_u_is_nearer_it_takes_over(kind: str, steps: int) -> None:
    """Below its middle a point is held by the upper wing, until the end wall is as near."""
    master = made(profile((0.0, -0.5), (9.0, -0.5), (9.0, 0.0), (0.0, 0.0), ends=(0, 9)), kind)
    way = [[7.0, 0.3, 4.0], [7.0, -0.4, 4.0], [8.9, -0.4, 4.0], [8.95, -0.2, 4.0]]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), [0.0, 0.4, 0.1, 0.05], 9.0)
    np.testing.assert_allclose(states[2].normal_B[0], [1, 0, 0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", [5, *full(50, 200)])
def test_a_block_without_its_bottom_is_the_block(kind: str, steps: int) -> None:
    """Upside down: its free edges are below, out of reach; the bed is run over by sharp edges."""
    low, high = (-2.0, -1.5, 0.0), (2.0, 1.5, 3.0)
    closed, opened = (made(block(low, high, without), kind) for without in ("", "z"))
    x, y = np.meshgrid(np.linspace(-3.1, 3.3, 15), np.linspace(-2.1, 2.2, 9))
    bed = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 3.1)])
    corners = [
        [0, 0, 0.0],
        [0, 0, 0.3],
        [1.6, 0.3, 0.35],
        [1.7, -1.0, 0.4],
        [0, 0, 0.2],
        [0, 0, -0.2],
    ]
    found = []
    for master in (closed, opened):
        contact = cg.Contact(master, cg.Slave(bed, area=np.ones(len(bed))), law=UNIT)
        states = [contact.start(bed)]
        for a, b in pairwise(np.array(corners)):
            for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
                place = cg.motion.pose.translation(a + share * (b - a))
                states.append(contact.step(states[-1], bed, place))
        found.append(states)
    for own, other in zip(*found, strict=True):
        np.testing.assert_array_equal(own.in_contact, other.in_contact)
        np.testing.assert_allclose(own.penetration, other.penetration, rtol=0, atol=1e-12)
        np.testing.assert_allclose(own.force, other.force, rtol=0, atol=1e-9)
    assert max(state.n_contact for state in found[0]) > 40


@pytest.mark.parametrize("steps", [1, 6, *full(60)])
def test_a_sphere_without_its_lowest_cap_is_the_sphere(steps: int) -> None:
    latitude = -1.0
    whole, cut = (
        Shell([Ball((0, 0, 0), 1.0, (south, 0.5 * np.pi))]).body()
        for south in (-0.5 * np.pi, latitude)
    )
    rng = np.random.default_rng(2)
    n = 80
    angle, up = rng.uniform(0, 2 * np.pi, (2, 5, n)), rng.uniform(latitude + 0.05, 1.4, (5, n))
    angle = angle[0] + np.cumsum(rng.uniform(-0.8, 0.8, (5, n)), axis=0)
    radius = rng.uniform(0.3, 0.95, (5, n))
    radius[[0, -1]] = 1.1
    way = radius[..., None] * np.stack(
        [np.cos(up) * np.cos(angle), np.cos(up) * np.sin(angle), np.sin(up)], axis=-1
    )
    found = []
    for master in (whole, cut):
        contact = cg.Contact(master, cg.Slave(way[0], area=np.ones(n)), law=UNIT)
        states = [contact.start(way[0])]
        for a, b in pairwise(way):
            for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
                states.append(contact.step(states[-1], a + share * (b - a)))
        found.append(states)
    # Chords may lead over the missing cap; from there on nothing is asked.
    sound, last = np.ones(n, bool), way[0]
    for own, other in zip(*found, strict=True):
        p = last + np.linspace(0.0, 1.0, 65)[:, None, None] * (own.points_B - last)
        sound &= (p[..., 2] > np.sin(latitude) * np.sqrt((p**2).sum(axis=-1))).all(axis=0)
        last = own.points_B
        np.testing.assert_allclose(
            own.penetration[sound], other.penetration[sound], rtol=0, atol=1e-11
        )
        np.testing.assert_allclose(own.normal_B[sound], other.normal_B[sound], rtol=0, atol=1e-9)
    assert sound.sum() > 12


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_beyond_the_border_of_a_plate_a_point_has_slid_off(kind: str, steps: int) -> None:
    master = made(plate(0.0), kind)
    way = [
        [1.0, 0.8, 0.1],
        [1.1, 0.9, -0.2],
        [1.95, 0.9, -0.2],
        [2.05, 0.9, -0.25],
        [1.5, 0.9, -0.25],
    ]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), [0.0, 0.2, 0.2, 0.0, 0.0])
    if steps == 1:
        assert statuses(states) == [Is.FREE, Is.NEW, Is.OLD, Is.SLID_OFF, Is.FREE]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("beyond", [1e-7, 1e-5, 1e-4, 1e-3])
def test_a_hair_beyond_a_border_a_point_has_slid_off(kind: str, beyond: float) -> None:
    master = made(plate(0.0), kind)
    at = [
        [1.9, 0.9, 0.1],
        [1.9, 0.9, -0.25],
        [2.0 - beyond, 0.9, -0.25],
        [2.0 + beyond, 0.9, -0.25],
    ]
    states = gone(master, *at)
    assert statuses(states) == [Is.FREE, Is.NEW, Is.OLD, Is.SLID_OFF]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_point_that_has_come_out_is_not_held_by_a_sheet_that_it_is_behind(
    kind: str, steps: int
) -> None:
    """In by the lower sheet beside the upper one, and out again below that."""
    master = made([*plate(0.0), *plate(-0.3, (0.5, 3.0))], kind)
    way = [[2.5, 1.0, 0.1], [2.5, 1.0, -0.5], [1.5, 1.1, -0.5], [1.4, 1.1, -0.05], [1.3, 1, -0.2]]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), [0.0, 0.2, 0.2, 0.0, 0.0])
    if steps == 1:
        assert statuses(states) == [Is.FREE, Is.NEW, Is.OLD, Is.RELEASED, Is.FREE]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_sheet_whose_border_a_point_passes_behind_does_not_take_it(kind: str, steps: int) -> None:
    """Held by the upper sheet it comes from beside the lower one to behind it."""
    master = made([*plate(0.0), *plate(-0.3, (0.5, 3.0))], kind)
    way = [[0.2, 1.0, 0.1], [0.2, 1.0, -0.2], [0.3, 1.1, -0.6], [1.5, 1.1, -0.5], [1.4, 1.2, -0.2]]
    is_near(depths(gone(master, *way, steps=steps)), [0.0, 0.2, 0.6, 0.5, 0.2])


@pytest.mark.parametrize("steps", STEPS)
def test_over_the_rim_of_a_hole_a_point_has_slid_off(steps: int) -> None:
    master = made(plate(0.0, hole=((1.0, 1.0, 0.0), 0.5)))
    way = [[0.2, 1.0, 0.1], [0.3, 1.0, -0.2], [0.49, 1.0, -0.2], [0.6, 1.0, -0.2], [1.6, 1.0, -0.2]]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), [0.0, 0.2, 0.2, 0.0, 0.0])
    if steps == 1:
        assert statuses(states) == [Is.FREE, Is.NEW, Is.OLD, Is.SLID_OFF, Is.FREE]


@pytest.mark.parametrize("steps", [50, 200])
def test_a_point_slides_off_into_a_hole_and_stays_free_beyond(steps: int) -> None:
    """In steps of less than 1/16 of the depth; a longer one is judged by its end."""
    master = made(plate(0.0, hole=((1.0, 1.0, 0.0), 0.05)))
    way = [[0.2, 1, 0.1], [0.3, 1, -0.4], [1.7, 1, -0.4]]
    assert statuses(gone(master, *way, steps=steps))[1:] == [Is.OLD, Is.FREE]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_a_border_holds_where_it_is_to(kind: str, steps: int) -> None:
    master = made(plate(0.0), kind)
    way = [[1.0, 0.8, 0.1], [1.1, 0.9, -0.2], [2.3, 0.9, -0.2], [2.4, 2.2, -0.1], [1.9, 1.1, -0.1]]
    states = gone(master, *way, steps=steps, on_edge="hold")
    is_near(depths(states), [0.0, 0.2, 0.2, 0.1, 0.1])
    expected = [[1.1, 0.9, 0.0], [2.0, 0.9, 0.0], [2.0, 2.0, 0.0], [1.9, 1.1, 0.0]]
    np.testing.assert_allclose([s.foot_B[0] for s in states[1:]], expected, rtol=0, atol=1e-12)
    assert statuses(states)[2:4] == [Is.HELD, Is.HELD]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_the_medial_plane_under_a_roof_does_not_depend_on_the_way(kind: str, steps: int) -> None:
    """A ridge of 90°, 2 long on each side: depth is the distance to the nearer slope."""
    s = np.sqrt(0.5)
    master = made(open_scenes.roof(90.0), kind)
    way = [
        [0.1, 0.1, 1.0],
        [0.12, -0.4, 1.0],
        [-0.12, -0.4, 1.0],
        [-0.02, -0.1, 0.5],
        [0.2, -0.3, 1.5],
    ]
    expected = [0.0] + [s * (-y - abs(x)) for x, y, _ in way[1:]]
    states = gone(master, *way, steps=steps)
    is_near(depths(states), expected)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_over_a_hollow_edge_the_foot_stands_on_the_edge(kind: str, steps: int) -> None:
    """A gutter of 90° from below: between the two normals the edge is the nearest."""
    master = made(open_scenes.gutter(90.0), kind)
    if master.project([[0.0, -0.5, 1.0]]).gap[0] < 0.0:
        master = master.flipped()
    way = [[0.4, -0.6, 1.0], [0.4, -0.2, 1.0], [0.1, 0.3, 1.0], [-0.2, 0.2, 1.0], [-0.5, 0.1, 1.0]]
    states = gone(master, *way, steps=steps)
    s = np.sqrt(0.5)
    expected = [0.0]
    for x, y, _ in way[1:]:
        along = s * (abs(x) - y)
        expected.append(s * (abs(x) + y) if along > 0.0 else float(np.hypot(x, y)))
    is_near(depths(states), expected)


@pytest.mark.parametrize("kind", KINDS)
def test_depth_hangs_on_the_place_and_not_on_the_number_of_steps(kind: str) -> None:
    """1, 50 and 1,600 steps through an open block."""
    master = made(block((0, 0, 0), (2.0, 1.4, 0.8), "z"), kind)
    way = [[1.0, 0.7, 0.9], [1.1, 0.6, 0.5], [1.8, 0.6, 0.4], [1.7, 1.25, 0.5], [0.9, 1.2, 0.75]]
    expected = [0.0, 0.3, 0.2, 0.15, 0.05]
    for steps in (1, 50, 1600 // 4):
        is_near(depths(gone(master, *way, steps=steps)), expected)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("length", [1e-9, 1e-6, 1e-3, 1.0, 1e3])
def test_a_plate_holds_over_any_length_in_any_unit(scale: float, length: float) -> None:
    master = made(plate(0.0)).scaled(scale)
    way = [
        [1.0, 1.0, 0.3 * length],
        [1.0, 1.1, -0.7 * length],
        [1.1, 1.1, -0.2 * length],
        [1, 1, length],
    ]
    states = gone(master, *(np.multiply(scale, way)).tolist())
    expected = [0.0, 0.7 * length, 0.2 * length, 0.0]
    np.testing.assert_allclose(
        depths(states), np.multiply(scale, expected), rtol=1e-12, atol=2e-15 * scale
    )
    assert statuses(states) == [Is.FREE, Is.NEW, Is.OLD, Is.RELEASED]


def loop(master: Master, steps: int) -> tuple[float, float]:
    """Energy error and most energy stored of a master pressed into a bed, moved, drawn out."""
    x, y = np.meshgrid(np.linspace(-1.6, 1.7, 14), np.linspace(-1.7, 1.5, 13))
    bed = np.column_stack([x.ravel(), y.ravel(), 0.03 * np.sin(3.0 * x.ravel())])
    contact = cg.Contact(master, cg.Slave(bed, area=np.ones(len(bed))), law=UNIT)
    corners = [
        [0, 0, 0.2],
        [0, 0, -0.12],
        [0.31, 0.05, -0.12],
        [0.3, 0.4, -0.15],
        [0, 0, -0.1],
        [0, 0, 0.2],
    ]
    poses = cg.motion.pose
    state = contact.start(bed, poses.translation(corners[0]))
    most = 0.0
    for a, b in pairwise(np.array(corners)):
        for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
            state = contact.step(state, bed, poses.translation(a + share * (b - a)))
            most = max(most, state.energy.stored)
    assert state.energy.stored == 0.0
    return abs(state.energy.error), most


LOOPED = {
    "block without its top": lambda: block((-1.0, -0.8, 0.0), (1.0, 0.8, 1.5), "Z"),
    "block": lambda: block((-1.0, -0.8, 0.0), (1.0, 0.8, 1.5)),
    "block without two sides": lambda: block((-1.0, -0.8, 0.0), (1.0, 0.8, 1.5), "ZY"),
    "half of a sphere": lambda: [Ball((0.0, 0.0, 1.5), 1.5, (-0.5 * np.pi, 0.0))],
}


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("block without its top", "patches"),
        ("block without its top", "triangles"),
        ("half of a sphere", "patches"),
        *full(
            ("block", "patches"),
            ("block", "triangles"),
            ("block without two sides", "patches"),
        ),
    ],
)
def test_round_a_loop_no_work_is_done_by_open_bodies(name: str, kind: str) -> None:
    """Sharp edges run over the bed, none of its borders does. The error is that of the steps."""
    master = made(LOOPED[name](), kind)
    (coarse, most), (fine, _) = (loop(master, steps) for steps in (20, 160))
    assert most > 0.05
    assert coarse < 0.05 * most
    assert fine < 0.3 * coarse + 1e-12


def test_polygons_of_the_scenes_face_outward() -> None:
    assert Shell(block((0, 0, 0), (1, 2, 3))).body().volume() == pytest.approx(6.0)
    assert all(isinstance(face, Polygon) for face in STACK)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("steps", STEPS)
def test_by_penetration_a_point_before_the_lower_sheet_comes_to_the_upper_one(
    kind: str, steps: int
) -> None:
    master = made([*plate(0.0), *plate(-0.3)], kind)
    states = gone(master, [1, 1, -0.16], [1, 1, -0.1], steps=steps, search="penetration")
    is_near(depths(states), [0.0, 0.1])


@pytest.mark.parametrize("steps", [1, 2, 20])
def test_an_edge_next_to_which_the_surface_is_nearer_holds_nothing(steps: int) -> None:
    master = open_scenes.scene("hills, mesh").master
    way = (
        [1.9026585855608094, 1.986592768933868, -0.21482197734729946],
        [2.476278363172905, 0.4181064185426957, -1.2549052400515426],
    )
    assert not gone(master, *way, steps=steps)[-1].in_contact[0]
