"""Parts of elements, sixteen each, and the contribution of a part to a neighbourhood."""

from __future__ import annotations

from contiga.arrays.codes import IN
from contiga.jit import inner
from contiga.search.certify.kernels.bend_nb import INNER, OUTER, SPEED_S, SPEED_T, WIDTH_S, WIDTH_T

N_PARTS = 4
"""Number of parts of an element in each direction."""


@inner(error_model="numpy")
def part_of(s, t):
    """Return the index `N_PARTS` i + j of the part of its element that contains (s, t).

    Places outside the element count as on its sides; for NaN the index in that direction is 0.
    """
    x, y = (s + 0.5) * N_PARTS, (t + 0.5) * N_PARTS
    # Clamped as floats: with integers it takes a branch, which is as random as the points.
    x = x if x > 0.0 else 0.0
    y = y if y > 0.0 else 0.0
    x = x if x < N_PARTS - 1.0 else N_PARTS - 1.0
    y = y if y < N_PARTS - 1.0 else N_PARTS - 1.0
    return int(x) * N_PARTS + int(y)


@inner(error_model="numpy")
def adjoins(elements, e, n, side):
    """Return whether n continues e across `side` in the parameters of the same patch.

    It does not across a seam, nor unless both have exactly the same range along the side.
    """
    element = elements.table[e]
    other = elements.table[n]
    if element["patch"] != other["patch"] or element["box"][side] != other["box"][side ^ 1]:
        return False
    along = 2 if side < 2 else 0
    return (
        element["box"][along] == other["box"][along]
        and element["box"][along + 1] == other["box"][along + 1]
    )


@inner(error_model="numpy")
def is_untrimmed_beyond(elements, e, n):
    """Return whether element n is untrimmed, or of the patch of e, whose trims are tested later."""
    element, other = elements.table[e], elements.table[n]
    return element["patch"] == other["patch"] or other["trim"] == IN


@inner(error_model="numpy")
def scales(elements, e, n):
    """Return the ratios of the ranges in u and v of element e to the ranges of n, of its patch."""
    a = elements.table[e]["box"]
    b = elements.table[n]["box"]
    return (a[1] - a[0]) / (b[1] - b[0]), (a[3] - a[2]) / (b[3] - b[2])


@inner(error_model="numpy")
def add_curvature(neighbourhood, bend):
    """Extend the curvatures of a neighbourhood by the bounds of a part."""
    neighbourhood["curvature"][0] = max(neighbourhood["curvature"][0], bend[INNER])
    neighbourhood["curvature"][1] = max(neighbourhood["curvature"][1], bend[OUTER])


@inner(error_model="numpy")
def add_metric(neighbourhood, bend, scale_s, scale_t):
    """Extend speeds and widths of a neighbourhood by the bounds of a part.

    `scale_s` and `scale_t` convert these to the parameters of the neighbourhood's element
    (`scales`).
    """
    neighbourhood["speed"][0] = max(neighbourhood["speed"][0], bend[SPEED_S] * scale_s)
    neighbourhood["speed"][1] = max(neighbourhood["speed"][1], bend[SPEED_T] * scale_t)
    neighbourhood["width"][0] = min(neighbourhood["width"][0], bend[WIDTH_S] * scale_s)
    neighbourhood["width"][1] = min(neighbourhood["width"][1], bend[WIDTH_T] * scale_t)
