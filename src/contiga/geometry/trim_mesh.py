"""Triangles of a body with its trims.

A trimmed patch is meshed in (u, v): the loops are flattened to the chord tolerance, the grid of
the untrimmed patch is thinned to what lies inside, and a Delaunay triangulation of both is refined
on the loops until it contains every segment of them. Triangles outside the loops are dropped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contiga.geometry._trim_nb import TrimTables, points_in_trim
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.tessellate import GRIDS, check_request, grid_mesh
from contiga.geometry.trimesh import TriMesh
from contiga.geometry.watertight import joined_faces
from contiga.records import FloatArray, IntArray

if TYPE_CHECKING:
    from contiga.geometry.body import Body

ROUNDS = 12
"""Refinements of the loops until the triangulation follows them."""
REFINEMENTS = 6
"""Rounds of points added where triangles between the loops miss the surface."""
LEVEL = 1e-7
"""Triangles lower than this share of their longest side are borders folded flat."""
FINEST = 256
"""Most segments of one monotone piece."""
APART = 0.3
"""Grid points nearer to a loop than this share of their cell are left out."""


def body_mesh(body: Body, tol: float, method: str = "chord") -> TriMesh:
    """One mesh of all faces of `body`; faces that share an edge share its vertices.

    Parameters
    ----------
    tol : for "chord" a length, from the surface to the triangles. For "net" an area, by patch:
        see `contiga.geometry.tessellate.net_grid`.
    method : "chord" or "net"

    Raises
    ------
    InputError
        `tol` is not positive, an unknown method.
    """
    return joined_faces(body, face_meshes(body, tol, method))


def face_meshes(body: Body, tol: float, method: str = "chord") -> list[tuple[FloatArray, IntArray]]:
    """Per patch its vertices (n, 3) and triangles (m, 3)."""
    check_request(tol, method)
    result = []
    for k, (patch, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        if loops is None:
            mesh = grid_mesh(patch, *GRIDS[method](patch, tol))
            result.append((mesh.vertices, mesh.triangles))
        else:
            result.append(_trimmed(body.trim_tables, k, patch, tol, method))
    return result


def _trimmed(
    tables: TrimTables, k: int, patch: NurbsSurface, tol: float, method: str
) -> tuple[FloatArray, IntArray]:
    pieces = np.arange(tables.patch_start[k], tables.patch_start[k + 1])
    low, high = np.array(patch.domain).T
    ends = tables.piece_ends[pieces]
    box = np.array([np.minimum(ends[:, :2], ends[:, 2:]).min(axis=0)])
    box = np.vstack([box, np.maximum(ends[:, :2], ends[:, 2:]).max(axis=0)])
    box = np.clip(box, low, high)
    if np.any(box[1] <= box[0]):
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int32)
    part = patch.restricted((box[0, 0], box[1, 0]), (box[0, 1], box[1, 1]))
    u, v = GRIDS[method](part, tol)
    # An area over the patch's extent is the length that the loops of a net may miss.
    sag = tol if method == "chord" else tol / max(float(np.sqrt(part.net_area())), 1e-300)
    metric = _metric(part)
    chains = [_flattened(tables, piece, patch, sag) for piece in pieces]
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    grid = grid[points_in_trim(tables, k, np.ascontiguousarray(grid))]
    grid = _apart_from(grid, chains, metric, np.array([np.diff(u).min(), np.diff(v).min()]))
    last = REFINEMENTS if method == "chord" else 0
    for attempt in range(last + 1):
        uv, triangles, region = _conforming(chains, grid, metric)
        middle = np.ascontiguousarray(uv[triangles].mean(axis=1))
        inside = points_in_trim(tables, k, middle)
        triangles = triangles[_of_most(inside, region, uv[triangles])]
        points = patch.evaluate(np.clip(uv, low, high))
        if attempt == last:
            break
        missed = _missed(patch, uv, points, triangles, tol)
        if not len(missed):
            break
        grid = np.unique(np.concatenate([grid, missed]), axis=0)
    return points, triangles


def _of_most(inside: np.ndarray, region: IntArray, corners: FloatArray) -> np.ndarray:
    """(m,) bool: whether most of the area of a triangle's region is inside.

    Between a loop and its chords the middle of a triangle says nothing.
    """
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    size = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    share = np.bincount(region, np.where(inside, size, -size))
    return np.asarray(share[region] > 0.0)


def _missed(
    patch: NurbsSurface, uv: FloatArray, points: FloatArray, triangles: IntArray, tol: float
) -> FloatArray:
    """(u, v) of inner sides' middles and of centres where the surface is off by more than `tol`.

    Sides that belong to one triangle only are on the loops, which are flattened to `tol` already.
    """
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    sides, times = np.unique(sides, axis=0, return_counts=True)
    sides = sides[times == 2]
    a, b = points[sides[:, 0]], points[sides[:, 1]]
    halves = uv[sides].mean(axis=1)
    miss = patch.evaluate(halves) - 0.5 * (a + b)
    along = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1, keepdims=True), 1e-300)
    off = np.linalg.norm(miss - np.einsum("ij,ij->i", miss, along)[:, None] * along, axis=1)
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    centres = uv[triangles].mean(axis=1)
    rise = np.abs(np.einsum("ij,ij->i", patch.evaluate(centres) - corners.mean(axis=1), normal))
    return np.concatenate([halves[off > tol], centres[rise > tol]])


def _metric(patch: NurbsSurface) -> FloatArray:
    """(2,) mean |S_u| and |S_v|: turns (u, v) into something nearly isometric."""
    (u0, u1), (v0, v1) = patch.domain
    share = np.linspace(0.05, 0.95, 7)
    uv = np.stack(np.meshgrid(u0 + share * (u1 - u0), v0 + share * (v1 - v0)), -1).reshape(-1, 2)
    first = patch.derivatives(uv, 1)
    lengths = np.linalg.norm(np.stack([first[:, 1, 0], first[:, 0, 1]], axis=1), axis=2)
    return np.maximum(lengths.mean(axis=0), 1e-9 * lengths.max())


def _piece_points(tables: TrimTables, piece: int, t: FloatArray) -> FloatArray:
    """(n, 2) of a piece at t in [0, 1], its ends closed up with its neighbours'."""
    degree = int(tables.piece_degree[piece])
    a = np.repeat(tables.piece_coefs[piece, None, : degree + 1], len(t), axis=0)
    x = t[:, None, None]
    for _ in range(degree):
        a = (1.0 - x) * a[:, :-1] + x * a[:, 1:]
    points = a[:, 0, :2] / a[:, 0, 2:]
    points[t == 0.0] = tables.piece_ends[piece, :2]
    points[t == 1.0] = tables.piece_ends[piece, 2:]
    d = tables.domain[tables.piece_patch[piece]]
    return np.clip(points, d[[0, 2]], d[[1, 3]])


