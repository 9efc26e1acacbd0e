"""How frictions change with their input, in any direction, against differences."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.laws.friction import FrictionChange, FrictionInput

N, WAYS = 30, 4
LAWS = [
    cg.Coulomb(0.4),
    cg.Coulomb(0.4, 0.1, decay=0.7),
    cg.Coulomb(0.4, stiffness=3.0, per_area=True),
    cg.ViscousFriction(0.3, speed=0.5),
]


def unit(rows: np.ndarray) -> np.ndarray:
    return rows / np.linalg.norm(rows, axis=1)[:, None]


def seen_by(law: object, rng: np.random.Generator) -> FrictionInput:
    normal = unit(rng.normal(size=(N, 3)))
    before = unit(normal + 0.3 * rng.normal(size=(N, 3)))
    before[:4] = 0.0  # without a past
    memory = np.zeros((N, law.n_memory))
    traction = 0.3 * rng.normal(size=(N, 3))
    memory[:, :3] = traction - (traction * before).sum(axis=1)[:, None] * before
    if law.n_memory == 7:
        memory[:, 6] = rng.uniform(0.5, 3.0, N)
        memory[:4] = 0.0
    force, stiffness, area = rng.uniform(0.2, 9.0, (3, N))
    path, velocity = 0.2 * rng.normal(size=(2, N, 3))
    return FrictionInput(normal, before, force, stiffness, area, path, velocity, 0.1, memory)


def along(seen: FrictionInput, change: FrictionChange, j: int, share: float) -> FrictionInput:
    """The input a little on in direction j; normals turn and stay of length one to second order."""
    turned = seen.normal + share * change.normal[:, :, j]
    return seen._replace(
        force=seen.force + share * change.force[:, j],
        stiffness=seen.stiffness + share * change.stiffness[:, j],
        normal=unit(turned),
        path=seen.path + share * change.path[:, :, j],
        velocity=seen.velocity + share * change.velocity[:, :, j],
    )


@pytest.mark.interpreted
@pytest.mark.parametrize("law", LAWS)
def test_against_differences_in_each_direction(law: object) -> None:
    rng = np.random.default_rng(0)
    seen = seen_by(law, rng)
    turn = rng.normal(size=(N, 3, WAYS))
    turn -= seen.normal[:, :, None] * np.einsum("nc,ncj->nj", seen.normal, turn)[:, None, :]
    change = FrictionChange(
        rng.normal(size=(N, WAYS)),
        rng.normal(size=(N, WAYS)),
        turn,
        *rng.normal(size=(2, N, 3, WAYS)),
    )
    found, h = law.changes(seen, change), 1e-5
    if isinstance(law, cg.Coulomb):
        pull, free = (
            np.linalg.norm(law.respond(seen._replace(force=size * seen.force)).force, axis=1)
            for size in (1.0, 1e9)
        )
        assert 0 < np.count_nonzero(np.isclose(pull, free)) < N  # some stick and some slip
    for j in range(WAYS):
        near, far = (
            law.respond(along(seen, change, j, k * h)).force
            - law.respond(along(seen, change, j, -k * h)).force
            for k in (1, 2)
        )
        wanted = (8.0 * near - far) / (12.0 * h)
        np.testing.assert_allclose(
            found[:, :, j], wanted, rtol=0.0, atol=1e-8 * np.abs(wanted).max()
        )


@pytest.mark.interpreted
@pytest.mark.parametrize("law", LAWS)
def test_at_rest_nothing_is_divided_by_zero(law: object) -> None:
    seen = seen_by(law, np.random.default_rng(1))
    still = seen._replace(path=0.0 * seen.path, velocity=0.0 * seen.velocity)
    still = still._replace(memory=0.0 * seen.memory)
    ways = np.broadcast_to(np.eye(3), (N, 3, 3)).copy()
    none = np.zeros((N, 3))
    found = law.changes(still, FrictionChange(none, none, 0.0 * ways, ways, ways))
    assert np.isfinite(found).all()
    assert (np.abs(found).max(axis=(1, 2)) > 0.0).all()
