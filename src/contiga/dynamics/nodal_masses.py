"""Lumped masses on nodes of a slave that deforms, in addition to those of its elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import real
from contiga.dynamics.nodal_loads import shares_at
from contiga.dynamics.places import nodes_at, place_of
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.slaves.slave import Slave


def lumped_masses(masses: Sequence[Mapping[str, Any]], slave: Slave, where: str) -> FloatArray:
    """Return the sum (n,) of the lumped masses on each node of a slave; zeros without tables.

    Parameters
    ----------
    masses : tables with a place, see `contiga.dynamics.places` (all nodes without one), and a
        ``"mass"``: a total that nodes share as they share a force (`shares_at`), or (k,) one for
        each node of the place, in the order of its node numbers if it has these, else ascending
    where : for messages
    slave : slave with the nodes

    Raises
    ------
    InputError
        A mass that is negative or not finite, not one mass for each node, an invalid place.
    """
    total = np.zeros(len(slave))
    for k, table in enumerate(masses):
        at = f"{where}[{k}]" if len(masses) > 1 else where
        key = place_of(table, ("mass",), at)
        place = table.get(key or "")
        real(table.get("mass"), f"{at}: mass")
        try:
            mass = np.asarray(table.get("mass"), dtype=np.float64)
        except (TypeError, ValueError):
            mass = np.array(np.nan)
        if mass.ndim > 1 or not (np.isfinite(mass) & (mass >= 0.0)).all():
            raise InputError(
                "must be a number, or one for each node of the place",
                where=f"{at}: mass",
                found=table.get("mass"),
                allowed="0 or more",
            )
        if mass.ndim == 0:
            total += mass * shares_at(key, place, slave, at)
            continue
        rows = np.flatnonzero(nodes_at(key, place, slave, at))
        if key == "nodes" and np.asarray(place).dtype != np.bool_:
            rows = np.asarray(place)
        if mass.shape != rows.shape:
            raise InputError(
                "must have one mass for each node of the place",
                where=f"{at}: mass",
                found=f"{len(mass)} for {len(rows)} nodes",
                allowed="a number in all, or one for each node",
            )
        np.add.at(total, rows, mass)
    return total


def check_carried(lumped: FloatArray, carriers: NDArray[np.intp], slave: Slave, where: str) -> None:
    """Refuse masses `lumped` (n,) on nodes that are not in `carriers`, the nodes of elements.

    Raises
    ------
    InputError
        A mass above zero on another node, which does not move; the lowest one is named.
    """
    bare = np.setdiff1d(np.flatnonzero(lumped), carriers)
    if len(bare):
        raise InputError(
            f"node {bare[0]} is in no element, stays where it is and carries no mass",
            where=where,
            found=slave.points[bare[0]].tolist(),
            remedy="Choose a place whose nodes are all of elements",
        )
