"""What does not change a contact: rigid motion of everything, scale, refinement of the master."""

from __future__ import annotations

from functools import cache

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sample import FULL

import contiga as cg
from contiga.rigid import pose

SETTINGS = settings(max_examples=25, deadline=None, derandomize=True)
# Each example makes bodies of its own, with all their tables; CONTIGA_FULL=1 asks for all.
FEW = SETTINGS if FULL else settings(SETTINGS, max_examples=3)

angles = st.floats(-3.0, 3.0)
shifts = st.tuples(*3 * [st.floats(-50.0, 50.0)])
axes = st.tuples(*3 * [st.floats(-1.0, 1.0)]).filter(lambda a: np.linalg.norm(a) > 0.1)
seeds = st.integers(0, 2**31 - 1)
shapes = st.sampled_from(["torus", "ellipsoid", "bumpy_plate", "saddle", "cylinder"])

STEPS = 4


def _path(seed: int, n: int = 60) -> list[np.ndarray]:
    """Points that wander about a shape of size about one to five."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.5, 1.5, (n, 3)) * [1.5, 1.5, 1.0]
    path = [points]
    for _ in range(STEPS):
        path.append(path[-1] + rng.normal(scale=0.15, size=(n, 3)))
    return path


def _respond(
    master: cg.Body,
    path: list[np.ndarray],
    law: object | None = None,
    poses: list[np.ndarray] | None = None,
    area: float = 0.3,
) -> list[cg.State]:
    cloud = cg.Slave(path[0], area=np.full(len(path[0]), area))
    chosen = cg.PenaltyLaw(2.0, per_area=True) if law is None else law
    contact = cg.Contact(master, cloud, law=chosen)  # type: ignore[arg-type]
    poses = [np.eye(4)] * len(path) if poses is None else poses
    states = [contact.start(path[0], poses[0])]
    for points, X_WB in zip(path[1:], poses[1:], strict=True):
        states.append(contact.step(states[-1], points, X_WB, dt=0.5))
    return states


@cache
def _body(name: str) -> cg.Body:
    return cg.Body([getattr(cg.shapes, name)()])


@FEW
@given(shape=shapes, seed=seeds, axis=axes, angle=angles, shift=shifts)
def test_rigid_motion_of_everything_turns_the_response_along(
    shape: str, seed: int, axis: tuple[float, ...], angle: float, shift: tuple[float, ...]
) -> None:
    X = pose.compose(pose.translation(shift), pose.rotation(axis, angle))
    path = _path(seed)
    moved_path = [pose.apply(X, points) for points in path]
    body = _body(shape)
    plain = _respond(body, path)
    by_pose = _respond(body, moved_path, poses=[X] * len(path))
    by_geometry = _respond(body.transformed(X), moved_path)
    R = X[:3, :3]
    for a, *others in zip(plain, by_pose, by_geometry, strict=True):
        for b in others:
            np.testing.assert_array_equal(a.status, b.status)
            np.testing.assert_allclose(b.penetration, a.penetration, rtol=0, atol=1e-10)
            np.testing.assert_allclose(b.force, a.force @ R.T, rtol=0, atol=1e-7)
            turned = np.concatenate([R @ a.wrench[:3], R @ a.wrench[3:]])
            np.testing.assert_allclose(b.wrench, turned, rtol=0, atol=1e-5)


@FEW
@given(shape=shapes, seed=seeds, scale=st.sampled_from([1e-6, 1e-3, 0.37, 25.4, 1e6]))
def test_penetration_scales_with_everything(shape: str, seed: int, scale: float) -> None:
    path = _path(seed)
    plain = _respond(_body(shape), path)
    scaled = _respond(_body(shape).scaled(scale), [scale * p for p in path], area=0.3 * scale**2)
    for a, b in zip(plain, scaled, strict=True):
        np.testing.assert_array_equal(a.status, b.status)
        np.testing.assert_allclose(b.penetration, scale * a.penetration, rtol=0, atol=1e-11 * scale)
        # Stiffness per area: force = k A λ grows with the cube of the scale.
        expected = scale**3 * np.asarray(a.total_force)
        np.testing.assert_allclose(b.total_force, expected, rtol=0, atol=1e-7 * scale**3)


@FEW
@given(shape=shapes, seed=seeds, factor=st.floats(0.01, 100.0))
def test_forces_of_stress_laws_scale_with_area_and_total_forces_do_not(
    shape: str, seed: int, factor: float
) -> None:
    path = _path(seed)
    body = _body(shape)
    for law, power in ((cg.StressLaw(2.0, 0.5, damping=0.1), 1), (cg.ForceLaw(3.0), 0)):
        plain = _respond(body, path, law)[-1]
        wide = _respond(body, path, law, area=0.3 * factor)[-1]
        np.testing.assert_array_equal(wide.status, plain.status)
        expected = factor**power * plain.force
        np.testing.assert_allclose(wide.force, expected, rtol=1e-12, atol=1e-13)


REFINEMENTS = {
    "knots": lambda s: s.insert_knots(u=[_at(s, 0, x) for x in (0.1, 0.33, 0.33, 0.8)],
                                      v=[_at(s, 1, x) for x in (0.2, 0.55)]),
    "degrees": lambda s: s.elevate(u=1, v=2),
    "both": lambda s: s.elevate(v=1).insert_knots(u=[_at(s, 0, 0.4)]),
}  # fmt: skip


def _at(surface: cg.NurbsSurface, direction: int, share: float) -> float:
    low, high = surface.domain[direction]
    return low + share * (high - low)


def _compare(a: list[cg.State], b: list[cg.State]) -> None:
    for one, other in zip(a, b, strict=True):
        np.testing.assert_array_equal(one.status, other.status)
        np.testing.assert_allclose(other.penetration, one.penetration, rtol=0, atol=1e-10)
        np.testing.assert_allclose(other.force, one.force, rtol=0, atol=1e-7)
        np.testing.assert_allclose(other.total_force, one.total_force, rtol=0, atol=1e-7)


@FEW
@given(shape=shapes, seed=seeds, how=st.sampled_from(sorted(REFINEMENTS)))
def test_refinement_of_the_master_leaves_the_response(shape: str, seed: int, how: str) -> None:
    path = _path(seed)
    (patch,) = _body(shape).patches
    refined = cg.Body([REFINEMENTS[how](patch)])
    _compare(_respond(_body(shape), path), _respond(refined, path))


@FEW
@given(shape=shapes, seed=seeds, share=st.floats(0.15, 0.85), along_u=st.booleans())
def test_splitting_the_master_leaves_the_response(
    shape: str, seed: int, share: float, along_u: bool
) -> None:
    path = _path(seed)
    (patch,) = _body(shape).patches
    at = _at(patch, 0 if along_u else 1, share)
    parts = patch.split(u=at) if along_u else patch.split(v=at)
    _compare(_respond(_body(shape), path), _respond(cg.Body(list(parts)), path))


@FEW
@given(shape=shapes, seed=seeds)
def test_action_is_reaction_and_forces_push_apart(shape: str, seed: int) -> None:
    for state in _respond(_body(shape), _path(seed)):
        np.testing.assert_array_equal(state.wrench[:3], -state.total_force)
        push = (state.force * state.normal).sum(axis=1)
        assert (push >= 0.0).all()
        np.testing.assert_allclose(push, np.linalg.norm(state.force, axis=1), rtol=1e-12)
        assert (state.penetration[~state.in_contact] == 0.0).all()
