"""Elements as parts of trimmed faces, and their poles."""

from __future__ import annotations

from contiga.arrays.codes import CUT, IN, POLE
from contiga.elements.kernels.element_nb import parameters
from contiga.geometry.kernels.trim_nb import point_in_trim
from contiga.jit import inner


@inner()
def in_face(elements, trims, e, s, t):
    """Return whether (s, t) of element e belongs to the trimmed face."""
    state = elements.table[e]["trim"]
    if state == CUT:
        u, v = parameters(elements, e, s, t)
        return point_in_trim(trims, elements.table[e]["patch"], u, v) != 0
    return state == IN


@inner()
def has_pole(elements, e):
    """Return whether a side of element e is one point."""
    kind = elements.table[e]["kind"]
    return kind[0] == POLE or kind[1] == POLE or kind[2] == POLE or kind[3] == POLE
