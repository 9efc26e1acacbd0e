"""Points settled in one call: what becomes of them is what looking at each one finds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.contact import settle
from contiga.contact.kernels import settle_nb
from contiga.contact.settle_records import Work


def bowl() -> cg.Body:
    """A sphere without its lowest part."""
    ball = cg.shapes.sphere(radius=1.0)
    (low, high), other = ball.domain[0], ball.domain[1]
    assert high > low
    return cg.Body(
        [ball.restricted((low, high), (other[0] + 0.3 * (other[1] - other[0]), other[1]))]
    )


BODIES = {
    "ball": lambda: cg.Body([cg.shapes.sphere(radius=1.0)]),
    "bowl": bowl,
    "egg": lambda: cg.Body([cg.shapes.sphere(radius=1.0).scaled([1.0, 0.8, 0.5])]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=1.0, minor=0.3)]),
    "box": lambda: box((-0.8, -0.6, -0.4), (0.8, 0.6, 0.4)),
    "plate": lambda: box((-0.8, -0.6, -0.15), (0.8, 0.6, 0.15)),
}


def _shaken(contact: cg.Contact, points: np.ndarray) -> list[cg.State]:
    """Points that come in and go out, by small steps and large ones, while the body moves."""
    rng = np.random.default_rng(1)
    states = [contact.start(points)]
    for k in range(14):
        size = (1e-6, 1e-3, 0.03, 0.3)[k % 4]
        points = points + size * rng.normal(size=points.shape)
        states.append(
            contact.step(states[-1], points, cg.motion.pose.translation([0.01 * k, 0, 0]))
        )
    return states


def _pressed(contact: cg.Contact, points: np.ndarray) -> list[cg.State]:
    """Points that go deeper, along and out again, by small steps and a large one."""
    rng = np.random.default_rng(2)
    states = [contact.start(points)]
    for k in range(16):
        size = (0.02, 0.05, 0.001, 0.1)[k % 4]
        way = np.array([0.03, 0.01, -0.05 if k < 8 else 0.05])
        points = points + size * rng.normal(size=points.shape) + way
        states.append(contact.step(states[-1], points))
    return states


def _contact(name: str, points: np.ndarray, **how: Any) -> cg.Contact:
    slave = cg.Slave(points, area=np.ones(len(points)))
    return cg.Contact(BODIES[name](), slave, law=cg.PenaltyLaw(1.0), **how)


@pytest.mark.parametrize("foot", ["nearest", "tracked"])
@pytest.mark.parametrize("search", ["intersection", "penetration"])
@pytest.mark.parametrize(
    ("name", "moved"),
    [
        *[(name, _shaken) for name in ("ball", "torus", "box", "bowl")],
        *[(name, _pressed) for name in ("egg", "torus", "plate")],
    ],
)
def test_nothing_changes_where_kernels_settle_points(
    name: str, moved: Any, search: str, foot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.random.default_rng(0).uniform(-1.3, 1.3, (1000, 3))
    contact = _contact(name, points, search=search, foot=foot, on_edge="hold")
    calls: list[int] = []
    for kernel in ("settle_touching", "settle_free", "settle_deep"):
        inner = getattr(settle_nb, kernel)

        def counted(*given: Any, inner: Any = inner) -> int:
            left = int(inner(*given))
            calls.append(len(given[-1]) - left)
            return left

        monkeypatch.setattr(settle_nb, kernel, counted)
    seen = moved(contact, points)
    settled = sum(calls)
    assert settled > 300 or (name, foot) == ("bowl", "tracked")
    monkeypatch.setattr(settle, "settle_points", lambda _, rows: rows)
    wanted = moved(contact, points)
    assert sum(calls) == settled
    assert wanted[-1].n_contact > 0
    for own, other in zip(seen, wanted, strict=True):
        differ = own.status != other.status
        # At a foot as near on another wall rounding decides.
        assert differ.mean() <= (0.002 if foot == "nearest" else 0.0)
        assert np.abs(own.penetration - other.penetration)[~differ].max() < 1e-11
        assert (own.in_contact == other.in_contact).all()


def test_of_contacts_that_keep_their_walls_no_closest_point_is_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(settle_nb, "settle_deep", None)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3))
    contact = _contact("egg", points, foot="tracked")
    assert _pressed(contact, points)[-1].n_contact > 0


def test_rows_of_many_chunks_are_left_in_their_order() -> None:
    rows = np.arange(100_000, dtype=np.int32)

    def settled(some: np.ndarray, work: Work, left: np.ndarray) -> int:
        assert len(work.rows) >= len(some)
        odd = some[some % 7 == 3]
        left[: len(odd)] = odd
        return len(odd)

    left = settle._settle_chunks(settled, rows, 1000, False)
    np.testing.assert_array_equal(left, rows[rows % 7 == 3])
