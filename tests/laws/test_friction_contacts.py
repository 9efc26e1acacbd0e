"""Contacts with friction: what rigid motion, seams and patches must not change, and balance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg

pose = cg.motion.pose


def fillet(*, radius: float = 0.5) -> cg.Body:
    """Two planes and the quarter of a cylinder that rounds the corner between them."""
    side = cg.shapes.line((radius, -1.0, 0.0), (radius, 0.0, 0.0))
    round_ = cg.shapes.arc(radius=radius, start=0.0, end=0.5 * np.pi)
    top = cg.shapes.line((0.0, radius, 0.0), (-1.0, radius, 0.0))
    return cg.Body([cg.shapes.extruded(c, (0.0, 0.0, 1.5)) for c in (side, round_, top)])


BODIES = {"torus": cg.Body([cg.shapes.torus(major=1.0, minor=0.4)]), "fillet": fillet()}
LAWS = {
    "stiff": cg.PenaltyLaw(50.0, per_area=True),
    "damped": cg.StressLaw(20.0, 0.5, damping=0.3),
    "total": cg.ForceLaw(30.0),
}
STEPS = 12


def cloud(body: cg.Body) -> np.ndarray:
    """Points a little outside a body, all over it."""
    on = np.vstack([cg.clouds.sample(patch, 9, 8) for patch in body.patches])
    foot = body.project(on)
    return foot.point + 0.01 * foot.normal


def history(body: cg.Body) -> list[np.ndarray]:
    """The cloud as it is pushed into the body on one side, and slides and turns there."""
    start, centre = cloud(body), body.bounds().mean(axis=0)
    along = np.array([-0.7, -0.6, 0.1])
    path = []
    for s in np.linspace(0.0, 1.0, STEPS + 1):
        turn = pose.rotation((0.2, -0.1, 1.0), 0.15 * np.sin(4.0 * s), centre)
        path.append(pose.apply(turn, start) + 0.06 * np.sin(2.2 * s) * along)
    return path


def carried(k: int) -> np.ndarray:
    """A further motion of the whole scene: it turns and goes far.

    It turns little in a step: points go straight in the world between its ends, and as the body
    sees it on arcs, which must not take them out of contact for long.
    """
    turn = pose.rotation((1.0, 2.0, -0.5), 2.0 + 0.04 * k)
    return pose.compose(pose.translation(np.array([1.5, -0.7, 0.4]) * k), turn)


def follow(
    contact: cg.Contact, path: list[np.ndarray], poses: list[np.ndarray], rates: bool
) -> list[cg.State]:
    """States along a path in the body's axes; each step takes 0.1, with rates made up for it."""
    rng = np.random.default_rng(7)
    states = [contact.start(pose.apply(poses[0], path[0]), poses[0])]
    for p, X_WB in zip(path[1:], poses[1:], strict=True):
        given: dict[str, Any] = {}
        if rates:
            own, (v, w) = rng.normal(size=p.shape), rng.normal(size=(2, 3))
            arm = p @ X_WB[:3, :3].T
            given["velocity"] = own @ X_WB[:3, :3].T + v + np.cross(w, arm)
            given["twist"] = v, w
        states.append(contact.step(states[-1], pose.apply(X_WB, p), X_WB, 0.1, **given))
    return states


def contact_of(body: cg.Body, law: Any, friction: Any = None) -> cg.Contact:
    start = cloud(body)
    slave = cg.Slave(start, area=np.full(len(start), 0.02))
    return cg.Contact(body, slave, law=law, friction=friction or cg.Coulomb(0.4, 0.25, decay=0.5))


