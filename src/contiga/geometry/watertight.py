"""One mesh of all faces without cracks: faces that share an edge share its vertices.

Each face is meshed on its own. Along an edge of the body the vertices of all its faces are put in
order by the edge's parameter; a triangle at the edge that has vertices of other faces between its
two is cut into a fan. No triangle away from an edge changes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.curve_foot import CurveFeet
from contiga.geometry.trimesh import TriMesh
from contiga.records import FloatArray, IntArray

if TYPE_CHECKING:
    from contiga.geometry.body import Body

NEAR = 1e-9
"""Points closer than this share of the body's size are one."""
JOINED = 1e-5
"""Vertices on a face's border this close to an edge of the face (share of the size) are on it."""
SPACING = 0.02
"""Vertices on an edge closer than this share of their spacing become one."""
SAG = 0.5
"""A side of a triangle runs along an edge if its middle is this close, as a share of its length."""
SAMPLES = 9

Ints = NDArray[np.int64]


class SharedEdge(NamedTuple):
    """A curve along which faces meet."""

    curve: NurbsCurve
    tolerance: float
    """Largest distance of the faces' borders to it, length."""
    patches: tuple[int, ...]


def joined_faces(body: Body, faces: list[tuple[FloatArray, IntArray]]) -> TriMesh:
    """The faces' meshes (vertices, triangles), one a patch, joined along the edges of `body`."""
    counts = np.cumsum([0, *(len(points) for points, _ in faces)])
    points = np.concatenate([p for p, _ in faces])
    triangles = np.concatenate([t + n for (_, t), n in zip(faces, counts, strict=False)])
    face = np.repeat(np.arange(len(faces)), np.diff(counts))
    rim = _Rim.of(triangles.astype(np.int64), face)
    near = NEAR * body.size
    edges = shared_edges(body, near)
    reach = _reaches(edges, near)
    along = _along(points, rim, edges, reach, JOINED * body.size)
    root = np.arange(len(points))
    places = points.copy()
    chains = []
    for k, edge in enumerate(edges):
        chain = _chain(points, rim, (along, k), edge, (near, reach[k]))
        chains.append(chain)
        for group, place in zip(chain.groups, chain.places, strict=True):
            _unite(root, group)
            places[group] = place
    cut = _fans(triangles.tolist(), rim, along, chains)
    root = _roots(root)
    result = root[cut]
    whole = (result != np.roll(result, 1, axis=1)).all(axis=1)
    return TriMesh(places[root], _unfolded(result[whole]).astype(np.int32)).compact()


