"""World forces, the wrench and the energies of a step, against the same in plain NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.contact.kernels import totals_nb
from contiga.contact.loads import NO_FORCES, NO_POINTS, NONE, Column
from contiga.contact.respond import ContactRows, Frame, LastForces, LawForces, PointForces

pytestmark = pytest.mark.interpreted

N = 40


def some(rng: np.random.Generator, *shape: int) -> Column:
    """Some rows of N, ascending, and values of them."""
    rows = np.flatnonzero(rng.random(N) < 0.5).astype(np.int32)
    return Column(rows, rng.normal(size=(len(rows), *shape)))


def whole(column: Column) -> np.ndarray:
    out = np.zeros((N, *column.values.shape[1:]))
    out[column.rows] = column.values
    return out


def half_work(force: np.ndarray, way: np.ndarray) -> float:
    return float(-0.5 * (force * way).sum())


def unfilled(k: int) -> PointForces:
    return PointForces(
        np.full((k, 3), np.nan), np.full(k, np.nan), np.full(totals_nb.TOTALS, np.nan)
    )


@pytest.fixture
def scene() -> dict[str, Any]:
    rng = np.random.default_rng(2)
    now, before = rng.normal(size=(2, N, 3))
    before[7, 1] = np.nan
    rows = np.flatnonzero(rng.random(N) < 0.4).astype(np.int32)
    way = np.where(np.isfinite(now - before), now - before, 0.0)[rows]
    carrying = ContactRows.of(rows)
    carrying.normal[:], carrying.rate[:] = rng.normal(size=way.shape), rng.normal(size=len(rows))
    carrying.path[:], carrying.rate[2] = way, 0.0
    columns = some(rng), some(rng, 3), some(rng, 3), some(rng)
    last = LastForces(*columns, rng.random(5), before, NO_FORCES)
    last.force.values[1], last.damping.values[::2] = 0.0, 0.0
    return {
        "carrying": carrying,
        "answer": rng.random((4, len(rows))),
        "friction": (rng.normal(size=(len(rows), 3)), *rng.random((2, len(rows)))),
        "last": last,
        "now": now,
        "frame": Frame(
            cg.motion.pose.rotation([1.0, 2.0, 3.0], 0.7, centre=(0.1, 0.2, 0.3)),
            rng.normal(size=3),
        ),
    }


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("rubbed", [False, True])
def test_forces_wrench_and_energies_are_those_of_plain_numpy(
    scene: dict[str, Any], damped: bool, rubbed: bool
) -> None:
    carrying, frame, last = scene["carrying"], scene["frame"], scene["last"]
    rows, normal, way, rate = carrying.rows, carrying.normal, carrying.path, carrying.rate
    size, stored, lost, damping = scene["answer"]
    friction = scene["friction"] if rubbed else (NO_POINTS, NONE, NONE)
    now, before = scene["now"], last.points
    out = unfilled(len(rows))
    answer = LawForces(size, stored, lost, damping if damped else NONE, *friction)
    assert totals_nb.forces(carrying, answer, last, now, frame, out) == damped

    force = size[:, None] * normal + (friction[0] if rubbed else 0.0)
    turn = frame.pose[:3, :3]
    np.testing.assert_allclose(out.force, force @ turn.T, rtol=1e-13)
    arm = (now[rows] - frame.reference_point) @ turn.T
    np.testing.assert_allclose(out.totals[:3], -out.force.sum(axis=0), rtol=1e-13)
    np.testing.assert_allclose(out.totals[3:6], -np.cross(arm, out.force).sum(axis=0), rtol=1e-12)
    if damped:
        each = np.where(rate != 0.0, np.abs(damping / np.where(rate != 0.0, rate, 1.0)), 0.0)
        np.testing.assert_array_equal(out.viscosity, each)

    f, n, t, d = map(whole, last[:4])
    own = np.flatnonzero(f)
    went = np.where(np.isfinite(now - before), now - before, 0.0)
    before_now = half_work(f[own, None] * n[own] + t[own], went[own])
    work = before_now + half_work(force, way)
    took = np.flatnonzero(d)
    taken = half_work(damping[:, None] * normal, way) if damped else 0.0
    taken += half_work(d[took, None] * n[took], went[took])
    added = [work, 0.0, lost.sum(), taken, friction[2].sum()]
    wanted = last.energies + added
    wanted[1] = stored.sum() + friction[1].sum()
    np.testing.assert_array_equal(out.totals[6:], wanted)


def test_a_law_that_damps_nothing_has_no_viscosity(scene: dict[str, Any]) -> None:
    size, stored, lost, damping = scene["answer"]
    answer = LawForces(size, stored, lost, 0.0 * damping, NO_POINTS, NONE, NONE)
    out, given = unfilled(len(size)), (scene["now"], scene["frame"])
    assert not totals_nb.forces(scene["carrying"], answer, scene["last"], *given, out)
