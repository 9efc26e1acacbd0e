"""Lumped masses on nodes of what deforms, beside those of its elements."""

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
    """Return the sum (n,) of the lumped masses on each node of a slave.

    Parameters
    ----------
    masses : tables with a place as `contiga.dynamics.places` has them (all nodes without one) and a
        ``"mass"``: a number in all, which nodes share as they share a force (`shares_at`), or (k,)
        one for each node of the place, in the order of the numbers that it names, else ascending
    where : for messages
    slave : slave with the nodes

    Raises
    ------
    InputError
        A mass that is negative or not finite, as many as there are not nodes, a place that is none.
    """
    whole = np.zeros(len(slave))
    for k, table in enumerate(masses):
        here = f"{where}[{k}]" if len(masses) > 1 else where
        key = place_of(table, ("mass",), here)
        place = table.get(key or "")
        mass = _numbers(table.get("mass"), f"{here}: mass")
        if mass.ndim == 0:
            whole += mass * shares_at(key, place, slave, here)
            continue
        rows = np.flatnonzero(nodes_at(key, place, slave, here))
        if key == "nodes" and np.asarray(place).dtype != np.bool_:
            rows = np.asarray(place)
        if mass.shape != rows.shape:
            raise InputError(
                "must have one mass for each node of the place",
                where=f"{here}: mass",
                found=f"{len(mass)} for {len(rows)} nodes",
                allowed="a number in all, or one for each node",
            )
        np.add.at(whole, rows, mass)
    return whole


def check_carried(lumped: FloatArray, carriers: NDArray[np.intp], slave: Slave, where: str) -> None:
    """Refuse masses `lumped` (n,) on nodes other than `carriers`, which stay where they are.

    Raises
    ------
    InputError
        As said.
    """
    lone = np.setdiff1d(np.flatnonzero(lumped), carriers)
    if len(lone):
        raise InputError(
            f"node {lone[0]} is in no element, stays where it is and carries no mass",
            where=where,
            found=slave.points[lone[0]].tolist(),
            remedy="Choose a place whose nodes are all of elements",
        )


def _numbers(given: Any, where: str) -> FloatArray:
    """A number, or (k,) of them, zero or above."""
    real(given, where)
    try:
        numbers = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if numbers.ndim > 1 or not (np.isfinite(numbers) & (numbers >= 0.0)).all():
        raise InputError(
            "must be a number, or one for each node of the place",
            where=where,
            found=given,
            allowed="0 or more",
        )
    return numbers
