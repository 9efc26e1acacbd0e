"""What the certificate of tracked feet keeps of a body: what is proved stands in `branch_nb`."""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Elements, Records
from contiga.search.certify.kernels import neighbourhood_nb, part_nb
from contiga.search.hierarchy.table_types import NEIGHBOURHOOD

# Elements below which a second thread does not pay.
ELEMENTS = 64
# How often a part is quartered for its bounds, and elements up to which that is worth its time.
QUARTERED = ((3, 100), (2, 400), (1, 4000))


def none() -> Records:
    """(0, 16) in the tables of a body whose feet are not tracked."""
    return np.zeros((0, part_nb.PARTS**2), NEIGHBOURHOOD)


def build_neighbourhoods(elements: Elements) -> Records:
    """(elements, 16) bounds around the parts of all elements."""
    n = len(elements.table)
    parts = part_nb.PARTS**2
    raw = np.empty((n, parts, 6))
    neighbourhoods = np.zeros((n, parts), NEIGHBOURHOOD)
    depth = next((d for d, most in QUARTERED if n <= most), 0)
    run_ranges(neighbourhood_nb.bends_of_parts, n, ELEMENTS, elements, depth, raw)
    run_ranges(neighbourhood_nb.join_parts, n, ELEMENTS, elements, raw, neighbourhoods)
    return neighbourhoods
