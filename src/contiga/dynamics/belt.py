"""A belt laid along a routed path: its nodes, elements, rest lengths, and what holds its ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from contiga.arrays.layout import checked_choice, positive
from contiga.curves.characteristic import CurveLike
from contiga.dynamics.belt_devices import Devices, LoadLimiter, Pretensioner, Retractor
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.springs import Spread, Spring
from contiga.errors import InputError
from contiga.matter.coefficients import Material
from contiga.matter.materials import Elastic
from contiga.matter.woven import Belt as Webbing
from contiga.patches.splines import Splines
from contiga.records import FloatArray, IntArray
from contiga.routing.path import MAX_MOVES, Path
from contiga.slaves.slave import Slave
from contiga.slaves.strip import Strip

KINDS = ("bars", "ribbon", "membrane")
LIFT = 1e-7
"""Height of a belt above a surface as a share of its path, so that its nodes start outside."""
OVERSHOOT = 1.1
"""Factor on the missing clearance by which a membrane is raised."""
SMOOTHING_WIDTHS, SMOOTHING_POINTS = 3.0, 15
"""Widths of a belt over which its normal is averaged, and number of normals in this mean."""
MIN_COSINE = 0.2
"""Lower bound of the cosine between the normals of body and belt that a lift is divided by."""
GROUND, FREE = "ground", "free"
"""Anchors other than bodies."""
ENDS = "start", "end"
STRAIGHT_TOL = 1e-6
"""Share of its length by which the chord of the webbing at an end may be shorter: the webbing is
one straight spring."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BeltEnd:
    """Webbing between an anchor and the first row of nodes of a belt, with the devices at it.

    It is a spring with one tension, which can be reeled in, paid out and pulled through a slip
    ring, unlike the nodes of a belt.

    Parameters
    ----------
    length : length of path that it replaces, > 0; at least the length ever pulled in at this end
    curve : force over elongation; that of the belt's material if omitted, for bars only
    unloading, hysteresis_slope, filter : as in `Spring`
    retractor, limiter, pretensioner, release : as in `Spring`

    Raises
    ------
    InputError
        A length that is not positive, an unloading without a curve.

    Examples
    --------
    >>> from contiga.belts import BeltEnd, LoadLimiter
    >>> BeltEnd(length=200.0, limiter=LoadLimiter(4000.0)).devices.limiter.force.tolist()
    [4000.0]
    """

    length: float
    curve: CurveLike | None = None
    unloading: CurveLike | None = None
    hysteresis_slope: float | None = None
    filter: str | None = None
    retractor: Retractor | None = None
    limiter: LoadLimiter | None = None
    pretensioner: Pretensioner | None = None
    release: str | None = None

    def __post_init__(self) -> None:
        positive(self.length, "length")
        if self.curve is None and (self.unloading, self.hysteresis_slope) != (None, None):
            raise InputError("is missing: an unloading needs it", where="curve")

    @property
    def devices(self) -> Devices:
        """The devices at its anchor."""
        return Devices(self.retractor, self.limiter, self.pretensioner, self.release)


