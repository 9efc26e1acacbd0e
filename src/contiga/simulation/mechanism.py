"""Derive from a model what forces move: free bodies, attached bodies and slaves, and nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.dynamics.free import Attached, Dependent, Free, is_driven
from contiga.dynamics.loads import Load
from contiga.dynamics.nodes import DrivenNodes, NodeMover
from contiga.dynamics.prescribed import BodyMotion
from contiga.dynamics.rigid_bodies import fixed_of, row_of, with_attached
from contiga.dynamics.slip_rings import SlipRing
from contiga.dynamics.springs import GROUND, Spring
from contiga.errors import InputError
from contiga.records import FloatArray, IntArray
from contiga.rigid.inertia import of_points
from contiga.rigid.rigid_lanes import FIXED, STATE

NODE_TOL = 0.02
"""How far a spring's end may be from the node that it is put on, as a share of the slave's size."""

NO_NODES, NO_SHARES = np.zeros(0, np.int32), np.zeros(0)

RING_TOL = 1e-6
"""How far apart the ends of two segments may be at a slip ring, as a share of their length."""


class Sides(NamedTuple):
    """The bodies at the two sides of a contact."""

    master: int
    """Number of the body that its master is fixed to."""
    slave: int | None
    """Number of the body that carries its slave; None without one."""
    free: tuple[int, ...]
    """Rows of the free ones among these bodies."""
    signs: tuple[float, ...]
    """Sign of the force on each of these: 1 on the slave's side, −1 on the master's."""
    about: FloatArray
    """(3,) reference point of the master, body axes."""
    size: float
    """Size of the master, length."""


class SpringEnd(NamedTuple):
    """An end of a spring, on a body, on a slave, or on the ground where neither is named."""

    body: int | None = None
    """Number of the body that the end is fixed to."""
    slave: str | None = None
    """Name of the slave; None on a body or the ground."""
    nodes: IntArray = NO_NODES
    """(k,) nodes of the slave that share the end."""
    shares: FloatArray = NO_SHARES
    """(k,) share of each node in the force on the end, and in its position; they sum to 1."""


class TiedEnd(NamedTuple):
    """An end of a spring on a slave."""

    spring: str
    """Name of the spring."""
    sign: float
    """1 for the first end, on which the pull acts; −1 for the second."""
    nodes: IntArray
    """(k,) nodes of the slave that share it."""
    shares: FloatArray
    """(k,) share of each node in the force; they sum to 1."""

    def forces(self, pull: FloatArray) -> FloatArray:
        """Return the forces (k, 3) on the nodes by the pull (3,) of the spring, world axes."""
        return np.asarray(self.sign * self.shares[:, None] * pull)


class RingSide(NamedTuple):
    """A segment of webbing at a slip ring."""

    spring: str
    end: int
    """Number of the end at the ring."""


@dataclass(frozen=True, eq=False)
class Mechanism:
    """All that forces move, derived once from the parts of a simulation."""

    index: Mapping[str, int]
    """Number of each body, in their order."""
    root: NDArray[np.intp]
    """(n,) body that each body is fixed to: itself where it is not attached."""
    free: NDArray[np.intp]
    """(b,) bodies that are free."""
    row: Mapping[int, int]
    """Row of a free body, by its number."""
    fixed: FloatArray
    """(b, 22) constants of free bodies: see `contiga.rigid.rigid_lanes`."""
    start: FloatArray
    """(b, 19) states of free bodies at the start."""
    driven: Mapping[int, BodyMotion]
    """Motions that drive bodies, by number; bodies at rest have none."""
    nodes: Mapping[str, NodeMover]
    """Mover of the nodes of each slave."""
    contacts: tuple[Any, ...]
    """Contacts: `contiga.simulation.model.ContactPart`."""
    springs: Mapping[str, Spring]
    """Springs by name, with ends on slaves moved to their nodes."""
    ends: Mapping[str, tuple[SpringEnd, SpringEnd]]
    """Both ends of each spring."""
    rings: Mapping[str, tuple[RingSide, RingSide]]
    """The segments of each slip ring."""
    loads: tuple[Load, ...]
    gas: bool = False
    """Whether there are chambers of gas."""

    @cached_property
    def carrier_of_slave(self) -> Mapping[str, int]:
        """Number of the body that carries all of a slave, by the name of the slave."""
        return {k: mover.host for k, mover in self.nodes.items() if mover.host is not None}

    @cached_property
    def carried_slaves(self) -> tuple[str, ...]:
        """Names of slaves of which bodies carry nodes, all or some."""
        return tuple(k for k, mover in self.nodes.items() if mover.host is not None or mover.joints)

    @cached_property
    def masses(self) -> Mapping[str, FloatArray]:
        """Nodal masses (n,) of slaves whose nodes are moved by forces, by name."""
        return {k: mover.mass for k, mover in self.nodes.items() if mover.mass is not None}

    @cached_property
    def loose(self) -> Mapping[str, FloatArray]:
        """Nodal masses (n,) of slaves of free nodes without elements, by name."""
        return {
            name: mass for name, mass in self.masses.items() if not self.nodes[name].has_elements
        }

    @cached_property
    def element_movers(self) -> Mapping[str, NodeMover]:
        """Movers of the nodes of slaves that are made of elements, by name of the slave."""
        return {name: mover for name, mover in self.nodes.items() if mover.has_elements}

    @cached_property
    def deforms(self) -> bool:
        """Whether any slave is made of elements."""
        return len(self.element_movers) > 0

    @cached_property
    def attached(self) -> bool:
        """Whether any body is attached to another."""
        return bool((self.root != np.arange(len(self.root))).any())

    @cached_property
    def has_dynamics(self) -> bool:
        """Whether forces move anything, or springs or gas take part."""
        devices = len(self.springs) > 0 or self.gas
        return len(self.free) > 0 or len(self.masses) > 0 or devices

    def root_of(self, name: str) -> int:
        """Return the number of the body that a body is fixed to in the end."""
        return int(self.root[self.index[name]])

    def free_ends(self, spring: str) -> list[tuple[int, int]]:
        """Return (end, row) for each end of a spring, 0 or 1, on a free body with that row."""
        bodies = enumerate(end.body for end in self.ends[spring])
        return [(k, self.row[i]) for k, i in bodies if i is not None and i in self.row]

    @cached_property
    def tied(self) -> Mapping[str, list[TiedEnd]]:
        """Ends of springs on slaves that no body carries, by slave, with the sign of the pull."""
        tied: dict[str, list[TiedEnd]] = {}
        for name, ends in self.ends.items():
            for k, end in enumerate(ends):
                if end.slave is not None:
                    sign = 1.0 if k == 0 else -1.0
                    tied.setdefault(end.slave, []).append(
                        TiedEnd(name, sign, end.nodes, end.shares)
                    )
        return tied

    @cached_property
    def sides(self) -> Mapping[str, Sides]:
        """The two sides of contacts, by name: bodies, rows of free ones, signs of forces."""
        sides: dict[str, Sides] = {}
        for part in self.contacts:
            i, host = self.root_of(part.master), self.carrier_of_slave.get(part.slave)
            free = [(self.row[i], -1.0)] if i in self.row else []
            if host is not None and host in self.row:
                free.append((self.row[host], 1.0))
            sides[part.name] = Sides(
                i,
                host,
                tuple(row for row, _ in free),
                tuple(sign for _, sign in free),
                np.array(part.contact.master.reference_point, np.float64),
                part.contact.master.size,
            )
        return sides

    @cached_property
    def followers(self) -> frozenset[str]:
        """Names of the contacts whose stiffness follows the step, so that no step is critical."""
        return frozenset(
            part.name
            for part in self.contacts
            if getattr(part.contact.law, "stiffness_follows_step", False)
        )

    @cached_property
    def keeps_energy(self) -> bool:
        """Whether the forces of all contacts are the gradient of an energy.

        Other forces leave an energy error at any step.
        """
        return all(
            part.contact.weights != "area" and has_energy(part.contact.law)
            for part in self.contacts
        )


def has_energy(law: object) -> bool:
    """Return whether a law's forces are the gradient of an energy; true if it does not say."""
    return bool(getattr(law, "has_energy", True))


