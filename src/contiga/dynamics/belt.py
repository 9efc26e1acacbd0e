"""A belt laid along a routed path: its nodes, elements, rest lengths, and what holds its ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from contiga.arrays.layout import one_of, positive
from contiga.dynamics.belt_devices import Devices, LoadLimiter, Pretensioner, Retractor
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.springs import Spread, Spring
from contiga.errors import InputError
from contiga.laws.characteristic import CurveLike
from contiga.matter.coefficients import Material
from contiga.matter.materials import Elastic
from contiga.matter.woven import Belt as Webbing
from contiga.patches.splines import Splines
from contiga.records import FloatArray, IntArray
from contiga.routing.path import MOVES, Path
from contiga.slaves.slave import Slave
from contiga.slaves.strip import Strip

KINDS = ("bars", "ribbon", "membrane")
LIFT = 1e-7
"""Share of its length that a belt is laid above a surface, for its nodes to enter it."""
SPARE = 1.1
"""Factor on what nodes of a membrane lack, as it is raised."""
TWIST, AROUND = 3.0, 15
"""Widths of a belt along which its normal is the mean of so many of the bodies'."""
STEEP = 0.2
"""Cosine of a body's normal and the belt's from which on moves off the body are no longer."""
GROUND, FREE = "ground", "free"
"""Anchors that are no body."""
ENDS = "start", "end"
STRAIGHT = 1e-6
"""Share of the length of the webbing at an end by which it may bend: it is one straight spring."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BeltEnd:
    """Webbing between an anchor and the first row of nodes of a belt, with the devices at it.

    A spring with one tension, which may be reeled in, paid out and slip through a ring, where the
    nodes of a belt cannot go.

    Parameters
    ----------
    length : length of the path that it takes, at least as long as what is ever pulled in there
    curve : force over elongation; that of the belt's material if omitted, which is for bars
    unloading, hysteresis_slope, filter : as of a `Spring`
    retractor, limiter, pretensioner, release : as of a `Spring`

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
            raise InputError("is missing: an unloading was given", where="curve")

    @property
    def devices(self) -> Devices:
        """Devices at its anchor."""
        return Devices(self.retractor, self.limiter, self.pretensioner, self.release)


