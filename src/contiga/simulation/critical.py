"""Find the critical step: the longest one at which vibrations do not grow.

A leapfrog with damping forces at predicted velocities is stable for a vibration ω with the decay
rate γ = c/m while ω² h²/4 + γ h ≤ 1 (the step matrix has the eigenvalue −1 at the limit). The
fastest vibration of coupled bodies is bounded by each side alone: ω² of a spring between two bodies
is at most the sum of its ω² with either body held, and ω² of several springs on one body at most
the sum of theirs.
"""

from __future__ import annotations

import math
import weakref
from operator import is_
from typing import Literal, NamedTuple

import numpy as np

from contiga.arrays.ordered import length, product, row_lengths, row_products
from contiga.contact.loads import Column
from contiga.contact.state import State
from contiga.dynamics.kernels.stiffness_nb import fastest
from contiga.dynamics.mapped_nodes import MappedNodes
from contiga.errors import RunError
from contiga.geometry.net import spread
from contiga.jit import straight
from contiga.records import FloatArray, IndexArray, SurfacePlaces
from contiga.rigid import quaternion
from contiga.rigid.frames import cross
from contiga.rigid.rigid_lanes import AXES, CENTRE, FREE_DIRECTIONS, MASS, MOMENTS, TURN
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.system_state import SystemState
from contiga.slaves.sampling import more_points
from contiga.slaves.skin import facet_width

MAX_GAIN = 100.0
"""Largest energy from nowhere, as a multiple of the energy supplied: near the critical step a
stable model holds a few times as much."""
MIN_TRAVEL = 1e-3
"""Smallest travel of the fastest node in a step, as a share of the slave's size, for a slave to
count as unstable: with less motion the energies are rounding."""
SINGLE_RATIO = 4.0
"""Ratio of ω² of single points to that of their body from which the points swing by themselves."""


class Rates(NamedTuple):
    """The square of the highest frequency and the fastest decay of a vibration."""

    square: float = 0.0
    """ω², 1/time²."""
    decay: float = 0.0
    """γ, 1/time."""

    def __add__(self, other: Rates) -> Rates:  # type: ignore[override]
        return Rates(self.square + other.square, self.decay + other.decay)

    def largest(self, other: Rates) -> Rates:
        """Return the higher frequency and the faster decay of both."""
        return Rates(max(self.square, other.square), max(self.decay, other.decay))

    @property
    def critical(self) -> float:
        """The critical step, infinite where nothing vibrates or decays."""
        root = self.decay + math.sqrt(self.decay * self.decay + self.square)
        return 2.0 / root if root > 0.0 else math.inf


class Limit(NamedTuple):
    """The critical step and its cause."""

    critical: float
    """Length of the critical step."""
    of: str
    """The contact, spring or slave with this step, in words; empty if the step is infinite."""
    bodies: Rates
    """Fastest rates of whole bodies; nodes may be faster."""
    points: float = 0.0
    """ω² of nodes, and of points that share a force, if they are faster than their bodies."""
    nodes: Rates = Rates()
    """Fastest rates of free nodes."""


Of = Literal["all", "lasting", "following"]
"""Couplings that count: all; those whose stiffness does not depend on the step; only normal forces
whose stiffness follows the step, which are stable at any step or at none."""


_LIMITS: dict[int, dict[Of, tuple[tuple[object, ...], Limit]]] = {}
"""Limits of recent states by the id of the state's array of free bodies; both end together."""


def limit_of(model: Model, state: SystemState, of: Of = "all") -> Limit:
    """Return the result of `find_limit`, cached with the `rigid` array of `state` for each `of`.

    It is computed anew unless model, contacts, springs, joints, slaves and bodies are the same
    objects as before.
    """
    key, rigid = id(state.rigid), state.rigid
    if key not in _LIMITS:
        _LIMITS[key] = {}
        weakref.finalize(rigid, _LIMITS.pop, key, None)
    inputs = model, state.contacts, state.springs, state.joints, state.slaves, state.bodies
    stored = _LIMITS[key].get(of)
    if stored is not None and all(map(is_, stored[0], inputs)):
        return stored[1]
    limit = find_limit(model, state, of)
    _LIMITS[key][of] = inputs, limit
    return limit


class _EndRates(NamedTuple):
    """Rates of a coupling at one body or slave with its other end held."""

    of: object
    """Row of the body, or name of the slave."""
    rates: Rates
    """Rates of its points, the fastest."""
    whole: Rates
    """Rates of that end as one whole body."""


