"""Fields that the pictures show in colour.

They are penetration, pressure, the regions of contact, and the inside of deforming slaves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray
from contiga.report.peak import Outline, Peak, RecordedContact
from contiga.report.run_folder import Units
from contiga.report.style import REGIONS

# A few nodes at the rim of a region, with hardly any area, may have many times the pressure of all
# others. With `MIN_NODES` nodes or more, colours end at this quantile if the largest value is more
# than `_MAX_RATIO` times it.
MIN_NODES = 20
_QUANTILE, _MAX_RATIO = 0.98, 2.0
_INSIDE: dict[str, tuple[str, Callable[[Units], str]]] = {
    "von_mises": ("Von Mises stress", lambda units: units.stress),
    "principal_strain": ("Largest strain", lambda units: ""),
    "energy_density": (
        "Energy density",
        lambda units: f"{units.energy}/{units.length}³" if units.energy else "",
    ),
}
"""Labels of the fields of the inside, and their units."""


class ColouredField(NamedTuple):
    """One field that colours can show."""

    label: str
    unit: str
    values: FloatArray
    """(n_s,) values at the slave points; zero outside the contact for fields of a contact."""
    top: float
    """Value at which the colours end."""
    cut: bool
    """Whether some values are larger."""
    everywhere: bool = False
    """Whether points without contact have it too."""


def fields_of(peak: Peak | RecordedContact, units: Units) -> dict[str, ColouredField]:
    """Return the fields of the slave by name, in the units of the page.

    Penetration is always among them, pressure if it is positive anywhere, and each recorded field
    of the inside of deforming slaves.
    """
    fields = {"penetration": _field("Penetration", units.length, peak.penetration, peak.in_contact)}
    if peak.pressure is not None and np.any(peak.pressure > 0.0):
        pressure = peak.pressure
        fields["pressure"] = _field("Pressure", units.stress, pressure, peak.in_contact)
    for name, values in peak.inside.items():
        label, unit = _INSIDE[name]
        field = _field(label, unit(units), values, values > 0.0)
        fields[name] = field._replace(everywhere=True)
    return fields


def first_field(peak: Peak, units: Units) -> ColouredField:
    """Return the field of a contact that is shown first: the pressure if there is some."""
    fields = fields_of(peak, units)
    return fields.get("pressure", fields["penetration"])


def _field(
    label: str, unit: str, values: FloatArray, has_value: NDArray[np.bool_]
) -> ColouredField:
    """Return a field with the value at which its colours end; GPa becomes MPa.

    Colours end at the largest value. If `MIN_NODES` points or more have a value, it is their 98 %
    quantile, where the largest is more than twice that.
    """
    if unit == "GPa":
        unit, values = "MPa", 1e3 * values
    greatest = float(values.max(initial=0.0))
    top = greatest
    if has_value.sum() >= MIN_NODES:
        quantile = float(np.quantile(values[has_value], _QUANTILE, method="lower"))
        top = quantile if 0.0 < _MAX_RATIO * quantile < greatest else greatest
    return ColouredField(label, unit, values, max(top, 1e-300), top < greatest)


def region_colours(outlines: tuple[Outline, ...]) -> dict[tuple[int, int], str]:
    """Return a colour for each region by the numbers of its contact and cluster, in their order.

    The colours of `REGIONS` repeat after the last.
    """
    keys = sorted({(line.contact, line.cluster) for line in outlines})
    return {key: REGIONS[k % len(REGIONS)] for k, key in enumerate(keys)}
