"""World forces, the wrench and the energies of a step, against the same in plain NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.contact.kernels import totals_nb
from contiga.contact.loads import NONE, NOWHERE

pytestmark = pytest.mark.interpreted

N = 40
Columns = dict[str, tuple[np.ndarray, np.ndarray]]


def some(rng: np.random.Generator, *shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Some rows of N, ascending, and values of them."""
    rows = np.flatnonzero(rng.random(N) < 0.5).astype(np.int32)
    return rows, rng.normal(size=(len(rows), *shape))


def whole(column: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    out = np.zeros((N, *column[1].shape[1:]))
    out[column[0]] = column[1]
    return out


def half_work(force: np.ndarray, way: np.ndarray) -> float:
    return float(-0.5 * (force * way).sum())


@pytest.fixture
def scene() -> dict[str, Any]:
    rng = np.random.default_rng(2)
    now, before = rng.normal(size=(2, N, 3))
    before[7, 1] = np.nan
    rows = np.flatnonzero(rng.random(N) < 0.4).astype(np.int32)
    way = np.where(np.isfinite(now - before), now - before, 0.0)[rows]
    normal, rate = rng.normal(size=(len(rows), 3)), rng.normal(size=len(rows))
    rate[2] = 0.0
    last = some(rng), some(rng, 3), some(rng, 3), some(rng), rng.random(5)
    last[0][1][1], last[3][1][::2] = 0.0, 0.0
    return {
        "carrying": (rows, normal, way, rate),
        "answer": rng.random((4, len(rows))),
        "friction": (rng.normal(size=(len(rows), 3)), *rng.random((2, len(rows)))),
        "last": last,
        "path": (now, before),
        "pose": cg.motion.pose.rotation([1.0, 2.0, 3.0], 0.7, centre=(0.1, 0.2, 0.3)),
        "about": rng.normal(size=3),
    }


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("rubbed", [False, True])
def test_forces_wrench_and_energies_are_those_of_plain_numpy(
    scene: dict[str, Any], damped: bool, rubbed: bool
) -> None:
    rows, normal, way, rate = scene["carrying"]
    size, stored, lost, damping = scene["answer"]
    friction = scene["friction"] if rubbed else (NOWHERE, NONE, NONE)
    now, before = scene["path"]
    k = len(rows)
    out = np.full((k, 3), np.nan), np.full(k, np.nan), np.full(totals_nb.TOTALS, np.nan)
    answer = size, stored, lost, damping if damped else NONE, *friction
    frame = scene["pose"], scene["about"]
    viscous = totals_nb.forces(scene["carrying"], answer, scene["last"], scene["path"], frame, out)
    assert viscous == damped

    force = size[:, None] * normal + (friction[0] if rubbed else 0.0)
    turn = scene["pose"][:3, :3]
    np.testing.assert_allclose(out[0], force @ turn.T, rtol=1e-13)
    arm = (now[rows] - scene["about"]) @ turn.T
    np.testing.assert_allclose(out[2][:3], -out[0].sum(axis=0), rtol=1e-13)
    np.testing.assert_allclose(out[2][3:6], -np.cross(arm, out[0]).sum(axis=0), rtol=1e-12)
    if damped:
        each = np.where(rate != 0.0, np.abs(damping / np.where(rate != 0.0, rate, 1.0)), 0.0)
        np.testing.assert_array_equal(out[1], each)

    f, n, t, d = map(whole, scene["last"][:4])
    own = np.flatnonzero(f)
    went = np.where(np.isfinite(now - before), now - before, 0.0)
    before_now = half_work(f[own, None] * n[own] + t[own], went[own])
    work = before_now + half_work(force, way)
    took = np.flatnonzero(d)
    taken = half_work(damping[:, None] * normal, way) if damped else 0.0
    taken += half_work(d[took, None] * n[took], went[took])
    added = [work, 0.0, lost.sum(), taken, friction[2].sum()]
    wanted = scene["last"][4] + added
    wanted[1] = stored.sum() + friction[1].sum()
    np.testing.assert_array_equal(out[2][6:], wanted)


def test_a_law_that_damps_nothing_has_no_viscosity(scene: dict[str, Any]) -> None:
    size, stored, lost, damping = scene["answer"]
    answer = size, stored, lost, 0.0 * damping, NOWHERE, NONE, NONE
    out = np.empty((len(size), 3)), np.empty(len(size)), np.empty(totals_nb.TOTALS)
    frame = scene["pose"], scene["about"]
    assert not totals_nb.forces(scene["carrying"], answer, scene["last"], scene["path"], frame, out)
