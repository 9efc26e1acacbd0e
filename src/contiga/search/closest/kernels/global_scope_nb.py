"""Restrict a search to all of a body, one patch, or minima that face a guard."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import BORDER, SMOOTH
from contiga.arrays.kernels.vector_nb import cross, dot
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inlined, inner
from contiga.search.closest.kernels.around_nb import collapsed_side, vertex_exit

HEIGHT_TOL = 1e-9
"""Largest height of a point behind a face over its tangent plane, as a share of its distance:
rounding."""
NORMAL_TOL = 1e-3
"""Sine of the largest angle between the normal and the direction to the point at a minimum: half
of the digits of a minimum are known, and beside a pole fewer."""
BORDER_TOL = 1e-7
"""Largest height behind the face at a border, as a share of the distance: rounding."""
NO_GUARD = -2.0
"""Minimum cosine that every two directions exceed."""


class Scope(NamedTuple):
    """The part of a body in which a search looks for its minimum."""

    patch: int
    """−1 for all patches."""
    guard: tuple[float, float, float]
    """Unit vector."""
    min_cosine: float
    """Smallest product of the guard with the normal at a minimum, which has the point behind it;
    `NO_GUARD` for minima of any direction."""
    min_distance: float
    """Smallest distance of a minimum if there is a guard, length."""


class SearchLimits(NamedTuple):
    """The state and limits of a search when it comes to a leaf."""

    best: float
    """Smallest distance so far, length."""
    slack: float
    """Smallest gain in distance that is searched for, length."""
    opened: int
    """Number of cells opened in leaves before this one."""
    scope: Scope


@inlined()
def all_patches():
    """Return the scope of a whole body."""
    return Scope(-1, (0.0, 0.0, 0.0), NO_GUARD, 0.0)


@inlined()
def on_patch(patch):
    """Return the scope of one patch, an integer of any width.

    It is converted to one width: each would compile a version of the search.
    """
    return Scope(np.int64(patch), (0.0, 0.0, 0.0), NO_GUARD, 0.0)


@inner()
def curve_faces_away(leaf, plate, point, scope):
    """Return whether the face along a curve leaf is proved to have no minimum for the guard.

    It has none if it faces away from the guard, or has the point before it, everywhere: the proof
    uses its normal in the middle and the bound of its rotation. False if the proof fails.
    """
    middle, bound, tangent = plate["middle"], leaf["bound"], plate["x"]
    if not bound[8] < 1.0 or plate["metric"][0] == 0.0:
        return False
    sine, scale = bound[8], (-1.0 if bound[7] < 0.0 else 1.0) / math.sqrt(plate["metric"][0])
    n = cross((tangent[0], tangent[1], tangent[2]), (bound[3], bound[4], bound[5]))
    if is_turned_away(scale * dot(n, scope.guard), sine, scope.min_cosine):
        return True
    offset = point[0] - middle[0], point[1] - middle[1], point[2] - middle[2]
    max_distance = math.sqrt(dot(offset, offset)) + plate["radius"]
    margin = plate["departure"] + (math.sqrt(2.0) * sine + HEIGHT_TOL) * max_distance
    return scale * dot(n, offset) > margin


@inlined()
def is_turned_away(cosine, sine, min_cosine):
    """Return whether all normals within an angle from a middle one are turned away from the guard.

    Their products with the guard are then below `min_cosine`. `cosine` is the product of the middle
    normal with the guard, `sine` the sine of the angle.
    """
    cos_angle = math.sqrt(1.0 - sine * sine)
    largest = cosine * cos_angle + math.sqrt(max(1.0 - cosine * cosine, 0.0)) * sine
    return cosine < cos_angle and largest < min_cosine


@inner()
def faces_guard(elements, place, point, scope, h):
    """Return whether a place faces the guard, and the point's distance and height over it, lengths.

    It does if neither the normal nor the direction from the point to the place, which is the normal
    at a kink, turns away from the guard, and the point is behind the face and at least
    `min_distance` away. The height is that over the tangent plane. Writes the derivatives at the
    place to `h`.
    """
    e, s, t = place
    normal = normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    height = square = cosine = advance = 0.0
    for c in range(3):
        r = point[c] - origin[c] - h[c, 0]
        square += r * r
        height += r * normal[c]
        cosine += normal[c] * scope.guard[c]
        advance -= r * scope.guard[c]
    distance = math.sqrt(square)
    faces = cosine >= scope.min_cosine and advance >= scope.min_cosine * distance
    faces = faces and height <= HEIGHT_TOL * distance and distance >= scope.min_distance
    return faces, distance, height


@inner(linked=False)
def is_admissible(elements, place, point, scope, h):
    """Return whether a place (element, s, t) is a minimum of the distance that the scope admits.

    On a side with a kink the direction to the point need not be normal to the face, but no nearby
    place of the same face may be closer; at a pole, no place around it. On a border, the point must
    be straight above or below it (`is_above_border`).
    """
    e, s, t = place
    faces, distance, height = faces_guard(elements, place, point, scope, h)
    if not faces:
        return False
    if collapsed_side(elements, e, s, t) >= 0:
        return vertex_exit(elements, place, point, NORMAL_TOL * distance, h)[0] < 0
    kind, origin = elements.table[e]["kind"], elements.table[e]["origin"]
    for side, offset in ((0, -s), (1, s), (2, -t), (3, t)):
        if offset >= 0.5 and kind[side] == BORDER:
            return is_above_border(distance, height)
    f_s = f_t = square_s = square_t = 0.0
    for c in range(3):
        r = origin[c] + h[c, 0] - point[c]
        f_s += r * h[c, 1]
        f_t += r * h[c, 2]
        square_s += h[c, 1] * h[c, 1]
        square_t += h[c, 2] * h[c, 2]
    tol_s = NORMAL_TOL * distance * math.sqrt(square_s)
    tol_t = NORMAL_TOL * distance * math.sqrt(square_t)
    pressed_s = s <= -0.5 and kind[0] != SMOOTH and f_s >= -tol_s
    pressed_s = pressed_s or (s >= 0.5 and kind[1] != SMOOTH and f_s <= tol_s)
    pressed_t = t <= -0.5 and kind[2] != SMOOTH and f_t >= -tol_t
    pressed_t = pressed_t or (t >= 0.5 and kind[3] != SMOOTH and f_t <= tol_t)
    if pressed_s or pressed_t:
        return (pressed_s or abs(f_s) <= tol_s) and (pressed_t or abs(f_t) <= tol_t)
    return distance * distance - height * height <= NORMAL_TOL * NORMAL_TOL * distance * distance


@inner()
def is_above_border(distance, height):
    """Return whether a point with this distance and height is straight above or below a border."""
    return distance * distance - height * height <= BORDER_TOL * BORDER_TOL * distance * distance