def _flattened(tables: TrimTables, piece: int, patch: NurbsSurface, tol: float) -> FloatArray:
    """(n, 2) points along a piece whose chords in space miss the curve by less than `tol`."""
    n = 1
    while True:
        t = np.linspace(0.0, 1.0, 4 * n + 1)
        points = _piece_points(tables, piece, t)
        space = patch.evaluate(points)
        chord = space[::4][:-1]
        step = space[4::4] - chord
        worst = 0.0
        for k, share in ((1, 0.25), (2, 0.5), (3, 0.75)):
            miss = space[k::4] - (chord + share * step)
            along = np.einsum("ij,ij->i", miss, step) / np.maximum((step**2).sum(axis=1), 1e-300)
            worst = max(worst, float(np.linalg.norm(miss - along[:, None] * step, axis=1).max()))
        if worst <= tol or n >= FINEST:
            return points[::4]
        n *= 2


def _apart_from(
    grid: FloatArray, chains: list[FloatArray], metric: FloatArray, cell: FloatArray
) -> FloatArray:
    """Grid points that are not about to make slivers against the loops."""
    from scipy.spatial import cKDTree

    if not len(grid):
        return grid
    near = APART * float((cell * metric).min())
    dense = []
    for chain in chains:
        steps = np.maximum(
            np.ceil(np.linalg.norm(np.diff(chain, axis=0) * metric, axis=1) / near), 1
        )
        steps = np.minimum(steps, 4096).astype(int)
        for a, b, n in zip(chain[:-1], chain[1:], steps, strict=True):
            dense.append(a + np.linspace(0.0, 1.0, n + 1)[:, None] * (b - a))
    distance = cKDTree(np.concatenate(dense) * metric).query(grid * metric)[0]
    return grid[distance > near]


def _conforming(
    chains: list[FloatArray], grid: FloatArray, metric: FloatArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Delaunay triangulation in which every segment of the chains is a side of triangles.

    Returns points, triangles, and the region between segments that each triangle is in. Segments
    that are missing are halved, which ends because short segments of a simple polygon are Delaunay
    edges. Triangles are anticlockwise in (u, v); flat ones are dropped.
    """
    from scipy.spatial import Delaunay

    segments = np.concatenate([np.stack([c[:-1], c[1:]], axis=1) for c in chains])
    segments = segments[np.any(segments[:, 0] != segments[:, 1], axis=1)]
    for _ in range(ROUNDS):
        border, ids = np.unique(segments.reshape(-1, 2), axis=0, return_inverse=True)
        uv = np.concatenate([border, grid])
        triangles = Delaunay(uv * metric).simplices
        sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        wanted = np.sort(ids.reshape(-1, 2), axis=1)
        count = len(uv)
        present = np.isin(wanted[:, 0] * count + wanted[:, 1], sides[:, 0] * count + sides[:, 1])
        if present.all():
            break
        middle = segments[~present].mean(axis=1)
        halves = [
            np.stack([segments[~present, 0], middle], axis=1),
            np.stack([middle, segments[~present, 1]], axis=1),
        ]
        segments = np.concatenate([segments[present], *halves])
    region = _regions(triangles, sides[:, 0] * count + sides[:, 1], wanted @ [count, 1])
    if not present.all():
        region = np.arange(
            len(triangles), dtype=np.int32
        )  # loops that cross part nothing: each for itself
    corners = (uv * metric)[triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    triangles[twice < 0.0] = triangles[twice < 0.0][:, ::-1]
    longest = np.max([(a**2).sum(axis=1), (b**2).sum(axis=1), ((b - a) ** 2).sum(axis=1)], axis=0)
    whole = np.abs(twice) > LEVEL * longest
    return uv, triangles[whole].astype(np.int32), region[whole]


def _regions(triangles: IntArray, side: np.ndarray, wanted: np.ndarray) -> IntArray:
    """(m,) number of the part each triangle is in, where `wanted` sides part neighbours."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    owner = np.repeat(np.arange(len(triangles)), 3)
    order = np.argsort(side, kind="stable")
    pair = np.flatnonzero(side[order][1:] == side[order][:-1])
    pair = pair[~np.isin(side[order][pair], wanted)]
    first, second = owner[order][pair], owner[order][pair + 1]
    n = len(triangles)
    graph = coo_matrix((np.ones(len(first)), (first, second)), (n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int32)
