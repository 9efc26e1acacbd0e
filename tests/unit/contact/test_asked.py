"""Few points that need their closest points, judged by the kernel that has settled the others."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.contact.state import State
from contiga.search.exact_surface import ExactSurface

from .pointed import pointed_ball

WAYS = [0.02, -1.5e-3, *(-1.6e-3 + 3e-4 * np.sin(1.3 * np.arange(60))), 2e-3, -1e-3, -2e-2, -0.1]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many closest points are asked for from Python, one entry a call."""
    told: list[int] = []
    closest = ExactSurface.closest

    def counted(surface: Any, p_B: Any, rows: np.ndarray, *rest: Any) -> None:
        told.append(len(rows))
        closest(surface, p_B, rows, *rest)

    monkeypatch.setattr(ExactSurface, "closest", counted)
    return told


def pressed(ways: list[float] | None = None, **how: Any) -> list[State]:
    """A ball whose point, where no balls touch that are known of, presses a sheet."""
    sheet = cg.clouds.sample(cg.shapes.plane(width=0.55, length=0.55), 12, 12)
    ball = pointed_ball()
    law, area = cg.PenaltyLaw(1.0), cg.NodalArea(1.0)
    contact = cg.Contact(ball, cg.Slave(sheet), law=law, area=area, **how)
    poses = [cg.motion.pose.translation([0.0, 0.0, 1.0 + up]) for up in ways or WAYS]
    values = [contact.start(sheet, poses[0])]
    for pose in poses[1:]:
        values.append(contact.step(values[-1], sheet, pose))
    return values


def bits(state: State) -> dict[str, bytes]:
    return {f.name: np.asarray(getattr(state, f.name)).tobytes() for f in fields(State)}


HOW: dict[str, dict[str, Any]] = {
    "plain": {},
    "by penetration": {"search": "penetration"},
    "no deeper": {"search": "penetration", "depth": 1e-3},
}


@pytest.mark.parametrize("how", HOW)
def test_the_bits_are_those_of_points_judged_one_question_after_the_other(
    monkeypatch: pytest.MonkeyPatch, asked: list[int], how: str
) -> None:
    now = pressed(**HOW[how])
    few = sum(asked)
    monkeypatch.setattr(ExactSurface, "pinned_parts", lambda *_: None)
    asked.clear()
    for k, (one, other) in enumerate(zip(now, pressed(**HOW[how]), strict=True)):
        assert bits(one) == bits(other), k
    assert sum(asked) > few + 30
    assert max(state.n_contact for state in now) >= 4


def test_steps_without_new_contacts_ask_nothing_from_python(asked: list[int]) -> None:
    pressed(WAYS[:2])
    coming_in = asked.copy()
    asked.clear()
    states = pressed(WAYS[:-4])
    assert [state.n_contact for state in states[1:]] == [4] * 61
    assert asked == coming_in