def mechanism_of(
    bodies: Mapping[str, Any],
    slaves: Mapping[str, Any],
    contacts: tuple[Any, ...],
    springs: Mapping[str, Spring],
    loads: tuple[Load, ...],
    slip_rings: Mapping[str, SlipRing],
    *,
    gas: bool = False,
) -> Mechanism:
    """Return the mechanism of bodies and slaves with their motions.

    Raises
    ------
    InputError
        A body attached to nothing or, in a circle, to itself; a free body without mass; springs and
        loads of unknown bodies; a body called "ground" beside springs to the ground; slip rings
        whose segments do not meet, or at an end with a device.
    """
    index = {name: i for i, name in enumerate(bodies)}
    root = np.array([index[_root_of_body(name, bodies)] for name in bodies], dtype=np.intp)

    def root_number(where: str, body: str) -> int:
        return int(root[_body_number(where, body, index)])

    nodes: dict[str, NodeMover] = {}
    for name, part in slaves.items():
        where = f"slaves[{name!r}]: motion"
        if isinstance(part.motion, Dependent):
            nodes[name] = part.motion.nodes(where, part.slave, partial(root_number, where))
        else:
            nodes[name] = DrivenNodes(where, part.motion, part.slave.points.shape)
    names = [name for name, part in bodies.items() if isinstance(part.motion, Free)]
    joints = [joint for mover in nodes.values() for joint in mover.joints]
    motions = []
    for name in names:  # with the masses of bodies that each carries, and of nodes glued to it
        host = index[name]
        carried = [part.motion for i, part in enumerate(bodies.values()) if root[i] == host != i]
        attached = [motion.mass for motion in carried if motion.mass is not None]
        glued = [of_points(joint.points_B, joint.mass) for joint in joints if joint.host == host]
        motions.append(with_attached(name, bodies[name].motion, attached, glued))
    fixed = [fixed_of(name, motion) for name, motion in zip(names, motions, strict=True)]
    rows = [row_of(motion, lanes) for motion, lanes in zip(motions, fixed, strict=True)]
    free = np.array([index[name] for name in names], dtype=np.intp)
    placed, ends = {}, {}
    for name, spring in springs.items():
        ends[name], at = _ends_of(name, spring, (root, index), slaves, nodes)
        placed[name] = spring if (at == spring.at).all() else spring.with_ends(at)
    rings = _ring_sides(slip_rings, placed)
    placed |= _segments(rings, placed)
    for i, load in enumerate(loads):
        _body_number(f"load[{i}]: body", load.body, index)
    return Mechanism(
        index,
        root,
        free,
        {int(i): k for k, i in enumerate(free)},
        np.array(fixed).reshape(-1, FIXED),
        np.array(rows).reshape(-1, STATE),
        {index[name]: part.motion for name, part in bodies.items() if is_driven(part.motion)},
        nodes,
        contacts,
        placed,
        ends,
        rings,
        loads,
        gas,
    )


