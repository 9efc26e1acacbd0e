"""Points deeper than their balls tell, settled in one call: what becomes of them is what the stages
make of them, and what has to be looked at is left."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.contact import closed_body, usual
from contiga.contact.kernels import deep_nb

BODIES = {
    "egg": lambda: cg.Body([cg.shapes.sphere(radius=1.0).scaled([1.0, 0.8, 0.5])]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=1.0, minor=0.3)]),
    "box": lambda: box((-0.8, -0.6, -0.4), (0.8, 0.6, 0.4)),
    "plate": lambda: box((-0.8, -0.6, -0.15), (0.8, 0.6, 0.15)),
}


def _states(contact: cg.Contact, points: np.ndarray) -> list[cg.State]:
    """Points that go deeper, along and out again, by small steps and a large one."""
    rng = np.random.default_rng(2)
    states = [contact.start(points)]
    for k in range(16):
        size = (0.02, 0.05, 0.001, 0.1)[k % 4]
        way = np.array([0.03, 0.01, -0.05 if k < 8 else 0.05])
        points = points + size * rng.normal(size=points.shape) + way
        states.append(contact.step(states[-1], points))
    return states


@pytest.mark.parametrize("search", ["intersection", "penetration"])
@pytest.mark.parametrize("name", BODIES)
def test_the_bits_are_those_of_the_stages(
    name: str, search: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = BODIES[name]()
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (3000, 3))
    how: dict[str, Any] = {"search": search, "on_edge": "hold"}
    contact = cg.Contact(
        body, cg.Slave(points, area=np.ones(len(points))), law=cg.PenaltyLaw(1.0), **how
    )
    _states(contact, points)  # from here on the balls are there
    chunks, left = [], [0]
    inner = deep_nb.settle_deep

    def counted(*given: Any) -> int:
        chunks.append(len(given[3]))
        left[0] += (count := int(inner(*given)))
        return count

    monkeypatch.setattr(deep_nb, "settle_deep", counted)
    seen = _states(contact, points)
    settled = sum(chunks) - left[0]
    assert settled > 30
    assert name != "egg" or max(chunks) == usual.DEEP  # several chunks in a step
    if name in ("box", "plate") and search == "intersection":
        assert left[0] > 10  # other walls come nearer, and ways lead over edges
    monkeypatch.setattr(closed_body.usual, "left", lambda *given: given[3])
    wanted = _states(contact, points)
    assert sum(chunks) - left[0] == settled
    for own, other in zip(seen, wanted, strict=True):
        for field, values in own.arrays.items():
            assert values.tobytes() == other.arrays[field].tobytes(), field


def test_of_contacts_that_keep_their_walls_none_is_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(deep_nb, "settle_deep", None)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3))
    contact = cg.Contact(
        BODIES["egg"](), cg.Slave(points, area=np.ones(200)), law=cg.PenaltyLaw(1.0), foot="tracked"
    )
    assert _states(contact, points)[-1].n_contact > 0