@dataclass(frozen=True, kw_only=True, eq=False)
class Belt:
    """A belt along a `Path`: bars, or a membrane of triangles or of one NURBS patch.

    The nodes are evenly spaced along the path, and the width of a membrane is tangent to the
    bodies. A membrane at rest lies flat along x, with its width along y: the warp of a `Fabric`
    along the belt is ``direction=[1, 0, 0]``.

    Parameters
    ----------
    path : from `contiga.route`
    material : `contiga.materials.Belt` or `Elastic` for bars; `Fabric`, `Elastic` or another
        material of membranes for the other kinds
    density : mass over volume, > 0
    width, thickness : length, > 0; their product is the cross-section of bars
    kind : "bars", "ribbon" of triangles, or "membrane", a patch of degree 2 without bending
        stiffness
    segments : number of elements along the belt
    across : number of elements across a ribbon or membrane
    shortening : 1 − length at rest over length of the path, 0 ≤ shortening < 1: the strain at the
        start is shortening/(1 − shortening)
    anchors : supports of the start and of the end: "ground", the name of a body, or "free" for an
        end without support or on springs of your own
    start, end : webbing and devices between an anchor and the nodes; see `Belt.springs`
    velocity : (3,) velocity of the nodes at the start, world axes
    damping : α of a force −α m v on each node, 1/time
    name : name in messages and results

    Raises
    ------
    InputError
        A width, thickness or density that is not positive, fewer than one element, a shortening
        outside its range, an unknown kind; webbing at a free end, longer than the path, or not
        straight.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
    >>> path = cg.route(ball, [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], via=[[0.0, 0.0, 1.5]])
    >>> webbing = cg.materials.Belt(loading=100.0)
    >>> belt = cg.Belt(
    ...     path=path, material=webbing, density=1.0, width=0.2, thickness=0.01, segments=40
    ... )
    >>> len(belt.slave), belt.ends[1].tolist()
    (41, [40])
    """

    path: Path
    material: Material
    density: float
    width: float
    thickness: float
    kind: str = "bars"
    segments: int = 40
    across: int = 4
    shortening: float = 0.0
    anchors: tuple[str, str] = (GROUND, GROUND)
    start: BeltEnd | None = None
    end: BeltEnd | None = None
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    damping: float = 0.0
    name: str = "belt"

    def __post_init__(self) -> None:
        checked_choice("kind", self.kind, KINDS)
        for key in ("density", "width", "thickness"):
            positive(getattr(self, key), key)
        for key in ("segments", "across"):
            if not (isinstance(getattr(self, key), int) and getattr(self, key) >= 1):
                raise InputError(
                    "must be a whole number",
                    where=key,
                    found=getattr(self, key),
                    allowed="1 or more",
                )
        if not 0.0 <= self.shortening < 1.0:
            raise InputError(
                "must be a share of the length", where="shortening", found=self.shortening,
                allowed="0 ≤ shortening < 1",
            )  # fmt: skip
        path_length, span = self.path.length, self._span
        if not span[0] < span[1]:
            raise InputError(
                "the webbing at its ends leaves nothing of the belt between",
                where="start.length",
                found=[end.length for end in (self.start, self.end) if end is not None],
                allowed=f"a sum below the length of the path, {path_length:.6g}",
            )
        wraps = self.path.wraps
        for name, end, anchor, tips in zip(
            ENDS,
            (self.start, self.end),
            self.anchors,
            ((0.0, span[0]), (path_length, span[1])),
            strict=True,
        ):
            if end is None:
                continue
            if anchor == FREE:
                raise InputError(
                    "webbing needs a support at its anchor",
                    where=f"anchors[{ENDS.index(name)}]",
                    found=FREE,
                    allowed=f'"{GROUND}" or a body, or no webbing at its {name}',
                )
            anchor_point, row_point = self.path.at(list(tips))
            if np.linalg.norm(row_point - anchor_point) < (1.0 - STRAIGHT_TOL) * end.length:
                free_length = wraps[0].start if name == "start" else path_length - wraps[-1].end
                raise InputError(
                    "this webbing would lie on a body, but it must be straight",
                    where=f"{name}.length",
                    found=end.length,
                    allowed=f"up to {free_length:.6g}, where the path meets the body",
                )

    @property
    def _span(self) -> tuple[float, float]:
        """Arc lengths of the path at the first and at the last row of nodes."""
        before, after = (0.0 if end is None else end.length for end in (self.start, self.end))
        return before, self.path.length - after

    @property
    def laid_length(self) -> float:
        """Length of the path between the first and the last row of nodes."""
        return self._span[1] - self._span[0]

    @cached_property
    def slave(self) -> Slave:
        """The slave: nodes along the path, row by row across the belt, just above the bodies.

        Bars are a cloud whose nodes have the area of their lengths of webbing; a ribbon has two
        facets a cell, which face away from the bodies; a membrane is a slave of splines.
        """
        if self.kind == "membrane":
            patch = self._strip.through(self._rows_of_strip)
            return Slave(surfaces=patch, thickness=self.thickness, name=self.name)
        points, rows = self._points, self._rows
        if self.kind == "bars":
            share = np.full(len(points), self.laid_length / self.segments)
            share[[0, -1]] *= 0.5
            lines = np.stack([rows[:-1, 0], rows[1:, 0]], axis=1)
            return Slave(
                points, area=self.width * share, thickness=self.thickness, name=self.name,
                elements={"line": lines},
            )  # fmt: skip
        a, b, c, d = rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]
        # Alternating diagonals: the ribbon is equally stiff towards both sides.
        is_odd = (np.indices(a.shape).sum(axis=0) % 2 == 1)[..., None, None]
        cut_a_c = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=-2)
        cut_b_d = np.stack([np.stack([a, b, d], -1), np.stack([b, c, d], -1)], axis=-2)
        facets = np.where(is_odd, cut_a_c, cut_b_d).reshape(-1, 3)
        return Slave(points, facets, thickness=self.thickness, name=self.name)

    @cached_property
    def motion(self) -> Deforming:
        """The motion: a slave that deforms by the forces of its elements.

        Nodes of an end without webbing are fixed at "ground", or attached to the body of its
        anchor; an end with webbing, or "free", is held by springs only.
        """
        ends = [
            (anchor if end is None else FREE, rows)
            for anchor, end, rows in zip(
                self.anchors, (self.start, self.end), self.ends, strict=True
            )
        ]
        fixed: list[dict[str, Any]] = [{"nodes": rows} for at, rows in ends if at == GROUND]
        carried = [{"nodes": rows, "body": at} for at, rows in ends if at not in (GROUND, FREE)]
        is_bars = self.kind == "bars"
        return Deforming(
            material=self.material,
            density=self.density,
            section=self.width * self.thickness if is_bars else None,
            thickness=None if is_bars else self.thickness,
            bending=0.0 if self.kind == "membrane" else 1.0,
            fixed=fixed or None,
            attached=carried or None,
            velocity=self.velocity,
            damping=self.damping,
            rest=self._rest,
        )

    @property
    def springs(self) -> dict[str, Spring]:
        """Springs of the webbing at the ends, by name: "<belt> start" and "<belt> end".

        Each goes from its anchor to the row of nodes at the end, which shares its force by
        tributary width. An end without webbing has none.

        Raises
        ------
        InputError
            A curve that webbing cannot have, or no curve where the material gives none.
        """
        springs = {}
        anchor_points = self.path.points[[0, -1]]
        for name, end, anchor, anchor_point, rows in zip(
            ENDS, (self.start, self.end), self.anchors, anchor_points, self.ends, strict=True
        ):
            if end is None:
                continue
            shares = np.ones(len(rows))
            if len(rows) > 1:  # proportional to the tributary widths
                shares[[0, -1]] = 0.5
            spread = Spread(rows, shares / shares.sum())
            spring_name = f"{self.name} {name}"
            springs[spring_name] = Spring(
                (anchor, self.name),
                at=np.array([anchor_point, spread.shares @ self.slave.points[rows]]),
                **self._webbing(name, end),
                length=(1.0 - self.shortening) * end.length,
                name=spring_name,
                filter=end.filter,
                retractor=end.retractor,
                limiter=end.limiter,
                pretensioner=end.pretensioner,
                release=end.release,
                spread=(None, spread),
            )
        return springs

    def _webbing(self, name: str, end: BeltEnd) -> dict[str, Any]:
        """Return the curves of the webbing at an end, as arguments of `Spring`.

        Keys are "curve", "unloading" and "hysteresis_slope", or "curve" alone, the stiffness, for
        bars of `Elastic`. They are the end's own, or the material's with strain turned into
        elongation. An `InputError` is raised if neither has one: membranes and ribbons of other
        materials.
        """
        if end.curve is not None:
            keys = "curve", "unloading", "hysteresis_slope"
            return {key: getattr(end, key) for key in keys}
        material, length = self.material, (1.0 - self.shortening) * end.length
        if isinstance(material, Webbing):
            to_elongation = [length, 1.0]  # rows of strain and force
            unloading, slope = material.unloading, material.hysteresis_slope
            return {
                "curve": np.asarray(material.loading) * to_elongation,
                "unloading": None if unloading is None else np.asarray(unloading) * to_elongation,
                "hysteresis_slope": None if slope is None else slope / length,
            }
        if isinstance(material, Elastic) and self.kind == "bars":
            return {"curve": material.young * self.width * self.thickness / length}
        raise InputError(
            "is missing: force over elongation of the webbing at this end",
            where=f"{name}.curve",
            allowed="a stiffness or a table; bars of material belt or elastic need none",
        )

    @property
    def ends(self) -> tuple[IntArray, IntArray]:
        """Nodes (k,) of its start and of its end, each across the belt.

        For a membrane they are the surface nodes on the edges "u0" and "u1" of its patch.
        """
        if self.kind == "membrane":
            surfaces = self.slave.surfaces
            assert surfaces is not None
            return surfaces.edge("u0"), surfaces.edge("u1")
        return self._rows[0], self._rows[-1]

    @property
    def rest_length(self) -> float:
        """Length of the belt at zero force, including the webbing at its ends."""
        return (1.0 - self.shortening) * self.path.length

    @cached_property
    def _rows(self) -> IntArray:
        """Numbers (segments + 1, nodes across) of the nodes."""
        nodes_across = 1 if self.kind == "bars" else self.across + 1
        count = (self.segments + 1) * nodes_across
        return np.arange(count, dtype=np.int32).reshape(-1, nodes_across)

    @cached_property
    def _offsets(self) -> FloatArray:
        """Signed distances (nodes across,) of nodes from the middle of the belt.

        For a membrane they are distances of control points.
        """
        if self.kind == "bars":
            return np.zeros(1)
        if self.kind == "membrane":
            return self.width * (self._strip.greville_v - 0.5)
        return np.linspace(-0.5 * self.width, 0.5 * self.width, self.across + 1)

    @cached_property
    def _points(self) -> FloatArray:
        """Nodes (n, 3) of bars and ribbons."""
        arc = np.linspace(*self._span, self.segments + 1)
        return self._laid(arc, LIFT * self.path.length).reshape(-1, 3)

    @property
    def _strip(self) -> Strip:
        """The spline patch of a membrane."""
        return Strip(self.segments, self.across)

    @cached_property
    def _rows_of_strip(self) -> FloatArray:
        """Rows (n, k, 3) of points along the path that the patch of a membrane interpolates.

        All are raised by the same gap, until the patch's nodes are all outside the bodies by `LIFT`
        times the length of the path, or after `MAX_MOVES` passes.
        """
        start, end = self._span
        arc = start + (end - start) * self._strip.greville_u
        min_gap = gap = LIFT * self.path.length
        for _ in range(MAX_MOVES):
            rows = self._laid(arc, gap)
            nodes = Splines.of(self._strip.through(rows)).points
            shortage = min_gap - self.path.over.clearances(nodes).gap.min()
            if shortage <= 0.0:
                break
            gap += OVERSHOOT * shortage
        return rows

    def _laid(self, arc: FloatArray, gap: float) -> FloatArray:
        """Return straight rows (n, k, 3) across the path at arc lengths (n,), above the bodies.

        The rows of bars are single points, k = 1. Others bridge a body that is concave across the
        path, as in a crease. Points are at least `gap` above the bodies, within the passes of
        `_lift`. An `InputError` is raised if the path of a ribbon or membrane runs along the normal
        of the nearest body, where it has no direction across.
        """
        normal, step = self._normals(arc), 0.5 * self.laid_length / self.segments
        middle = self.path.at(arc)
        ahead, behind = (np.clip(arc + x, 0.0, self.path.length) for x in (step, -step))
        tangent = self.path.at(ahead) - self.path.at(behind)
        # In this order the facets face away from the bodies.
        across = np.cross(normal, tangent)
        norms = np.linalg.norm(across, axis=1)
        if self.kind != "bars" and not (norms > 1e-6 * step).all():
            raise InputError(
                f"a {self.kind} cannot run straight towards a body",
                where=f"{self.name}: path",
                found=middle[int(np.argmin(norms))].tolist(),
                allowed="a path that passes beside the nearest body",
                remedy="Move the end aside, or use bars",
            )
        across /= np.maximum(norms, 1e-300)[:, None]
        rows = middle[:, None] + self._offsets[None, :, None] * across[:, None]
        if self.kind == "bars":
            return self.path.outside(rows[:, 0], gap)[:, None]
        return rows + self._lift(rows, normal, gap)[:, None]

    def _normals(self, arc: FloatArray) -> FloatArray:
        """Return unit normals (n, 3) of the belt at arc lengths (n,).

        Of bars, or of a path that touches nothing, they are the path's. Otherwise they are the
        normals of the bodies below it, interpolated between two bodies, and averaged over
        `SMOOTHING_WIDTHS` widths: a belt that twists faster is stretched by more than one per cent
        at its edges.
        """
        path = self.path
        on_body = np.flatnonzero(path.body >= 0)
        if self.kind == "bars" or len(on_body) == 0:
            return path.normal_at(arc)
        window = SMOOTHING_WIDTHS * self.width * np.linspace(-0.5, 0.5, SMOOTHING_POINTS)
        at = (arc[:, None] + window).ravel()
        columns = [np.interp(at, path.arc[on_body], axis) for axis in path.normal[on_body].T]
        normals = np.stack(columns, axis=1).reshape(len(arc), SMOOTHING_POINTS, 3).mean(axis=1)
        return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])

    def _lift(self, rows: FloatArray, normal: FloatArray, gap: float) -> FloatArray:
        """Return displacements (n, 3) of rows (n, k, 3) along normals (n, 3) out of bodies.

        They are smoothed over the belt's width, and put all nodes, and the middles of the edges of
        a ribbon's facets, at least `gap` outside, unless `MAX_MOVES` passes do not suffice.
        """
        lift = np.zeros(len(rows))
        for _ in range(MAX_MOVES):
            lifted = rows + (lift[:, None] * normal)[:, None]
            shortage = self._shortage(lifted, normal, gap)
            if self.kind == "ribbon":
                first, second = lifted[:-1], lifted[1:]
                sums = first + second, first[:, 1:] + second[:, :-1], first[:, :-1] + second[:, 1:]
                edge_middles = 0.5 * np.concatenate(sums, axis=1)
                of_edges = self._shortage(edge_middles, normal[1:], gap)
                shortage[1:] = np.maximum(shortage[1:], of_edges)
                shortage[:-1] = np.maximum(shortage[:-1], of_edges)
            if not shortage.any():
                break
            lift += shortage
        # The mean of running maxima over the same window is never below the values themselves.
        size = 2 * round(0.5 * self.width * self.segments / self.laid_length) + 1
        smooth = uniform_filter1d(maximum_filter1d(lift, size), size)
        return np.asarray(smooth[:, None] * normal)

    def _shortage(self, rows: FloatArray, normal: FloatArray, gap: float) -> FloatArray:
        """Return the lengths (n,) that rows (n, k, 3) lack along normals to be `gap` outside.

        A length is the largest of its row, to first order: the missing clearance over the cosine
        between the normals of belt and body, at least `MIN_COSINE`.
        """
        nearest = self.path.over.clearances(np.ascontiguousarray(rows.reshape(-1, 3)))
        shortage = np.maximum(gap - nearest.gap, 0.0).reshape(rows.shape[:2])
        cosine = np.abs((nearest.normal.reshape(rows.shape) * normal[:, None]).sum(axis=2))
        return np.asarray((shortage / np.maximum(cosine, MIN_COSINE)).max(axis=1))

    @cached_property
    def _rest(self) -> FloatArray:
        """Nodes (n, 3) at rest, or control points of a membrane, flat and along x.

        The distance of two rows is the mean distance of their nodes, times 1 − shortening.
        """
        if self.kind == "membrane":
            return self._strip.flat(self._rows_of_strip, self.width, 1.0 - self.shortening)
        rows = self._points.reshape(self.segments + 1, -1, 3)
        chords = np.linalg.norm(np.diff(rows, axis=0), axis=2).mean(axis=1)
        x = (1.0 - self.shortening) * np.concatenate([[0.0], np.cumsum(chords)])
        rest = np.zeros((*self._rows.shape, 3))
        rest[:, :, 0], rest[:, :, 1] = x[:, None], self._offsets
        return rest.reshape(-1, 3)