def _ends_of(
    name: str,
    spring: Spring,
    bodies: tuple[NDArray[np.intp], Mapping[str, int]],
    slaves: Mapping[str, Any],
    nodes: Mapping[str, NodeMover],
) -> tuple[tuple[SpringEnd, SpringEnd], FloatArray]:
    """Return the bodies or nodes at the ends of a spring, and their positions (2, 3) at the start.

    An end on a slave that no body carries moves to the nearest node, or to the mean of the nodes
    that share it.

    Raises
    ------
    InputError
        An unknown body or slave, one called "ground", a point far from all nodes of its slave.
    """
    (root, index), ends, at = bodies, [], spring.at.copy()
    for k, part in enumerate(spring.between):
        where = f"spring {name!r}: between"
        if part == GROUND and (part in index or part in slaves):
            raise InputError(
                "means the world, and is also the name of a body or slave",
                where=where,
                found=GROUND,
                remedy="Rename the body or slave",
            )
        if part in index and part in slaves:
            raise InputError(
                "is the name of a body and of a slave",
                where=where,
                found=part,
                remedy="Rename one of them",
            )
        if part == GROUND:
            ends.append(SpringEnd())
        elif part in slaves and part not in index:
            host = nodes[part].host
            if host is not None:  # a body carries all of it
                ends.append(SpringEnd(host))
                continue
            points = slaves[part].slave.points
            spread = spring.spread[k]
            if spread is not None:
                at[k] = spread.shares @ points[spread.nodes]
                ends.append(SpringEnd(None, part, spread.nodes, spread.shares))
                continue
            distances = np.sqrt(np.square(points - at[k]).sum(axis=1))
            node = int(np.argmin(distances))
            if not distances[node] <= NODE_TOL * float(np.ptp(points, axis=0).max()):
                raise InputError(
                    f"no node of slave {part!r} is there: the nearest, node {node}, is "
                    f"{distances[node]:.4g} away at {points[node].tolist()}",
                    where=f"spring {name!r}: at[{k}]",
                    found=at[k].tolist(),
                    allowed=f"no farther from a node than {NODE_TOL:g} of the slave's size",
                )
            at[k] = points[node]
            ends.append(SpringEnd(None, part, np.array([node], np.int32), np.ones(1)))
        else:
            names = dict(index)
            if part not in index:
                names |= dict.fromkeys(slaves, 0)
            ends.append(SpringEnd(int(root[_body_number(where, part, names)])))
    return (ends[0], ends[1]), at


