"""Find the element that continues the surface across each side, in a patch or beyond it.

Sides are matched by what they are in space: the same end points and the same points between.
Faces that share a CAD edge without lining up element by element are listed as adjacent patches.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import BORDER, CREASE, POLE, SHARED, SMOOTH
from contiga.arrays.groups import groups_of
from contiga.arrays.near_pairs import near_pairs
from contiga.elements.element_arrays import Elements, Grid, Records
from contiga.elements.kernels import sides_nb
from contiga.geometry.faces import Faces
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.slits import gaping_edges
from contiga.records import FloatArray, IntArray

# Sides closer than this share of the body's size are one side.
MATCH = 1e-7
# Sides shorter than this share of the body's size are one point.
COLLAPSED = 1e-9
# Normals that differ by less than this (radians) make a smooth joint.
SMOOTH_ANGLE = 1e-6
# How far from a pole, as a share of an element, it is asked whether trims leave the face there.
BESIDE_POLE = 1e-3


def join(elements: Elements, grid: Grid, body: Faces) -> Grid:
    """Fill in the sides of `elements`; returns `grid` with the list of touching patches."""
    table = elements.table
    points, normals = sides_nb.sample(elements)  # (n, 4, 5, 3), body axes
    size = body.size
    n = len(table)
    kind = np.full((n, 4), BORDER)
    neighbour = np.full((n, 4), -1)
    side = np.zeros((n, 4), int)
    flip = np.zeros((n, 4), int)
    collapsed = np.ptp(points, axis=2).max(axis=2) <= COLLAPSED * size
    _within_patches(grid, neighbour, side)
    _across(points, collapsed, neighbour, side, flip, MATCH * size)
    linked = neighbour >= 0
    kind[linked] = _joint(normals, neighbour, side, flip)[linked]
    kind[collapsed] = POLE
    neighbour[collapsed] = -1
    _mark_shared(table["patch"], body, kind)
    table["kind"] = kind
    table["neighbour"] = neighbour
    table["neighbour_side"] = side
    table["flip"] = flip
    table["ring"] = _rings(points[:, :, 0], collapsed, MATCH * size)
    table["round"] = _round(table, normals, body)
    return _with_adjacency(grid, table["patch"], body, neighbour)


def _within_patches(grid: Grid, neighbour: IntArray, side: IntArray) -> None:
    for row in grid.patches:
        nu, nv = int(np.ptp(row["u"])) - 1, int(np.ptp(row["v"])) - 1
        index = int(row["first"]) + np.arange(nu * nv).reshape(nu, nv)
        for here, other, a, b in (
            (index[1:], index[:-1], 0, 1),
            (index[:-1], index[1:], 1, 0),
            (index[:, 1:], index[:, :-1], 2, 3),
            (index[:, :-1], index[:, 1:], 3, 2),
        ):
            neighbour[here, a] = other
            side[here, a] = b


def _across(
    points: FloatArray,
    collapsed: np.ndarray,
    neighbour: IntArray,
    side: IntArray,
    flip: IntArray,
    tolerance: float,
) -> None:
    """Match the open sides of all patches (seams included) by their points in space."""
    e, s = np.nonzero((neighbour < 0) & ~collapsed)
    if len(e) < 2:
        return
    curves = points[e, s]  # (m, 5, 3)
    pairs = near_pairs(curves[:, 2], tolerance)
    if len(pairs) == 0:
        return
    a, b = curves[pairs[:, 0]], curves[pairs[:, 1]]
    same = np.abs(a - b).max(axis=(1, 2))
    turned = np.abs(a - b[:, ::-1]).max(axis=(1, 2))
    off = np.minimum(same, turned)
    for k in np.argsort(off, kind="stable"):
        if off[k] > tolerance:
            break
        i, j = pairs[k]
        if neighbour[e[i], s[i]] >= 0 or neighbour[e[j], s[j]] >= 0:
            continue  # more than two sides in one place: only the closest pair is joined
        for here, other in ((i, j), (j, i)):
            neighbour[e[here], s[here]] = e[other]
            side[e[here], s[here]] = s[other]
            flip[e[here], s[here]] = turned[k] < same[k]


def _joint(normals: FloatArray, neighbour: IntArray, side: IntArray, flip: IntArray) -> np.ndarray:
    """SMOOTH or CREASE of every side that has a neighbour."""
    other = normals[neighbour, side]  # rows without a neighbour read nonsense and are not used
    other = np.where(flip[:, :, None, None] == 1, other[:, :, ::-1], other)
    sine = np.linalg.norm(np.cross(normals, other), axis=3).max(axis=2)
    cosine = (normals * other).sum(axis=3).min(axis=2)
    return np.where((sine < SMOOTH_ANGLE) & (cosine > 0.0), SMOOTH, CREASE)


def _rings(corner: FloatArray, collapsed: np.ndarray, tolerance: float) -> IntArray:
    """Return (n, 4) the next of the sides (element*4 + side) that collapse to the same point."""
    ring = np.full(collapsed.shape, -1)
    e, s = np.nonzero(collapsed)
    if len(e) == 0:
        return ring
    first, second = near_pairs(corner[e, s], tolerance).T
    label = groups_of(first, second, len(e))
    for pole in np.unique(label):
        elements = np.flatnonzero(label == pole)
        after = np.roll(elements, -1)
        ring[e[elements], s[elements]] = 4 * e[after] + s[after]
    return ring


def _round(table: Records, normals: FloatArray, body: Faces) -> IntArray:
    """Return 1 (n, 4) for sides at whose pole the surface has one tangent plane, as a sphere has.

    There it has a normal as anywhere else, and a foot is none at a vertex. `normals` (n, 4, 5, 3)
    are those along the sides.
    """
    ring = table["ring"]
    found = np.zeros(ring.shape, int)
    seen = np.zeros(ring.shape, bool)
    for e, side in np.argwhere(ring >= 0).tolist():
        around = []
        while not seen[e, side]:
            seen[e, side] = True
            around.append((e, side))
            e, side = divmod(int(ring[e, side]), 4)
        if around:
            rows, sides = np.array(around).T
            here = normals[rows, sides].reshape(-1, 3)
            off = np.linalg.norm(here - here[0], axis=1).max()
            flat = here[0].any() and off < SMOOTH_ANGLE
            whole = set(rows.tolist())
            found[rows, sides] = flat and all(_goes_on(table, body, whole, *at) for at in around)
    return found


def _goes_on(table: Records, body: Faces, around: set[int], e: int, pole: int) -> bool:
    """Whether the face is there beside the pole and joined to its neighbours around it.

    Both sides that start from the pole must lead to other faces of those `around` it.
    """
    along = 2 if pole < 2 else 0
    if not around.issuperset(table["neighbour"][e, along : along + 2].tolist()):
        return False
    (u0, u1), (v0, v1) = table["box"][e].reshape(2, 2)
    share, off = (
        np.linspace(0.05, 0.95, 5),
        np.full(5, BESIDE_POLE if pole % 2 == 0 else 1.0 - BESIDE_POLE),
    )
    s, t = (off, share) if pole < 2 else (share, off)
    places = np.column_stack([u0 + s * (u1 - u0), v0 + t * (v1 - v0)])
    return bool(points_in_trim(body.trim_tables, int(table["patch"][e]), places).all())


def _mark_shared(patch_of: IntArray, body: Faces, kind: IntArray) -> None:
    """Natural sides on which the topology knows a second face: SHARED instead of BORDER."""
    shared: dict[tuple[int, int], bool] = {}
    for edge, gapes in zip(body.edges, gaping_edges(body), strict=True):
        for use in edge.uses:
            if use.loop < 0:
                key = (use.patch, use.index)
                shared[key] = shared.get(key, True) and len(edge.uses) > 1 and not gapes
    for (patch, side), both in shared.items():
        inside = patch_of == patch
        if both:
            kind[inside, side] = np.where(kind[inside, side] == BORDER, SHARED, kind[inside, side])


def _with_adjacency(grid: Grid, patch_of: IntArray, body: Faces, neighbour: IntArray) -> Grid:
    """`grid` with, for each patch, itself and then the patches it touches."""
    n = len(body.patches)
    linked: list[set[int]] = [set() for _ in range(n)]
    touching: list[set[int]] = [set() for _ in range(n)]
    e, s = np.nonzero(neighbour >= 0)
    pairs = np.stack([patch_of[e], patch_of[neighbour[e, s]]], axis=1)
    for i, j in np.unique(pairs, axis=0).tolist():
        linked[i].add(j)
    for edge in body.edges:
        patches = {use.patch for use in edge.uses}
        for i in patches:
            touching[i] |= patches
    adjacent: list[int] = []
    loose: list[int] = []
    patches_table = grid.patches.copy()
    for i in range(n):
        others = sorted((linked[i] | touching[i]) - {i})
        patches_table["adjacent"][i] = len(adjacent), len(adjacent) + 1 + len(others)
        adjacent += [i, *others]
        loose.append(0)
        for j in others:
            whole = body.trims[i] is None and body.trims[j] is None
            loose.append(int(j in touching[i] and not (j in linked[i] and whole)))
    return Grid(
        patches_table,
        grid.breaks,
        np.array(adjacent, dtype=np.int32),
        np.array(loose, dtype=np.int8),
    )
