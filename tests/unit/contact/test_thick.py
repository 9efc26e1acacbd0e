"""Shells that touch from half their thickness on: closed forms, edges, starts, energy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.scenes import box, square_sheet

import contiga as cg
from contiga.errors import InputError
from contiga.records import ContactStatus as Is

LAW = cg.PenaltyLaw(50.0, per_area=True)
TABLE = cg.Body([cg.shapes.plane(width=10.0, length=10.0)], name="table")
BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
BRICK = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


def _sheet() -> cg.Slave:
    return cg.Slave(*square_sheet(1.0, 9), name="sheet")


def _contact(master: cg.Body, slave: cg.Slave, **options: object) -> cg.Contact:
    options = {"search": "penetration", "shell_thickness": 0.2, "law": LAW} | options
    return cg.Contact(master, slave, **options)


def _points(master: cg.Body, thickness: float, **options: object) -> cg.Contact:
    """Of one point."""
    slave = cg.Slave([[0.0, 0.0, 0.0]], area=1.0)
    return _contact(master, slave, shell_thickness=thickness, **options)


@pytest.mark.parametrize("quadrature", ["nodes", 1, 6])
@pytest.mark.parametrize("master", [TABLE, BRICK])
def test_a_sheet_feels_the_table_half_its_thickness_away(
    master: cg.Body, quadrature: str | int
) -> None:
    sheet, top = _sheet(), 0.0 if master is TABLE else 1.0
    contact = _contact(master, sheet, quadrature=quadrature)
    for depth in (-1e-3, 0.02, 0.15):
        state = contact.start(np.add(sheet.points, [0.0, 0.0, top + 0.1 - depth]))
        expected = 50.0 * max(depth, 0.0) * sheet.area.sum()
        assert state.max_penetration == pytest.approx(max(depth, 0.0), abs=1e-12)
        assert state.total_force[2] == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert state.force[:, 2].sum() == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert state.total_area == pytest.approx(sheet.area.sum() if depth > 0.0 else 0.0)


def test_it_makes_no_difference_which_way_facets_face() -> None:
    points, quads = square_sheet(1.0, 9)
    turned = np.array(quads)
    turned[::2] = turned[::2, ::-1]
    states = []
    for facets in (quads, turned):
        contact = _contact(TABLE, cg.Slave(points, facets), quadrature=3)
        states.append(contact.start(np.add(points, [0.0, 0.0, 0.09])))
    np.testing.assert_allclose(states[0].total_force, states[1].total_force, atol=1e-12)


@pytest.mark.parametrize(
    ("place", "foot", "depth"),
    [
        ((1.05, 0.0, 0.0), (1.0, 0.0, 0.0), 0.05),
        ((1.03, 1.04, 0.0), (1.0, 1.0, 0.0), 0.05),  # off an edge
        ((1.02, 1.02, 1.01), (1.0, 1.0, 1.0), 0.07),  # off a corner
        ((0.9, 0.0, 0.0), (1.0, 0.0, 0.0), 0.2),  # inside
        ((1.2, 1.2, 0.0), None, 0.0),
    ],
)
def test_a_point_is_pushed_from_the_nearest_place(
    place: tuple[float, ...], foot: tuple[float, ...] | None, depth: float
) -> None:
    contact = _points(BRICK, 0.2)
    state = contact.start([place])
    assert state.penetration[0] == pytest.approx(depth, abs=1e-12)
    if foot is None:
        assert not state.force.any()
        return
    away = np.subtract(place, foot) * (1.0 if depth < 0.1 else -1.0)
    normal = away / np.linalg.norm(away)
    np.testing.assert_allclose(state.force[0], 50.0 * depth * normal, atol=1e-9)
    np.testing.assert_allclose(state.foot_B[0], np.add(foot, 0.1 * normal), atol=1e-9)


@pytest.mark.parametrize("master", [BALL, BRICK, TABLE])
def test_forces_are_the_gradient_of_the_energy(master: cg.Body) -> None:
    rng, sheet = np.random.default_rng(3), _sheet()
    contact = _contact(master, sheet, quadrature=6)
    top = 0.0 if master is TABLE else 1.0
    points = np.add(sheet.points, [0.7, 0.7, top + 0.03]) + 0.01 * rng.normal(size=(81, 3))
    if master is BALL:
        points -= [0.7, 0.7, 0.0]
    state, h, way = contact.start(points), 1e-6, rng.normal(size=points.shape)
    ahead, behind = (contact.start(points + s * h * way).energy.stored for s in (1.0, -1.0))
    assert state.energy.stored > 0.0
    assert (state.force * way).sum() == pytest.approx(-(ahead - behind) / (2.0 * h), rel=1e-5)


def _passed(contact: cg.Contact, places: list[tuple[float, float, float]]) -> list[int]:
    state = contact.start([places[0]])
    states = [state]
    for place in places[1:]:
        state = contact.step(state, [place], dt=1.0)
        states.append(state)
    return [int(one.status[0]) for one in states]


@pytest.mark.parametrize(
    ("search", "first"), [("intersection", [Is.FREE, Is.FREE]), ("penetration", [Is.NEW, Is.OLD])]
)
@pytest.mark.parametrize("master", [BRICK, TABLE])
def test_what_starts_within_reach_must_have_been_out_of_it(
    master: cg.Body, search: str, first: list[int]
) -> None:
    top = 0.0 if master is TABLE else 1.0
    heights = [0.05, 0.06, 0.2, 0.09, 0.02, -0.05, 0.2]
    places = [(0.3, 0.2, top + z) for z in heights]
    status = _passed(_points(master, 0.2, search=search), places)
    out = Is.FREE if search == "intersection" else Is.RELEASED
    assert status == [*first, out, Is.NEW, Is.OLD, Is.OLD, Is.RELEASED]


def test_beside_a_border_it_slides_off_or_is_held() -> None:
    places = [(4.9, 0.0, 0.3), (4.9, 0.0, 0.05), (5.03, 0.0, 0.05), (5.03, 0.0, 0.3)]
    slid = _passed(_points(TABLE, 0.2, search="intersection"), places)
    assert slid == [Is.FREE, Is.NEW, Is.SLID_OFF, Is.FREE]
    contact = _points(TABLE, 0.2, search="intersection", on_edge="hold")
    assert _passed(contact, places) == [Is.FREE, Is.NEW, Is.HELD, Is.RELEASED]
    state = contact.start([places[0]])
    for place in places[1:3]:
        state = contact.step(state, [place], dt=1.0)
    away = np.array([0.03, 0.0, 0.05])
    depth = 0.1 - np.linalg.norm(away)
    np.testing.assert_allclose(
        state.force[0], 50.0 * depth * away / np.linalg.norm(away), rtol=1e-9, atol=1e-12
    )


def test_one_point_and_many_small_steps_come_to_the_same() -> None:
    contact = _points(BALL, 0.2, search="intersection")
    ends = np.array([2.0, 0.1, 0.2]), np.array([0.95, 0.1, 0.1])
    found = []
    for count in (1, 1600):
        state = contact.start([ends[0]])
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            state = contact.step(state, [ends[0] + share * (ends[1] - ends[0])], dt=1.0)
        found.append(state)
    np.testing.assert_array_equal(found[0].force, found[1].force)
    assert found[0].penetration[0] == pytest.approx(1.1 - np.linalg.norm(ends[1]), rel=1e-9)


def test_a_turning_body_is_asked_at_the_ends_of_its_steps() -> None:
    contact = _points(BRICK, 0.2, search="intersection")
    state = contact.start([[1.3, 1.3, 0.0]])
    for angle in np.linspace(0.0, np.pi / 4, 10)[1:]:
        pose = cg.motion.pose.rotation([0.0, 0.0, 1.0], angle)
        state = contact.step(state, [[1.3, 0.0, 0.0]], pose, dt=1.0)
    assert state.penetration[0] == pytest.approx(0.1 + 1.0 - 1.3 * np.sqrt(0.5), rel=1e-9)


def test_the_same_scene_in_any_length() -> None:
    forces = []
    for factor in (1.0, 1e-9, 1e3):
        sheet = cg.Slave(*square_sheet(factor, 9))
        ball = cg.Body([cg.shapes.sphere(radius=factor)])
        law = cg.PenaltyLaw(50.0 / factor**3, per_area=True)
        thick = {"shell_thickness": 0.2 * factor, "quadrature": 3}
        contact = _contact(ball, sheet, law=law, **thick)
        forces.append(contact.start(np.add(sheet.points, [0.0, 0.0, 1.05 * factor])).force)
    assert forces[0].any()
    for other in forces[1:]:
        np.testing.assert_allclose(other, forces[0], atol=1e-9 * np.abs(forces[0]).max())


def test_facets_are_as_thick_as_their_corners_and_those_of_solids_beside_are_not() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    slave = cg.Slave(points, [[0, 1, 2], [1, 3, 2]])
    thick = {"shell_thickness": [0.6, 0.3, 0.3, 0.0], "quadrature": 1}
    contact = _contact(TABLE, slave, **thick)
    np.testing.assert_allclose(contact.half_thickness, [0.3, 0.15, 0.15, 0.0, 0.2, 0.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"shell_thickness": 0.0}, "shell_thickness: must be above zero somewhere"),
        ({"shell_thickness": True}, "shell_thickness: must be above zero somewhere"),
        ({"shell_thickness": -1.0}, "shell_thickness of point 0 is negative"),
        ({"shell_thickness": [1.0, 2.0]}, "shell_thickness must be one number, or one a point"),
        ({"shell_thickness": "front"}, "shell_thickness must be an array of numbers"),
        ({"foot": "tracked"}, "pushed by the nearest wall"),
        ({"through": "hold", "search": "intersection"}, "pushed by the nearest wall"),
    ],
)
def test_what_cannot_be_is_told(options: dict, text: str) -> None:
    with pytest.raises(InputError, match=text):
        _contact(TABLE, _sheet(), **options)


def test_a_point_that_is_nowhere_touches_nothing() -> None:
    contact = _points(BRICK, 0.2)
    state = contact.start([[np.nan, 0.0, 0.0]])
    assert state.status[0] == Is.NOT_FINITE
    state = contact.step(state, [[1.05, 0.0, 0.0]], dt=1.0)
    assert state.status[0] == Is.NEW
    assert contact.step(state, [[np.nan, 0.0, 0.0]], dt=1.0).status[0] == Is.NOT_FINITE


def test_a_dry_run_finds_what_a_run_finds() -> None:
    sheet = _sheet()
    contact = _contact(BALL, sheet, search="intersection", quadrature=3)
    placements = [(np.add(sheet.points, [0.0, 0.0, z]), None) for z in (1.05, 1.2, 1.06, 1.02)]
    state = contact.start(placements[0][0])
    runs = list(contact.dry_run(placements))
    assert len(runs[0].inside) > 0
    assert runs[0].deepest == pytest.approx(0.05, rel=1e-2)
    for placement, run in zip(placements[1:], runs[1:], strict=True):
        state = contact.step(state, placement[0], dt=1.0)
        held = np.flatnonzero(state.patch >= 0)
        np.testing.assert_array_equal(run.rows, held)
        np.testing.assert_allclose(run.penetration, state.penetration[held], rtol=1e-12)


@pytest.mark.parametrize("master", [BRICK, TABLE])
@pytest.mark.parametrize("off", [-1e-16, 0.0, 1e-16, 1e-12, 1e-9])
def test_a_point_that_was_just_out_of_reach_comes_in(master: cg.Body, off: float) -> None:
    """Rounding is no reason to take it for one that was within reach since the start."""
    top = 0.0 if master is TABLE else 1.0
    for start in ([], [(0.3, 0.2, top + 0.3)]):
        places = [*start, (0.3, 0.2, top + 0.1 + off), (0.3, 0.2, top + 0.08)]
        contact = _points(master, 0.2, search="intersection")
        assert _passed(contact, places)[-1] in (Is.NEW, Is.OLD)


def test_an_open_body_is_not_entered_from_behind() -> None:
    contact = _points(TABLE, 0.2, search="intersection")
    places = [(0.0, 0.0, z) for z in (-2.0, -1.6, -0.05, 0.05, 0.2, 0.05)]
    assert _passed(contact, places) == [Is.FREE] * 5 + [Is.NEW]


@pytest.mark.parametrize("edge", ["release", "hold"])
def test_a_loop_round_a_border_makes_no_energy(edge: str) -> None:
    contact = _points(TABLE, 0.2, search="intersection", on_edge=edge)
    loops = (
        [(4.5, 0.3), (5.3, 0.3), (5.3, -0.05), (4.9, -0.05), (4.9, 0.3)],
        [(5.3, 0.3), (5.05, 0.3), (5.05, 0.0), (5.05, -0.05), (4.95, -0.05), (4.95, 0.3)],
        [(5.5, 0.05), (4.9, 0.05), (4.9, 0.3)],
    )
    for loop in loops:
        state = contact.start([(loop[0][0], 0.0, loop[0][1])])
        for a, b in pairwise(loop):
            for share in np.linspace(0.0, 1.0, 201)[1:]:
                x, z = np.add(a, share * np.subtract(b, a))
                state = contact.step(state, [(x, 0.0, z)], dt=1.0)
        assert state.energy.stored == 0.0
        assert state.energy.work > -1e-6


def test_who_comes_behind_a_sheet_round_its_border_stays_out_until_out_of_reach() -> None:
    """However often it is looked at meanwhile."""
    contact = _points(TABLE, 0.2, on_edge="hold", depth=0.1)
    along = [(x, 0.0, -0.05) for x in np.linspace(4.95, 3.0, 40)]
    out = [(3.0, 0.0, -0.15), (3.0, 0.0, -0.05)]
    status = _passed(contact, [(5.2, 0.0, 0.0), (5.05, 0.0, 0.0), *along, *out])
    assert status[:3] == [Is.FREE, Is.HELD, Is.RELEASED]
    assert set(status[3:-1]) == {Is.FREE}
    assert status[-1] == Is.NEW


def test_who_comes_over_a_face_from_beside_its_border_is_in_contact_at_once() -> None:
    places = [(x, 0.0, 0.05) for x in (5.2, 5.005, 4.995)]
    assert _passed(_points(TABLE, 0.2), places) == [Is.FREE, Is.FREE, Is.NEW]
    assert _passed(_points(TABLE, 0.2), places[1:]) == [Is.FREE, Is.NEW]


def test_areas_and_outlines_end_where_half_the_thickness_does() -> None:
    points, quads = square_sheet(1.0, 9)
    slope = np.add(points, [0.003, 0.0, 0.0])
    slope[:, 2] += 0.2 * points[:, 0]
    found = []
    for thick, up in ((None, 0.0), (0.2, 0.1)):
        contact = _contact(TABLE, cg.Slave(points, quads), shell_thickness=thick)
        state = contact.start(np.add(slope, [0.0, 0.0, up]))
        found.append((state.total_area, contact.outlines(state).points[:, 0].max()))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)
    np.testing.assert_allclose(found[0], [0.5 * np.sqrt(1.04), 0.003], rtol=1e-6)


def test_areas_at_a_border_end_at_it() -> None:
    points, quads = square_sheet(1.0, 9)
    contact = _contact(TABLE, cg.Slave(points, quads), quadrature=3)
    state = contact.start(np.add(points, [5.03, 0.0, 0.05]))
    assert state.total_area == pytest.approx(0.47, rel=1e-6)


@pytest.mark.parametrize("d", [1e-2, 1e-6, 1e-10, -1e-6])
def test_forces_point_along_the_normal_however_near_the_surface(d: float) -> None:
    normals = np.random.default_rng(0).normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    slave = cg.Slave(normals, area=np.ones(50))
    state = _contact(BALL, slave).start((1.0 + d) * normals)
    np.testing.assert_allclose(state.force, 50.0 * (0.1 - d) * normals, atol=1e-10)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"contact_type": "master"}, "gives way by itself"),
        ({"area": cg.FacetArea("master")}, "measured on its mid-surface"),
        ({"area": cg.HullArea()}, "measured on its mid-surface"),
        ({"area": cg.CloudArea(by="feet")}, "measured on its mid-surface"),
    ],
)
def test_nothing_of_it_is_measured_on_the_master(options: dict, text: str) -> None:
    with pytest.raises(InputError, match=text):
        _contact(BALL, _sheet(), **options)


def test_half_the_thickness_cannot_be_written_to() -> None:
    contact = _contact(BALL, _sheet())
    with pytest.raises(ValueError, match="read-only"):
        contact.half_thickness[0] = 9.0
