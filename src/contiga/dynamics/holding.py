"""Degrees of freedom of nodes that are held, driven by a motion or carried by a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.dynamics.nodes import Instant
from contiga.dynamics.places import PLACES, nodes_at, nodes_given, place_of
from contiga.dynamics.prescribed import BodyMotion, pose_at
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.frames import to_world
from contiga.slaves.slave import Slave

WAYS = ("x", "y", "z")
Ways = NDArray[np.bool_]
"""(n, 3)."""


class Drive(NamedTuple):
    """Nodes that go as a body would by a motion, whatever the forces on them."""

    ways: Ways
    """(n, 3) directions in which they do."""
    rows: NDArray[np.intp]
    """(k,) nodes."""
    base: FloatArray
    """(k, 3) points that the poses of the motion carry."""
    motion: BodyMotion

    def place(self, now: Instant, points: FloatArray, velocities: FloatArray) -> None:
        """Have points and velocities (n, 3) of the nodes as the motion says at a time."""
        X, twist = pose_at(self.motion, now.time), self.motion.twist(now.time)
        there, ways = to_world(X, self.base), self.ways[self.rows]
        points[self.rows] = np.where(ways, there, points[self.rows])
        speed = twist.at(X[:3, 3], there)
        velocities[self.rows] = np.where(ways, speed, velocities[self.rows])


def held_ways(fixed: Any, slave: Slave, where: str) -> Ways:
    """Return the ways (n, 3) of the points of a slave that are held.

    Parameters
    ----------
    fixed : (n,) bool, (n, 3) bool, or numbers of nodes; a table with a place as
        `contiga.dynamics.places` has them, and the ways as ``"hold": ["x", …]``, all if omitted
        (``"slope"`` is for `slopes_kept`); several of them in a list; None holds nothing
    where : for messages
    slave : slave whose points are held

    Raises
    ------
    InputError
        It is none of these, or no node is there.
    """
    held = np.zeros(slave.points.shape, np.bool_)
    if fixed is None:
        return held
    tables = isinstance(fixed, Sequence) and len(fixed) > 0
    if tables and all(isinstance(one, Mapping) for one in fixed):
        for k, one in enumerate(fixed):
            held |= _held_by(one, slave, f"{where}[{k}]")
        return held
    if isinstance(fixed, Mapping):
        return _held_by(fixed, slave, where)
    given = np.asarray(fixed)
    if given.dtype == np.bool_ and given.shape == held.shape:
        return given.copy()
    held[nodes_given(given, len(slave), where)] = True
    return held


def slopes_kept(fixed: Any, slave: Slave, where: str) -> list[tuple[int, str]]:
    """Return patches and names of the edges of a slave of splines that keep their slope.

    These are wholly at a place of `fixed` with ``"slope": True``.

    Raises
    ------
    InputError
        No whole edge is there, or a slave that is no surface of splines.
    """
    tables = [fixed] if isinstance(fixed, Mapping) else fixed
    several = isinstance(tables, Sequence) and all(isinstance(one, Mapping) for one in tables)
    edges: list[tuple[int, str]] = []
    for k, table in enumerate(tables if several else ()):
        if not table.get("slope"):
            continue
        here = f"{where}[{k}]: slope"
        if slave.surfaces is None:
            raise InputError("only a slave of splines keeps slopes", where=here, found=True)
        key = place_of(table, ("hold", "slope"), here)
        kept = slave.surfaces.edges_within(nodes_at(key, table.get(key or ""), slave, here))
        if not kept:
            raise InputError(
                "no edge of a patch is wholly at this place",
                where=here,
                found=f"the {key}",
                allowed="a place with all nodes of an edge",
            )
        edges += [one for one in kept if one not in edges]
    return edges


def drives_of(
    driven: Sequence[Mapping[str, Any]], held: Ways, slave: Slave, where: str
) -> tuple[Drive, ...]:
    """Return the drives of nodes of a slave whose ways `held` are held.

    Parameters
    ----------
    driven : tables as of `held_ways` with a ``"motion"``, of `contiga.motion`
    held : (n, 3) directions that are held
    slave : slave whose nodes are driven
    where : for messages

    Raises
    ------
    InputError
        No motion, a way is held and driven at once, or driven twice.
    """
    drives: list[Drive] = []
    taken = held.copy()
    for k, table in enumerate(driven):
        here = f"{where}[{k}]" if len(driven) > 1 else where
        motion: Any = table.get("motion")
        if not (callable(getattr(motion, "pose", None)) and callable(getattr(motion, "twist", 0))):
            raise InputError(
                "must have the motion of a body",
                where=f"{here}: motion",
                found=motion,
                allowed="one of contiga.motion with pose(t) and twist(t)",
            )
        ways = _of_table(table, ("motion",), slave, here)
        twice = np.flatnonzero((ways & taken).any(axis=1))
        if twice.size:
            node, way = int(twice[0]), int(np.argmax((ways & taken)[twice[0]]))
            raise InputError(
                f"node {node} is {'held' if held[node, way] else 'driven'} along {WAYS[way]} "
                "already",
                where=here,
                found=slave.points[node].tolist(),
                remedy='Leave the way out of one of the two, as hold = ["x", "y"]',
            )
        taken |= ways
        rows = np.flatnonzero(ways.any(axis=1))
        drives.append(Drive(ways, rows, slave.points[rows], motion))
    return tuple(drives)


def attached_to(
    attached: Sequence[Mapping[str, Any]],
    taken: Ways,
    number: Callable[[str], int],
    slave: Slave,
    where: str,
) -> NDArray[np.int32]:
    """Return the number (n,) of the body that each node is attached to, −1 for none.

    Parameters
    ----------
    attached : tables with a place as of `held_ways` (all nodes without one) and a ``"body"``
    taken : (n, 3) ways that are held or driven
    number : of the body of a name
    slave : slave whose nodes are attached
    where : for messages

    Raises
    ------
    InputError
        No such body; a node is held, driven or attached to another already.
    """
    hosts = np.full(len(slave), -1, np.int32)
    others = taken.any(axis=1)
    for k, table in enumerate(attached):
        here = f"{where}[{k}]" if len(attached) > 1 else where
        body = table.get("body")
        if not isinstance(body, str):
            raise InputError("must be the name of a body", where=f"{here}: body", found=body)
        key = place_of(table, ("body",), here)
        there = nodes_at(key, table.get(key or ""), slave, here)
        host = number(body)
        twice = np.flatnonzero(there & (others | ((hosts >= 0) & (hosts != host))))
        if twice.size:
            raise InputError(
                f"node {int(twice[0])} is held, driven or attached already",
                where=here,
                found=slave.points[int(twice[0])].tolist(),
                remedy="Leave it out of one of the two places",
            )
        hosts[there] = host
    return hosts


def _held_by(table: Mapping[str, Any], slave: Slave, where: str) -> Ways:
    """Return the ways (n, 3) of one table, which names a place."""
    if place_of(table, ("hold", "slope"), where) is None:
        raise InputError(
            "says which nodes by one key",
            where=where,
            found=", ".join(map(str, table)) or "none",
            allowed=", ".join(PLACES),
        )
    return _of_table(table, ("slope",), slave, where)


def _of_table(table: Mapping[str, Any], others: tuple[str, ...], slave: Slave, where: str) -> Ways:
    """Return the ways (n, 3) of one table."""
    key = place_of(table, ("hold", *others), where)
    held = names_held(table.get("hold", WAYS), WAYS, f"{where}: hold")
    ways = np.array([way in held for way in WAYS])
    return nodes_at(key, table.get(key or ""), slave, where)[:, None] & ways


def names_held(hold: Any, known: tuple[str, ...], where: str) -> tuple[str, ...]:
    """Return those of the names `known` that are to be held, in their order.

    Raises
    ------
    InputError
        Another name.
    """
    names = (hold,) if isinstance(hold, str) else tuple(hold)
    for name in names:
        if name not in known:
            raise InputError(
                "nothing of this name can be held",
                where=where,
                found=name,
                allowed=", ".join(known),
            )
    return tuple(name for name in known if name in names)
