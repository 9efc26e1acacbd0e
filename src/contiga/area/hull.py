"""The thesis' contact area: clusters, their hulls in (u, v), and a map to space (4.5.1)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from contiga.area.cluster import check_options, clusters_of, is_positive
from contiga.area.kernels import hull_nb
from contiga.area.method import AreaInput, Areas, Outlines, Rest
from contiga.area.outline import joined
from contiga.area.polygon import area_over, closing, plane_area
from contiga.area.profile import profile_depth
from contiga.area.regions import Graph, Topology, regions, structure_of
from contiga.errors import InputError
from contiga.geometry.faces import Faces
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.tessellate import grid_mesh, net_grid
from contiga.records import FloatArray, IntArray

MAPPINGS = ("linear", "exact")
# Default tolerance of a patch's base area, as a share of the area of its control net.
BASE_TOL = 1e-3
# Points per side of a hull in outlines.
POINTS_PER_SIDE = 8


class _Patch(NamedTuple):
    """A patch and the figures that the mappings need."""

    surface: NurbsSurface
    periods: tuple[float, float]
    domain_area: float
    """In (u, v)."""


@dataclass(frozen=True)
class HullArea:
    """Area of the convex hull of the feet in (u, v), one for each cluster, shared equally.

    Parameters
    ----------
    clusters : "auto": regions joined over facets, or over neighbours in space. A number: k-means
        with that many. "kmeans", "dbscan", "meanshift", "hdbscan": by scikit-learn, in (u, v)
        scaled to the unit square as in the thesis; in space where the feet are on several patches
    mapping : "linear": Eq. 4.10, hull over domain times the patch's base area. "exact":
        `∫ |S_u × S_v| du dv` over the hull
    k : clusters of k-means; as many as points where those are fewer
    eps : radius of DBSCAN > 0, in the unit square (a length on several patches)
    min_points : P_min of DBSCAN, or the least size of a cluster of HDBSCAN
    tolerance : largest Σ|A_net − A_base| (Eq. 4.8), area; a thousandth of each patch if omitted

    Raises
    ------
    InputError
        An unknown method or mapping, k < 1, eps ≤ 0, a tolerance that is not positive.
    MissingPackageError
        A method of scikit-learn, which is not installed.

    Notes
    -----
    The area is the master's, whatever the contact type. A hull covers holes and hollows of its
    cluster, and misses half a spacing around it. A cluster on several patches has one hull on
    each, and the hulls' areas are added; across a seam (u, v) is unrolled first. Points that
    DBSCAN or HDBSCAN calls noise have no area, and cluster −1. On a body made by
    `Body.from_profile`, points in its plane stand for its whole depth.

    Examples
    --------
    >>> import contiga as cg
    >>> plane = cg.Body([cg.shapes.plane(width=10.0, length=10.0)])
    >>> cloud = cg.Slave([[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    >>> contact = cg.Contact(plane, cloud, law=cg.PenaltyLaw(1.0), area=cg.HullArea())
    >>> state = contact.start(cloud.points)
    >>> round(contact.step(state, cloud.points - [0.0, 0.0, 1.5]).total_area, 9)
    2.0
    """

    clusters: str | int = "auto"
    _: KW_ONLY
    mapping: str = "linear"
    k: int = 2
    eps: float = 0.1
    min_points: int = 4
    tolerance: float | None = None

    def __post_init__(self) -> None:
        if self.mapping not in MAPPINGS:
            raise InputError(
                "unknown mapping", where="mapping", found=self.mapping, allowed='"linear", "exact"'
            )
        check_options(self.clusters, self.k, self.eps, self.min_points)
        if self.tolerance is not None and not is_positive(self.tolerance):
            raise InputError(
                "a tolerance must be positive",
                where="tolerance",
                found=self.tolerance,
                allowed="an area > 0",
            )

    def prepare(self, rest: Rest) -> Topology | Graph | None:
        """Return the connectivity of the slave's points for `clusters` "auto"; None for others."""
        return structure_of(rest) if self.clusters == "auto" else None

    def measure(self, inp: AreaInput) -> Areas:
        """Return the areas of the points in contact, on the master; 0 and cluster −1 for noise.

        The area of a cluster, by its hull on each patch, is shared equally among its points.
        """
        if len(inp.rows) == 0:
            return Areas(np.zeros(0), np.zeros(0, np.int32), "master")
        label = self._clusters(inp)
        totals = np.zeros(int(label.max()) + 1)
        for cluster, k, patch, polygon in _hulls(inp, label):
            if self.mapping == "exact":
                totals[cluster] += area_over(patch.surface, polygon, patch.periods)
            else:
                base = _base_area(inp.exact, k, self.tolerance)
                totals[cluster] += plane_area(polygon) / patch.domain_area * base
        rows, area = np.flatnonzero(label >= 0), np.zeros(len(label))
        area[rows] = (totals / np.bincount(label[rows], minlength=len(totals)))[label[rows]]
        return Areas(area, label, "master")

    def _clusters(self, inp: AreaInput) -> IntArray:
        """Return the cluster (n_c,) of each point in contact, −1 for noise.

        Feet on one patch are clustered in its (u, v), scaled to the unit square; on several, in
        space.
        """
        if self.clusters == "auto":
            return regions(inp.prepared, inp.rows, inp.points)
        points = inp.feet.point
        if (inp.feet.patch == inp.feet.patch[0]).all():
            (u0, u1), (v0, v1) = inp.exact.patches[int(inp.feet.patch[0])].domain
            points = (inp.feet.uv - (u0, v0)) / (u1 - u0, v1 - v0)
        if isinstance(self.clusters, str):
            method, k = self.clusters, self.k
        else:
            method, k = "kmeans", self.clusters
        return clusters_of(points, method, k=k, eps=self.eps, min_points=self.min_points)

    def outlines(self, inp: AreaInput) -> Outlines:
        """Return the hulls, as they lie on the master; none with fewer than three corners."""
        lines, clusters = [], []
        label = self._clusters(inp) if len(inp.rows) else np.zeros(0, np.int32)
        t = np.arange(POINTS_PER_SIDE)[:, None] / POINTS_PER_SIDE
        for cluster, _, patch, polygon in _hulls(inp, label):
            if len(polygon) < 3:
                continue
            sides = zip(polygon, np.roll(polygon, -1, axis=0), strict=True)
            uv = np.concatenate([a + t * (b - a) for a, b in sides])
            for axis, (low, high) in enumerate(patch.surface.domain):
                if patch.periods[axis] > 0.0:
                    uv[:, axis] = low + np.mod(uv[:, axis] - low, patch.periods[axis])
                uv[:, axis] = np.clip(uv[:, axis], low, high)
            lines.append(patch.surface.evaluate(uv))
            clusters.append(cluster)
        return joined(lines, clusters)


def _hulls(inp: AreaInput, label: IntArray) -> Iterator[tuple[int, int, _Patch, FloatArray]]:
    """Yield hulls in (u, v), one for each cluster and patch: both numbers, the patch, the corners.

    Corners (k, 2) are anticlockwise; k is 1 or 2 for feet at one point or on a line. Noise, `label`
    −1, has no hull. Feet in the plane of a profile are spread over its depth first.
    """
    for cluster in range(int(label.max(initial=-1)) + 1):
        rows = np.flatnonzero(label == cluster)
        for k in np.unique(inp.feet.patch[rows]):
            patch = patch_of(inp.exact, int(k))
            uv = unrolled(inp.feet.uv[rows[inp.feet.patch[rows] == k]], patch.periods)
            depth = profile_depth(inp.exact)
            if depth is not None and np.abs(uv[:, 1]).max() <= 1e-9 * depth:
                half = np.array([0.0, 0.5 * depth])
                uv = np.concatenate([uv - half, uv + half])
            yield cluster, int(k), patch, hull_of(uv)


def hull_of(points: FloatArray) -> FloatArray:
    """Return the corners (h, 2) of the convex hull of points (n, 2), anticlockwise.

    There are one or two where it has no area, none without points.
    """
    return points[hull_nb.jarvis(np.ascontiguousarray(points, dtype=np.float64))]


def unrolled(uv: FloatArray, periods: tuple[float, float]) -> FloatArray:
    """Return (n, 2) parameters without a jump at a seam, as a copy.

    In a direction with a period the widest gap is the cut: values below it move up by the period.
    """
    out = uv.copy()
    for axis, period in enumerate(periods):
        if period == 0.0 or len(uv) < 2:
            continue
        order = np.sort(uv[:, axis])
        gaps = np.append(np.diff(order), order[0] + period - order[-1])
        widest = int(np.argmax(gaps))
        if widest < len(order) - 1:
            out[uv[:, axis] <= order[widest], axis] += period
    return out


_PATCHES: WeakKeyDictionary[Faces, dict[int, _Patch]] = WeakKeyDictionary()
_BASES: WeakKeyDictionary[Faces, dict[tuple[int, float | None], float]] = WeakKeyDictionary()


def patch_of(body: Faces, k: int) -> _Patch:
    """Return the cached figures of patch `k` of a body."""
    cache = _PATCHES.setdefault(body, {})
    if k not in cache:
        surface = body.patches[k]
        (u0, u1), (v0, v1) = surface.domain
        cache[k] = _Patch(surface, closing(surface), (u1 - u0) * (v1 - v0))
    return cache[k]


def _base_area(body: Faces, k: int, tolerance: float | None) -> float:
    """Return the cached area of patch `k` by the mesh of the thesis (Eq. 4.8)."""
    cache = _BASES.setdefault(body, {})
    if (k, tolerance) not in cache:
        surface = body.patches[k]
        tol = BASE_TOL * surface.net_area() if tolerance is None else tolerance
        mesh = grid_mesh(surface, *net_grid(surface, tol))
        cache[k, tolerance] = float(mesh.area())
    return cache[k, tolerance]
