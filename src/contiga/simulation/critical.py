"""The critical step: how long a step may be before vibrations grow.

A leapfrog with damping that is foreseen by half a step is stable for a vibration ω with the decay
rate γ = c/m while ω² h²/4 + γ h ≤ 1 (the step matrix has the eigenvalue −1 at the end of that).
The fastest vibration of all that a contact connects is bounded from each side alone: what a spring
does to two bodies is at most the sum of what it does to each with the other held, and what several
do to one body at most the sum of that.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Iterable, Iterator
from operator import is_
from typing import Literal, NamedTuple

import numpy as np

from contiga.arrays.ordered import row_lengths, row_products
from contiga.contact.state_rows import kept_of
from contiga.dynamics.kernels.stiffness_nb import fastest
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_world, turn_to_world
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.system_state import SystemState

FASTER = 4.0
"""Times ω² of whole bodies that that of single points is, for them to swing by themselves."""


class Rates(NamedTuple):
    """How fast things happen."""

    square: float = 0.0
    """ω², 1/time²."""
    decay: float = 0.0
    """γ, 1/time."""

    def __add__(self, other: Rates) -> Rates:  # type: ignore[override]
        return Rates(self.square + other.square, self.decay + other.decay)

    @classmethod
    def total(cls, rates: Iterable[Rates]) -> Rates:
        """The sum of several."""
        square = decay = 0.0
        for one in rates:
            square += one.square
            decay += one.decay
        return cls(square, decay)

    def most(self, other: Rates) -> Rates:
        """The faster of both, each."""
        return Rates(max(self.square, other.square), max(self.decay, other.decay))

    @property
    def critical(self) -> float:
        """The critical step, infinite where nothing vibrates or decays."""
        root = self.decay + math.sqrt(self.decay * self.decay + self.square)
        return 2.0 / root if root > 0.0 else math.inf


class Limit(NamedTuple):
    """What limits the step."""

    critical: float
    """Length of the critical step."""
    of: str
    """What has it, in words; empty where nothing does."""
    bodies: Rates
    """The fastest of whole bodies; nodes may be faster."""
    points: float = 0.0
    """ω² of nodes, and of points that share a force, where they are faster than their bodies."""
    nodes: Rates = Rates()
    """The fastest of free nodes."""


Of = Literal["all", "lasting", "following"]
"""All that touches and pulls; that whose stiffness a shorter step does not change; normal forces
alone whose stiffness follows the step, of which no step is short enough if one is not."""


_KNOWN: dict[int, dict[Of, tuple[tuple[object, ...], Limit]]] = {}
"""Limits of states that steps ask for again, by the state's array of free bodies, with which they
are forgotten."""


def limit_of(model: Model, state: SystemState, of: Of = "all") -> Limit:
    """`find_limit`, found once for each state that is asked for again and again.

    A state that differs in what steps know of one another has the same limit.
    """
    key, rigid = id(state.rigid), state.rigid
    if key not in _KNOWN:
        _KNOWN[key] = {}
        weakref.finalize(rigid, _KNOWN.pop, key, None)
    what = model, state.contacts, state.springs, state.slaves, state.bodies
    known = _KNOWN[key].get(of)
    if known is not None and all(map(is_, known[0], what)):
        return known[1]
    limit = find_limit(model, state, of)
    _KNOWN[key][of] = what, limit
    return limit


class _End(NamedTuple):
    """What a coupling does to one body or slave with its other end held."""

    of: object
    """Row of the body, or name of the slave."""
    rates: Rates
    whole: Rates
    """Those of it as one body."""


def find_limit(model: Model, state: SystemState, of: Of = "all") -> Limit:
    """Find the critical step of what touches and pulls in `state`."""
    felt: dict[object, list[tuple[str, Rates, Rates]]] = {}
    for text, ends in _couplings(model, state, of):
        both, whole = Rates.total([e.rates for e in ends]), Rates.total([e.whole for e in ends])
        for end in ends:
            felt.setdefault(end.of, []).append((text, both, whole))
    critical, who, bodies, points, nodes = math.inf, "", Rates(), 0.0, Rates()
    for of_end, couplings in felt.items():
        rates = Rates.total([both for _, both, _ in couplings])
        whole = Rates.total([w for _, _, w in couplings])
        if of_end in model.mechanism.masses:
            nodes = nodes.most(rates)
        else:
            bodies = bodies.most(whole)
        if rates.square > FASTER * whole.square:
            points = max(points, rates.square)
        if rates.critical < critical:
            critical = rates.critical
            who = max(couplings, key=lambda entry: entry[1])[0]
    return Limit(critical, who, bodies, points, nodes)


def has_energy(law: object) -> bool:
    """Whether a law's forces belong to an energy, so that this can judge a step."""
    return bool(getattr(law, "has_energy", True))


def follows_step(law: object) -> bool:
    """Whether a law's stiffness goes with the step, so that no step is critical for it."""
    return bool(getattr(law, "stiffness_follows_step", False))


