"""What is known of sides at once spares work, and changes nothing of what a step finds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.sample import FULL, full
from tests.stress import shaking, solids

import contiga as cg
from contiga.records import ContactStatus as Is
from contiga.search.balls.radii import balls_of
from contiga.search.contact_tables import ContactTables
from contiga.search.exact_surface import ExactSurface
from contiga.search.sides.side_grid import UNKNOWN

N = 300 if FULL else 50
QUICK = ("slot", "torus", "lens", "block, fillets 3")
OTHERS = [n for n in solids.RECIPES if n not in QUICK and not n.startswith("small")]
SAME = ("status", "feature", "patch", "penetration", "normal", "foot", "force", "area", "certified")


def _know_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def told(surface: ExactSurface) -> ContactTables:
        return ContactTables(surface.tables, UNKNOWN, balls_of(surface.tables))

    monkeypatch.setattr(ExactSurface, "_grid", UNKNOWN)
    monkeypatch.setattr(ExactSurface, "contact_tables", property(told))


def _run(
    solid: solids.Solid, scale: float, search: str, n: int = N, foot: str = "nearest"
) -> list[cg.State]:
    rng = np.random.default_rng([17, round(1e6 * scale)])
    points = shaking.cloud(solid, n, scale, rng)
    slave = cg.Slave(points, area=np.ones(n))
    options: dict[str, Any] = {"search": search, "foot": foot}
    contact = cg.Contact(solid.body, slave, law=cg.PenaltyLaw(1.0), **options)
    states = [contact.start(points, shaking.pose(solid, scale, rng))]
    for _ in range(4 if FULL else 2):
        moved = points + scale * solid.size * rng.normal(scale=0.2, size=points.shape)
        states.append(contact.step(states[-1], moved, shaking.pose(solid, scale, rng)))
    return states


@pytest.mark.parametrize(
    "name",
    [*QUICK, *full(*OTHERS)],
)
def test_the_steps_are_the_same_where_no_side_is_known_at_once(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    solid = solids.solid(name)
    cases = [(s, k) for s in (1e-5, 3e-3, 0.1) for k in ("intersection", "penetration")]
    known = [_run(solid, *case) for case in cases]
    _know_nothing(monkeypatch)
    for case, states in zip(cases, known, strict=True):
        for a, b in zip(states, _run(solid, *case), strict=True):
            for field in SAME:
                np.testing.assert_array_equal(getattr(a, field), getattr(b, field))


def test_few_points_are_asked_for_their_closest_point(monkeypatch: pytest.MonkeyPatch) -> None:
    solid = solids.solid("shell")
    asked = 0
    inner = ExactSurface.closest

    def counted(self: ExactSurface, p: np.ndarray, rows: np.ndarray, *rest: object) -> None:
        nonlocal asked
        asked += len(rows)
        inner(self, p, rows, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(ExactSurface, "closest", counted)
    _run(solid, 0.05, "intersection", 2000, "tracked")
    few = asked
    asked = 0
    _know_nothing(monkeypatch)
    _run(solid, 0.05, "intersection", 2000, "tracked")
    assert few < 0.25 * asked


@pytest.mark.parametrize("blind", [False, True])
def test_a_point_that_crosses_a_cavity_has_come_in_by_its_far_wall(
    monkeypatch: pytest.MonkeyPatch, blind: bool
) -> None:
    # Its foot on the outer wall would do before and after, and both cells are told to be inside.
    body = cg.Body([cg.shapes.sphere(), cg.shapes.sphere(radius=0.5).flipped()])
    if blind:
        _know_nothing(monkeypatch)
    near, far = np.array([[-0.6, 0.0, 0.36]]), np.array([[0.6, 0.0, 0.36]])
    contact = cg.Contact(body, cg.Slave(near, area=[1.0]), law=cg.PenaltyLaw(1.0))
    states = [contact.start(2.0 * near)]
    for points in (1.3 * near, near, far):
        states.append(contact.step(states[-1], points))
    status = [int(s.status[0]) for s in states]
    assert status == [Is.FREE, Is.NEW, Is.OLD, Is.NEW]
    assert states[2].penetration[0] == pytest.approx(1.0 - np.linalg.norm(near))
    assert states[3].penetration[0] == pytest.approx(np.linalg.norm(far) - 0.5)


@pytest.mark.parametrize("blind", [False, True])
def test_what_lies_inside_since_the_start_comes_in_through_a_cavity(
    monkeypatch: pytest.MonkeyPatch, blind: bool
) -> None:
    body = cg.Body([cg.shapes.sphere(), cg.shapes.sphere(radius=0.5).flipped()])
    if blind:
        _know_nothing(monkeypatch)
    near, far = np.array([[-0.45, 0.0, 0.4]]), np.array([[0.45, 0.0, 0.4]])
    contact = cg.Contact(body, cg.Slave(near, area=[1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.start(near)
    state = contact.step(state, 1.1 * near)
    assert state.status[0] == Is.FREE
    assert contact.step(state, far).status[0] == Is.NEW


@pytest.mark.parametrize("blind", [False, True])
def test_a_foot_that_is_the_closest_point_stays_though_the_way_led_through_a_cavity(
    monkeypatch: pytest.MonkeyPatch, blind: bool
) -> None:
    body = cg.Body([cg.shapes.sphere(), cg.shapes.sphere(radius=0.5).flipped()])
    if blind:
        _know_nothing(monkeypatch)
    # Nor does the ball at its foot tell.
    monkeypatch.setattr(ExactSurface, "contact_tables", property(lambda _: None))
    near, far = np.array([[-0.35, 0.0, 0.45]]), np.array([[0.35, 0.0, 0.45]])
    contact = cg.Contact(body, cg.Slave(near, area=[1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.start(0.5 * near)
    assert contact.step(state, near).status[0] == Is.NEW
    state = contact.step(contact.step(state, near), far)
    assert state.status[0] == Is.OLD
    assert state.penetration[0] == pytest.approx(np.linalg.norm(far) - 0.5)
