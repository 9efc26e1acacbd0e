"""From what the search has found to forces: laws, sums over points, and where the work went."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.contact.checks import checked_answer
from contiga.contact.kernels import carrying_nb, totals_nb
from contiga.contact.sparse import Sparse
from contiga.contact.state import State
from contiga.contact.tracked import BoolArray, Detected
from contiga.laws.friction import Friction, FrictionInput, FrictionOutput
from contiga.laws.normal import Law
from contiga.num.arrays import locked
from contiga.records import FloatArray, IntArray, LawInput, LawOutput
from contiga.slaves.sampling import Sampling


class Past(NamedTuple):
    """How the points came where they are."""

    state: State
    """Of the last step."""
    dt: float
    velocity_B: FloatArray | None
    """(m, 3) against the body, body axes, where it is known exactly."""


class Touching(NamedTuple):
    """Points in contact, one row each, body axes."""

    rows: IntArray
    depth: FloatArray
    """(k,) λ."""
    normal: FloatArray
    foot: FloatArray
    path: FloatArray
    """(k, 3) against the body in the step; zero at the start and of points without a past."""
    old: BoolArray
    """(k,) whether each was in contact before."""
    rate: FloatArray
    """(k,) dλ/dt: exact where velocities are given, else of old contacts the change of λ over the
    step and of new ones their speed of approach; zero at the start."""

    @classmethod
    def of(cls, rows: IntArray) -> Touching:
        """Of these rows, with nothing filled in."""
        k = len(rows)
        depth, rate, old = np.empty(k), np.empty(k), np.empty(k, np.bool_)
        return cls(rows, depth, np.empty((k, 3)), np.empty((k, 3)), np.empty((k, 3)), old, rate)

    def since(self, first: int) -> Touching:
        """Those of them from the point `first` on: the ones that carry forces."""
        if first == 0:
            return self
        k = int(np.searchsorted(self.rows, first))
        return Touching._make(values[k:] for values in self)


class Response(NamedTuple):
    """What law and friction say of the points that carry."""

    normal: LawOutput
    friction: FrictionOutput | None


class Forces(NamedTuple):
    """What the points that carry feel, and what that sums up to."""

    world: FloatArray
    """(k, 3) forces on them, world axes."""
    viscosity: FloatArray | None
    """(k,) damping over the rate of penetration; None where nothing is damped."""
    wrench: FloatArray
    """(6,) on the points, about the body's reference point, world axes."""
    energies: FloatArray
    """(5,) where the work went up to now, as `ContactEnergy`."""


NOWHERE = np.zeros((0, 3))
"""Velocities that are not told."""
NONE = np.zeros(0)
NO_ROWS = np.zeros(0, np.int32)
FORCES = ("normal_force", "normal_B", "traction_B", "damping")
NO_FORCES = (NO_ROWS, NONE), (NO_ROWS, NOWHERE), (NO_ROWS, NOWHERE), (NO_ROWS, NONE)
"""`FORCES` of the last step, where there was none."""


def touching(found: Detected, p_B: FloatArray, past: Past | None) -> Touching:
    """What is known of the points in contact before forces."""
    points = Touching.of(found.held)
    rows, out = found.held, points[1:]
    if past is None:
        last = np.full(len(p_B), -1, np.int32), NO_ROWS, NONE
        carrying_nb.gather(rows, found.feet, (p_B, p_B), last, NOWHERE, 1.0, out)
        points.rate.fill(0.0)
        return points
    state, velocity = past.state, past.velocity_B
    last = state.patch, *state.listed("penetration")
    velocity = NOWHERE if velocity is None else velocity
    path = p_B, state.points_B
    carrying_nb.gather(rows, found.feet, path, last, velocity, past.dt, out)
    return points


def law_input(
    points: Touching, sampling: Sampling, area: FloatArray, past: Past | None, n_memory: int
) -> LawInput:
    """What the law sees of the points that carry."""
    rows, thickness, mass = points.rows, sampling.thickness, sampling.mass
    if past is None or n_memory == 0:
        memory = np.zeros((len(rows), n_memory))
    else:
        memory = past.state.part("memory", rows)
    return LawInput(
        locked(points.depth),
        points.rate,
        locked(area),
        None if thickness is None else thickness[rows],
        None if mass is None else mass[rows],
        0.0 if past is None else past.dt,
        memory,
    )


def respond(
    law: Law, friction: Friction | None, points: Touching, inp: LawInput, past: Past | None
) -> Response:
    """What law and friction answer, in arrays of their own."""
    answer = checked_answer(law, inp)
    if friction is None:
        return Response(answer, None)
    gripped = friction.respond(_friction_input(friction, points, answer, inp, past))
    force = np.empty(points.normal.shape)
    force[...] = gripped.force
    return Response(answer, gripped._replace(force=force))


