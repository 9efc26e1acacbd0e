"""Proof that the surface over a triangle stays within a distance of the triangle's plane.

Times the weight, the height over a plane is a polynomial on each element, so it lies in the hull
of its Bernstein coefficients; the rectangle around the triangle in (u, v) is quartered until they
decide, and quarters outside the triangle are dropped.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.kernels.sort_nb import count_below
from contiga.geometry.kernels.chord_nb import copy_piece, cut, restrict
from contiga.jit import inner

MAX_DEPTH = 8
"""Largest number of quarterings of an element's part."""
MIN_WIDTH = 1e-12
"""Parts thinner than this share of an element are skipped: the triangle only touches them."""


class Heights(NamedTuple):
    """A surface as Bézier elements, and memory for one proof."""

    coefs: np.ndarray
    """(nu, nv, p + 1, q + 1, 4) homogeneous, about `middle`."""
    u: np.ndarray
    """(nu + 1,) borders of elements."""
    v: np.ndarray
    """(nv + 1,)."""
    middle: np.ndarray
    """(3,)."""
    stack: np.ndarray
    """(3 MAX_DEPTH + 4, p + 1, q + 1, 2) distance below the limit, upwards and downwards."""
    boxes: np.ndarray
    """(3 MAX_DEPTH + 4, 5) u from and to, v from and to, quarterings."""


@inner()
def plane_of(a, b, c, plane):
    """Write unit normal and offset n · a of plane abc to `plane` (4,); False if abc has no area."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    p, q, r = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    plane[0], plane[1], plane[2] = y * r - z * q, z * p - x * r, x * q - y * p
    size = math.sqrt(plane[0] ** 2 + plane[1] ** 2 + plane[2] ** 2)
    if not size > 0.0:
        return False
    for d in range(3):
        plane[d] /= size
    plane[3] = plane[0] * a[0] + plane[1] * a[1] + plane[2] * a[2]
    return True


@inner()
def is_separated(box, uv):
    """Return whether a side of the triangle uv, anticlockwise, separates it from a rectangle.

    `box` starts with u from and to, v from and to. False is no proof that the two meet: the sides
    of the rectangle are not tried.
    """
    for k in range(3):
        m = (k + 1) % 3
        du, dv = uv[m, 0] - uv[k, 0], uv[m, 1] - uv[k, 1]
        # The corner that is farthest to the left.
        u = box[0] if dv > 0.0 else box[1]
        v = box[3] if du > 0.0 else box[2]
        if du * (v - uv[k, 1]) - dv * (u - uv[k, 0]) < 0.0:
            return True
    return False


@inner()
def is_over(uv, u, v):
    """Return whether (u, v) is in or on the triangle uv, anticlockwise."""
    for k in range(3):
        m = (k + 1) % 3
        du, dv = uv[m, 0] - uv[k, 0], uv[m, 1] - uv[k, 1]
        if du * (v - uv[k, 1]) - dv * (u - uv[k, 0]) < 0.0:
            return False
    return True


@inner()
def margins_of(coefs, plane, limit, net):
    """Write `limit` minus the height over a plane, times the weight, to net[..., 0].

    net[..., 1] gets the same for the height below it.
    """
    for i in range(net.shape[0]):
        for j in range(net.shape[1]):
            x = coefs[i, j]
            w = x[3]
            height = plane[0] * x[0] + plane[1] * x[1] + plane[2] * x[2] - plane[3] * w
            net[i, j, 0] = limit * w - height
            net[i, j, 1] = limit * w + height


@inner()
def is_below(net):
    """Return whether no margin is negative, which proves the limit for the piece of surface."""
    for i in range(net.shape[0]):
        for j in range(net.shape[1]):
            if min(net[i, j, 0], net[i, j, 1]) < 0.0:
                return False
    return True


@inner()
def high_corner(net, box, uv):
    """Return the corner of a rectangle over the triangle with the most negative margin, or −1.

    Corner k is at the end k % 2 of u and k // 2 of v; −1 if no margin there is negative.
    """
    best, lowest = -1, 0.0
    for k in range(4):
        i, j = k % 2, k // 2
        corner_margins = net[i * (net.shape[0] - 1), j * (net.shape[1] - 1)]
        low = min(corner_margins[0], corner_margins[1])
        if low < lowest and is_over(uv, box[i], box[2 + j]):
            best, lowest = k, low
    return best


@inner()
def quarter(h, top):
    """Replace entry `top` of h.stack and h.boxes by its quarters; return the number of entries."""
    box = h.boxes[top].copy()
    u, v = 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])
    for k in range(3, -1, -1):
        part = h.stack[top + k]
        if k > 0:
            copy_piece(h.stack[top], part)
        cut(part, 0, 0.5, k % 2 == 0)
        cut(part, 1, 0.5, k // 2 == 0)
        to = h.boxes[top + k]
        to[0], to[1] = (box[0], u) if k % 2 == 0 else (u, box[1])
        to[2], to[3] = (box[2], v) if k // 2 == 0 else (v, box[3])
        to[4] = box[4] + 1.0
    return top + 4


@inner()
def element_below(h, uv):
    """Return whether entry 0 of the stack is proved within the limit over a triangle, and u, v.

    If not, (u, v) is a corner that misses, or the centre of a part after `MAX_DEPTH` quarterings.
    """
    top = 1
    while top > 0:
        top -= 1
        box, net = h.boxes[top], h.stack[top]
        if is_separated(box, uv) or is_below(net):
            continue
        k = high_corner(net, box, uv)
        if k >= 0:
            return False, box[k % 2], box[2 + k // 2]
        if box[4] >= MAX_DEPTH:
            return False, 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])
        top = quarter(h, top)
    return True, 0.0, 0.0


@inner()
def all_below(h, uv, plane, limit):
    """Return whether the surface over a triangle is proved within `limit` of a plane, and u, v.

    The triangle uv runs anticlockwise. By `element_below` for every element it reaches over, but
    for parts thinner than `MIN_WIDTH`; the first element that fails gives (u, v).
    """
    u0, u1 = min(uv[0, 0], uv[1, 0], uv[2, 0]), max(uv[0, 0], uv[1, 0], uv[2, 0])
    v0, v1 = min(uv[0, 1], uv[1, 1], uv[2, 1]), max(uv[0, 1], uv[1, 1], uv[2, 1])
    net, box = h.stack[0], h.boxes[0]
    for i in range(count_below(h.u[1:-1], u0), h.u.size - 1):
        du = h.u[i + 1] - h.u[i]
        a, b = max((u0 - h.u[i]) / du, 0.0), min((u1 - h.u[i]) / du, 1.0)
        if h.u[i] > u1:
            break
        for j in range(count_below(h.v[1:-1], v0), h.v.size - 1):
            dv = h.v[j + 1] - h.v[j]
            c, d = max((v0 - h.v[j]) / dv, 0.0), min((v1 - h.v[j]) / dv, 1.0)
            if h.v[j] > v1:
                break
            if b - a < MIN_WIDTH or d - c < MIN_WIDTH:
                continue
            box[0], box[1] = h.u[i] + a * du, h.u[i] + b * du
            box[2], box[3] = h.v[j] + c * dv, h.v[j] + d * dv
            box[4] = 0.0
            if is_separated(box, uv):
                continue
            margins_of(h.coefs[i, j], plane, limit, net)
            restrict(net, 0, a, b)
            restrict(net, 1, c, d)
            below, u, v = element_below(h, uv)
            if not below:
                return False, u, v
    return True, 0.0, 0.0
