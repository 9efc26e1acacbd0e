"""Keep the bounds of a body that certify tracked feet; the proof stands in `branch_nb`.

It is worked out when feet are first tracked with certificates, and kept as long as the body lives.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Records
from contiga.search.certify.kernels import neighbourhood_nb, part_nb
from contiga.search.hierarchy.kept import Kept
from contiga.search.hierarchy.table_types import NEIGHBOURHOOD, Tables

# Elements below which a second thread does not pay.
ELEMENTS = 64
# How often a part is quartered for its bounds, and elements up to which that is worth its time.
QUARTERED = ((3, 100), (2, 400), (1, 4000))


def none() -> Records:
    """Return (0, 16) in the tables of a body whose feet are not tracked."""
    return np.zeros((0, part_nb.PARTS**2), NEIGHBOURHOOD)


def build_neighbourhoods(tables: Tables) -> Records:
    """Return (elements, 16) bounds around the parts of all elements."""
    elements = tables.elements
    n = len(elements.table)
    parts = part_nb.PARTS**2
    raw = np.empty((n, parts, 6))
    neighbourhoods = np.zeros((n, parts), NEIGHBOURHOOD)
    depth = next((d for d, most in QUARTERED if n <= most), 0)
    run_ranges(neighbourhood_nb.bends_of_parts, n, ELEMENTS, elements, depth, raw)
    run_ranges(neighbourhood_nb.join_parts, n, ELEMENTS, elements, raw, neighbourhoods)
    return neighbourhoods


_KEPT = Kept(build_neighbourhoods)


def with_neighbourhoods(tables: Tables) -> Tables:
    """The tables of a body with its neighbourhoods, worked out at the first call."""
    return tables._replace(neighbourhoods=_KEPT.of(tables))
