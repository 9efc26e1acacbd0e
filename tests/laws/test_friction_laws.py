"""Properties of friction, for any path, load and surface."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from contiga.laws.friction import Coulomb, Friction, FrictionInput, FrictionOutput, ViscousFriction

seeds = st.integers(0, 2**32 - 1)
LAWS = [
    Coulomb(0.4, 0.2, decay=0.7),
    Coulomb(0.4, 0.2, decay=0.7, stiffness=30.0, per_area=True),
    ViscousFriction(0.3, speed=0.5),
]


def scenes(seed: int, n: int = 12, steps: int = 6) -> list[FrictionInput]:
    """Steps of n points on a surface that curves; the memories are left to be filled."""
    rng = np.random.default_rng(seed)
    normal, found = np.zeros((n, 3)), []
    for step in range(steps):
        before = normal
        normal = before + rng.normal(scale=0.3 if step else 1.0, size=(n, 3))
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        force = rng.uniform(0.0, 5.0, n) * rng.integers(0, 4, n).clip(0, 1)
        stiffness, area = rng.uniform(1.0, 100.0, n), rng.uniform(0.1, 2.0, n)
        path, velocity = rng.normal(scale=0.1, size=(n, 3)), rng.normal(size=(n, 3))
        none = np.zeros((n, 0))
        found.append(
            FrictionInput(normal, before, force, stiffness, area, path, velocity, 0.1, none)
        )
    return found


def follow(law: Friction, inputs: list[FrictionInput]) -> list[FrictionOutput]:
    memory, answers = np.zeros((len(inputs[0].force), law.n_memory)), []
    for inp in inputs:
        answers.append(law.respond(inp._replace(memory=memory)))
        memory = answers[-1].memory
    return answers


@pytest.mark.parametrize("law", LAWS)
@given(seeds)
def test_tractions_are_tangential_within_the_cone_and_never_make_energy(law, seed) -> None:
    inputs = scenes(seed)
    for inp, answer in zip(inputs, follow(law, inputs), strict=True):
        size = np.linalg.norm(answer.force, axis=1)
        largest = law.static if isinstance(law, Coulomb) else law.coefficient
        assert (size <= largest * inp.force * (1 + 1e-14)).all()
        assert (np.abs((answer.force * inp.normal).sum(axis=1)) <= 1e-14 * (1 + size)).all()
        for column in range(0, law.n_memory - 1, 3):
            way = answer.memory[:, column : column + 3]
            assert (np.abs((way * inp.normal).sum(axis=1)) <= 1e-14 * (1 + size)).all()
        assert (answer.lost >= 0.0).all()
        assert (answer.stored >= 0.0).all()


@pytest.mark.parametrize("law", LAWS)
@given(seeds)
def test_a_scene_turned_as_a_whole_turns_the_answer(law, seed) -> None:
    turn = Rotation.random(random_state=seed % 1000).as_matrix()
    inputs = scenes(seed)
    vectors = ("normal", "normal_before", "path", "velocity")
    turned = [
        inp._replace(**{name: getattr(inp, name) @ turn.T for name in vectors}) for inp in inputs
    ]
    for one, other in zip(follow(law, inputs), follow(law, turned), strict=True):
        np.testing.assert_allclose(other.force, one.force @ turn.T, rtol=1e-12, atol=1e-12)
        for name in ("stiffness", "stored", "lost"):
            np.testing.assert_allclose(
                getattr(other, name), getattr(one, name), rtol=1e-12, atol=1e-12
            )


@pytest.mark.parametrize("law", LAWS)
@given(seeds)
def test_points_in_another_order_have_the_same_bits(law, seed) -> None:
    inputs = scenes(seed)
    order = np.random.default_rng(seed).permutation(len(inputs[0].force))
    mixed = [
        FrictionInput(*(v[order] if isinstance(v, np.ndarray) else v for v in inp))
        for inp in inputs
    ]
    for one, other in zip(follow(law, inputs), follow(law, mixed), strict=True):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(b, a[order])


@pytest.mark.parametrize("law", LAWS)
def test_rows_alone_have_the_same_bits_as_many_thousands_together(law) -> None:
    inputs, few = scenes(7, n=9000, steps=2), slice(4090, 4100)
    alone = [
        FrictionInput._make(v[few] if isinstance(v, np.ndarray) else v for v in inp)
        for inp in inputs
    ]
    for one, other in zip(follow(law, inputs), follow(law, alone), strict=True):
        assert len(one.force) == 9000
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(b, a[few])


@settings(deadline=None)
@given(seeds, st.sampled_from([0.01, 0.1, 1.0]))
def test_on_a_plane_the_work_of_the_mean_traction_is_what_is_stored_and_lost(seed, size) -> None:
    rng = np.random.default_rng(seed)
    law, n = Coulomb(0.3, stiffness=50.0), 8
    up = np.tile([0.0, 0.0, 1.0], (n, 1))
    force = rng.uniform(1.0, 20.0, n)
    none = np.zeros(n)
    memory, traction, stored = np.zeros((n, 7)), np.zeros((n, 3)), np.zeros(n)
    for _ in range(30):
        path = rng.normal(scale=size, size=(n, 3))
        answer = law.respond(
            FrictionInput(up, up, force, none, none, path, 0.0 * path, 0.1, memory)
        )
        flat = path * [1.0, 1.0, 0.0]
        work = -(0.5 * (traction + answer.force) * flat).sum(axis=1)
        np.testing.assert_allclose(
            work, answer.stored - stored + answer.lost, rtol=1e-11, atol=1e-12 * size
        )
        memory, traction, stored = answer.memory, answer.force, answer.stored
