"""From what the search has found to forces: laws, sums over points, and where the work went."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.checks import checked_answer
from contiga.contact.energy import ContactEnergy, half_work
from contiga.contact.sparse import Sparse
from contiga.contact.state import Column, State
from contiga.contact.tracked import Detected
from contiga.laws.friction import Friction, FrictionInput, FrictionOutput
from contiga.laws.normal import Law
from contiga.num.arrays import locked
from contiga.records import FloatArray, IndexArray, IntArray, LawInput, LawOutput, Projection
from contiga.slaves.sampling import Sampling


class Past(NamedTuple):
    """How the points came where they are."""

    state: State
    """Of the last step."""
    dt: float
    velocity_B: FloatArray | None
    """(m, 3) against the body, body axes, where it is known exactly."""


class Carrying(NamedTuple):
    """The points in contact that carry forces, one row each, body axes."""

    rows: IntArray
    feet: Projection
    depth: FloatArray
    """(k,) λ."""
    path: FloatArray
    """(k, 3) against the body in the step; zero at the start and of points without a past."""
    old: np.ndarray
    """(k,) whether each was in contact before."""


class Response(NamedTuple):
    """Forces at the points that carry."""

    normal: LawOutput
    friction: FrictionOutput | None
    force_B: FloatArray
    """(k, 3) on the points, body axes."""


def carrying(rows: IntArray, feet: Projection, p_B: FloatArray, past: Past | None) -> Carrying:
    """What is known of the points `rows`."""
    depth = np.maximum(-feet.gap, 0.0)
    if past is None:
        return Carrying(rows, feet, depth, np.zeros((len(rows), 3)), np.zeros(len(rows), np.bool_))
    path = _way(past.state, p_B, rows)
    return Carrying(rows, feet, depth, path, past.state.patch[rows] >= 0)


def _way(last: State, p_B: FloatArray, rows: IndexArray) -> FloatArray:
    """(k, 3) that points have gone against the body since `last`; zero where that is unknown."""
    way = p_B.take(rows, axis=0) - last.points_B.take(rows, axis=0)
    return np.where(np.isfinite(way), way, 0.0)


def _way_of(points: Carrying, last: State, p_B: FloatArray, rows: IndexArray) -> FloatArray:
    """The same, which is known already where the rows are those of `points`."""
    return points.path if np.array_equal(rows, points.rows) else _way(last, p_B, rows)


def rates(points: Carrying, past: Past | None) -> FloatArray:
    """(k,) dλ/dt: exact where velocities are given, else of old contacts the change of λ over the
    step and of new ones their speed of approach."""
    if past is None:
        return np.zeros(len(points.rows))
    n = points.feet.normal
    if past.velocity_B is not None:
        return -(past.velocity_B[points.rows] * n).sum(axis=1)
    change = points.depth - past.state.part("penetration", points.rows)
    return np.where(points.old, change, -(points.path * n).sum(axis=1)) / past.dt


def law_input(
    points: Carrying, sampling: Sampling, area: FloatArray, past: Past | None, n_memory: int
) -> LawInput:
    """What the law sees of the points that carry."""
    rows, thickness, mass = points.rows, sampling.thickness, sampling.mass
    return LawInput(
        locked(points.depth),
        rates(points, past),
        locked(area),
        None if thickness is None else thickness[rows],
        None if mass is None else mass[rows],
        0.0 if past is None else past.dt,
        np.zeros((len(rows), n_memory)) if past is None else past.state.part("memory", rows),
    )


def respond(
    law: Law, friction: Friction | None, points: Carrying, inp: LawInput, past: Past | None
) -> Response:
    """Forces at the points that carry."""
    answer = checked_answer(law, inp)
    force_B = answer.force[:, None] * points.feet.normal
    if friction is None:
        return Response(answer, None, force_B)
    gripped = friction.respond(_friction_input(friction, points, answer, inp, past))
    return Response(answer, gripped, force_B + gripped.force)


def _friction_input(
    friction: Friction, points: Carrying, answer: LawOutput, inp: LawInput, past: Past | None
) -> FrictionInput:
    rows, n = points.rows, points.feet.normal
    if past is None:
        before, memory = np.zeros_like(n), np.zeros((len(rows), friction.n_memory))
        velocity = np.zeros_like(n)
    else:
        before, memory = past.state.part("normal_B", rows), past.state.part("grip", rows)
        known = past.velocity_B
        velocity = points.path / past.dt if known is None else known[rows]
    return FrictionInput(
        normal=n,
        normal_before=before,
        force=answer.force,
        stiffness=_stiffness(points, answer),
        area=inp.area,
        path=points.path * _part_inside(points)[:, None],
        velocity=velocity,
        dt=inp.dt,
        memory=memory,
    )


def _stiffness(points: Carrying, answer: LawOutput) -> FloatArray:
    """(k,) of the normal force over the penetration; on a plateau of its curve the secant."""
    elastic = answer.force if answer.damping is None else answer.force - answer.damping
    secant = np.zeros(len(elastic))
    np.divide(elastic, points.depth, out=secant, where=points.depth > 0.0)
    return np.where(answer.stiffness > 0.0, answer.stiffness, np.maximum(secant, 0.0))


def _part_inside(points: Carrying) -> FloatArray:
    """(k,) share of the step's path that a point has gone in contact: of a new one what is below
    the tangent plane at its foot, and nothing of a path that leads away from there."""
    way = -(points.path * points.feet.normal).sum(axis=1)
    inside = np.zeros(len(way))
    np.divide(np.minimum(points.depth, way), way, out=inside, where=way > 0.0)
    return np.where(points.old, 1.0, inside)


def balance(
    points: Carrying, response: Response, p_B: FloatArray, past: Past | None
) -> ContactEnergy:
    """Where the work done on the contact went, up to now; `p_B` (m, 3) are all points."""
    normal, grip = response.normal, response.friction
    stored = float(normal.stored.sum()) + (0.0 if grip is None else float(grip.stored.sum()))
    if past is None:
        return ContactEnergy(stored, stored, 0.0, 0.0, 0.0)
    last, energy = past.state, past.state.energy
    rows, pressed = last.nonzero("normal_force")
    way = _way_of(points, last, p_B, rows)
    force = pressed[:, None] * last.part("normal_B", rows)
    if last.shape("traction_B")[0]:
        force = force + last.part("traction_B", rows)
    work = half_work(force, way) + half_work(response.force_B, points.path)
    damped = 0.0
    if normal.damping is not None:
        damped += half_work(normal.damping[:, None] * points.feet.normal, points.path)
    # Also where it takes all of the normal force, of points that come out fast.
    rows, taken = last.nonzero("damping")
    if len(rows):
        way = _way_of(points, last, p_B, rows)
        damped += half_work(taken[:, None] * last.part("normal_B", rows), way)
    return ContactEnergy(
        energy.work + work,
        stored,
        energy.hysteresis + (0.0 if normal.hysteresis is None else float(normal.hysteresis.sum())),
        energy.damping + damped,
        energy.friction + (0.0 if grip is None else float(grip.lost.sum())),
    )


def columns_of(
    found: Detected,
    held: IntArray,
    p_B: FloatArray,
    points: Carrying,
    answers: tuple[LawInput, Response],
) -> dict[str, Column]:
    """The columns of a state that are one row a point, by name.

    `held` are those in contact, also where they carry no forces, `p_B` (m, 3) all points.
    """
    n, feet, rows = len(p_B), found.feet, points.rows
    inp, response = answers
    normal, grip = response.normal, response.friction

    def sparse(values: FloatArray) -> Sparse:
        return Sparse.of(n, rows, values)

    damping: Column = np.zeros(0)
    viscosity: Column = np.zeros(0)
    if normal.damping is not None and normal.damping.any():
        each = np.zeros(len(rows))
        np.divide(normal.damping, inp.rate, out=each, where=inp.rate != 0.0)
        damping, viscosity = sparse(normal.damping), sparse(np.abs(each))

    return {
        "status": found.status,
        "feature": feet.feature,
        "patch": feet.patch,
        "uv": found.uv,
        "near": found.near,
        "penetration": Sparse(n, held, np.maximum(-feet.gap.take(held), 0.0)),
        "normal_B": Sparse(n, held, feet.normal.take(held, axis=0)),
        "foot_B": Sparse(n, held, feet.point.take(held, axis=0), p_B),
        "points_B": p_B,
        "normal_force": sparse(normal.force),
        "stiffness": sparse(normal.stiffness),
        "damping": damping,
        "viscosity": viscosity,
        "memory": sparse(normal.memory),
        "grip": np.zeros((n, 0)) if grip is None else sparse(grip.memory),
        "traction_B": np.zeros((0, 3)) if grip is None else sparse(grip.force),
        "tangential": np.zeros(0) if grip is None else sparse(grip.stiffness),
        "certified": feet.certified,
        "safe_distance": found.safe_distance,
    }
