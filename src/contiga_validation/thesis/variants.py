"""Variants of a scene with one contact: another area, law or slave than in its case file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contiga import Contact, Simulation, Slave, build, load_case
from contiga_validation.engine.arrays import IntArray
from contiga_validation.thesis.scenes import scene


def simulation_of(name: str) -> Simulation:
    """Build the simulation of a scene; an unknown one raises a FileError."""
    return build(load_case(scene(name)))


def variant(simulation: Simulation, *, master: Any = None, **options: Any) -> Simulation:
    """Return a copy of `simulation` with its one contact replaced.

    Law, area, search, weights and foot are those of the contact unless given; other options are
    those of `Contact` by default.

    Parameters
    ----------
    master : replaces the body in the contact; it must be at rest
    options : of `Contact`, and `slave`, whose points must be the same
    """
    (part,) = simulation.contacts
    original = part.contact
    slave = options.pop("slave", original.slave)
    arguments: dict[str, Any] = {
        "law": original.law,
        "area": original.area,
        "search": original.search,
    }
    arguments |= {"weights": original.weights, "foot": original.foot, **options}
    contact = Contact(original.master if master is None else master, slave, **arguments)
    return replace(simulation, contacts=(part._replace(contact=contact),))


def slave_of(simulation: Simulation) -> Slave:
    """Return the slave of the one contact."""
    (part,) = simulation.contacts
    return part.contact.slave


def ring_facets(rows: int, columns: int, keep: range | None = None) -> IntArray:
    """Return (m, 3) triangles of a tube of points, `rows` around it and `columns` along it.

    Parameters
    ----------
    keep : numbers of the strips between rows to mesh; all if omitted
    """
    facets = []
    for i in range(rows) if keep is None else keep:
        for j in range(columns - 1):
            a, b = (i % rows) * columns + j, ((i + 1) % rows) * columns + j
            facets += [(a, b, b + 1), (a, b + 1, a + 1)]
    return np.array(facets, dtype=np.int32)
