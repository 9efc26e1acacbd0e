"""Slopes across edges of shells: springs between normals, and their stiffness.

Between two elements with the normals a and b and the unit tangent t of the edge, the angle φ has
cos φ = a·b and sin φ = t·(a × b); the stored energy is k (1 − cos(φ − φ₀)), the penalty of Herrema
et al. (CMAME 346, 2019). At a plane of symmetry it is k (a·n − A·n)²/2.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner, kernel
from contiga.jit.scratch import scratch

MAX_CONTROL_POINTS = 24
"""Control points in two rows of two elements of degree 5."""
NET = 3 * MAX_CONTROL_POINTS


@inlined()
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined()
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined()
def _sum(net, row, count):
    """Return the sum of control points times a row of a basis."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(count):
        x += row[k] * net[3 * k]
        y += row[k] * net[3 * k + 1]
        z += row[k] * net[3 * k + 2]
    return x, y, z


@inlined()
def _unit(a):
    """Return a direction, and 1/length; zeros for a vector without length."""
    length = math.sqrt(_dot(a, a))
    inverse = 1.0 / length if length > 0.0 else 0.0
    return (a[0] * inverse, a[1] * inverse, a[2] * inverse), inverse


@inlined()
def _across(g, a, inverse):
    """Return (g − (g·a) a)/length for a direction a of a vector of length 1/inverse."""
    product = _dot(g, a)
    return (
        inverse * (g[0] - product * a[0]),
        inverse * (g[1] - product * a[1]),
        inverse * (g[2] - product * a[2]),
    )


@inner()
def _pull(rows, first, count, g, sides, force):
    """Add the forces on control points of g = ∂W/∂(S_u × S_v) of a side with `sides` (S_u, S_v)."""
    along_u, along_v = _cross(sides[1], g), _cross(g, sides[0])
    for k in range(count):
        u, v = rows[first, k], rows[first + 1, k]
        for i in range(3):
            force[3 * k + i] -= u * along_u[i] + v * along_v[i]


@inner(linked=False)
def slope_point(net, tables, n, force):
    """Return the energy of point n, and write the forces on its control points `net` (3 k).

    It is a spring to a plane if that has a normal, else one between two sides.
    """
    count = tables.nodes.shape[1]
    rows, stiffness = tables.basis[n], tables.stiffness[n]
    c, s = tables.rest[n, 0], tables.rest[n, 1]
    plane = tables.plane[n, 0], tables.plane[n, 1], tables.plane[n, 2]
    for k in range(3 * count):
        force[k] = 0.0
    first = _sum(net, rows[0], count), _sum(net, rows[1], count)
    a, a_inverse = _unit(_cross(first[0], first[1]))
    if _dot(plane, plane) > 0.0:
        deviation = _dot(a, plane) - c
        pull = stiffness * deviation
        g = pull * plane[0], pull * plane[1], pull * plane[2]
        _pull(rows, 0, count, _across(g, a, a_inverse), first, force)
        return 0.5 * pull * deviation
    second = _sum(net, rows[2], count), _sum(net, rows[3], count)
    b, b_inverse = _unit(_cross(second[0], second[1]))
    t, t_inverse = _unit(_sum(net, rows[4], count))
    bt, ta, ab = _cross(b, t), _cross(t, a), _cross(a, b)
    c, s = stiffness * c, stiffness * s
    g = -c * b[0] - s * bt[0], -c * b[1] - s * bt[1], -c * b[2] - s * bt[2]
    _pull(rows, 0, count, _across(g, a, a_inverse), first, force)
    g = -c * a[0] - s * ta[0], -c * a[1] - s * ta[1], -c * a[2] - s * ta[2]
    _pull(rows, 2, count, _across(g, b, b_inverse), second, force)
    g = _across((-s * ab[0], -s * ab[1], -s * ab[2]), t, t_inverse)
    for k in range(count):
        for i in range(3):
            force[3 * k + i] -= rows[4, k] * g[i]
    return stiffness - c * _dot(a, b) - s * _dot(t, ab)


@inner()
def _gather(points, nodes, net):
    """Copy control points into `net` (3 k)."""
    for k in range(len(nodes)):
        for i in range(3):
            net[3 * k + i] = points[nodes[k], i]


@kernel()
def slopes(points, tables, out, start, stop):
    """Write forces and energies of points start … stop into `out.partial` and `out.energy`."""
    net, force = scratch(NET), scratch(NET)
    count = tables.nodes.shape[1]
    for n in range(start, stop):
        _gather(points, tables.nodes[n], net)
        out.energy[n] = slope_point(net, tables, n, force)
        for k in range(count):
            for i in range(3):
                out.partial[n * count + k, i] = force[3 * k + i]


@kernel()
def slope_stiffness(points, tables, stiffness, start, stop):
    """Write K (3 k, 3 k) of points start … stop, by central differences of their forces."""
    net, before, after = scratch(NET), scratch(NET), scratch(NET)
    count = 3 * tables.nodes.shape[1]
    for n in range(start, stop):
        _gather(points, tables.nodes[n], net)
        step = tables.nudge[n]
        for column in range(count):
            at = net[column]
            net[column] = at - step
            slope_point(net, tables, n, before)
            net[column] = at + step
            slope_point(net, tables, n, after)
            net[column] = at
            for row in range(count):
                stiffness[n, row, column] = (before[row] - after[row]) / (2.0 * step)