def shared_edges(body: Body, near: float) -> list[SharedEdge]:
    """Edges at which faces of `body` meet; coinciding natural sides where it names no edges."""
    named = [
        SharedEdge(
            edge.curve, max(edge.tolerance, edge.stated), tuple({use.patch for use in edge.uses})
        )
        for edge in body.edges
        if len(edge.uses) > 1
    ]
    if body.edges or len(body.patches) < 2:
        return named
    sides = []
    for k, (patch, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        (u0, u1), (v0, v1) = patch.domain
        if loops is None:
            curves = [patch.isocurve(u=u0), patch.isocurve(u=u1)]
            curves += [patch.isocurve(v=v0), patch.isocurve(v=v1)]
            sides += [(k, c, c.evaluate(np.linspace(*c.domain, SAMPLES))) for c in curves]
    sides = [side for side in sides if np.ptp(side[2], axis=0).max() > near]
    for i, (k, curve, p) in enumerate(sides):
        for other, _, q in sides[:i]:
            if min(np.abs(p - q).max(), np.abs(p - q[::-1]).max()) <= near:
                named.append(SharedEdge(curve, near, tuple({k, other})))
                break
    return named


class _Rim(NamedTuple):
    """Sides of triangles that belong to one triangle of their face."""

    ends: Ints
    """(r, 2) vertices, in the triangle's sense."""
    owner: Ints
    """(r,) triangle."""
    face: Ints
    """(r,)."""

    @classmethod
    def of(cls, triangles: Ints, face: Ints) -> _Rim:
        a = triangles.ravel()
        b = np.roll(triangles, -1, axis=1).ravel()
        n = int(triangles.max(initial=0)) + 1
        single = ~np.isin(a * n + b, b * n + a)
        ends = np.stack([a, b], axis=1)[single]
        return cls(ends, np.flatnonzero(single) // 3, face[ends[:, 0]])


class _Along(NamedTuple):
    """By side of the rim the edge it runs along, and the parameters of its ends."""

    edge: Ints
    """(r,) −1 for none."""
    span: FloatArray
    """(r, 2) unrolled, so that a side over the start of a closed curve has no jump."""


def _along(
    points: FloatArray, rim: _Rim, edges: list[SharedEdge], reach: FloatArray, joined: float
) -> _Along:
    best = np.full(len(rim.ends), np.inf)
    which = np.full(len(rim.ends), -1)
    span = np.zeros((len(rim.ends), 2))
    order = np.argsort(rim.face, kind="stable")
    faces = max((max(edge.patches) for edge in edges), default=-1) + 1
    start = np.searchsorted(rim.face[order], np.arange(faces + 1))
    for k, edge in enumerate(edges):
        rows = np.concatenate([order[start[f] : start[f + 1]] for f in edge.patches])
        if not len(rows):
            continue
        feet = CurveFeet(edge.curve)
        vertices, place = np.unique(rim.ends[rows], return_inverse=True)
        t, distance = feet(points[vertices])
        corners = edge.curve.evaluate(np.array(edge.curve.domain))
        to_corners = np.linalg.norm(points[vertices, None] - corners, axis=2)
        close = (distance <= 3.0 * edge.tolerance + joined) | (to_corners <= reach[k]).any(axis=1)
        place = place.reshape(-1, 2)
        on = close[place].all(axis=1)
        rows, ends = rows[on], t[place[on]]
        if not len(rows):
            continue
        a, b = points[rim.ends[rows]].transpose(1, 0, 2)
        middle, miss = feet(0.5 * (a + b))
        better = (miss <= SAG * np.linalg.norm(b - a, axis=1)) & (miss < best[rows])
        rows, ends, middle = rows[better], ends[better], middle[better]
        best[rows] = miss[better]
        which[rows] = k
        span[rows] = _unrolled(ends, middle, feet.period)
    return _Along(which, span)


def _unrolled(ends: FloatArray, middle: FloatArray, period: float) -> FloatArray:
    """Parameters (r, 2) moved by whole turns to the side of the middle they are on."""
    if period == 0.0:
        return ends
    return np.asarray(ends - period * np.round((ends - middle[:, None]) / period))


class _Chain(NamedTuple):
    """The vertices along an edge, in order."""

    groups: list[Ints]
    """Vertices that are to be one."""
    places: FloatArray
    t: FloatArray
    """Increasing."""
    period: float


def _reaches(edges: list[SharedEdge], near: float) -> FloatArray:
    """(e, 2) how far borders may end from the start and the end of each edge.

    Edges that meet at a corner may miss each other by the tolerance of the worst of them.
    """
    corners = np.array([e.curve.evaluate(np.array(e.curve.domain)) for e in edges]).reshape(-1, 3)
    own = np.repeat([max(2.0 * e.tolerance, near) for e in edges], 2)
    reach = own.copy()
    for i, corner in enumerate(corners):
        apart = np.linalg.norm(corners - corner, axis=1)
        reach[i] = own[apart <= np.maximum(own, own[i])].max()
    return reach.reshape(-1, 2)


def _chain(
    points: FloatArray,
    rim: _Rim,
    place: tuple[_Along, int],
    edge: SharedEdge,
    lengths: tuple[float, FloatArray],
) -> _Chain:
    along, k = place
    near, reach = lengths
    rows = np.flatnonzero(along.edge == k)
    curve, feet = edge.curve, CurveFeet(edge.curve)
    low, high = curve.domain
    vertices, first = np.unique(rim.ends[rows].ravel(), return_index=True)
    face = np.repeat(rim.face[rows], 2)[first]
    t = along.span[rows].ravel()[first]
    if not len(vertices):
        return _Chain([], np.zeros((0, 3)), np.zeros(0), feet.period)
    if feet.period:
        t = low + np.mod(t - low, feet.period)
    else:
        t = _to_ends(curve, np.clip(t, low, high), face, reach)
    order = np.argsort(t, kind="stable")
    vertices, t = vertices[order], t[order]
    steps = np.linalg.norm(np.diff(curve.evaluate(t), axis=0), axis=1)
    # Faces are cut where their neighbours have vertices, so only those in about one place need
    # to become one. The tolerance of the edge is across it and may exceed their spacing.
    spacing = steps.sum() * len(np.unique(face)) / max(1, len(steps))
    limit = max(near, SPACING * spacing)
    cuts = np.flatnonzero(steps > limit) + 1
    groups = np.split(vertices, cuts)
    places = np.array([_place(curve, part) for part in np.split(t, cuts)])
    middle = np.array([part.mean() for part in np.split(t, cuts)])
    if feet.period and len(groups) > 1:
        ends = curve.evaluate(t[[0, -1]])
        if np.linalg.norm(ends[1] - ends[0]) <= limit:
            groups[0] = np.concatenate([groups[0], groups[-1]])
            groups, places, middle = groups[:-1], places[:-1], middle[:-1]
    return _Chain(groups, places, middle, feet.period)


def _to_ends(curve: NurbsCurve, t: FloatArray, face: Ints, reach: FloatArray) -> FloatArray:
    """`t` with the first and the last of each face put to the ends of `curve`, where near these.

    There all faces at a corner meet, however far the curves of their borders miss each other.
    """
    t = t.copy()
    ends = np.array(curve.domain)
    corners = curve.evaluate(ends)
    for f in np.unique(face):
        own = np.flatnonzero(face == f)
        last = own[[np.argmin(t[own]), np.argmax(t[own])]]
        close = np.linalg.norm(curve.evaluate(t[last]) - corners, axis=1) <= reach
        t[last[close]] = ends[close]
    return t


def _place(curve: NurbsCurve, t: FloatArray) -> FloatArray:
    """One point for vertices at `t`: that of an end where one is there, so corners keep still."""
    low, high = curve.domain
    at = low if low in t else (high if high in t else float(t.mean()))
    return np.asarray(curve.evaluate(np.array([at]))[0])


def _fans(triangles: list[list[int]], rim: _Rim, along: _Along, chains: list[_Chain]) -> Ints:
    """The triangles, those at edges cut where other faces' vertices lie between their own."""
    owner = {(int(a), int(b)): int(o) for (a, b), o in zip(rim.ends, rim.owner, strict=True)}
    group_of = [
        {int(v): i for i, group in enumerate(chain.groups) for v in group} for chain in chains
    ]
    for row in np.flatnonzero(along.edge >= 0):
        k = int(along.edge[row])
        p, q = (int(v) for v in rim.ends[row])
        own = {group_of[k][p], group_of[k][q]}
        span = _of_groups(chains[k], (group_of[k][p], group_of[k][q]), along.span[row])
        between = [i for i in _between(chains[k], span) if i not in own]
        if not between:
            continue
        inner = [int(chains[k].groups[i][0]) for i in between]
        at = owner[p, q]
        r = next(v for v in triangles[at] if v not in (p, q))
        line = [p, *inner, q]
        triangles[at] = [p, line[1], r]
        triangles += [[a, b, r] for a, b in pairwise(line[1:])]
        if (q, r) in owner:
            owner[q, r] = len(triangles) - 1
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _unfolded(triangles: Ints) -> Ints:
    """`triangles` but pairs of the same corners that face opposite ways.

    Coarse faces that meet at a sharp edge fold onto each other there; without such a pair what
    was around it meets.
    """
    corners = np.sort(triangles, axis=1)
    _, place, times = np.unique(corners, axis=0, return_inverse=True, return_counts=True)
    turn = np.argmin(triangles, axis=1)[:, None]
    first = np.take_along_axis(triangles, (turn + 1) % 3, axis=1)[:, 0]
    sense = np.where(first == corners[:, 1], 1, -1)
    folded = (times == 2) & (np.bincount(place.ravel(), sense, minlength=len(times)) == 0)
    return triangles[~folded[place.ravel()]]


def _of_groups(chain: _Chain, groups: tuple[int, int], span: FloatArray) -> FloatArray:
    """(2,) parameters of two groups, in the turn of the curve that `span` is in."""
    t = chain.t[list(groups)]
    return t + chain.period * np.round((span - t) / chain.period) if chain.period else t


def _between(chain: _Chain, span: FloatArray) -> list[int]:
    """Groups from one parameter to the other, in this order."""
    low, high = float(span.min()), float(span.max())
    found = []
    for turn in (-1, 0, 1) if chain.period else (0,):
        t = chain.t + turn * chain.period
        found += [(float(t[i]), int(i)) for i in np.flatnonzero((t > low) & (t < high))]
    found.sort(reverse=bool(span[0] > span[1]))
    return [i for _, i in found]


def _unite(root: Ints, group: Ints) -> None:
    first = _find(root, int(group[0]))
    for v in group[1:]:
        other = _find(root, int(v))
        root[max(first, other)] = min(first, other)
        first = min(first, other)


def _find(root: Ints, v: int) -> int:
    while root[v] != v:
        root[v] = root[root[v]]
        v = int(root[v])
    return v


def _roots(root: Ints) -> Ints:
    while True:
        next_root = root[root]
        if (next_root == root).all():
            return root
        root = next_root
