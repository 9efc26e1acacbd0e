"""What is known of sides at once spares work, and changes nothing of what a step finds."""

from __future__ import annotations

import numpy as np
import pytest
from tests.stress import shaking, solids

import contiga as cg
from contiga.search.surface import ExactSurface

SAME = ("status", "feature", "patch", "penetration", "normal", "foot", "force", "area", "certified")


def _know_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def sides(_: object, __: object, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(len(rows), np.int8), np.zeros(len(rows))

    def clear_ways(*args: np.ndarray) -> np.ndarray:
        return np.zeros(len(args[-1]), dtype=bool)

    def nearby(_: object, __: object, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.full(len(rows), -1, np.int32), np.zeros((len(rows), 2))

    for method in (sides, clear_ways, nearby):
        monkeypatch.setattr(ExactSurface, method.__name__, method)


def _run(solid: solids.Solid, scale: float, search: str, n: int = 300) -> list[cg.State]:
    rng = np.random.default_rng([17, round(1e6 * scale)])
    points = shaking.cloud(solid, n, scale, rng)
    slave = cg.Slave(points, area=np.ones(n))
    contact = cg.Contact(solid.body, slave, law=cg.PenaltyLaw(1.0), search=search)
    states = [contact.start(points, shaking.pose(solid, scale, rng))]
    for _ in range(4):
        moved = points + scale * solid.size * rng.normal(scale=0.2, size=points.shape)
        states.append(contact.step(states[-1], moved, shaking.pose(solid, scale, rng)))
    return states


@pytest.mark.parametrize("name", [n for n in solids.RECIPES if not n.startswith("small")])
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
    _run(solid, 0.05, "intersection", 2000)
    few = asked
    asked = 0
    _know_nothing(monkeypatch)
    _run(solid, 0.05, "intersection", 2000)
    assert few < 0.25 * asked