@pytest.mark.parametrize("rates", [False, True], ids=["steps", "velocities"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", BODIES)
def test_a_motion_of_the_whole_scene_turns_forces_and_slips_along(name, law, rates) -> None:
    body, path = BODIES[name], history(BODIES[name])
    contact = contact_of(body, LAWS[law])
    poses = [carried(k) for k in range(STEPS + 1)]
    at_rest = follow(contact, path, [np.eye(4)] * (STEPS + 1), rates)
    moved = follow(contact, path, poses, rates)
    assert at_rest[-1].n_contact > 10
    assert np.abs(at_rest[-1].friction).max() > 0.1 * at_rest[-1].normal_force.max()
    force, slip = (max(np.abs(getattr(s, v)).max() for s in at_rest) for v in ("force", "slip"))
    for a, b, X_WB in zip(at_rest, moved, poses, strict=True):
        R = X_WB[:3, :3]
        np.testing.assert_array_equal(a.in_contact, b.in_contact)
        np.testing.assert_allclose(b.force @ R, a.force, rtol=0, atol=1e-12 * force)
        np.testing.assert_allclose(b.friction @ R, a.friction, rtol=0, atol=1e-12 * force)
        np.testing.assert_allclose(b.slip @ R, a.slip, rtol=0, atol=1e-12 * slip)
        np.testing.assert_allclose(b.energy, a.energy, rtol=0, atol=1e-12 * a.energy.work)


@pytest.mark.parametrize("name", BODIES)
def test_a_motion_of_the_whole_scene_makes_no_slip_and_takes_no_work(name) -> None:
    body, path = BODIES[name], history(BODIES[name])[:7]
    still, n = [path[-1]] * 60, len(path) + 60
    poses = [carried(k) for k in range(n)]
    contact = contact_of(body, LAWS["stiff"], cg.Coulomb(0.4))
    states = follow(contact, path + still, poses, rates=False)
    pressed, last = states[6], states[-1]
    assert np.abs(pressed.friction).max() > 0.0
    R, Q = (poses[k][:3, :3] for k in (6, n - 1))
    force, slip = np.abs(pressed.force).max(), np.abs(pressed.slip).max()
    np.testing.assert_allclose(last.friction @ Q, pressed.friction @ R, rtol=0, atol=3e-11 * force)
    np.testing.assert_allclose(last.slip @ Q, pressed.slip @ R, rtol=0, atol=3e-12 * slip)
    np.testing.assert_allclose(last.energy, pressed.energy, rtol=0, atol=1e-11 * last.energy.work)


def sheet(n: int) -> cg.Slave:
    """A flat square of n × n nodes above a body of size two."""
    points, quads = square_sheet(3.2, n)
    return cg.Slave(points + np.array([0.01, 0.02, 0.41]), quads)


@pytest.mark.parametrize("quadrature", ["nodes", 1, 3, 6, 12])
def test_action_is_reaction_with_friction_and_so_are_the_moments(quadrature) -> None:
    patch, about = cg.shapes.torus(major=1.0, minor=0.4), np.array([0.3, -2.0, 1.0])
    body, slave = cg.Body([patch], reference_point=about), sheet(21)
    law = cg.StressLaw(20.0, 0.5, damping=0.3)
    contact = cg.Contact(body, slave, law=law, friction=cg.Coulomb(0.5), quadrature=quadrature)
    poses = [carried(k) for k in range(9)]
    path = [slave.points + np.array([0.02 * k, -0.01 * k, -0.03 * min(k, 3)]) for k in range(9)]
    path = [pose.apply(pose.rotation("z", 0.03 * k), p) for k, p in enumerate(path)]
    for k, state in enumerate(follow(contact, path, poses, rates=False)[1:], start=1):
        assert state.n_contact > 20
        np.testing.assert_array_equal(state.wrench[:3], -state.force.sum(axis=0))
        p_W, arm_W = (pose.apply(poses[k], p) for p in (path[k], about[None]))
        moments = np.cross(p_W - arm_W, state.force)
        size = np.abs(moments).sum(axis=0).max()
        np.testing.assert_allclose(
            state.wrench[3:], -moments.sum(axis=0), rtol=0, atol=1e-14 * size
        )
        slid = np.abs(np.cross(state.friction, state.normal)).sum()
        assert slid > 0.05 * np.abs(state.normal_force).sum()


def split(patch: cg.NurbsSurface) -> cg.Body:
    """The patch in nine pieces that join without sharing anything."""
    pieces = []
    for part in thirds(patch, "u"):
        pieces.extend(thirds(part, "v"))
    return cg.Body(pieces)


def thirds(patch: cg.NurbsSurface, along: str) -> list[cg.NurbsSurface]:
    """The patch cut twice along a direction."""
    low, high = patch.domain["uv".index(along)]
    first, rest = patch.split(**{along: low + 0.31 * (high - low)})
    return [first, *rest.split(**{along: low + 0.62 * (high - low)})]


BALLS = {
    "one patch": cg.Body([cg.shapes.sphere()]),
    "nine patches": split(cg.shapes.sphere()),
    "pole along x": cg.Body([cg.shapes.sphere(axis="x")]),
}


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-3, 0.7])
@pytest.mark.parametrize("name", BALLS)
def test_a_great_circle_over_seams_and_poles_is_as_any_other(name, tilt) -> None:
    mu, depth, steps, n = 0.3, 0.01, 400, 5
    # From one side of the seam through the poles and round, and beside that.
    first = pose.rotation("z", 0.3 if tilt == 0.7 else 0.0) @ pose.rotation("x", tilt)
    angle = np.linspace(0.0, 2.0 * np.pi, steps + 1)[:, None] + 0.05 * np.arange(n)
    along = np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=-1) @ first[:3, :3].T
    ahead = np.stack([-np.sin(angle), 0.0 * angle, np.cos(angle)], axis=-1) @ first[:3, :3].T
    law, friction = cg.PenaltyLaw(100.0), cg.Coulomb(mu)
    contact = cg.Contact(
        BALLS[name], cg.Slave(along[0], area=np.ones(n)), law=law, friction=friction
    )
    state = contact.start(1.01 * along[0])
    for k in range(steps + 1):
        state = contact.step(state, (1.0 - depth) * along[k])
        assert state.n_contact == n
        # As exact as the feet, which turn the normals by 1e-11.
        gone = (1.0 - depth) * k * np.sin(angle[1, 0] - angle[0, 0])
        np.testing.assert_allclose(state.slip, gone * ahead[k], rtol=0, atol=1e-10 * (1 + gone))
        if k > 0:
            full = -mu * 100.0 * depth
            np.testing.assert_allclose(state.friction, full * ahead[k], rtol=0, atol=1e-10)


