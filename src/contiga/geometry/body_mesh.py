"""One mesh of all faces of a body, closed where the body is.

Every edge gets its vertices once, as many as the tolerance needs, and both faces at it use them.
Each face is then triangulated between them and refined inside only, so the faces fit whatever
they are. Where the borders of a face cross because the vertices are too few for its width, the
edges involved get more vertices, for all their faces.
"""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.threads import map_threads
from contiga.errors import ContigaWarning, GeometryError
from contiga.geometry.body_key import key_of
from contiga.geometry.border import POINT_TOL, Borders, Side, borders_of, edge_corners, path_points
from contiga.geometry.chains import EdgeShape, chain_shares, pole_shares
from contiga.geometry.face_mesh import ANY_DISTANCE, FaceMesh, Ints, Polygons
from contiga.geometry.faces_like import FacesLike
from contiga.geometry.tessellate import MAX_CELLS, check_request, net_grid
from contiga.geometry.trim import LARGEST_GAP, parameter_box
from contiga.records import FloatArray, IntArray
from contiga.triangles.kernels.mesh_sides_nb import side_numbers
from contiga.triangles.trimesh import TriMesh

MAX_TRIANGLES = 2 * MAX_CELLS
"""Largest number of triangles of a mesh."""
N_SAMPLES = 6
"""Samples in each direction of a patch for the estimate of the number of triangles."""
MAX_SPLITS = 16
"""Largest number of rounds that split edges whose polygons cross."""
MAX_REPAIRS = 8
"""Largest number of rounds that separate coincident triangles of different faces."""
EDGE_TOL_SHARE = 0.9
"""Share of the tolerance that is used along edges, so that the triangles next to them keep it."""
MEET_TOL = 1e-9
"""Ends of p-curves closer than this share of the domain are one vertex of the polygon."""
_MESHES = DiskCache("meshes", __file__)


class _MeshParts(NamedTuple):
    """The parts of a mesh, as the disk cache keeps them."""

    points: FloatArray
    """(n, 3)."""
    triangles: IntArray
    """(m, 3) rows of the points."""
    crossed: list[int]
    """Numbers of the faces whose borders cross each other."""


def body_mesh(body: FacesLike, tol: float, method: str = "chord") -> TriMesh:
    """Return one mesh of all faces of `body`; faces that share an edge share its vertices.

    It is read from the disk cache if the body is large and was meshed before.

    Parameters
    ----------
    body : the faces
    tol : for "chord" a length, from the surface to the triangles. For "net" an area, by patch:
        see `contiga.geometry.tessellate.net_grid`.
    method : "chord" or "net"

    Raises
    ------
    InputError
        `tol` is not positive, or the method is unknown.
    GeometryError
        The tolerance needs more than 40 million triangles, by an estimate or on the way.

    Warns
    -----
    ContigaWarning
        The borders of a face cross each other: it gets triangles, but none inside.
    """
    check_request(tol, method)
    if method == "chord":
        number = fewest_triangles(body, tol)
        if number > MAX_TRIANGLES:
            raise too_many(tol, number)
    key = key_of(body)
    points, triangles, crossed = _MESHES.get_or_build(
        None if key is None else f"{key} {method} {tol!r}",
        lambda: _Mesher(body, tol, method == "net").mesh(),
    )
    if crossed:
        warnings.warn(
            f"{body.name}: the borders of face {crossed[0]} cross each other"
            + (f", so do those of {len(crossed) - 1} others" if len(crossed) > 1 else "")
            + "; they get triangles, but none inside, so the tolerance may not be kept there",
            ContigaWarning,
            stacklevel=4,
        )
    return TriMesh(points, triangles)


class Polyline(NamedTuple):
    """Vertices along one side of a face."""

    uv: FloatArray
    """(n, 2)."""
    ids: Ints
    """(n,) vertex of the mesh."""
    parts: Ints
    """(n, 2) edge and number of its part from each vertex to the next."""


