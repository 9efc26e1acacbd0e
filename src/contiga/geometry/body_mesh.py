"""One mesh of all faces of a body, closed where the body is.

Every edge gets its vertices once, as many as the distance asks for; both faces at it take them.
Each face is then triangulated between them and refined inside only, so the faces fit whatever
they are. Where borders of a face cross because the vertices are too few for its width, the edges
in question get more, for all their faces.
"""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import numpy as np

from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.threads import map_threads
from contiga.errors import ContigaWarning, GeometryError
from contiga.geometry.body_key import key_of
from contiga.geometry.border import NEAR, Borders, Side, borders_of, corners, path_points
from contiga.geometry.chains import EdgeShape, chain_shares, pole_shares
from contiga.geometry.face_mesh import ANYWHERE, FaceMesh, Ints, Polygons
from contiga.geometry.faces_like import FacesLike
from contiga.geometry.tessellate import MAX_CELLS, check_request, net_grid
from contiga.geometry.trim import LARGEST_GAP, parameter_box
from contiga.records import FloatArray, IntArray
from contiga.triangles.kernels.mesh_sides_nb import side_numbers
from contiga.triangles.trimesh import TriMesh

MAX_TRIANGLES = 2 * MAX_CELLS
"""Largest number of triangles of a mesh."""
COARSE = 6
"""Places in each direction of a patch from which the number of triangles is estimated."""
ROUNDS = 16
"""Refinements of edges whose parts are in each other's way."""
REPAIRS = 8
"""Rounds of parting triangles of different faces that fall on each other."""
ALONG = 0.9
"""Share of the tolerance that is used along edges, so that triangles beside them keep it."""
MEET = 1e-9
"""Ends of p-curves closer than this share of the domain are one place of the polygon."""
_MESHES = DiskCache("meshes", __file__)


class _Meshed(NamedTuple):
    """The parts of a mesh, as they are kept on the disk."""

    points: FloatArray
    triangles: IntArray
    crossed: list[int]
    """Faces whose borders cross each other."""