def find_limit(model: Model, state: SystemState, of: Of = "all") -> Limit:
    """Return the critical step in `state`, its cause, and the highest rates of vibration.

    Contacts, springs, laws of joints, gas and elements count, as `of` selects; without any the step
    is infinite and its cause empty. The rates of a coupling are the sum over its ends, each with
    the other end held. At each free body and slave the rates of its couplings are added; the least
    critical step of these is the limit, named by the fastest coupling there. Bodies, points and
    nodes have their highest rates.
    """
    rates_at: dict[object, list[tuple[str, Rates, Rates]]] = {}
    for text, sides in _coupling_rates(model, state, of):
        pair_rates, whole = sides[0].rates, sides[0].whole
        for side in sides[1:]:
            pair_rates, whole = pair_rates + side.rates, whole + side.whole
        for side in sides:
            rates_at.setdefault(side.of, []).append((text, pair_rates, whole))
    critical, cause, bodies, points, nodes = math.inf, "", Rates(), 0.0, Rates()
    for side_of, of_side in rates_at.items():
        fastest_text, rates, whole = of_side[0]
        fastest_rates = rates
        for text, pair_rates, of_whole in of_side[1:]:
            rates, whole = rates + pair_rates, whole + of_whole
            if pair_rates > fastest_rates:
                fastest_text, fastest_rates = text, pair_rates
        if side_of in model.mechanism.masses:
            nodes = nodes.largest(rates)
        else:
            bodies = bodies.largest(whole)
        if rates.square > SINGLE_RATIO * whole.square:
            points = max(points, rates.square)
        if rates.critical < critical:
            critical, cause = rates.critical, fastest_text
    return Limit(critical, cause, bodies, points, nodes)


def _coupling_rates(model: Model, state: SystemState, of: Of) -> list[tuple[str, list[_EndRates]]]:
    """Return (text, ends) of each coupling that counts by `of`: its name, the rates at moving ends.

    Ends on the ground, on driven bodies and on driven nodes are left out.
    """
    system = model.mechanism
    couplings: list[tuple[str, list[_EndRates]]] = []
    for part in model.contacts:
        if of != "all" and (part.name in model.mechanism.followers) == (of == "lasting"):
            continue
        if len(state.contacts[part.name].kept.normal_force.rows):
            _add_contact(couplings, model, part, state, of)
    if of == "following":
        return couplings
    _add_gas(couplings, model, state)
    for name, nodes in system.element_movers.items():
        rates = Rates(*nodes.rates(state.slaves[name]))
        text = f"the elements of slave {name!r}"
        if rates.square > 0.0:
            couplings.append((text, [_EndRates(name, rates, rates)]))
        # Row sums bound the elements' energy node by node: the coupling of nodes to a body adds
        # nothing to their coupling to one another.
        for joint in nodes.springs_to_bodies(state.slaves[name]):
            if joint.host in system.row:
                _, points, stiffness = joint
                row = system.row[joint.host]
                body = state.rigid[row], system.fixed[row]
                square = straight(fastest)(points, points, stiffness, stiffness, *body)
                couplings.append((text, [_EndRates(row, Rates(square), Rates())]))
    for name, now in state.springs.items():
        spring, ends = system.springs[name], []
        axial, lateral = map(float, spring.stiffness_bound(now))
        arm = now.ends[1:] - now.ends[:1]
        axis = arm / now.length if now.length > 0.0 else np.array([[1.0, 0.0, 0.0]])
        for k, row in system.free_ends(name):
            body = state.rigid[row], system.fixed[row]
            at = now.ends[k : k + 1], axis
            rates = Rates(
                straight(fastest)(*at, np.array([axial]), np.array([lateral]), *body),
                straight(fastest)(*at, np.array([float(spring.damping)]), np.zeros(1), *body),
            )
            ends.append(_EndRates(row, rates, rates))
        for end in system.ends[name]:
            if end.slave is not None and end.slave in system.masses:
                mover = system.nodes[end.slave]
                square = mover.square_bound(end.nodes, max(axial, lateral) * end.shares)
                decay = mover.square_bound(end.nodes, float(spring.damping) * end.shares)
                ends.append(_EndRates(end.slave, Rates(square, decay), Rates()))
        if ends:
            couplings.append((f"spring {name!r}", ends))
    _add_joint_laws(couplings, model, state)
    return couplings


def _add_joint_laws(
    couplings: list[tuple[str, list[_EndRates]]], model: Model, state: SystemState
) -> None:
    """Add the laws of joints to `couplings`, with their rates on the free bodies that they join.

    Constraints do not raise the highest frequency: that of a constrained system is at most that of
    the free one (Rayleigh).
    """
    if state.joints is None:
        return
    system, linkage = model.mechanism, model.linkage
    for entry in linkage.laws:
        c = entry.number
        g = int(linkage.table.coordinates[c, 0])
        stiffness = entry.law.stiffness_bound(float(state.joints.values[c]))
        ends = []
        for row in linkage.table.rows[g].tolist():
            if row >= 0:
                mobility = _mobility(
                    state.rigid[row],
                    system.fixed[row],
                    state.joints.points[g],
                    state.joints.ways[c],
                )
                rates = Rates(stiffness * mobility, entry.law.damping * mobility)
                ends.append(_EndRates(row, rates, rates))
        couplings.append((f"{entry.coordinate} of joint {entry.joint!r}", ends))


