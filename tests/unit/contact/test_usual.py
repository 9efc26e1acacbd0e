"""Usual points settled in one call: what becomes of them is what the stages make of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.contact import closed_body, usual
from contiga.contact.kernels import usual_nb

STEPS = 14
BODIES = {
    "ball": lambda: cg.Body([cg.shapes.sphere(radius=1.0)]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=1.0, minor=0.3)]),
    "box": lambda: box((-0.8, -0.6, -0.4), (0.8, 0.6, 0.4)),
}


def _states(contact: cg.Contact, points: np.ndarray) -> list[cg.State]:
    """Points that come in and go out, by small steps and large ones, while the body moves."""
    rng = np.random.default_rng(1)
    states = [contact.start(points)]
    for k in range(STEPS):
        size = (1e-6, 1e-3, 0.03, 0.3)[k % 4]
        points = points + size * rng.normal(size=points.shape)
        pose = np.eye(4)
        pose[:3, 3] = 0.01 * k, 0.0, 0.0
        states.append(contact.step(states[-1], points, pose))
    return states


@pytest.mark.parametrize("foot", ["nearest", "tracked"])
@pytest.mark.parametrize("search", ["intersection", "penetration"])
@pytest.mark.parametrize("name", BODIES)
def test_the_bits_are_those_of_the_stages(
    name: str, search: str, foot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = BODIES[name]()
    points = np.random.default_rng(0).uniform(-1.3, 1.3, (1000, 3))
    kinds: dict[str, Any] = {"search": search, "foot": foot, "on_edge": "hold"}
    slave = cg.Slave(points, area=np.ones(len(points)))
    contact = cg.Contact(body, slave, law=cg.PenaltyLaw(1.0), **kinds)
    _states(contact, points)  # from here on the balls are there
    calls: list[int] = []
    for kernel in ("settle_touching", "settle_free"):
        inner = getattr(usual_nb, kernel)

        def counted(*given: Any, inner: Any = inner) -> int:
            left = int(inner(*given))
            calls.append(len(given[2 if len(given) == 7 else 3]) - left)
            return left

        monkeypatch.setattr(usual_nb, kernel, counted)
    seen = _states(contact, points)
    assert sum(calls) > 300
    monkeypatch.setattr(closed_body.usual, "left", lambda *given: given[3])
    settled = sum(calls)
    wanted = _states(contact, points)
    assert sum(calls) == settled
    assert wanted[-1].n_contact > 0
    for own, other in zip(seen, wanted, strict=True):
        for field, values in own.arrays.items():
            assert values.tobytes() == other.arrays[field].tobytes(), field


def test_rows_of_many_chunks_are_left_in_their_order() -> None:
    rows = np.arange(100_000, dtype=np.int32)

    def settle(some: np.ndarray, work: usual.Work, left: np.ndarray) -> int:
        assert len(work.rows) >= len(some)
        odd = some[some % 7 == 3]
        left[: len(odd)] = odd
        return len(odd)

    left = usual._left(settle, rows, 1000, False)
    np.testing.assert_array_equal(left, rows[rows % 7 == 3])