def bent(rise: float) -> cg.Body:
    """Two planes that meet in the line x = y = 0 and rise, or fall, to both sides; y is up."""
    right, middle, left = (1.0, rise, -0.5), (0.0, 0.0, -0.5), (-1.0, rise, -0.5)
    parts = [cg.shapes.line(right, middle), cg.shapes.line(middle, left)]
    return cg.Body([cg.shapes.extruded(part, (0.0, 0.0, 1.0)) for part in parts])


@pytest.mark.parametrize("across", [0.0, 0.5])
@pytest.mark.parametrize("rise", [0.1, -0.1], ids=["valley", "ridge"])
def test_traction_goes_on_over_a_crease(rise, across) -> None:
    mu, depth, steps = 0.3, 0.02, 400
    x = np.linspace(0.03, -0.03, steps + 1)
    path = np.stack([x, np.full(steps + 1, -depth), across * x], axis=-1)[:, None, :]
    law, friction = cg.PenaltyLaw(100.0), cg.Coulomb(mu)
    contact = cg.Contact(bent(rise), cg.Slave(path[0], area=[1.0]), law=law, friction=friction)
    state = contact.step(contact.start(path[0] + [-0.1 * rise, 0.1, 0.0]), path[0])
    states = [state := contact.step(state, p) for p in path[1:]]
    normal, traction, slip = (
        np.array([getattr(s, name)[0] for s in states]) for name in ("normal", "friction", "slip")
    )
    force = np.array([s.normal_force[0] for s in states])
    # Sliding from about the fiftieth step on, until the end, against the motion.
    np.testing.assert_allclose(np.linalg.norm(traction[50:], axis=1), mu * force[50:], rtol=1e-12)
    np.testing.assert_allclose((traction * normal).sum(axis=1), 0.0, atol=1e-12)
    assert (traction[50:] @ [-1.0, 0.0, -across] < 0.0).all()
    # It changes by what the normals and the normal force do, and no more.
    turned, risen = (np.linalg.norm(np.diff(v, axis=0), axis=-1) for v in (normal, force[:, None]))
    changed = np.linalg.norm(np.diff(traction, axis=0), axis=1)[50:]
    assert (changed <= 1.5 * mu * (force[51:] * turned[50:] + risen[50:])).all()
    jump = np.linalg.norm(np.diff(slip, axis=0), axis=1)
    way = np.linalg.norm(path[1, 0] - path[0, 0])
    assert (jump <= way + 1.5 * turned * np.linalg.norm(slip[1:], axis=1)).all()
    # Under a valley the normals turn bit by bit, under a ridge at once.
    assert (turned.max() < 0.01) == (rise > 0.0)


def test_a_point_that_sticks_on_a_round_body_does_not_creep() -> None:
    """To and fro along and into a torus, a thousand times, within the cone."""
    start = np.array([[1.05, 0.3, 0.35], [0.2, -1.3, 0.2], [-0.62, 0.1, -0.05]])
    body, n = BODIES["torus"], len(start)
    foot = body.project(start)
    normal = foot.normal
    side = np.cross(normal, [0.3, -0.2, 1.0])
    law, friction = cg.PenaltyLaw(100.0), cg.Coulomb(0.9)
    contact = cg.Contact(body, cg.Slave(start, area=np.ones(n)), law=law, friction=friction)
    state = contact.start(foot.point + 0.01 * normal)
    for _ in range(1000):
        for depth, way in ((0.02, 0.0), (0.025, 0.012)):
            state = contact.step(state, foot.point - depth * normal + way * side)
    state = contact.step(state, foot.point - 0.02 * normal)
    assert state.n_contact == n
    assert state.energy.friction < 1e-12
    np.testing.assert_allclose(state.friction, 0.0, rtol=0, atol=1e-10)
    np.testing.assert_allclose(state.slip, 0.0, rtol=0, atol=1e-12)
