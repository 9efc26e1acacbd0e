"""What the pictures can show in colour: penetration, pressure, and the regions of contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import FloatArray
from contiga.report.peak import Outline, Peak, Touched
from contiga.report.run_folder import Units
from contiga.report.style import REGIONS

# A few nodes at the rim of a region, of next to no area, may have many times the pressure of all
# others. Of `MANY` nodes and more, colours end at this share where the greatest is beyond `_FAR`
# times it.
MANY = 20
_SHARE, _FAR = 0.98, 2.0


class ColouredField(NamedTuple):
    """One field that colours can show."""

    label: str
    unit: str
    values: FloatArray
    """(n_s,) of the slave points, zero outside the contact."""
    top: float
    """Where the colours end."""
    cut: bool
    """Whether some values are greater."""


def fields_of(peak: Peak | Touched, units: Units) -> dict[str, ColouredField]:
    """Fields of the slave by name: penetration always, pressure where there is some."""
    fields = {"penetration": _coloured("Penetration", units.length, peak.penetration, peak)}
    if peak.pressure is not None and np.any(peak.pressure > 0.0):
        fields["pressure"] = _coloured("Pressure", units.stress, peak.pressure, peak)
    return fields


def first_field(peak: Peak, units: Units) -> ColouredField:
    """What is shown first: the pressure where there is some."""
    fields = fields_of(peak, units)
    return fields.get("pressure", fields["penetration"])


def _coloured(label: str, unit: str, values: FloatArray, peak: Peak | Touched) -> ColouredField:
    greatest = float(values.max(initial=0.0))
    top = greatest
    if peak.in_contact.sum() >= MANY:
        most = float(np.quantile(values[peak.in_contact], _SHARE, method="lower"))
        top = most if 0.0 < _FAR * most < greatest else greatest
    return ColouredField(label, unit, values, max(top, 1e-300), top < greatest)


def region_colours(outlines: tuple[Outline, ...]) -> dict[tuple[int, int], str]:
    """A colour for every region, by the numbers of its contact and cluster."""
    keys = sorted({(line.contact, line.cluster) for line in outlines})
    return {key: REGIONS[k % len(REGIONS)] for k, key in enumerate(keys)}