def body_mesh(body: FacesLike, tol: float, method: str = "chord") -> TriMesh:
    """One mesh of all faces of `body`; faces that share an edge share its vertices.

    Parameters
    ----------
    body : the faces
    tol : for "chord" a length, from the surface to the triangles. For "net" an area, by patch:
        see `contiga.geometry.tessellate.net_grid`.
    method : "chord" or "net"

    Raises
    ------
    InputError
        `tol` is not positive, an unknown method.
    GeometryError
        a tolerance that would take more than 40 million triangles.

    Warns
    -----
    ContigaWarning
        the borders of a face cross each other: it gets triangles, but none inside.
    """
    check_request(tol, method)
    if method == "chord":
        number = fewest_triangles(body, tol)
        if number > MAX_TRIANGLES:
            raise too_many(tol, number)
    key = key_of(body)
    points, triangles, crossed = _MESHES.kept(
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


class Line(NamedTuple):
    """Vertices of a side of a face."""

    uv: FloatArray
    ids: Ints
    parts: Ints
    """(n, 2) edge and number of its part from each vertex to the next."""


class _Mesher:
    """The steps from a body to its mesh, and what they share."""

    def __init__(self, body: FacesLike, tol: float, net: bool = False) -> None:
        self.body, self.tol = body, tol
        self.borders: Borders = borders_of(body)
        self.ends: Ints = corners(self.borders).astype(np.int64)
        self.grids = [net_grid(patch, tol) for patch in body.patches] if net else None
        # An area over the patch's extent is the length that the edges of a net may miss.
        self.sags = [
            tol / max(math.sqrt(patch.net_area()), 1e-300) if net else ALONG * tol
            for patch in body.patches
        ]
        self.edges = {
            e: EdgeShape(body, self.borders, e, min(self.sags[side.path.patch] for side in sides))
            for e, sides in enumerate(self.borders.sides)
            if sides and not self.borders.pole[e]
        }
        self.shares = {e: self._share(e) for e in self.edges}

    def _share(self, e: int) -> FloatArray:
        """Return where an edge gets vertices, by the distance and by grids of a net."""
        edge = self.edges[e]
        share = chain_shares(edge, edge.sag, bool(self.ends[e, 0] == self.ends[e, 1]))
        if self.grids is None:
            return share
        for side in edge.sides:
            if side.path.curve is None:
                grid = self.grids[side.path.patch][1 - side.path.side // 2]
                at = (grid - side.path.start) / (side.path.end - side.path.start)
                at = 1.0 - at if side.reversed else at
                share = np.concatenate([share, at[(at > MEET) & (at < 1.0 - MEET)]])
        share = np.unique(share)
        return share[np.append(np.diff(share) > MEET, True)]

    def mesh(self) -> _Meshed:
        """Triangles of all faces over one set of vertices."""
        faces = self._bordered()
        crossed = [k for k, face in enumerate(faces) if not face.whole]
        for k in crossed:
            faces[k].cut_ears()
        map_threads(lambda k: self._fill(k, faces[k]), range(len(faces)))
        if sum(len(face.triangles()) for face in faces) > MAX_TRIANGLES:
            raise too_many(self.tol, MAX_TRIANGLES)
        for _ in range(REPAIRS):
            triangles, places = self._joined(faces)
            if not _parted(faces, triangles, places):
                break
        points = np.concatenate([self._border_points(), *(face.own_points() for face in faces)])
        whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
        mesh = TriMesh(points, triangles[whole].astype(np.int32)).compact()
        return _Meshed(mesh.vertices, mesh.triangles, crossed)

    def _fill(self, k: int, face: FaceMesh) -> None:
        """Put vertices in a face: where it misses, or those of its net's grid."""
        if face.ears is not None:
            return
        if self.grids is None:
            face.prepare(self.tol)
            if not face.refined(MAX_TRIANGLES):
                raise too_many(self.tol, MAX_TRIANGLES)
            return
        face.prepare(math.inf)
        grid = np.stack(np.meshgrid(*self.grids[k], indexing="ij"), axis=-1).reshape(-1, 2)
        for x, y in ((grid - face.low) / face.extent).tolist():
            if 0.0 < x < 1.0 and 0.0 < y < 1.0:
                face.put(x, y, ANYWHERE)

    def _bordered(self) -> list[FaceMesh]:
        """Faces between their polygons, edges refined until these do not cross."""
        faces: list[FaceMesh | None] = [None] * len(self.body.patches)
        for attempt in range(ROUNDS + 1):
            number = self._numbered()
            crossed: dict[int, set[int]] = {}
            for k, face in enumerate(faces):
                polygons = self._polygons(k, number)
                if face is not None and len(face.polygons.uv) == len(polygons.uv):
                    face.renumber(polygons)
                else:
                    face = faces[k] = FaceMesh(self.body.patches[k], polygons)
                if not face.whole:
                    for e, part in polygons.parts[face.in_the_way].tolist():
                        crossed.setdefault(e, set()).add(part)
            if attempt == ROUNDS or not self._cut(crossed):
                break
        return [face for face in faces if face is not None]

    def _numbered(self) -> dict[int, Ints]:
        """Vertices of the mesh along each edge."""
        at = int(self.ends.max(initial=-1)) + 1
        number = {}
        for e, share in self.shares.items():
            inner = len(share) - 2
            a, b = self.ends[e]
            number[e] = np.concatenate([[a], np.arange(at, at + inner), [b]])
            at += inner
        return number

    def _cut(self, crossed: dict[int, set[int]]) -> bool:
        """Halve parts of edges; False if none can be."""
        near = NEAR * self.body.size
        done = False
        for e, parts in crossed.items():
            if e not in self.shares:
                continue
            share = self.shares[e]
            points = self.edges[e].evaluate(share)
            chosen = np.array([p for p in sorted(parts) if 0 <= p < len(share) - 1], dtype=int)
            chosen = chosen[np.linalg.norm(points[chosen + 1] - points[chosen], axis=1) > near]
            middles = 0.5 * (share[chosen] + share[chosen + 1])
            self.shares[e] = np.sort(np.concatenate([share, middles]))
            done = done or len(chosen) > 0
        return done

    def _polygons(self, k: int, number: dict[int, Ints]) -> Polygons:
        near = MEET * np.ptp(np.array(self.body.patches[k].domain), axis=1)
        loops = []
        for loop in self.borders.loops[k]:
            lines = [self._line(side, number) for side in loop]
            # A gap that a short p-curve closes may run back over its neighbours.
            lines = [line for line in lines if not _is_gap(line, near)] or lines
            ends = zip(lines, lines[1:] + lines[:1], strict=True)
            loops.append([_without_end(line, after, near) for line, after in ends])
        starts = np.cumsum([0, *(sum(len(line.uv) for line in loop) for loop in loops)])
        flat = [line for loop in loops for line in loop]
        uv, ids, parts = (np.concatenate([line[i] for line in flat]) for i in range(3))
        return Polygons(uv, ids, parts, starts)

    def _line(self, side: Side, number: dict[int, Ints]) -> Line:
        """The vertices along a side, in the sense of its loop."""
        e, patch = side.edge, self.body.patches[side.path.patch]
        if self.borders.pole[e]:
            share = pole_shares(side, patch)
            uv = path_points(side.path, patch, share)
            ids, part = np.full(len(share), self.ends[e, 0]), np.arange(len(share))
        else:
            edge = self.edges[e]
            uv, ids = edge.parameters(edge.sides.index(side), self.shares[e]), number[e]
            part = np.arange(len(ids))
            if side.reversed:
                uv, ids, part = uv[::-1], ids[::-1], part[::-1] - 1
        return Line(uv, ids, np.stack([np.full(len(ids), e), part], axis=1))

    def _border_points(self) -> FloatArray:
        """Return places (n, 3) of vertices on edges; corners have the first edge's."""
        number = self._numbered()
        count = max((int(ids.max()) + 1 for ids in number.values()), default=0)
        points = np.zeros((max(count, int(self.ends.max(initial=-1)) + 1), 3))
        for loops, patch in zip(self.borders.loops, self.body.patches, strict=True):
            for side in (side for loop in loops for side in loop if self.borders.pole[side.edge]):
                place = path_points(side.path, patch, np.array([0.0]))
                points[self.ends[side.edge, 0]] = patch.evaluate(place)[0]
        for e in sorted(number, reverse=True):
            points[number[e]] = self.edges[e].evaluate(self.shares[e])
        return points

    def _joined(self, faces: list[FaceMesh]) -> tuple[Ints, Ints]:
        """Triangles (m, 3) of all faces in vertices of the mesh, and (m, 2) face and own number."""
        at = len(self._border_points())
        triangles, places = [], []
        for k, face in enumerate(faces):
            count = len(face.own_points())
            ids = np.concatenate([face.polygons.ids, np.arange(at, at + count)])
            at += count
            local = face.triangles()
            triangles.append(ids[local])
            places.append(np.stack([np.full(len(local), k), np.arange(len(local))], axis=1))
        return np.concatenate(triangles), np.concatenate(places)


def _is_gap(line: Line, near: FloatArray) -> bool:
    """Return whether a side only closes a gap between two others."""
    small = np.ptp(line.uv, axis=0) <= near / MEET * LARGEST_GAP
    return bool(small.all() and (line.ids == line.ids[0]).all())


def _without_end(line: Line, after: Line, near: FloatArray) -> Line:
    """A side without its last vertex, where the next one starts there or just beside."""
    apart = np.abs(line.uv[-1] - after.uv[0])
    meets = (apart <= near).all() or (
        line.ids[-1] == after.ids[0] and (apart <= near / MEET * LARGEST_GAP).all()
    )
    return Line(line.uv[:-1], line.ids[:-1], line.parts[:-1]) if meets else line


def _parted(faces: list[FaceMesh], triangles: Ints, places: Ints) -> bool:
    """Put vertices where triangles or inner sides of faces fall on others; False if none do.

    Coarse faces that meet at a sharp edge may have the same corners, or one a side inside that
    another has too.
    """
    rows = np.flatnonzero((triangles != np.roll(triangles, 1, axis=1)).all(axis=1))
    whole, n = triangles[rows], int(triangles.max(initial=0)) + 1
    numbers, times = side_numbers(whole, n)
    # A triangle is its side of the lowest number, and the corner across from that.
    first = numbers.argmin(axis=1)
    number = np.arange(len(whole))
    _, place, copies = np.unique(
        numbers[number, first] * n + whole[number, (first + 2) % 3],
        return_inverse=True,
        return_counts=True,
    )
    done = False
    for k, i in places[rows[copies[place] > 1]].tolist():
        done |= faces[k].put_inside(i)
    crowded, j = np.nonzero(times[numbers] > 2)
    middles = [
        (k, faces[k].middle_of(i, (side + 2) % 3))
        for (k, i), side in zip(places[rows[crowded]].tolist(), j.tolist(), strict=True)
    ]
    for k, middle in middles:
        if middle is not None:
            done |= faces[k].put(*middle, apart=ANYWHERE)
    return done


def fewest_triangles(body: FacesLike, tol: float) -> float:
    """About the fewest triangles that a tolerance takes, before any is made.

    √|K| dA over 2.6 tol (Pottmann et al. 2000); nothing of faces that bend one way or not at all.
    """
    share = (np.arange(COARSE) + 0.5) / COARSE
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
    """Return the message about a tolerance that is too fine."""
    return GeometryError(
        f"this tolerance needs about {number:.2g} triangles or more, "
        f"and {MAX_TRIANGLES:.2g} are the most",
        where="tol",
        found=tol,
        remedy="Take a larger one",
    )