def _friction_input(
    friction: Friction, points: Touching, answer: LawOutput, inp: LawInput, past: Past | None
) -> FrictionInput:
    rows, n = points.rows, points.normal
    if past is None:
        before, memory = np.zeros_like(n), np.zeros((len(rows), friction.n_memory))
        velocity = np.zeros_like(n)
    else:
        before, memory = past.state.part("normal_B", rows), past.state.part("grip", rows)
        known = past.velocity_B
        velocity = points.path / past.dt if known is None else known[rows]
    return FrictionInput(
        normal=locked(n),
        normal_before=before,
        force=answer.force,
        stiffness=_stiffness(points, answer),
        area=inp.area,
        path=points.path * _part_inside(points)[:, None],
        velocity=velocity,
        dt=inp.dt,
        memory=memory,
    )


def _stiffness(points: Touching, answer: LawOutput) -> FloatArray:
    """(k,) of the normal force over the penetration; on a plateau of its curve the secant."""
    elastic = answer.force if answer.damping is None else answer.force - answer.damping
    secant = np.zeros(len(elastic))
    np.divide(elastic, points.depth, out=secant, where=points.depth > 0.0)
    return np.where(answer.stiffness > 0.0, answer.stiffness, np.maximum(secant, 0.0))


def _part_inside(points: Touching) -> FloatArray:
    """(k,) share of the step's path that a point has gone in contact: of a new one what is below
    the tangent plane at its foot, and nothing of a path that leads away from there."""
    way = -(points.path * points.normal).sum(axis=1)
    inside = np.zeros(len(way))
    np.divide(np.minimum(points.depth, way), way, out=inside, where=way > 0.0)
    return np.where(points.old, 1.0, inside)


def forces(
    points: Touching,
    response: Response,
    p_B: FloatArray,
    past: Past | None,
    frame: tuple[FloatArray, FloatArray],
) -> Forces:
    """Forces of the points that carry, and where the work done on the contact went, up to now.

    `p_B` (m, 3) are all points, `frame` the pose of the body and its reference point.
    """
    normal, grip = response.normal, response.friction
    world, viscosity, totals = (
        np.empty(points.normal.shape),
        np.empty(len(points.rows)),
        _totals(past),
    )
    lost = NONE if normal.hysteresis is None else normal.hysteresis
    damping = NONE if normal.damping is None else normal.damping
    held = (
        (NOWHERE, NONE, NONE) if grip is None else (grip.force, _row(grip.stored), _row(grip.lost))
    )
    carrying = points.rows, points.normal, points.path, points.rate
    last = NO_FORCES if past is None else tuple(map(past.state.listed, FORCES))
    path = p_B, p_B if past is None else past.state.points_B
    viscous = totals_nb.forces(
        carrying,
        (normal.force, normal.stored, lost, damping, *held),
        last,
        path,
        frame,
        (world, viscosity, totals),
    )
    energies = totals[totals_nb.WORK :]
    if past is None:
        stored = totals[totals_nb.STORED]
        energies[:] = stored, stored, 0.0, 0.0, 0.0
    return Forces(world, viscosity if viscous else None, totals[: totals_nb.WORK], energies)


def _totals(past: Past | None) -> FloatArray:
    """Totals to be added to: of energies those of the last step."""
    totals = np.zeros(totals_nb.TOTALS)
    if past is not None:
        totals[totals_nb.WORK :] = past.state.energies
    return totals


def _row(values: FloatArray) -> FloatArray:
    """What is only summed, as kernels take it."""
    return np.array(values, dtype=np.float64).reshape(-1)


def columns_of(
    found: Detected,
    held: Touching,
    p_B: FloatArray,
    points: Touching,
    answers: tuple[Response, Forces],
) -> tuple[dict[str, Any], dict[str, Sparse]]:
    """The columns of a state that are one row a point, by name: whole ones, and those of some rows.

    `held` are those in contact, also where they carry no forces, `p_B` (m, 3) all points.
    """
    n, feet, rows = len(p_B), found.feet, points.rows
    response, felt = answers
    normal, grip = response.normal, response.friction
    whole: dict[str, Any] = {
        "status": found.status,
        "feature": feet.feature,
        "patch": feet.patch,
        "uv": found.uv,
        "near": found.near,
        "points_B": p_B,
        "certified": feet.certified,
        "safe_distance": found.safe_distance,
    }
    sparse = {
        "penetration": Sparse(n, held.rows, held.depth),
        "normal_B": Sparse(n, held.rows, held.normal),
        "foot_B": Sparse(n, held.rows, held.foot, p_B),
        "normal_force": Sparse(n, rows, normal.force),
        "stiffness": Sparse(n, rows, normal.stiffness),
        "memory": Sparse(n, rows, normal.memory),
    }
    if felt.viscosity is None or normal.damping is None:
        whole |= {"damping": np.zeros(0), "viscosity": np.zeros(0)}
    else:
        sparse["damping"] = Sparse(n, rows, normal.damping)
        sparse["viscosity"] = Sparse(n, rows, felt.viscosity)
    if grip is None:
        whole |= {"grip": np.zeros((n, 0)), "traction_B": np.zeros((0, 3))}
        whole["tangential"] = np.zeros(0)
    else:
        sparse["grip"] = Sparse.of(n, rows, grip.memory)
        sparse["traction_B"] = Sparse(n, rows, grip.force)
        sparse["tangential"] = Sparse.of(n, rows, grip.stiffness)
    return whole, sparse