def _ring_sides(
    rings: Mapping[str, SlipRing], springs: Mapping[str, Spring]
) -> dict[str, tuple[RingSide, RingSide]]:
    """Return the two segments at each slip ring, with the end that is at the ring.

    Ends meet if they are on one body or slave, and nearer than `RING_TOL` of the longer segment.

    Raises
    ------
    InputError
        An unknown spring, two segments that do not meet or meet twice, an end in two slip rings.
    """
    sides: dict[str, tuple[RingSide, RingSide]] = {}
    ring_at: dict[RingSide, str] = {}
    for name, ring in rings.items():
        where = f"slip_ring {name!r}: between"
        for segment in ring.between:
            if segment not in springs:
                raise InputError(
                    "no spring of this name is there",
                    where=where,
                    found=segment,
                    allowed=", ".join(map(repr, springs)),
                )
        first, second = (springs[segment] for segment in ring.between)
        size = max(float(np.ptp(spring.at, axis=0).max()) for spring in (first, second))
        distances = {
            (i, j): float(np.abs(first.at[i] - second.at[j]).max())
            for i in (0, 1)
            for j in (0, 1)
            if first.between[i] == second.between[j]
        }
        meeting_pairs = [
            pair for pair, distance in distances.items() if distance <= RING_TOL * size
        ]
        if len(meeting_pairs) != 1:
            ends = " and ".join(f"{s.between[0]!r}-{s.between[1]!r}" for s in (first, second))
            defect = "meet twice" if meeting_pairs else "do not meet"
            raise InputError(
                f"its segments {defect}: they end at {ends}",
                where=where,
                found=list(ring.between),
                allowed="two springs with one end in common: one body or slave, one point",
            )
        (i, j) = meeting_pairs[0]
        pair = RingSide(ring.between[0], i), RingSide(ring.between[1], j)
        for side in pair:
            if side in ring_at:
                raise InputError(
                    f"{side.spring!r} is in slip ring {ring_at[side]!r} with this end already",
                    where=where,
                    found=side.spring,
                    allowed="one device at an end",
                )
            ring_at[side] = name
        sides[name] = pair
    return sides


def _segments(
    rings: Mapping[str, tuple[RingSide, RingSide]], springs: Mapping[str, Spring]
) -> dict[str, Spring]:
    """Return the springs in slip rings, as webbing.

    Raises
    ------
    InputError
        A spring that is no webbing; one with devices and slip rings at both ends, or with one at
        its anchor.
    """
    ends: dict[str, int] = {}
    for side in (side for pair in rings.values() for side in pair):
        ends[side.spring] = ends.get(side.spring, 0) + 1
    segments: dict[str, Spring] = {}
    for name, count in ends.items():
        devices = springs[name].devices
        on_a_belt = springs[name].spread != (None, None)
        if (count == 2 or on_a_belt) and any(device is not None for device in devices[:3]):
            rings_found = "slip rings at both ends" if count == 2 else "a slip ring at its anchor"
            raise InputError(
                f"has {rings_found}, and no end left for its devices",
                where=f"spring {name!r}",
                allowed="one device at an end",
            )
        try:
            segments[name] = springs[name].as_webbing()
        except InputError as error:
            raise InputError(
                error.what,
                where=f"spring {name!r}: {error.where}",
                found=error.found,
                allowed=error.allowed,
                remedy=error.remedy,
            ) from error
    return segments


def _body_number(where: str, name: str, numbers: Mapping[str, int]) -> int:
    """Return the number of the body `name`; raise `InputError` about `where` if it is unknown."""
    if name not in numbers:
        raise InputError(
            "no body of this name is there",
            where=where,
            found=name,
            allowed=", ".join(map(repr, numbers)),
        )
    return numbers[name]


def _root_of_body(name: str, bodies: Mapping[str, Any]) -> str:
    """Return the name of the body at the end of a chain of attachments; `name` if it has none.

    Raises `InputError` for an unknown body, or a circle of attachments.
    """
    chain = [name]
    while isinstance(motion := bodies[chain[-1]].motion, Attached):
        _body_number(f"bodies[{chain[-1]!r}]: motion", motion.body, dict.fromkeys(bodies, 0))
        if motion.body in chain:
            raise InputError(
                "bodies are attached in a circle: none of them says where they go",
                where=f"bodies[{name!r}]: motion",
                found=" -> ".join([*chain, motion.body]),
                remedy="Give one of them a motion of its own",
            )
        chain.append(motion.body)
    return chain[-1]
