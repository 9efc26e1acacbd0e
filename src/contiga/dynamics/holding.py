"""Degrees of freedom of nodes that are held, driven by a motion or carried by a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.dynamics.nodes import Instant
from contiga.dynamics.places import PLACES, mask_of, nodes_at, place_of
from contiga.dynamics.prescribed import BodyMotion, pose_at
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.frames import to_world
from contiga.slaves.slave import Slave

DIRECTIONS = ("x", "y", "z")
DofMask = NDArray[np.bool_]
"""(n, 3) translational degrees of freedom of nodes."""


class Drive(NamedTuple):
    """Degrees of freedom of nodes that follow the motion of a body, whatever the forces on them."""

    dofs: DofMask
    """(n, 3) degrees of freedom that the motion prescribes."""
    rows: NDArray[np.intp]
    """(k,) nodes."""
    base: FloatArray
    """(k, 3) points in the axes of the motion."""
    motion: BodyMotion

    def place(self, now: Instant, points: FloatArray, velocities: FloatArray) -> None:
        """Write the driven degrees of freedom at a time into points and velocities (n, 3)."""
        X, twist = pose_at(self.motion, now.time), self.motion.twist(now.time)
        points_W, dofs = to_world(X, self.base), self.dofs[self.rows]
        velocities_W = twist.at(X[:3, 3], points_W)
        points[self.rows] = np.where(dofs, points_W, points[self.rows])
        velocities[self.rows] = np.where(dofs, velocities_W, velocities[self.rows])


def held_dofs(fixed: Any, slave: Slave, where: str) -> DofMask:
    """Return the mask (n, 3) of the degrees of freedom of a slave's points that are held.

    Tables add up. Nodes by number, or a mask (n,), are held in all directions.

    Parameters
    ----------
    fixed : (n,) bool, (n, 3) bool, or numbers of nodes; a table of one place, see
        `contiga.dynamics.places`, with ``"hold": ["x", …]``, all three directions if omitted
        (``"slope"`` is for `clamped_edges`); a list of such tables; None holds nothing
    where : for messages
    slave : slave whose points are held

    Raises
    ------
    InputError
        The argument is none of these, a table has no place or more than one, or no node is at it.
    """
    held = np.zeros(slave.points.shape, np.bool_)
    if fixed is None:
        return held
    if (tables := _tables_of(fixed)) is not None:
        for k, table in enumerate(tables):
            at = where if isinstance(fixed, Mapping) else f"{where}[{k}]"
            if place_of(table, ("hold", "slope"), at) is None:
                raise InputError(
                    "says which nodes by one key",
                    where=at,
                    found=", ".join(map(str, table)) or "none",
                    allowed=", ".join(PLACES),
                )
            held |= _dofs_of_table(table, ("slope",), slave, at)
        return held
    nodes = np.asarray(fixed)
    if nodes.dtype == np.bool_ and nodes.shape == held.shape:
        return nodes.copy()
    held[mask_of(nodes, len(slave), where)] = True
    return held


def clamped_edges(fixed: Any, slave: Slave, where: str) -> list[tuple[int, str]]:
    """Return patch and name of the edges of a slave of splines whose slope is held, each once.

    All their nodes are at one place of `fixed` with ``"slope": True``. Without such a table the
    list is empty; `fixed` need not be tables.

    Raises
    ------
    InputError
        No edge has all its nodes at such a place, or the slave is no surface of splines.
    """
    edges: list[tuple[int, str]] = []
    for k, table in enumerate(_tables_of(fixed) or ()):
        if not table.get("slope"):
            continue
        at = f"{where}[{k}]: slope"
        if slave.surfaces is None:
            raise InputError("only a slave of splines keeps slopes", where=at, found=True)
        key = place_of(table, ("hold", "slope"), at)
        clamped = slave.surfaces.edges_within(nodes_at(key, table.get(key or ""), slave, at))
        if not clamped:
            raise InputError(
                "no edge of a patch is wholly at this place",
                where=at,
                found=f"the {key}",
                allowed="a place with all nodes of an edge",
            )
        edges += [edge for edge in clamped if edge not in edges]
    return edges


def drives_of(
    driven: Sequence[Mapping[str, Any]], held: DofMask, slave: Slave, where: str
) -> tuple[Drive, ...]:
    """Return one drive a table for nodes of a slave, which move from their places in the slave.

    Parameters
    ----------
    driven : tables as for `held_dofs` with a ``"motion"``, of `contiga.motion`
    held : (n, 3) degrees of freedom that are held
    slave : slave whose nodes are driven
    where : for messages

    Raises
    ------
    InputError
        No motion; a degree of freedom that is held and driven at once, or driven twice.
    """
    drives: list[Drive] = []
    prescribed = held.copy()
    for k, table in enumerate(driven):
        at = f"{where}[{k}]" if len(driven) > 1 else where
        motion: Any = table.get("motion")
        if not (callable(getattr(motion, "pose", None)) and callable(getattr(motion, "twist", 0))):
            raise InputError(
                "must have the motion of a body",
                where=f"{at}: motion",
                found=motion,
                allowed="one of contiga.motion with pose(t) and twist(t)",
            )
        dofs = _dofs_of_table(table, ("motion",), slave, at)
        conflicts = np.argwhere(dofs & prescribed)
        if conflicts.size:
            node, axis = conflicts[0].tolist()
            raise InputError(
                f"node {node} is {'held' if held[node, axis] else 'driven'} along "
                f"{DIRECTIONS[axis]} already",
                where=at,
                found=slave.points[node].tolist(),
                remedy='Leave the way out of one of the two, as hold = ["x", "y"]',
            )
        prescribed |= dofs
        rows = np.flatnonzero(dofs.any(axis=1))
        drives.append(Drive(dofs, rows, slave.points[rows], motion))
    return tuple(drives)


def attachment_hosts(
    attached: Sequence[Mapping[str, Any]],
    prescribed: DofMask,
    number: Callable[[str], int],
    slave: Slave,
    where: str,
) -> NDArray[np.int32]:
    """Return the number (n,) of the body that each node is attached to, −1 for none.

    Parameters
    ----------
    attached : tables with a place as for `held_dofs` (all nodes without one) and a ``"body"``
    prescribed : (n, 3) degrees of freedom that are held or driven
    number : number of a body by its name
    slave : slave whose nodes are attached
    where : for messages

    Raises
    ------
    InputError
        No such body; a node is held, driven or attached to another body already.
    """
    hosts = np.full(len(slave), -1, np.int32)
    is_prescribed = prescribed.any(axis=1)
    for k, table in enumerate(attached):
        at = f"{where}[{k}]" if len(attached) > 1 else where
        body = table.get("body")
        if not isinstance(body, str):
            raise InputError("must be the name of a body", where=f"{at}: body", found=body)
        key = place_of(table, ("body",), at)
        nodes = nodes_at(key, table.get(key or ""), slave, at)
        host = number(body)
        conflicts = np.flatnonzero(nodes & (is_prescribed | ((hosts >= 0) & (hosts != host))))
        if conflicts.size:
            raise InputError(
                f"node {int(conflicts[0])} is held, driven or attached already",
                where=at,
                found=slave.points[int(conflicts[0])].tolist(),
                remedy="Leave it out of one of the two places",
            )
        hosts[nodes] = host
    return hosts


def _tables_of(fixed: Any) -> Sequence[Mapping[str, Any]] | None:
    """Return one table, or the tables of a list; None if `fixed` is neither, or an empty list."""
    tables = [fixed] if isinstance(fixed, Mapping) else fixed
    is_list = isinstance(tables, Sequence) and len(tables) > 0
    return tables if is_list and all(isinstance(table, Mapping) for table in tables) else None


def _dofs_of_table(
    table: Mapping[str, Any], other_keys: tuple[str, ...], slave: Slave, where: str
) -> DofMask:
    """Return the mask (n, 3) of the degrees of freedom that one table selects.

    Without ``"hold"`` they are all three of a node; without a place, those of all nodes.
    """
    key = place_of(table, ("hold", *other_keys), where)
    names = held_names(table.get("hold", DIRECTIONS), DIRECTIONS, f"{where}: hold")
    axes = np.array([axis in names for axis in DIRECTIONS])
    return nodes_at(key, table.get(key or ""), slave, where)[:, None] & axes


def held_names(hold: Any, allowed_names: tuple[str, ...], where: str) -> tuple[str, ...]:
    """Return the names in `hold`, a string or several, once each in the order of `allowed_names`.

    Raises
    ------
    InputError
        Another name.
    """
    names = (hold,) if isinstance(hold, str) else tuple(hold)
    for name in names:
        if name not in allowed_names:
            raise InputError(
                "nothing of this name can be held",
                where=where,
                found=name,
                allowed=", ".join(allowed_names),
            )
    return tuple(name for name in allowed_names if name in names)