class _Mesher:
    """The steps from a body to its mesh, and their common data."""

    def __init__(self, body: FacesLike, tol: float, net: bool = False) -> None:
        self.body, self.tol = body, tol
        self.borders: Borders = borders_of(body)
        self.corners: Ints = edge_corners(self.borders).astype(np.int64)
        self.grids = [net_grid(patch, tol) for patch in body.patches] if net else None
        # For a net the tolerance is an area: over the patch's extent it is a length for edges.
        self.sags = [
            tol / max(math.sqrt(patch.net_area()), 1e-300) if net else EDGE_TOL_SHARE * tol
            for patch in body.patches
        ]
        self.edges = {
            e: EdgeShape(body, self.borders, e, min(self.sags[side.path.patch] for side in sides))
            for e, sides in enumerate(self.borders.sides)
            if sides and not self.borders.pole[e]
        }
        self.shares: dict[int, FloatArray] = {}
        """By edge, the shares of its range at which it has vertices."""
        for e, edge in self.edges.items():
            share = chain_shares(edge, edge.sag, bool(self.corners[e, 0] == self.corners[e, 1]))
            self.shares[e] = share
            if self.grids is None:
                continue
            # The grid lines of a net end in vertices of its natural sides.
            for side in edge.sides:
                if side.path.curve is None:
                    grid = self.grids[side.path.patch][1 - side.path.side // 2]
                    t = (grid - side.path.start) / (side.path.end - side.path.start)
                    t = 1.0 - t if side.reversed else t
                    share = np.concatenate([share, t[(t > MEET_TOL) & (t < 1.0 - MEET_TOL)]])
            share = np.unique(share)
            self.shares[e] = share[np.append(np.diff(share) > MEET_TOL, True)]

    def mesh(self) -> _MeshParts:
        """Return the mesh: all faces triangulated over one set of vertices, and refined inside.

        Faces whose borders cross get triangles by ears, and are not refined. Triangles of different
        faces that coincide are separated by further vertices, in up to `MAX_REPAIRS` rounds;
        triangles with a vertex twice are left out. Raises GeometryError for more than
        `MAX_TRIANGLES`.
        """
        faces = self._triangulate_borders()
        crossed = [k for k, face in enumerate(faces) if not face.is_valid]
        for k in crossed:
            faces[k].cut_ears()
        map_threads(lambda k: self._refine_face(k, faces[k]), range(len(faces)))
        if sum(len(face.triangles()) for face in faces) > MAX_TRIANGLES:
            raise too_many(self.tol, MAX_TRIANGLES)
        border_points = self._border_points()
        for _ in range(MAX_REPAIRS):
            n_points, blocks, owner_blocks = len(border_points), [], []
            for k, face in enumerate(faces):
                n_interior = len(face.interior_points())
                ids = [face.polygons.ids, np.arange(n_points, n_points + n_interior)]
                n_points += n_interior
                local = face.triangles()
                blocks.append(np.concatenate(ids)[local])
                owner_blocks.append(
                    np.stack([np.full(len(local), k), np.arange(len(local))], axis=1)
                )
            triangles = np.concatenate(blocks)
            if not _separate_coincident(faces, triangles, np.concatenate(owner_blocks)):
                break
        points = np.concatenate([border_points, *(face.interior_points() for face in faces)])
        mesh = TriMesh(points, triangles[_has_area(triangles)].astype(np.int32)).compact()
        return _MeshParts(mesh.vertices, mesh.triangles, crossed)

    def _triangulate_borders(self) -> list[FaceMesh]:
        """Return the faces, triangulated between their polygons.

        Parts of edges whose polygons cross are halved, up to `MAX_SPLITS` times; a face that still
        crosses is not valid.
        """
        faces: list[FaceMesh | None] = [None] * len(self.body.patches)
        for attempt in range(MAX_SPLITS + 1):
            ids_by_edge = self._vertex_ids()
            crossing_parts: dict[int, set[int]] = {}
            for k, face in enumerate(faces):
                polygons = self._polygons(k, ids_by_edge)
                if face is not None and len(face.polygons.uv) == len(polygons.uv):
                    face.renumber(polygons)
                else:
                    face = faces[k] = FaceMesh(self.body.patches[k], polygons)
                if not face.is_valid:
                    for e, part in polygons.parts[face.is_crossing].tolist():
                        crossing_parts.setdefault(e, set()).add(part)
            if attempt == MAX_SPLITS or not self._halve_parts(crossing_parts):
                break
        return [face for face in faces if face is not None]

    def _halve_parts(self, parts_by_edge: dict[int, set[int]]) -> bool:
        """Halve parts of edges, in `shares`, that are longer than rounding; False if none is.

        Poles and parts that do not exist are left out.
        """
        point_tol = POINT_TOL * self.body.size
        any_halved = False
        for e, parts in parts_by_edge.items():
            if e not in self.shares:
                continue
            share = self.shares[e]
            points = self.edges[e].evaluate(share)
            rows = np.array([p for p in sorted(parts) if 0 <= p < len(share) - 1], dtype=int)
            rows = rows[np.linalg.norm(points[rows + 1] - points[rows], axis=1) > point_tol]
            middles = 0.5 * (share[rows] + share[rows + 1])
            self.shares[e] = np.sort(np.concatenate([share, middles]))
            any_halved = any_halved or len(rows) > 0
        return any_halved

    def _refine_face(self, k: int, face: FaceMesh) -> None:
        """Insert vertices in a face: where it misses the surface, or at its net's grid.

        Faces with ears stay as they are. Raises GeometryError for more than `MAX_TRIANGLES`.
        """
        if face.ears is not None:
            return
        if self.grids is None:
            face.prepare(self.tol)
            if not face.refine(MAX_TRIANGLES):
                raise too_many(self.tol, MAX_TRIANGLES)
            return
        face.prepare(math.inf)
        grid = np.stack(np.meshgrid(*self.grids[k], indexing="ij"), axis=-1).reshape(-1, 2)
        for x, y in ((grid - face.low) / face.extent).tolist():
            if 0.0 < x < 1.0 and 0.0 < y < 1.0:
                face.insert(x, y, ANY_DISTANCE)

    def _vertex_ids(self) -> dict[int, Ints]:
        """Return by edge the vertices of the mesh along it, corners included.

        Vertices inside edges are numbered after the corners, edge after edge.
        """
        n_points = int(self.corners.max(initial=-1)) + 1
        ids_by_edge = {}
        for e, share in self.shares.items():
            n_inner = len(share) - 2
            first, last = self.corners[e]
            inner = np.arange(n_points, n_points + n_inner)
            ids_by_edge[e] = np.concatenate([[first], inner, [last]])
            n_points += n_inner
        return ids_by_edge

    def _polygons(self, k: int, ids_by_edge: dict[int, Ints]) -> Polygons:
        """Return the border of face k as polygons, without p-curves that only close a gap.

        A side's last vertex is left out if the next side starts at it, or at the same vertex of the
        mesh within `LARGEST_GAP` in (u, v).
        """
        tol = MEET_TOL * np.ptp(np.array(self.body.patches[k].domain), axis=1)
        gap_tol = tol / MEET_TOL * LARGEST_GAP
        lines, lengths = [], []
        for loop in self.borders.loops[k]:
            sides = [self._polyline(side, ids_by_edge) for side in loop]
            # A short p-curve that closes a gap may run back over its neighbours.
            is_gap = [
                (np.ptp(side.uv, axis=0) <= gap_tol).all() and (side.ids == side.ids[0]).all()
                for side in sides
            ]
            sides = [side for side, gap in zip(sides, is_gap, strict=True) if not gap] or sides
            n_vertices = 0
            for side, following in zip(sides, sides[1:] + sides[:1], strict=True):
                # The last vertex goes where the next side starts at it, or within a gap of it.
                distance = np.abs(side.uv[-1] - following.uv[0])
                meets = (distance <= tol).all() or (
                    side.ids[-1] == following.ids[0] and (distance <= gap_tol).all()
                )
                n = len(side.ids) - 1 if meets else len(side.ids)
                lines.append(Polyline(side.uv[:n], side.ids[:n], side.parts[:n]))
                n_vertices += n
            lengths.append(n_vertices)
        uv, ids, parts = (np.concatenate(columns) for columns in zip(*lines, strict=True))
        return Polygons(uv, ids, parts, np.cumsum([0, *lengths]))

    def _polyline(self, side: Side, ids_by_edge: dict[int, Ints]) -> Polyline:
        """Return the vertices along a side, in the sense of its loop."""
        e, patch = side.edge, self.body.patches[side.path.patch]
        if self.borders.pole[e]:
            share = pole_shares(side, patch)
            uv = path_points(side.path, patch, share)
            ids, part = np.full(len(share), self.corners[e, 0]), np.arange(len(share))
        else:
            edge = self.edges[e]
            uv, ids = edge.parameters(edge.sides.index(side), self.shares[e]), ids_by_edge[e]
            part = np.arange(len(ids))
            if side.reversed:
                uv, ids, part = uv[::-1], ids[::-1], part[::-1] - 1
        return Polyline(uv, ids, np.stack([np.full(len(ids), e), part], axis=1))

    def _border_points(self) -> FloatArray:
        """Return points (n, 3) of vertices on edges; a corner has the point of its first edge.

        A corner of poles alone has the point of one of their sides.
        """
        ids_by_edge = self._vertex_ids()
        count = max((int(ids.max()) + 1 for ids in ids_by_edge.values()), default=0)
        points = np.zeros((max(count, int(self.corners.max(initial=-1)) + 1), 3))
        for loops, patch in zip(self.borders.loops, self.body.patches, strict=True):
            for side in (side for loop in loops for side in loop if self.borders.pole[side.edge]):
                uv = path_points(side.path, patch, np.array([0.0]))
                points[self.corners[side.edge, 0]] = patch.evaluate(uv)[0]
        for e in sorted(ids_by_edge, reverse=True):
            points[ids_by_edge[e]] = self.edges[e].evaluate(self.shares[e])
        return points


def _has_area(triangles: Ints) -> NDArray[np.bool_]:
    """Return (m,) whether the three vertices of each triangle differ."""
    return np.asarray((triangles != np.roll(triangles, 1, axis=1)).all(axis=1))


def _separate_coincident(faces: list[FaceMesh], triangles: Ints, owners: Ints) -> bool:
    """Insert vertices where triangles or inner sides of faces coincide; False if none went in.

    Coarse faces that meet at a sharp edge may have the same corners, or an inner side of one may
    be a side of another. The first get a vertex at their centres, the second at the middles of
    sides that more than two triangles have.

    Parameters
    ----------
    faces : all faces
    triangles : (m, 3) of all faces, in vertices of the mesh
    owners : (m, 2) face, and number of the triangle in it
    """
    rows = np.flatnonzero(_has_area(triangles))
    corners, n = triangles[rows], int(triangles.max(initial=0)) + 1
    numbers, times = side_numbers(corners, n)
    # The side of the lowest number and the corner opposite to it identify a triangle.
    first, at = numbers.argmin(axis=1), np.arange(len(corners))
    _, group, n_copies = np.unique(
        numbers[at, first] * n + corners[at, (first + 2) % 3],
        return_inverse=True,
        return_counts=True,
    )
    any_inserted = False
    for k, i in owners[rows[n_copies[group] > 1]].tolist():
        any_inserted |= faces[k].insert_at_centre(i)
    crowded, sides = np.nonzero(times[numbers] > 2)
    middles = [
        (k, faces[k].side_middle(i, (side + 2) % 3))
        for (k, i), side in zip(owners[rows[crowded]].tolist(), sides.tolist(), strict=True)
    ]
    for k, middle in middles:
        if middle is not None:
            any_inserted |= faces[k].insert(*middle, ANY_DISTANCE)
    return any_inserted


def fewest_triangles(body: FacesLike, tol: float) -> float:
    """Return an estimate of the fewest triangles that a tolerance needs: ∫ √|K| dA / (2.6 tol).

    Pottmann et al. (2000), by 6 × 6 samples of the parameter box of each face, with the parts that
    trims cut off. Faces that bend in one direction or not at all add nothing.
    """
    share = (np.arange(N_SAMPLES) + 0.5) / N_SAMPLES
    total = 0.0
    for patch, loops in zip(body.patches, body.trims, strict=True):
        low, high = parameter_box(patch, loops)
        uv = np.stack(np.meshgrid(*(low + share[:, None] * (high - low)).T), axis=-1)
        d = patch.derivatives(uv.reshape(-1, 2), 2)
        n = np.cross(d[:, 1, 0], d[:, 0, 1])
        size = np.linalg.norm(n, axis=1)
        bends = [(d[:, i, j] * n).sum(axis=1) for i, j in ((2, 0), (1, 1), (0, 2))]
        root = np.sqrt(np.abs(bends[0] * bends[2] - bends[1] ** 2))
        density = np.divide(root, size, out=np.zeros_like(root), where=size > 1e-9 * size.max())
        total += float(density.mean() * np.prod(high - low))
    return total / (2.6 * tol)


def too_many(tol: float, number: float) -> GeometryError:
    """Return the error for a tolerance that needs about `number` triangles or more."""
    return GeometryError(
        f"this tolerance needs about {number:.2g} triangles or more, "
        f"and {MAX_TRIANGLES:.2g} are the most",
        where="tol",
        found=tol,
        remedy="Take a larger one",
    )