def _couplings(model: Model, state: SystemState, of: Of) -> Iterator[tuple[str, list[_End]]]:
    """Each contact and spring, with what it does to the free bodies at its two ends."""
    system = model.mechanism
    for part in model.contacts:
        follows = follows_step(part.contact.law)
        if of == ("lasting" if follows else "following"):
            continue
        springs = _springs_of(part, state, of)
        if len(springs.rows) and (ends := _contact_ends(system, part, springs, state)):
            drags = springs.dragging.any() and all(e.rates.decay**2 > e.rates.square for e in ends)
            yield f"{'viscous friction of ' if drags else ''}contact {part.name!r}", ends
    for name, nodes in system.nodes.items() if of != "following" else ():
        rates = Rates(*nodes.rates(state.slaves[name]))
        if rates.square > 0.0:
            yield f"the elements of slave {name!r}", [_End(name, rates, rates)]
        # Row sums bound the elements' energy node by node: what their nodes do to a body adds
        # nothing to what they do to one another.
        for joint in nodes.joints:
            if joint.host in system.row:
                points = state.slaves[name].points[joint.rows]
                stiffness = nodes.stiffness(state.slaves[name])[joint.rows]
                row = system.row[joint.host]
                square = fastest(points, points, stiffness, stiffness, *_row(system, state, row))
                yield f"the elements of slave {name!r}", [_End(row, Rates(square), Rates())]
    for name in state.springs if of != "following" else ():
        if ends := _spring_ends(system, name, state):
            yield f"spring {name!r}", ends


def _spring_ends(system: Mechanism, name: str, state: SystemState) -> list[_End]:
    """The free ends of a spring."""
    spring, now = system.springs[name], state.springs[name]
    along, across = spring.stiffness_bound(now)
    way = now.ends[1:] - now.ends[:1]
    axis = way / now.length if now.length > 0.0 else np.array([[1.0, 0.0, 0.0]])
    ends: list[_End] = []
    for k, row in system.free_ends(spring):
        place, body_row = now.ends[k : k + 1], _row(system, state, row)
        rates = Rates(
            fastest(place, axis, np.array([along]), np.array([across]), *body_row),
            fastest(place, axis, np.array([spring.damping]), np.zeros(1), *body_row),
        )
        ends.append(_End(row, rates, rates))
    return ends


def _row(system: Mechanism, state: SystemState, row: int) -> tuple[FloatArray, FloatArray]:
    return state.rigid[row], system.fixed[row]


class _Springs(NamedTuple):
    """Springs and dampers of a contact at k points."""

    rows: IndexArray
    """(k,) the points."""
    along: FloatArray
    """(k,) stiffness of the normal forces."""
    across: FloatArray
    """(k,) that of friction."""
    damping: FloatArray
    """(k,) viscosity of the normal forces."""
    dragging: FloatArray
    """(k,) viscous friction over the sliding speed."""


def _springs_of(part: ContactPart, state: SystemState, of: Of) -> _Springs:
    kept = kept_of(state.contacts[part.name])
    rows, along = kept.normal_springs
    across = np.zeros(len(rows)) if of == "following" else kept.part("tangential", rows)
    damping = kept.part("viscosity", rows)
    return _Springs(rows, along, across, damping, _dragging(part, rows, state))


def _contact_ends(
    system: Mechanism, part: ContactPart, springs: _Springs, state: SystemState
) -> list[_End]:
    """The free sides of a contact."""
    ends: list[_End] = []
    contact, (rows, along, across, damping, dragging) = state.contacts[part.name], springs
    damped = damping.any() or dragging.any()
    bodies, kept = system.free_sides(part.master, part.slave), kept_of(contact)
    if bodies:
        points = to_world(contact.pose, contact.points_B[rows])
        normals = turn_to_world(contact.pose, kept.part("normal_B", rows))
    for row in bodies:
        body_row = _row(system, state, row)
        rates = whole = Rates(
            fastest(points, normals, along, across, *body_row),
            fastest(points, normals, damping, dragging, *body_row) if damped else 0.0,
        )
        if kept.shape("tangent")[0]:
            # Steps follow the swing on the curve; what shares its force is kept stable alone.
            single = kept.part("stiffness", rows)
            whole = rates._replace(square=fastest(points, normals, single, across, *body_row))
        ends.append(_End(row, rates, whole))
    if part.slave in system.masses:
        nodes, stiffness = part.contact.nodal_sum(rows, np.maximum(along, across))
        mass = system.masses[part.slave][nodes]
        square, decay = float((stiffness / mass).max()), 0.0
        if damped:
            viscosity = part.contact.nodal_sum(rows, np.maximum(damping, dragging)).values
            decay = float((viscosity / mass).max())
        ends.append(_End(part.slave, Rates(square, decay), Rates()))
    return ends


def _dragging(part: ContactPart, rows: np.ndarray, state: SystemState) -> FloatArray:
    """(k,) viscous friction of the points `rows` over their sliding speeds, zero without."""
    viscosity = getattr(part.contact.friction, "viscosity", None)
    if viscosity is None:
        return np.zeros(len(rows))
    contact, body = state.contacts[part.name], state.bodies[part.master]
    speed = np.zeros(len(rows))  # of points between nodes the least, at which it is stiffest
    nodes = rows < len(contact.force)
    points, velocities = state.slaves[part.slave]
    node_rows = rows[nodes]
    v_W = velocities[node_rows] - body.twist.at(body.pose[:3, 3], points[node_rows])
    n_W = turn_to_world(contact.pose, kept_of(contact).part("normal_B", node_rows))
    across = v_W - row_products(v_W, n_W)[:, None] * n_W
    speed[nodes] = row_lengths(across)
    return np.asarray(viscosity(contact.normal_force[rows], speed))
