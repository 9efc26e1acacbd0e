"""Patches that share control points where their edges meet, and what is refused of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from contiga.errors import GeometryError, InputError
from contiga.matter.iga.basis import VALUE, Patch, U, V, basis_at
from contiga.records import FloatArray, IntArray

EDGES = ("u0", "u1", "v0", "v1")
DEGREES = 5
"""The highest."""
NEAR = 1e-6
"""Part of the size of all patches within which control points are the same, where none is given."""
PARALLEL = 1e-9
"""Sine of the angle between S_u and S_v below which a surface has no normal."""
SAME = 1e-9
"""Part by which knots and weights of two edges may differ and still be the same."""
SAMPLES = 5
HALVINGS = 40
"""Of the distance between samples, until there is rounding alone."""


class Piece(NamedTuple):
    """A part of a patch between lines across which its slope may jump: a patch itself."""

    patch: int
    """Number of the patch it is of."""
    ends: tuple[str, ...]
    """Its edges that lie on edges of the patch, which have the same names."""
    degrees: tuple[int, int]
    knots: tuple[FloatArray, FloatArray]
    control_points: FloatArray
    weights: FloatArray | None
    control: IntArray
    """(n, m) degrees of freedom of its control points."""


class Joint(NamedTuple):
    """Two edges that share their control points, by number of piece and name of edge."""

    pieces: tuple[int, int]
    edges: tuple[str, str]
    turned: bool
    """Whether the second runs the other way."""


class Net(NamedTuple):
    """Patches and their control points, as degrees of freedom."""

    control: tuple[IntArray, ...]
    """(n, m) degree of freedom of each control point of each patch."""
    pieces: tuple[Piece, ...]
    """Of all patches."""
    points: FloatArray
    """(d, 3) control points at rest."""
    sites: FloatArray
    """(d, 3) where each control point has its place on the surface: at its Greville parameters."""
    joints: tuple[Joint, ...]

    def edge(self, name: str, patch: int = 0, rows: int = 1) -> IntArray:
        """Degrees of freedom of an edge of a patch, ascending.

        Parameters
        ----------
        name : "u0", "u1", "v0" or "v1": where u or v begins or ends
        rows : of control points, from the edge on; two hold the slope there as well

        Raises
        ------
        InputError
            No such edge or patch, more rows than the patch has.
        """
        net = self._control_of(patch)
        way = rows_from(net, _edge_name(name))
        if not 1 <= rows <= len(way):
            raise InputError(
                f"patch {patch} has {len(way)} rows of control points from its edge {name} on",
                where="rows",
                found=rows,
                allowed=f"1 to {len(way)}",
            )
        return np.unique(way[:rows]).astype(np.int32)

    def box(self, low: Sequence[float], high: Sequence[float]) -> IntArray:
        """Degrees of freedom whose place on the surface is in a box, ascending.

        Raises
        ------
        InputError
            None is there.
        """
        near = NEAR * _size(self.sites)
        inside = (self.sites >= np.asarray(low) - near) & (self.sites <= np.asarray(high) + near)
        rows = np.flatnonzero(inside.all(axis=1))
        if rows.size == 0:
            raise InputError(
                "no control point has its place on the surface there",
                where="box",
                found=[list(low), list(high)],
                allowed=f"from {self.sites.min(axis=0).tolist()} to "
                f"{self.sites.max(axis=0).tolist()}",
            )
        return rows.astype(np.int32)

    def _control_of(self, patch: int) -> IntArray:
        if not 0 <= patch < len(self.control):
            raise InputError(
                "there is no such patch",
                where="patch",
                found=patch,
                allowed=f"0 to {len(self.control) - 1}",
            )
        return self.control[patch]


def join(surfaces: Sequence[Patch], tolerance: float | None = None) -> Net:
    """Patches joined where their edges have the same control points.

    Parameters
    ----------
    surfaces : of degrees 1 to 5, such as `contiga.NurbsSurface`
    tolerance : length within which control points are the same; a millionth of the size of all
        patches if omitted

    Raises
    ------
    InputError
        No patch, a degree above 5, weights that are not positive, a pole or another edge along
        which the surface has no normal, patches that do not meet, that meet along a part of an
        edge, or with other control points, knots or weights.
    """
    patches = tuple(surfaces)
    if not patches:
        raise InputError("a shell needs a surface", where="surfaces", allowed="at least one")
    for k, patch in enumerate(patches):
        _check_numbers(patch, f"surfaces[{k}]")
    size = _size(np.concatenate([patch.control_points.reshape(-1, 3) for patch in patches]))
    near = NEAR * size if tolerance is None else float(tolerance)
    starts = np.cumsum([0, *(patch.control_points[..., 0].size for patch in patches)])
    pieces = [
        piece for k, patch in enumerate(patches) for piece in _pieces(patch, k, int(starts[k]))
    ]
    for piece in pieces:
        _check_edges(piece, near)
    joints = _joints(pieces, near)
    _check_whole_edges(pieces, joints, near)
    _check_connected(pieces, joints)
    first, numbers = _shared(int(starts[-1]), pieces, joints)
    points, sites = (
        np.concatenate([part.reshape(-1, 3) for part in parts])[first]
        for parts in (
            [np.asarray(patch.control_points, np.float64) for patch in patches],
            [_greville_points(patch) for patch in patches],
        )
    )
    control = tuple(
        numbers[start : start + patch.control_points[..., 0].size].reshape(
            patch.control_points.shape[:2]
        )
        for start, patch in zip(starts, patches, strict=False)
    )
    renumbered = tuple(piece._replace(control=numbers[piece.control]) for piece in pieces)
    return Net(control, renumbered, points, sites, joints)


def _pieces(patch: Patch, number: int, first: int) -> list[Piece]:
    """A patch cut along knots that stand there as often as its degree; control points are counted
    from `first` on."""
    n, m = patch.control_points.shape[:2]
    control = first + np.arange(n * m, dtype=np.int32).reshape(n, m)
    points = np.asarray(patch.control_points, np.float64)
    factors = None if patch.weights is None else np.asarray(patch.weights, np.float64)
    along, across = (
        _cuts(np.asarray(knots), p) for knots, p in zip(patch.knots, patch.degrees, strict=True)
    )
    found = []
    for i, (rows, U_knots) in enumerate(along):
        for j, (columns, V_knots) in enumerate(across):
            outer = i == 0, i == len(along) - 1, j == 0, j == len(across) - 1
            piece = Piece(
                number,
                tuple(name for name, is_outer in zip(EDGES, outer, strict=True) if is_outer),
                patch.degrees,
                (U_knots, V_knots),
                points[rows, columns],
                None if factors is None else factors[rows, columns],
                control[rows, columns],
            )
            found.append(piece)
    return found


def _cuts(knots: FloatArray, degree: int) -> list[tuple[slice, FloatArray]]:
    """The control points along one direction and the knots of each piece.

    A line of degree 1 is not cut: it has no slope to keep, and does not bend.
    """
    breaks, times = np.unique(knots, return_counts=True)
    inner = (times >= degree) & (breaks > knots[0]) & (breaks < knots[-1])
    cuts = breaks[inner] if degree > 1 else breaks[:0]
    ends = np.concatenate([knots[:1], cuts, knots[-1:]])
    found = []
    for low, high in pairwise(ends):
        between = knots[(knots > low) & (knots < high)]
        start = max(int(np.searchsorted(knots, low)) - 1, 0)
        count = len(between) + degree + 1
        whole = np.concatenate([np.full(degree + 1, low), between, np.full(degree + 1, high)])
        found.append((slice(start, start + count), whole))
    return found


def _shared(
    count: int, pieces: Sequence[Piece], joints: Sequence[Joint]
) -> tuple[NDArray[np.intp], IntArray]:
    """The first control point of each degree of freedom, and the degree of freedom of each."""
    lowest = np.arange(count)
    while True:
        before = lowest.copy()
        for joint in joints:
            one, other = (
                rows_from(pieces[piece].control, edge)[0]
                for piece, edge in zip(joint.pieces, joint.edges, strict=True)
            )
            other = other[::-1] if joint.turned else other
            least = np.minimum(lowest[one], lowest[other])
            np.minimum.at(lowest, one, least)
            np.minimum.at(lowest, other, least)
        if (before == lowest).all():
            break
    first, numbers = np.unique(lowest, return_inverse=True)
    return first, numbers.astype(np.int32)


def _joints(pieces: Sequence[Piece], near: float) -> tuple[Joint, ...]:
    """All pairs of edges with the same control points.

    Raises
    ------
    InputError
        A pair of edges that is the same curve with other control points, knots or weights.
    """
    edges = [(piece, name) for piece in range(len(pieces)) for name in EDGES]
    lines = [rows_from(pieces[piece].control_points, name)[0] for piece, name in edges]
    ends = np.stack([line[[0, -1]] for line in lines])
    close = cKDTree(ends.mean(axis=1)).query_pairs(2.0 * near, output_type="ndarray")
    joints = []
    for a, b in close[np.lexsort(close.T[::-1])]:
        for turned in (False, True):
            other = ends[b][::-1] if turned else ends[b]
            if np.abs(ends[a] - other).max() > near:
                continue
            joint = Joint((edges[a][0], edges[b][0]), (edges[a][1], edges[b][1]), turned)
            if _same_curve(pieces, joint, near):
                joints.append(joint)
                break
    return tuple(joints)


def _same_curve(pieces: Sequence[Piece], joint: Joint, near: float) -> bool:
    """Whether two edges that have their ends in common are one, with the same control points."""
    both = [(pieces[k], name) for k, name in zip(joint.pieces, joint.edges, strict=True)]
    one, other = (_edge_of(piece, name) for piece, name in both)
    if joint.turned:
        other = other.turned()
    if np.abs(one.samples - other.samples).max() > near:
        return False
    for what, a, b, slack in (
        ("degree", np.array([one.degree]), np.array([other.degree]), 0.5),
        ("knots", one.knots, other.knots, SAME),
        ("control points", one.points, other.points, near),
        ("weights", one.weights, other.weights, SAME),
    ):
        if a.shape != b.shape or np.abs(a - b).max() > slack:
            raise InputError(
                f"they meet, but their {what} there differ",
                where=" and ".join(f"surfaces[{piece.patch}] {name}" for piece, name in both),
                found=f"{len(one.points)} and {len(other.points)} control points, "
                f"degrees {one.degree} and {other.degree}",
                allowed="the same degree, knots, control points and weights along the joint",
                remedy="Refine both alike: NurbsSurface.insert_knots, elevate",
            )
    return True


class _Edge(NamedTuple):
    """An edge of a patch as a curve, its knots from 0 to 1 and its first weight one."""

    degree: int
    knots: FloatArray
    points: FloatArray
    weights: FloatArray
    samples: FloatArray
    """(SAMPLES, 3) on it."""

    def turned(self) -> _Edge:
        """The other way round."""
        weights = self.weights[::-1] / self.weights[-1]
        return _Edge(
            self.degree, 1.0 - self.knots[::-1], self.points[::-1], weights, self.samples[::-1]
        )


def _edge_of(patch: Patch, name: str) -> _Edge:
    axis = 1 if name[0] == "u" else 0  # along which the edge runs
    knots = np.asarray(patch.knots[axis])
    low, high = knots[0], knots[-1]
    points = rows_from(patch.control_points, name)[0]
    weights = np.ones(len(points))
    if patch.weights is not None:
        weights = rows_from(patch.weights, name)[0]
    along = np.linspace(low, high, SAMPLES)
    samples = basis_at(patch, edge_parameters(patch, name, along)).of(
        VALUE, patch.control_points.reshape(-1, 3)
    )
    return _Edge(
        patch.degrees[axis], (knots - low) / (high - low), points, weights / weights[0], samples
    )


def edge_parameters(patch: Patch, name: str, along: FloatArray) -> FloatArray:
    """(k, 2) parameters on an edge, of those along it (k,)."""
    axis = 0 if name[0] == "u" else 1
    end = patch.knots[axis][0 if name[1] == "0" else -1]
    uv = np.empty((len(along), 2))
    uv[:, axis], uv[:, 1 - axis] = end, along
    return uv


def _check_connected(pieces: Sequence[Piece], joints: Sequence[Joint]) -> None:
    """Refuse patches that hang together with none of the others."""
    reached, new = {0}, True
    while new:
        new = False
        for joint in joints:
            if len(reached.intersection(joint.pieces)) == 1:
                reached.update(joint.pieces)
                new = True
    apart = [k for k in range(len(pieces)) if k not in reached]
    if not apart:
        return
    own = _border_points(pieces[apart[0]])
    gaps = {k: _gap(own, _border_points(pieces[k])) for k in reached}
    nearest = min(gaps, key=lambda k: gaps[k])
    patches = dict.fromkeys(str(pieces[k].patch) for k in apart)
    raise InputError(
        f"surfaces {', '.join(patches)} do not meet the others: no edge of theirs has the control "
        "points of another",
        where="surfaces",
        found=f"surfaces[{pieces[apart[0]].patch}] is {gaps[nearest]:.3g} from "
        f"surfaces[{pieces[nearest].patch}]",
        allowed="patches that share control points along whole edges",
        remedy="Give a tolerance, refine neighbours alike, or make shells of their own",
    )


def _check_whole_edges(pieces: Sequence[Piece], joints: Sequence[Joint], near: float) -> None:
    """Refuse edges that meet another along a part of theirs: a slit would open there."""
    joined = {
        (piece, edge)
        for joint in joints
        for piece, edge in zip(joint.pieces, joint.edges, strict=True)
    }
    free = [(k, name) for k in range(len(pieces)) for name in EDGES if (k, name) not in joined]
    if not free:
        return
    lines = [rows_from(pieces[k].control_points, name)[0] for k, name in free]
    ends = np.concatenate([line[[0, -1]] for line in lines])
    for (k, name), line in zip(free, lines, strict=True):
        # A curve lies in the box of its control points, and other corners lie on it if on any.
        inside = (ends >= line.min(axis=0) - near) & (ends <= line.max(axis=0) + near)
        apart = [np.abs(ends - end).max(axis=1) > near for end in line[[0, -1]]]
        rows = np.flatnonzero(inside.all(axis=1) & apart[0] & apart[1])
        on = rows[_distances(pieces[k], name, ends[rows]) <= near]
        if on.size:
            other, edge = free[int(on[0]) // 2]
            raise InputError(
                "they meet along a part of an edge",
                where=f"surfaces[{pieces[k].patch}] {name} and "
                f"surfaces[{pieces[other].patch}] {edge}",
                found=f"a corner at {np.round(ends[on[0]], 9).tolist()}",
                allowed="patches that share control points along whole edges",
                remedy="Split the longer one there: NurbsSurface.split",
            )


def _distances(piece: Piece, name: str, points: FloatArray) -> FloatArray:
    """(k,) of points from an edge, by halving the distance between samples around the nearest."""
    knots = piece.knots[1 if name[0] == "u" else 0]
    low, high = float(knots[0]), float(knots[-1])
    net = piece.control_points.reshape(-1, 3)
    found = np.empty(len(points))
    for row, point in enumerate(points):
        width, middle = high - low, 0.5 * (low + high)
        count = 8 * len(knots) + 1
        for _ in range(HALVINGS):
            along = np.linspace(
                max(middle - 0.5 * width, low), min(middle + 0.5 * width, high), count
            )
            x = basis_at(piece, edge_parameters(piece, name, along)).of(VALUE, net)
            ways = _lengths(x - point)
            best = int(np.argmin(ways))
            found[row], middle = ways[best], along[best]
            width, count = 4.0 * width / (count - 1), 9
    return found


def _border_points(patch: Patch) -> FloatArray:
    """Points on all edges."""
    return np.concatenate([_edge_of(patch, name).samples for name in EDGES])


def _gap(some: FloatArray, others: FloatArray) -> float:
    return float(np.sqrt(np.min(np.sum((some[:, None] - others[None]) ** 2, axis=2))))


def _check_numbers(patch: Patch, where: str) -> None:
    if max(patch.degrees) > DEGREES or min(patch.degrees) < 1:
        raise InputError(
            "is of a degree that shells do not have",
            where=where,
            found=tuple(patch.degrees),
            allowed=f"1 to {DEGREES}",
        )
    if not np.isfinite(patch.control_points).all():
        raise GeometryError("control points must be finite", where=where)
    if patch.weights is not None and not (np.asarray(patch.weights) > 0.0).all():
        raise GeometryError(
            "weights must be positive", where=where, found=float(np.min(patch.weights))
        )


def _check_edges(patch: Piece, near: float) -> None:
    """Refuse a pole, and any other edge along which there is no normal."""
    net = patch.control_points.reshape(-1, 3)
    for name in EDGES:
        line = rows_from(patch.control_points, name)[0]
        knots = patch.knots[1 if name[0] == "u" else 0]
        inner = knots[0] + (knots[-1] - knots[0]) * (np.arange(SAMPLES) + 0.5) / SAMPLES
        at = basis_at(patch, edge_parameters(patch, name, inner))
        a, b = at.of(U, net), at.of(V, net)
        sine = _lengths(np.cross(a, b))
        if np.abs(line - line[0]).max() <= near:
            what = "is a pole: all its control points are one"
        elif (sine <= PARALLEL * _lengths(a) * _lengths(b)).any():
            what = "is degenerate: the surface has no normal along it"
        else:
            continue
        raise InputError(
            f"edge {name} {what}",
            where=f"surfaces[{patch.patch}]",
            found=np.round(line[0], 9).tolist(),
            allowed="edges of a length, along which S_u and S_v span a plane",
            remedy="Cut it off, or cover it by patches of four sides",
        )


def _greville_points(patch: Patch) -> FloatArray:
    """(n · m, 3) points of the surface at the Greville parameters of its control points."""
    means = [
        np.array([knots[i + 1 : i + p + 1].mean() for i in range(len(knots) - p - 1)])
        for knots, p in zip(patch.knots, patch.degrees, strict=True)
    ]
    uv = np.stack(np.meshgrid(*means, indexing="ij"), axis=2).reshape(-1, 2)
    return basis_at(patch, uv).of(VALUE, patch.control_points.reshape(-1, 3))


def _edge_name(name: str) -> str:
    if name not in EDGES:
        raise InputError(
            "there is no such edge", where="edge", found=name, allowed=", ".join(EDGES)
        )
    return name


def rows_from(net: NDArray[Any], name: str) -> NDArray[Any]:
    """Rows of a net (n, m, …) parallel to an edge, from it on."""
    rows = net if name[0] == "u" else np.swapaxes(net, 0, 1)
    return rows if name[1] == "0" else rows[::-1]


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.sum(vectors * vectors, axis=-1)))


def _size(points: FloatArray) -> float:
    return float(np.sqrt(np.sum(np.ptp(points, axis=0) ** 2)))