@dataclass(frozen=True, kw_only=True, eq=False)
class Belt:
    """A belt along a `Path`: bars, or a membrane whose width is tangent to the bodies, of triangles
    or of one NURBS patch.

    The nodes of the belt are evenly spaced along the path. A membrane at rest lies flat, along x,
    with its width along y: the warp of a `Fabric` along the belt is ``direction=[1, 0, 0]``.

    Parameters
    ----------
    path : from `contiga.route`
    material : of bars `contiga.materials.Belt` or `Elastic`, of the others `Fabric`, `Elastic` or
        another of membranes
    density : mass over volume
    width, thickness : length; of bars their product is the section
    kind : "bars", "ribbon" of triangles, or "membrane", a patch of degree 2 without stiffness in
        bending
    segments : elements along the belt
    across : elements across a ribbon or membrane
    shortening : share of its length that the belt is shorter at rest than the path: its strain at
        the start is shortening/(1 − shortening)
    anchors : what holds its start and its end: "ground", the name of a body, or "free", for springs
        that end there
    start, end : webbing and devices between that and its nodes; `Belt.springs` are these
    velocity : (3,) of its nodes at the start
    damping : α of a force −α m v on each node, 1/time
    name : what messages and results call it

    Raises
    ------
    InputError
        A width, thickness or density that is not positive, fewer than one element, a shortening
        outside 0 to 1, an unknown kind; webbing at an end that is held by nothing, longer than the
        path, or not straight.

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
        one_of("kind", self.kind, KINDS)
        for key in ("density", "width", "thickness"):
            positive(getattr(self, key), key)
        for key in ("segments", "across"):
            if not (isinstance(getattr(self, key), int) and getattr(self, key) >= 1):
                raise InputError(
                    "must be a whole number", where=key, found=getattr(self, key), allowed="≥ 1"
                )
        if not 0.0 <= self.shortening < 1.0:
            raise InputError(
                "is a share of the length", where="shortening", found=self.shortening,
                allowed="0 up to, not including, 1",
            )  # fmt: skip
        self._check_ends()

    def _check_ends(self) -> None:
        """Refuse webbing at an end that nothing holds, or that is no straight part of the path."""
        whole, span = self.path.length, self._span
        if not span[0] < span[1]:
            raise InputError(
                "the webbing at its ends leaves nothing of the belt between",
                where="start.length",
                found=[end.length for end in (self.start, self.end) if end is not None],
                allowed=f"less in all than the path, which is {whole:.6g} long",
            )
        for name, end, anchor, near, far in zip(
            ENDS, (self.start, self.end), self.anchors, (0.0, whole), span, strict=True
        ):
            if end is None:
                continue
            if anchor == FREE:
                raise InputError(
                    "webbing that ends at nothing holds nothing",
                    where=f"anchors[{ENDS.index(name)}]",
                    found=FREE,
                    allowed=f'"{GROUND}" or a body, or no webbing at its {name}',
                )
            between = self.path.at([near, far])
            if np.linalg.norm(between[1] - between[0]) < (1.0 - STRAIGHT) * end.length:
                raise InputError(
                    "this webbing would lie on a body, and is to be straight",
                    where=f"{name}.length",
                    found=end.length,
                    allowed=f"up to {self._free_length(name):.6g}, where the path meets it",
                )

    def _free_length(self, end: str) -> float:
        """Length of the path from an end to where it first lies on a body."""
        wraps = self.path.wraps
        return wraps[0].start if end == "start" else self.path.length - wraps[-1].end

    @property
    def _span(self) -> tuple[float, float]:
        """Arc lengths of the path between which the nodes of the belt lie."""
        before, after = (0.0 if end is None else end.length for end in (self.start, self.end))
        return before, self.path.length - after

    @property
    def laid_length(self) -> float:
        """Length of the path between its first and its last row of nodes."""
        return self._span[1] - self._span[0]

    @cached_property
    def slave(self) -> Slave:
        """The nodes of the belt, row by row across it, where the path lies."""
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
        # Diagonals cross, so that the ribbon is no stiffer towards one side.
        odd = (np.indices(a.shape).sum(axis=0) % 2 == 1)[..., None, None]
        one = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=-2)
        other = np.stack([np.stack([a, b, d], -1), np.stack([b, c, d], -1)], axis=-2)
        facets = np.where(odd, one, other).reshape(-1, 3)
        return Slave(points, facets, thickness=self.thickness, name=self.name)

    @cached_property
    def motion(self) -> Deforming:
        """How the belt moves: by the forces of its elements."""
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
        """Webbing between its anchors and its nodes, by name: "<belt> start" and "<belt> end".

        Raises
        ------
        InputError
            A curve that is no webbing's, or missing where the material has none for it.
        """
        springs = {}
        spots = self.path.points[[0, -1]]
        for name, end, anchor, spot, rows in zip(
            ENDS, (self.start, self.end), self.anchors, spots, self.ends, strict=True
        ):
            if end is None:
                continue
            shares = np.ones(len(rows))
            if len(rows) > 1:  # by the widths of the elements beside them
                shares[[0, -1]] = 0.5
            spread = Spread(rows, shares / shares.sum())
            called = f"{self.name} {name}"
            springs[called] = Spring(
                (anchor, self.name),
                at=np.array([spot, spread.shares @ self.slave.points[rows]]),
                **self._webbing(name, end),
                length=(1.0 - self.shortening) * end.length,
                name=called,
                filter=end.filter,
                retractor=end.retractor,
                limiter=end.limiter,
                pretensioner=end.pretensioner,
                release=end.release,
                spread=(None, spread),
            )
        return springs

    def _webbing(self, name: str, end: BeltEnd) -> dict[str, Any]:
        """Curves of the webbing at an end, as `Spring` takes them."""
        if end.curve is not None:
            keys = "curve", "unloading", "hysteresis_slope"
            return {key: getattr(end, key) for key in keys}
        material, length = self.material, (1.0 - self.shortening) * end.length
        if isinstance(material, Webbing):
            per_length = [length, 1.0]
            lower, slope = material.unloading, material.hysteresis_slope
            return {
                "curve": np.asarray(material.loading) * per_length,
                "unloading": None if lower is None else np.asarray(lower) * per_length,
                "hysteresis_slope": None if slope is None else slope / length,
            }
        if isinstance(material, Elastic) and self.kind == "bars":
            return {"curve": material.young * self.width * self.thickness / length}
        raise InputError(
            "is missing: the force over the elongation of the webbing there",
            where=f"{name}.curve",
            allowed="a stiffness or a table; bars of the material belt or elastic need none",
        )

    @property
    def ends(self) -> tuple[IntArray, IntArray]:
        """Nodes of its start and of its end."""
        if self.kind == "membrane":
            surfaces = self.slave.surfaces
            assert surfaces is not None
            return surfaces.edge("u0"), surfaces.edge("u1")
        return self._rows[0], self._rows[-1]

    @property
    def rest_length(self) -> float:
        """Length of the belt without force, with the webbing at its ends."""
        return (1.0 - self.shortening) * self.path.length

    @cached_property
    def _rows(self) -> IntArray:
        """(segments + 1, nodes across) numbers of the nodes."""
        wide = 1 if self.kind == "bars" else self.across + 1
        count = (self.segments + 1) * wide
        return np.arange(count, dtype=np.int32).reshape(-1, wide)

    @cached_property
    def _offsets(self) -> FloatArray:
        """(nodes across,) from the middle of the belt; of a membrane control points."""
        if self.kind == "bars":
            return np.zeros(1)
        if self.kind == "membrane":
            return self.width * (self._strip.beside - 0.5)
        return np.linspace(-0.5 * self.width, 0.5 * self.width, self.across + 1)

    @cached_property
    def _points(self) -> FloatArray:
        """(n, 3) nodes of bars and ribbons."""
        arc = np.linspace(*self._span, self.segments + 1)
        return self._laid(arc, LIFT * self.path.length).reshape(-1, 3)

    @property
    def _strip(self) -> Strip:
        return Strip(self.segments, self.across)

    @cached_property
    def _rows_of_strip(self) -> FloatArray:
        """(n, k, 3) rows that the patch of a membrane goes through: on the path, so far above the
        bodies that its nodes between are outside."""
        start, end = self._span
        arc = start + (end - start) * self._strip.along
        least = gap = LIFT * self.path.length
        for _ in range(MOVES):
            rows = self._laid(arc, gap)
            nodes = Splines.of(self._strip.through(rows)).points
            short = least - self.path.over.clearances(nodes).gap.min()
            if short <= 0.0:
                break
            gap += SPARE * short
        return rows

    def _laid(self, arc: FloatArray, gap: float) -> FloatArray:
        """(n, k, 3) rows at arc lengths, on the path and beside it, `gap` above the bodies.

        They are straight, and stand off where a body is hollow across the path, as in a crease.
        """
        normal, step = self._normals(arc), 0.5 * self.laid_length / self.segments
        middle = self.path.at(arc)
        ahead, behind = (np.clip(arc + x, 0.0, self.path.length) for x in (step, -step))
        along = self.path.at(ahead) - self.path.at(behind)
        # Width and normal in this order: facets face away from the bodies.
        wide = np.cross(normal, along)
        sizes = np.linalg.norm(wide, axis=1)
        if self.kind != "bars" and not (sizes > 1e-6 * step).all():
            raise InputError(
                f"a {self.kind} cannot be laid straight towards a body",
                where=f"{self.name}: path",
                found=middle[int(np.argmin(sizes))].tolist(),
                allowed="a path that passes beside the nearest body",
                remedy="Move the end aside, or lay it as bars",
            )
        wide /= np.maximum(sizes, 1e-300)[:, None]
        rows = middle[:, None] + self._offsets[None, :, None] * wide[:, None]
        if self.kind == "bars":
            return self.path.outside(rows[:, 0], gap)[:, None]
        return rows + self._lift(rows, normal, gap)[:, None]

    def _normals(self, arc: FloatArray) -> FloatArray:
        """(n, 3) normals of the belt at arc lengths.

        Those of the bodies that it lies on, between two of them by its way from one to the other;
        of these the means over `TWIST` widths, as a belt that turns faster is stretched at its
        edges by more than a per cent.
        """
        path = self.path
        lies = np.flatnonzero(path.body >= 0)
        if self.kind == "bars" or len(lies) == 0:
            return path.normal_at(arc)
        around = TWIST * self.width * np.linspace(-0.5, 0.5, AROUND)
        near = (arc[:, None] + around).ravel()
        columns = [np.interp(near, path.arc[lies], one) for one in path.normal[lies].T]
        normals = np.stack(columns, axis=1).reshape(len(arc), AROUND, 3).mean(axis=1)
        return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])

    def _lift(self, rows: FloatArray, normal: FloatArray, gap: float) -> FloatArray:
        """(n, 3) moves of rows (n, k, 3) along their normals until all their nodes are `gap`
        outside, and the edges of facets of a ribbon, no less than that and even over its width."""
        lift = np.zeros(len(rows))
        for _ in range(MOVES):
            lifted = rows + (lift[:, None] * normal)[:, None]
            short = self._shortage(lifted, normal, gap)
            if self.kind == "ribbon":
                first, then = lifted[:-1], lifted[1:]
                middles = first + then, first[:, 1:] + then[:, :-1], first[:, :-1] + then[:, 1:]
                of_facets = 0.5 * np.concatenate(middles, axis=1)
                between = self._shortage(of_facets, normal[1:], gap)
                short[1:] = np.maximum(short[1:], between)
                short[:-1] = np.maximum(short[:-1], between)
            if not short.any():
                break
            lift += short
        # What is no less than the largest near by on both sides is so in their mean, too.
        size = 2 * round(0.5 * self.width * self.segments / self.laid_length) + 1
        even = uniform_filter1d(maximum_filter1d(lift, size), size)
        return np.asarray(even[:, None] * normal)

    def _shortage(self, rows: FloatArray, normal: FloatArray, gap: float) -> FloatArray:
        """(n,) lengths that rows (n, k, 3) must move along their normals to be `gap` outside."""
        near = self.path.over.clearances(np.ascontiguousarray(rows.reshape(-1, 3)))
        short = np.maximum(gap - near.gap, 0.0).reshape(rows.shape[:2])
        along = np.abs((near.normal.reshape(rows.shape) * normal[:, None]).sum(axis=2))
        return np.asarray((short / np.maximum(along, STEEP)).max(axis=1))

    @cached_property
    def _rest(self) -> FloatArray:
        """(n, 3) nodes without strain, of a membrane control points: flat, along x.

        Between two rows it is as long as the mean distance of their nodes, a chord's, less the
        shortening.
        """
        if self.kind == "membrane":
            return self._strip.flat(self._rows_of_strip, self.width, 1.0 - self.shortening)
        rows = self._points.reshape(self.segments + 1, -1, 3)
        chords = np.linalg.norm(np.diff(rows, axis=0), axis=2).mean(axis=1)
        x = (1.0 - self.shortening) * np.concatenate([[0.0], np.cumsum(chords)])
        rest = np.zeros((*self._rows.shape, 3))
        rest[:, :, 0], rest[:, :, 1] = x[:, None], self._offsets
        return rest.reshape(-1, 3)
