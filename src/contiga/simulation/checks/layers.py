"""Describe the layers that the law of a contact compresses: thickness and end of the table."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.contact import Contact
from contiga.curves.characteristic import Characteristic
from contiga.laws.by_face import FaceLaws
from contiga.laws.combined import CombinedLaw
from contiga.laws.force import ForceLaw
from contiga.laws.stress import StressLaw

BEYOND = {
    "linear": "continued straight on",
    "constant": "held at its last value",
    "error": "an error that ends the run",
}


class Layer(NamedTuple):
    """The layer that a contact compresses."""

    thickness: float | None
    """Largest thickness of the layer; None for a law without."""
    end: float | None
    """Penetration at the end of the law's table; None for a law without end."""
    beyond: str
    """Continuation beyond the end, in words."""
    curve: Characteristic
    """Curve of the law: stress over strain with a thickness, else a force."""


def layers_of(contact: Contact) -> list[Layer]:
    """Return the layers of a contact: one per law by face, none for laws without a curve."""
    if isinstance(contact.law, FaceLaws):
        return [layer for law in contact.law.laws for layer in _layers(law, contact)]
    return _layers(contact.law, contact)


def _layers(law: object, contact: Contact) -> list[Layer]:
    """Return the layer of a law, at most one; of a combined law if both sides have a thickness."""
    if isinstance(law, CombinedLaw):
        # The law divides the penetration between the sides, so their thicknesses add up.
        slave, master = _layer(law.slave, contact), _layer(law.master, contact)
        if slave is None or master is None or slave.thickness is None or master.thickness is None:
            return []
        both = slave.thickness + master.thickness
        return [Layer(both, None, "", slave.curve)]
    layer = _layer(law, contact)
    return [] if layer is None else [layer]


def _layer(law: object, contact: Contact) -> Layer | None:
    """Return the layer of a force or stress law; None for others, or a stress law without one.

    A stress law without a thickness has the largest of the slave's active points.
    """
    if isinstance(law, ForceLaw):
        return Layer(None, end_of(law.curve), BEYOND[law.curve.extrapolation], law.curve)
    if not isinstance(law, StressLaw):
        return None
    thickness = law.thickness
    if thickness is None:
        nodal = contact.slave.thickness
        if nodal is None or not (nodal[contact.slave.active] > 0.0).any():
            return None
        thickness = float(nodal[contact.slave.active].max())
    end = end_of(law.elastic)
    beyond = BEYOND[law.elastic.extrapolation]
    return Layer(thickness, None if end is None else end * thickness, beyond, law.elastic)


def thickness_of(contact: Contact) -> float | None:
    """Return the thickness of the layer of a law of stress over strain.

    None for another law, or for a layer of varying thickness.
    """
    if not isinstance(contact.law, StressLaw):
        return None
    if contact.law.thickness is not None:
        return contact.law.thickness
    nodal = contact.slave.thickness
    active = None if nodal is None else nodal[contact.slave.active]
    if active is None or not len(active) or not active.min() == active.max() > 0.0:
        return None
    return float(active[0])


def end_of(curve: Characteristic) -> float | None:
    """Return the last x of a table; None for a formula, or a straight line that continues."""
    if not curve.is_table or (len(curve.x) == 2 and curve.extrapolation == "linear"):
        return None
    return float(curve.x[-1])


def strength(curve: Characteristic, strain: float) -> float:
    """Return the value of a curve at a strain, or at the end of its table if that comes first."""
    at = min(strain, float(curve.x[-1])) if curve.is_table else strain
    return float(np.asarray(curve(at)))
