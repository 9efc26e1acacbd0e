"""Parts of elements, sixteen each, and what the record of a neighbourhood takes over of one."""

from __future__ import annotations

from contiga.arrays.codes import IN
from contiga.jit import inner
from contiga.search.certify.kernels.bend_nb import INNER, OUTER, SPEED_S, SPEED_T, WIDTH_S, WIDTH_T

PARTS = 4
"""Of an element in each direction."""


@inner(error_model="numpy")
def part_of(s, t):
    """The part of its element that holds (s, t); the first where that is not a number."""
    x, y = (s + 0.5) * PARTS, (t + 0.5) * PARTS
    # Kept within as numbers: of whole ones it takes a branch, which is as random as the points.
    x = x if x > 0.0 else 0.0
    y = y if y > 0.0 else 0.0
    x = x if x < PARTS - 1.0 else PARTS - 1.0
    y = y if y < PARTS - 1.0 else PARTS - 1.0
    return int(x) * PARTS + int(y)


@inner(error_model="numpy")
def adjoins(elements, e, n, side):
    """Return whether n goes on where e ends at `side`, in the parameters of the same patch."""
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
def is_whole(elements, e, n):
    """Return whether nothing is trimmed away from element n that the patch of e does not tell."""
    element, other = elements.table[e], elements.table[n]
    return element["patch"] == other["patch"] or other["trim"] == IN


@inner(error_model="numpy")
def scales(elements, e, n):
    """Ratios of the parameter ranges of element e to those of n, of the same patch, in u and v."""
    a = elements.table[e]["box"]
    b = elements.table[n]["box"]
    return (a[1] - a[0]) / (b[1] - b[0]), (a[3] - a[2]) / (b[3] - b[2])


@inner(error_model="numpy")
def take_curvature(neighbourhood, bend):
    """Take over the curvatures that bound a part."""
    neighbourhood["curvature"][0] = max(neighbourhood["curvature"][0], bend[INNER])
    neighbourhood["curvature"][1] = max(neighbourhood["curvature"][1], bend[OUTER])


@inner(error_model="numpy")
def take_metric(neighbourhood, bend, scale_s, scale_t):
    """Take over speeds and widths, measured in parameters `scale` times as long as e's own."""
    neighbourhood["speed"][0] = max(neighbourhood["speed"][0], bend[SPEED_S] * scale_s)
    neighbourhood["speed"][1] = max(neighbourhood["speed"][1], bend[SPEED_T] * scale_t)
    neighbourhood["width"][0] = min(neighbourhood["width"][0], bend[WIDTH_S] * scale_s)
    neighbourhood["width"][1] = min(neighbourhood["width"][1], bend[WIDTH_T] * scale_t)
