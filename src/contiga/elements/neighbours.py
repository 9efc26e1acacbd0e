"""Find the element that continues the surface across each side, within a patch or across patches.

Sides match if they have the same end points and the same points between in space. Faces that share
a CAD edge without matching element by element are listed as adjacent patches.
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

# Largest distance of matching sides, as a share of the body's size.
MATCH_TOL = 1e-7
# Length of a side, as a share of the body's size, up to which it is one point.
COLLAPSE_TOL = 1e-9
# Largest angle between the normals at a smooth joint, rad.
SMOOTH_ANGLE = 1e-6
# Distance from a pole, as a share of an element, at which the face is checked against the trims.
POLE_OFFSET = 1e-3


def join(elements: Elements, grid: Grid, body: Faces) -> Grid:
    """Write the sides in `elements.table`; return a copy of `grid` with lists of adjacent patches.

    A joint is SMOOTH if the normals differ by less than `SMOOTH_ANGLE` at all samples, else a
    CREASE; a side without neighbour is a BORDER, or SHARED if the topology has a second face there
    and no gap; a side that is a point is a POLE, without neighbour.
    """
    table = elements.table
    points, normals = sides_nb.sample(elements)  # (n, 4, 5, 3), body axes
    size = body.size
    n = len(table)
    neighbour = np.full((n, 4), -1)
    side = np.zeros((n, 4), int)
    flip = np.zeros((n, 4), int)
    for patch in grid.patches:
        nu, nv = int(np.ptp(patch["u"])) - 1, int(np.ptp(patch["v"])) - 1
        index = int(patch["first"]) + np.arange(nu * nv).reshape(nu, nv)
        for element, across_side, s, side_across in (
            (index[1:], index[:-1], 0, 1),
            (index[:-1], index[1:], 1, 0),
            (index[:, 1:], index[:, :-1], 2, 3),
            (index[:, :-1], index[:, 1:], 3, 2),
        ):
            neighbour[element, s] = across_side
            side[element, s] = side_across
    collapsed = np.ptp(points, axis=2).max(axis=2) <= COLLAPSE_TOL * size
    _match_sides(points, collapsed, neighbour, side, flip, MATCH_TOL * size)

    # Normals on both sides of each joint; rows without a neighbour are not used.
    across_side = normals[neighbour, side]
    across_side = np.where(flip[:, :, None, None] == 1, across_side[:, :, ::-1], across_side)
    sine = np.linalg.norm(np.cross(normals, across_side), axis=3).max(axis=2)
    cosine = (normals * across_side).sum(axis=3).min(axis=2)
    joint = np.where((sine < SMOOTH_ANGLE) & (cosine > 0.0), SMOOTH, CREASE)
    kind = np.where(neighbour >= 0, joint, BORDER)
    kind[collapsed] = POLE
    neighbour[collapsed] = -1
    # Natural sides with a second face in the topology.
    is_shared: dict[tuple[int, int], bool] = {}
    for edge, gapes in zip(body.edges, gaping_edges(body), strict=True):
        for use in edge.uses:
            if use.loop < 0:
                key = (use.patch, use.index)
                is_shared[key] = is_shared.get(key, True) and len(edge.uses) > 1 and not gapes
    for (patch, s), shared in is_shared.items():
        if shared:
            kind[(table["patch"] == patch) & (kind[:, s] == BORDER), s] = SHARED
    table["kind"] = kind
    table["neighbour"] = neighbour
    table["neighbour_side"] = side
    table["flip"] = flip
    table["ring"] = _rings(points[:, :, 0], collapsed, MATCH_TOL * size)
    table["round"] = _smooth_poles(table, normals, body)
    return _with_adjacency(grid, table["patch"], body, neighbour)


def _match_sides(
    points: FloatArray,
    collapsed: np.ndarray,
    neighbour: IntArray,
    side: IntArray,
    flip: IntArray,
    tolerance: float,
) -> None:
    """Write neighbour, side and flip of the open sides of all patches, matched in space.

    Pairs whose points differ by `tolerance` at most are joined from the closest on, seams included;
    of more than two sides in one place the others stay open.
    """
    e, s = np.nonzero((neighbour < 0) & ~collapsed)
    if len(e) < 2:
        return
    curves = points[e, s]  # (m, 5, 3)
    pairs = near_pairs(curves[:, 2], tolerance)
    if len(pairs) == 0:
        return
    a, b = curves[pairs[:, 0]], curves[pairs[:, 1]]
    forward_dist = np.abs(a - b).max(axis=(1, 2))
    reverse_dist = np.abs(a - b[:, ::-1]).max(axis=(1, 2))
    distance = np.minimum(forward_dist, reverse_dist)
    for k in np.argsort(distance, kind="stable"):
        if distance[k] > tolerance:
            break
        i, j = pairs[k]
        if neighbour[e[i], s[i]] >= 0 or neighbour[e[j], s[j]] >= 0:
            continue  # more than two sides in one place: only the closest pair is joined
        for m, n in ((i, j), (j, i)):
            neighbour[e[m], s[m]] = e[n]
            side[e[m], s[m]] = s[n]
            flip[e[m], s[m]] = reverse_dist[k] < forward_dist[k]


def _rings(corner: FloatArray, collapsed: np.ndarray, tolerance: float) -> IntArray:
    """Return for each side (n, 4) the next that collapses to the same pole, as element*4 + side.

    The last one is followed by the first; −1 at sides that are no pole. Poles closer than
    `tolerance` are the same; `corner` (n, 4, 3) is the first point of each side.
    """
    ring = np.full(collapsed.shape, -1)
    e, s = np.nonzero(collapsed)
    if len(e) == 0:
        return ring
    first, second = near_pairs(corner[e, s], tolerance).T
    label = groups_of(first, second, len(e))
    for pole in np.unique(label):
        rows = np.flatnonzero(label == pole)
        next_rows = np.roll(rows, -1)
        ring[e[rows], s[rows]] = 4 * e[next_rows] + s[next_rows]
    return ring


def _smooth_poles(table: Records, normals: FloatArray, body: Faces) -> IntArray:
    """Return 1 for sides (n, 4) at whose pole the surface has a tangent plane, as a sphere; else 0.

    There it has a normal as elsewhere, and a foot at the pole is not at a vertex. All normals at
    the pole agree within `SMOOTH_ANGLE`, and its elements surround it without gap or trim.
    `normals` (n, 4, 5, 3) are the normals along the sides.
    """
    ring = table["ring"]
    is_smooth = np.zeros(ring.shape, int)
    visited = np.zeros(ring.shape, bool)
    for e, side in np.argwhere(ring >= 0).tolist():
        sides_at_pole = []
        while not visited[e, side]:
            visited[e, side] = True
            sides_at_pole.append((e, side))
            e, side = divmod(int(ring[e, side]), 4)
        if sides_at_pole:
            rows, sides = np.array(sides_at_pole).T
            normal = normals[rows, sides].reshape(-1, 3)
            deviation = np.linalg.norm(normal - normal[0], axis=1).max()
            elements = set(rows.tolist())
            is_smooth[rows, sides] = (
                normal[0].any()
                and deviation < SMOOTH_ANGLE
                and all(_surrounds_pole(table, body, elements, e, s) for e, s in sides_at_pole)
            )
    return is_smooth


def _surrounds_pole(table: Records, body: Faces, elements: set[int], e: int, pole: int) -> bool:
    """Return whether element e is not trimmed at its pole and joined to the next ones around it.

    Both sides that start from the pole must lead to `elements` at the pole, and five samples at
    `POLE_OFFSET` from it must be inside the trim.
    """
    first = 2 if pole < 2 else 0
    if not elements.issuperset(table["neighbour"][e, first : first + 2].tolist()):
        return False
    (u0, u1), (v0, v1) = table["box"][e].reshape(2, 2)
    x = np.linspace(0.05, 0.95, 5)
    y = np.full(5, POLE_OFFSET if pole % 2 == 0 else 1.0 - POLE_OFFSET)
    s, t = (y, x) if pole < 2 else (x, y)
    uv = np.column_stack([u0 + s * (u1 - u0), v0 + t * (v1 - v0)])
    return bool(points_in_trim(body.trim_tables, int(table["patch"][e]), uv).all())


def _with_adjacency(grid: Grid, patch_of: IntArray, body: Faces, neighbour: IntArray) -> Grid:
    """Return a copy of `grid` with, for each patch, the list of itself and the patches it touches.

    These are ascending: patches with a joined element, and all at an edge of the topology. A pair
    at an edge is loose unless elements are joined and neither patch is trimmed.
    """
    n = len(body.patches)
    joined: list[set[int]] = [set() for _ in range(n)]
    on_edge: list[set[int]] = [set() for _ in range(n)]
    e, s = np.nonzero(neighbour >= 0)
    pairs = np.stack([patch_of[e], patch_of[neighbour[e, s]]], axis=1)
    for i, j in np.unique(pairs, axis=0).tolist():
        joined[i].add(j)
    for edge in body.edges:
        patches = {use.patch for use in edge.uses}
        for i in patches:
            on_edge[i] |= patches
    adjacent: list[int] = []
    loose: list[int] = []
    table = grid.patches.copy()
    for i in range(n):
        touching = sorted((joined[i] | on_edge[i]) - {i})
        table["adjacent"][i] = len(adjacent), len(adjacent) + 1 + len(touching)
        adjacent += [i, *touching]
        loose.append(0)
        for j in touching:
            is_untrimmed = body.trims[i] is None and body.trims[j] is None
            loose.append(int(j in on_edge[i] and not (j in joined[i] and is_untrimmed)))
    adjacent_array = np.array(adjacent, dtype=np.int32)
    return Grid(table, grid.breaks, adjacent_array, np.array(loose, dtype=np.int8))
