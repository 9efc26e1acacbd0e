"""Crossing of a cell that is a point, or flat along the path, by the ends of the path."""

from __future__ import annotations

import math

from contiga.arrays.kernels.vector_nb import column, dot, minus
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner


@inner(error_model="numpy")
def _passage(box, line, pad):
    """Return the range of x (low, high) in which a line is over a rectangle; low > high for none.

    The rectangle is `box` (s0, s1, t0, t1) widened by `pad` (2,). `line` (4,) is (s, t) at x = 0
    and their derivatives with respect to x.
    """
    low, high = -math.inf, math.inf
    for c in range(2):
        start, rate = line[c], line[2 + c]
        box_low, box_high = box[2 * c] - pad[c], box[2 * c + 1] + pad[c]
        if rate == 0.0:
            if start < box_low or start > box_high:
                return math.inf, -math.inf
        else:
            x_low = (box_low - start) / rate
            x_high = (box_high - start) / rate
            low = max(low, min(x_low, x_high))
            high = min(high, max(x_low, x_high))
    return low, high


@inner(error_model="numpy")
def over_plane(h, r, d):
    """Project the line r + x d onto the tangent plane, in (s, t) from the place of `h`.

    Returns whether there is a plane; the line as (s, t, ds/dx, dt/dx) at x = 0; and the largest
    changes of s and t per length of a displacement. Without a plane the numbers are zeros.
    """
    a = column(h, 1)
    b = column(h, 2)
    aa, ab, bb = dot(a, a), dot(a, b), dot(b, b)
    ra, rb = dot(r, a), dot(r, b)
    da, db = dot(d, a), dot(d, b)
    det = aa * bb - ab * ab
    if not det > 1e-12 * aa * bb:
        return False, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0)
    line = (
        (bb * ra - ab * rb) / det,
        (aa * rb - ab * ra) / det,
        (bb * da - ab * db) / det,
        (aa * db - ab * da) / det,
    )
    return True, line, (math.sqrt(bb / det), math.sqrt(aa / det))


@inner(linked=False, error_model="numpy")
def touch(elements, e, cell, path, length, h):
    """Find the crossing of a cell that is a point, or flat along the path.

    A path crosses if its ends are on different sides of the cell's tangent plane, to `slack`, and
    it meets the plane at the cell. Returns x, the length along the path to the crossing; the steps
    in s and t from the middle to the place of the cell nearest to where the path meets the plane;
    and the slope −1, 0 (no crossing, all are zero) or 1.
    Places beyond a side of the element within its room count as in the cell.
    """
    s, t = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3])
    normal = normal_at(elements, e, s, t, h)
    r = minus(path.p, column(h, 0))
    height = dot(r, normal)
    slope = dot(path.d, normal)
    return meet_plane(cell, path, length, h, r, (height, slope))


@inner(error_model="numpy")
def meet_plane(cell, path, length, h, r, heights):
    """Intersect a path with the tangent plane of a cell; return the same as `touch`.

    `r` (3,) is the vector from the cell's middle, whose derivatives are `h`, to the start of the
    path; `heights` are the height of the start above the plane and the change of the height per
    length of the path. If `h` spans no plane, the path crosses where it is nearest to the middle.
    """
    s, t = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3])
    d, slack, room = path.d, path.slack, path.room
    start_height, height_slope = heights
    end_height = start_height + length * height_slope
    if start_height >= -slack and end_height < 0.0 and end_height < start_height:
        slope = -1.0
    elif start_height <= slack and end_height > 0.0 and end_height > start_height:
        slope = 1.0
    else:
        return 0.0, 0.0, 0.0, 0.0
    has_plane, line, per = over_plane(h, r, d)
    if not has_plane:
        return min(max(-dot(r, d), 0.0), length), 0.0, 0.0, slope
    box = (
        cell[0] - s - (room[0] * per[0] if cell[0] <= -0.5 else 0.0),
        cell[1] - s + (room[1] * per[0] if cell[1] >= 0.5 else 0.0),
        cell[2] - t - (room[2] * per[1] if cell[2] <= -0.5 else 0.0),
        cell[3] - t + (room[3] * per[1] if cell[3] >= 0.5 else 0.0),
    )
    low, high = _passage(box, line, (2.0 * slack * per[0], 2.0 * slack * per[1]))
    low, high = max(low, 0.0), min(high, length)
    plane_x = -start_height / height_slope
    x = min(max(plane_x, low), high)
    # Neighbouring cells find where the path meets their planes, to within slack along the normal.
    if low > high or abs(x - plane_x) * abs(height_slope) > 2.0 * slack:
        return 0.0, 0.0, 0.0, 0.0
    ds = min(max(line[0] + x * line[2], box[0]), box[1])
    dt = min(max(line[1] + x * line[3], box[2]), box[3])
    return x, ds, dt, slope
