"""Bounds of a body that certify tracked feet; the proof is in `branch_nb`.

They are computed when feet are first tracked with certificates, and cached with the body.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Records
from contiga.search.certify.kernels import neighbourhood_nb, part_nb
from contiga.search.hierarchy.table_cache import TableCache
from contiga.search.hierarchy.table_types import NEIGHBOURHOOD, Tables

# Number of elements below which a second thread does not pay.
MIN_ELEMENTS = 64
# Largest number of quarterings of a part for its bounds, each up to a number of elements.
DEPTHS = ((3, 100), (2, 400), (1, 4000))


def none() -> Records:
    """Return an empty table (0, 16), for a body whose feet are not tracked."""
    return np.zeros((0, part_nb.N_PARTS**2), NEIGHBOURHOOD)


def build_neighbourhoods(tables: Tables) -> Records:
    """Return (elements, 16) `NEIGHBOURHOOD` bounds around the parts of all elements.

    The more elements, the less often parts are quartered for tighter bounds (`DEPTHS`).
    """
    elements = tables.elements
    n = len(elements.table)
    parts = part_nb.N_PARTS**2
    raw = np.empty((n, parts, 6))
    neighbourhoods = np.zeros((n, parts), NEIGHBOURHOOD)
    depth = next((d for d, max_elements in DEPTHS if n <= max_elements), 0)
    run_ranges(neighbourhood_nb.bends_of_parts, n, MIN_ELEMENTS, elements, depth, raw)
    run_ranges(neighbourhood_nb.join_parts, n, MIN_ELEMENTS, elements, raw, neighbourhoods)
    return neighbourhoods


_NEIGHBOURHOODS = TableCache(build_neighbourhoods)


def with_neighbourhoods(tables: Tables) -> Tables:
    """Return the tables of a body with its neighbourhoods, computed at the first call."""
    return tables._replace(neighbourhoods=_NEIGHBOURHOODS.of(tables))