def _mobility(
    row: FloatArray, fixed: FloatArray, point: FloatArray, direction: FloatArray
) -> float:
    """Return the acceleration along `direction` (6,), linear and angular, by a unit load along it.

    It is JᵀM⁻¹J at a point (3,) of a free body with lanes `row` (19,) and `fixed` (22,). Locked
    rotations are ignored, so the result may be too large.
    """
    moment = direction[3:] + cross(point - row[CENTRE : CENTRE + 3], direction[:3])
    turn = quaternion.to_matrix(row[TURN : TURN + 4])
    principal = product(fixed[AXES : AXES + 9].reshape(3, 3).T, product(turn.T, moment))
    linear = (
        np.square(direction[:3] * fixed[FREE_DIRECTIONS : FREE_DIRECTIONS + 3]).sum() / fixed[MASS]
    )
    return float(linear + (principal * principal / fixed[MOMENTS : MOMENTS + 3]).sum())


def _add_gas(
    couplings: list[tuple[str, list[_EndRates]]], model: Model, state: SystemState
) -> None:
    """Add to `couplings` the chambers in slaves whose nodes are moved by forces.

    Gas is a spring on the volume, adiabatic; excess pressure turns with the facets.
    """
    system, chambers = model.mechanism, model.chambers
    for name, (gas, _) in state.gas.items():
        chamber, skin = chambers.chambers[name], chambers.skins[name]
        if chamber.slave not in system.masses:
            continue
        points, mover = state.slaves[chamber.slave].points, system.nodes[chamber.slave]
        _, gradient, stiffness, _ = chambers.closed(name, points)
        nodal = np.zeros(points.shape)
        Column(skin.rows, gradient).add_to(nodal)
        gamma = chambers.physics.gamma(gas)
        square = gamma * gas.pressure / gas.volume * mover.force_square_over_mass(nodal)
        excess = abs(gas.pressure - chamber.surroundings.pressure)
        square += mover.square_bound(skin.rows, excess * stiffness)
        couplings.append((f"gas {name!r}", [_EndRates(chamber.slave, Rates(square), Rates())]))


def _add_contact(
    couplings: list[tuple[str, list[_EndRates]]],
    model: Model,
    part: ContactPart,
    state: SystemState,
    of: Of,
) -> None:
    """Add a contact to `couplings`, with its rates on the free bodies and slaves at its two sides.

    It is left out if no point presses, or nothing at its sides is free.
    """
    system, contact, ends = model.mechanism, state.contacts[part.name], []
    columns, bodies = contact.kept, model.mechanism.sides[part.name].free
    rows, normal_stiffness = columns.springs
    host = model.shapes.slave_of(part.master)
    if len(rows) == 0 or not (bodies or host or part.slave in system.masses):
        return
    tangential_stiffness = damping = friction_damping = np.zeros(len(rows))
    if of != "following" and columns.tangential is not None:
        tangential_stiffness = columns.tangential.at(rows)
    if columns.viscosity is not None:
        damping = columns.viscosity.at(rows)
    if (viscosity := getattr(part.contact.friction, "viscosity", None)) is not None:
        # Viscosity at the sliding speed; points between nodes count at speed zero, the stiffest.
        speed, (pose, twist) = np.zeros(len(rows)), state.bodies[part.master]
        slave = state.slaves[part.slave]
        nodes = rows[rows < len(slave.points)]
        v_W = slave.velocities[nodes] - twist.at(pose[:3, 3], slave.points[nodes])
        n_W = contact.held_W.normals.at(nodes)
        speed[: len(nodes)] = row_lengths(v_W - row_products(v_W, n_W)[:, None] * n_W)
        friction_damping = np.array(viscosity(columns.normal_force.at(rows), speed), np.float64)
    damped = damping.any() or friction_damping.any()
    max_stiffness = np.maximum(normal_stiffness, tangential_stiffness)
    max_damping = np.maximum(damping, friction_damping)
    if bodies:
        points, normals = contact.held_W.points.at(rows), contact.held_W.normals.at(rows)
    for row in bodies:
        body = state.rigid[row], system.fixed[row]
        rates = whole = Rates(
            straight(fastest)(points, normals, normal_stiffness, tangential_stiffness, *body),
            straight(fastest)(points, normals, damping, friction_damping, *body) if damped else 0.0,
        )
        if columns.stiffness_bound is not None:
            # Steps follow the swing of the body; points sharing its force are only kept stable.
            single = columns.stiffness.at(rows)
            whole = Rates(
                straight(fastest)(points, normals, single, tangential_stiffness, *body), rates.decay
            )
        ends.append(_EndRates(row, rates, whole))
    if part.slave in system.masses:
        nodes, stiffness = part.contact.nodal_sum(rows, max_stiffness)
        mover, decay = system.nodes[part.slave], 0.0
        square = mover.square_bound(nodes, stiffness)
        if damped:
            nodal_damping = part.contact.nodal_sum(rows, max_damping).values
            decay = mover.square_bound(nodes, nodal_damping)
        ends.append(_EndRates(part.slave, Rates(square, decay), Rates()))
    if host is not None:  # its degrees of freedom are the master's control points
        degrees = system.nodes[host]
        assert isinstance(degrees, MappedNodes)
        sums = _sums_at_control_points(part, contact, rows, max_stiffness)
        square, decay = degrees.square_bound_of_dofs(sums), 0.0
        if damped:
            sums = _sums_at_control_points(part, contact, rows, max_damping)
            decay = degrees.square_bound_of_dofs(sums)
        ends.append(_EndRates(host, Rates(square, decay), Rates()))
    is_dragged = friction_damping.any() and all(
        end.rates.decay**2 > end.rates.square for end in ends
    )
    couplings.append((f"{'viscous friction of ' if is_dragged else ''}contact {part.name!r}", ends))


