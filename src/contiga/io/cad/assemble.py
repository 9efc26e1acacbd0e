"""Faces and edges of a CAD file, assembled into a `Body`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.errors import ContigaWarning, FileError, GeometryError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import UNTRIMMED, BodyEdge, EdgeUse, mirrored
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import check_loops
from contiga.io.cad.loops import Loop, PCurve, Sides, ends, gaps
from contiga.masters.body import Body

MIN_GAP = 1e-9
"""Gaps in a loop above this share of the domain get a straight closing piece."""
REMEDY = "Mend or delete it in the program that wrote the file"
"""Remedy for a face that cannot be read."""


class Edge(NamedTuple):
    """An edge in space, of the file's topology."""

    curve: NurbsCurve
    tolerance: float
    """Largest distance of its faces from it according to the file, length."""
    corner: float = 0.0
    """Largest distance of its ends from their corner according to the file, length."""


class Assembly:
    """The faces of a future body, added one by one; `body` makes the Body.

    Parameters
    ----------
    where : file name, for messages
    """

    def __init__(self, where: str) -> None:
        self.where = where
        self._patches: list[NurbsSurface] = []
        self._trims: list[list[list[NurbsCurve]] | None] = []
        self._uses: dict[int, list[tuple[EdgeUse, tuple[float, float]]]] = {}
        """Uses of each edge, with the interval of the p-curve or side."""

    def add_trimmed(
        self, surface: NurbsSurface, loops: list[Loop], where: str, *, flip: bool = False
    ) -> None:
        """Add a face cut out by `loops`; `flip` reverses its free side and mirrors the loops.

        Gaps in a loop of more than `MIN_GAP` of the domain are closed by straight pieces. A face
        whose loops then do not fit is kept whole and shares no edge, with a warning: one bad face
        is no reason to refuse a file. `where` names the face in messages.
        """
        patch = len(self._patches)
        domain = surface.domain[0]
        span = np.array([np.ptp(interval) for interval in surface.domain])
        closed: list[Loop] = []
        for loop in loops:
            closed.append([])
            for pcurve, gap in zip(loop, gaps(loop), strict=True):
                closed[-1].append(pcurve)
                if np.any(np.abs(gap) > MIN_GAP * span):
                    start = ends(pcurve)[1]
                    line = NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], np.array([start, start + gap]))
                    closed[-1].append(PCurve(line, -1, False, 0.0))
        try:
            curves = tuple(tuple(pcurve.curve for pcurve in loop) for loop in closed)
            check_loops(curves, surface.domain, where)
        except GeometryError as error:
            warn(f"{error}. The face is kept whole")
            self.add_whole(surface, flip=flip)
            return
        trims: list[list[NurbsCurve]] = []
        for pcurves in closed:
            trims.append([mirrored(s.curve, domain) if flip else s.curve for s in pcurves])
            for index, pcurve in enumerate(pcurves):
                use = EdgeUse(patch, len(trims) - 1, index, pcurve.reversed)
                self._add_use(pcurve.edge, use, pcurve.curve.domain)
        self._patches.append(surface.flipped() if flip else surface)
        self._trims.append(trims)

    def add_whole(
        self,
        surface: NurbsSurface,
        loop: Loop | None = None,
        sides: Sides | None = None,
        *,
        flip: bool = False,
    ) -> None:
        """Add a face that is its whole natural rectangle; `flip` reverses its free side.

        `loop` and `sides` have its edges and their places; unless both are given, it shares no
        edge.
        """
        patch = len(self._patches)
        if loop is not None and sides is not None:
            total = sum(surface.domain[0])
            rows = zip(loop, sides.side, sides.against, sides.span, strict=True)
            for pcurve, side, against, span in rows:
                runs_against = against != pcurve.reversed
                if flip and side < 2:
                    side = 1 - side
                elif flip:
                    runs_against = not runs_against
                    span = (total - span[1], total - span[0])
                use = EdgeUse(patch, UNTRIMMED, side, runs_against)
                self._add_use(pcurve.edge, use, span)
        self._patches.append(surface.flipped() if flip else surface)
        self._trims.append(None)

    def _add_use(self, edge: int, use: EdgeUse, span: tuple[float, float]) -> None:
        if edge >= 0:
            self._uses.setdefault(edge, []).append((use, span))

    def connected_owners(self, owner: Sequence[int]) -> list[int]:
        """Return, ascending, the owners that share an edge with others; `owner` is by patch."""
        connected: set[int] = set()
        for uses in self._uses.values():
            owners = {owner[use.patch] for use, _ in uses}
            if len(owners) > 1:
                connected |= owners
        return sorted(connected)

    def body(self, name: str, edge_of: Callable[[int], Edge | None], unit: str | None) -> Body:
        """Return the body of all faces; `edge_of` gives the `Edge` of a number, or None.

        Edges for which it gives None are left out.

        Raises
        ------
        FileError
            No faces, or faces of which no body can be made.
        """
        if not self._patches:
            raise FileError(
                "no faces found",
                where=self.where,
                allowed="a file with at least one surface",
                remedy="Curves, points and facets cannot serve as a master.",
            )
        edges = []
        for number, uses in self._uses.items():
            edge = edge_of(number)
            if edge is not None:
                edges.append(
                    BodyEdge(
                        edge.curve,
                        0.0,
                        tuple(use for use, _ in uses),
                        tuple(span for _, span in uses),
                        stated=edge.tolerance,
                        corner=edge.corner,
                    )
                )
        try:
            return Body(self._patches, name=name, trims=self._trims, edges=edges, unit=unit)
        except GeometryError as error:
            raise FileError(str(error), where=self.where) from error


def merge_bodies(bodies: list[Body], path: Path, unit: str | None) -> Body:
    """Return all faces of `bodies` in their order as one body, named after the file `path`.

    Edges stay those of each body: faces of different bodies are not joined.

    Raises
    ------
    FileError
        No bodies.
    """
    if not bodies:
        Assembly(str(path)).body(path.stem, lambda _: None, unit)
    patches: list[NurbsSurface] = []
    trims: list[tuple[tuple[NurbsCurve, ...], ...] | None] = []
    edges: list[BodyEdge] = []
    for body in bodies:
        first = len(patches)
        patches += body.patches
        trims += body.trims
        for edge in body.edges:
            uses = tuple(use._replace(patch=use.patch + first) for use in edge.uses)
            edges.append(edge._replace(uses=uses))
    return Body(patches, name=path.stem, trims=trims, edges=edges, unit=unit)


def warn(message: str) -> None:
    """Issue a `ContigaWarning` that points four calls up; in a worker only its text counts."""
    warnings.warn(message, ContigaWarning, stacklevel=5)