def _sums_at_control_points(
    part: ContactPart, state: State, rows: IndexArray, values: FloatArray
) -> FloatArray:
    """Return Σ k N_i (m,) of values k at points `rows` by their feet.

    These are the row sums of Nᵀ k N, as Σ N_i is one.
    """
    body = part.contact.master.faces
    assert body is not None
    feet, forces = SurfacePlaces(state.patch[rows], state.uv[rows]), np.zeros((len(rows), 3))
    forces[:, 0] = values
    # Points on the surface itself: a force there has no couple.
    half = part.contact.half_thickness
    assert half is not None
    points = state.kept.foot_B.at(rows) - half[rows, None] * state.kept.normal_B.at(rows)
    return spread(body, state.control_points, feet, points, forces)[:, 0]


def check_stable(model: Model, state: SystemState) -> None:
    """Refuse to go on if elements have far more energy than was supplied.

    Raises
    ------
    RunError
        The energy balance has gained more than `MAX_GAIN` of initial energy and work, and the
        fastest node of a slave of elements goes farther in a step than `MIN_TRAVEL` of the size of
        the slave. The message names the slave, the time, that node with its position, and a remedy.
    """
    energy = state.energy
    gain, supplied = -energy.error, max(energy.initial + energy.external, 0.0)
    joined = model.mechanism.element_movers
    for name, nodes in joined.items():
        # Unstable steps conserve the usual kinetic energy: take that of the shaking instead.
        slave = state.slaves[name]
        gain += nodes.velocity_energy(slave) - nodes.energy(slave).kinetic
    if gain <= MAX_GAIN * supplied:
        return
    for name in joined:
        slave = state.slaves[name]
        speeds = np.sqrt(np.square(slave.velocities).sum(axis=1))
        node = int(np.argmax(np.where(np.isfinite(speeds), speeds, np.inf)))
        size = length(np.ptp(model.slaves[name].slave.points, axis=0))
        if speeds[node] * state.step <= MIN_TRAVEL * size:
            continue
        place = ", ".join(f"{x:.6g}" for x in slave.points[node])
        raise RunError(
            f"t = {state.time:g}: slave {name!r} is unstable: {gain:.4g} of energy came from "
            f"nothing, and {supplied:.4g} from outside. Node {node} at ({place}) goes at "
            f"{speeds[node]:.4g}. {remedy(model, state, name)}"
        )


def remedy(model: Model, state: SystemState, slave: str) -> str:
    """Return advice on an unstable slave, by the first likely cause.

    These are a step above the critical one, then points in contact deeper than its facets are wide;
    the advice is general if there is neither.
    """
    critical = limit_of(model, state).critical
    if state.step > critical:
        return f'Take steps below {0.9 * critical:.3g}, or step = "auto"'
    mesh = model.slaves[slave].slave
    width = np.inf if mesh.facets is None else facet_width(mesh.points, mesh.facets)
    for part in model.contacts:
        deep = state.contacts[part.name].max_penetration
        if part.slave == slave and deep > width:
            return (
                f"Its facets, {width:.4g} wide, are too coarse for {part.master}, in which points "
                f"of theirs lie {deep:.4g} deep: mesh it finer there"
                f"{more_points(part.contact.quadrature)}"
            )
    return "Look at its material, at its contacts and at the units; shorter steps show which it is"
