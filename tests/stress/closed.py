"""Valid solids as contiga has them: closed, as heavy as they are, and each point on its side."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable, Iterable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tests import occ_solids
from tests.cases import occ
from tests.stress import valid
from tests.stress.tally import Clock, Tally

import contiga as cg
from contiga.errors import ContigaError, ContigaWarning
from contiga.io.cad.assemble import Assembly
from contiga.io.cad.occ_geometry import quiet
from contiga.io.cad.sew import SewnEdges
from contiga.io.cad.step_iges import edge_of, gather

POINTS = 200
NEAR = 1e-6
"""Points nearer to the surface than this share of the size are not judged."""
PRECISE = 1e-9
"""Share by which a mass may be off."""
COARSE, FINE = 1e-4, 1e-5
"""How far triangles are off the surface, shares of the size."""
PLACES = 24
"""Of an edge, at which its slits are measured."""
WAYS = ("step", "iges", "iges faces", "direct")


class Verdict(NamedTuple):
    """What contiga makes of a valid solid."""

    name: str
    way: str
    body: cg.Body | None
    refused: str
    """The message of an error, "" if there was none."""
    told: tuple[str, ...]
    """Warnings."""
    off: float
    """Share by which the mass is off, NaN if there is none."""
    doubt: float
    """Share by which the truth may be off."""
    judged: int
    wrong: int
    """Points on the wrong side."""
    point: tuple[float, ...]
    """The first of them."""

    @property
    def faults(self) -> list[str]:
        """What is wrong, a text each."""
        if self.body is None:
            return [f"refused: {self.refused}"]
        texts = []
        if not self.body.closed:
            texts.append(f"open: {'; '.join(self.body.flaws)}")
        elif not abs(self.off) <= PRECISE + self.doubt:
            texts.append(f"mass off by {self.off:.1e}, may be by {self.doubt:.1e} {self.refused}")
        if self.told and "solids that touch" not in self.told[0]:
            texts.append(f"told: {'; '.join(self.told)}")
        if self.wrong:
            texts.append(f"{self.wrong} of {self.judged} on the wrong side, {self.point}")
        return texts


def way_of(solid: valid.Valid, number: int) -> str:
    """How the solid of a number comes to contiga.

    Several shells are kept by files of solids alone: of loose faces none knows what is hollow.
    """
    if len(occ_solids.parts(solid.piece.shape, "SHELL")) > 1:
        return WAYS[number % 2]
    return WAYS[(0, 3, 1, 0, 2, 3)[number % 6]]


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="contiga-valid-")


def handed_over(shape: Any, way: str) -> cg.Body:
    """A shape through a file, or by its faces directly."""
    if way == "direct":
        return direct(shape)
    folder = Path(_folder().name)
    if way == "step":
        return cg.read_cad(occ_solids.write(shape, folder / "solid.step"), unit="mm")
    path = write_iges(shape, folder / "solid.iges", solids=way == "iges")
    return cg.read_cad(path, unit="mm")


def write_iges(shape: Any, path: Path, solids: bool) -> Path:
    """As solids with their edges, or as loose trimmed faces, which IGES files mostly have."""
    from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer

    with quiet():
        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer("MM", int(solids))
        writer.AddShape(shape)
        writer.ComputeModel()
        assert writer.Write(str(path))
    return path


def direct(shape: Any) -> cg.Body:
    """The faces of a shape in memory, as the reader of files converts them."""
    from OCP.TopoDS import TopoDS

    sewn, assembly = SewnEdges(shape), Assembly("a shape")
    faces = [TopoDS.Face(face) for face in occ.faces_of(shape)]
    gather(assembly, list(enumerate(faces, 1)), sewn, 1.0, "a shape, face")
    return assembly.body("shape", lambda number: edge_of(sewn, 1.0, 0.0, number), "mm")


def judged(solid: valid.Valid, way: str, seed: int = 0) -> Verdict:
    """One solid, handed over in one way."""
    piece = solid.piece
    body, refused, off, doubt, wrong, count, point = None, "", np.nan, 0.0, 0, 0, ()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", ContigaWarning)
        try:
            body = handed_over(piece.shape, way)
            if body.closed:
                truth, doubt = truth_of(solid, way)
                off = body.mass_properties(1.0).mass / truth - 1.0
        except ContigaError as error:
            refused = str(error)
        if body is not None:
            points, truth = sides(solid, seed)
            given = body.contains(points)
            rows = np.flatnonzero(given != truth)
            rows = (
                rows[confirmed(solid, points[rows], given[rows], body.size)] if len(rows) else rows
            )
            wrong, count = len(rows), len(points)
            point = tuple(points[rows[0]].tolist()) if wrong else ()
    texts = tuple(str(each.message) for each in told)
    return Verdict(solid.name, way, body, refused, texts, off, doubt, count, wrong, point)


class Truth(NamedTuple):
    """The volume of a solid."""

    volume: float
    off: float
    """Share by which it may be off: by slits along edges, and as OpenCASCADE integrates."""


def truth_of(solid: valid.Valid, way: str) -> Truth:
    """The volume in closed form, or OpenCASCADE's.

    Writing IGES rounds, so that there it is the volume of what OpenCASCADE reads back.
    """
    shape, volume, off = solid.piece.shape, solid.piece.volume, 0.0
    if way.startswith("iges"):
        shape, volume = occ_solids.sewn_shape(Path(_folder().name) / "solid.iges"), None
    if volume is None:
        volume, off = valid.volume_of(shape)
    low, high = valid.bounds(shape)
    return Truth(
        abs(volume), off + slits_of(shape) * float(np.linalg.norm(high - low)) / abs(volume)
    )


def slits_of(shape: Any) -> float:
    """Area between the edges of a shape and the p-curves of their faces."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.TopoDS import TopoDS

    area = 0.0
    for face in map(TopoDS.Face, occ.faces_of(shape)):
        for edge in map(TopoDS.Edge, occ_solids.parts(face, "EDGE")):
            if BRep_Tool.Degenerated_s(edge):
                continue
            curves = BRepAdaptor_Curve(edge), BRepAdaptor_Curve(edge, face)
            t = np.linspace(curves[0].FirstParameter(), curves[0].LastParameter(), PLACES)
            points = [[curve.Value(float(at)) for at in t] for curve in curves]
            length = sum(a.Distance(b) for a, b in pairwise(points[0]))
            area += length * max(a.Distance(b) for a, b in zip(*points, strict=True))
    return area


def sides(solid: valid.Valid, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in and about a solid, half of them near its surface, and which are inside.

    By its closed form, else by OpenCASCADE's triangles: its classifier is wrong of points up to
    5e-3 of the size beside a thread.
    """
    shape, field = solid.piece.shape, solid.piece.field
    rng = np.random.default_rng([seed, *solid.name.encode()])
    low, high = valid.bounds(shape)
    size = float(np.linalg.norm(high - low))
    corners = triangles_of(shape, COARSE * size)
    far = rng.uniform(low - 0.05 * size, high + 0.05 * size, (POINTS // 2, 3))
    chosen = corners[rng.integers(0, len(corners), POINTS // 2)]
    foot = np.einsum("nk,nkc->nc", rng.dirichlet(np.ones(3), len(chosen)), chosen)
    way = rng.normal(size=foot.shape)
    way /= np.linalg.norm(way, axis=1)[:, None]
    near = foot + size * 10.0 ** rng.uniform(-5.0, -1.5, (len(foot), 1)) * way
    points = np.concatenate([far, near])
    if field is None:
        return points, turns_about(points, corners) > 0.5
    away = field(points)
    judged = np.abs(away) > NEAR * size
    return points[judged], away[judged] < 0.0


def confirmed(solid: valid.Valid, points: np.ndarray, given: np.ndarray, size: float) -> Any:
    """(n,) which points are on the wrong side: near ones are not, as far as the truth goes."""
    shape, field = solid.piece.shape, solid.piece.field
    away = [min(occ.distance(p, face) for face in occ.faces_of(shape)) for p in points]
    if field is not None:
        return np.array(away) > NEAR * size
    fine = triangles_of(shape, FINE * size)
    return (np.array(away) > 2.0 * FINE * size) & ((turns_about(points, fine) > 0.5) != given)


def triangles_of(shape: Any, tol: float) -> np.ndarray:
    """(n, 3, 3) corners of OpenCASCADE's triangles, outward, no farther off than `tol`."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    BRepTools.Clean_s(shape)
    BRepMesh_IncrementalMesh(shape, tol)
    corners = []
    for face in map(TopoDS.Face, occ.faces_of(shape)):
        place = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, place)
        move = place.Transformation()
        nodes = [mesh.Node(k + 1).Transformed(move) for k in range(mesh.NbNodes())]
        points = np.array([(p.X(), p.Y(), p.Z()) for p in nodes])
        rows = np.array([mesh.Triangle(k + 1).Get() for k in range(mesh.NbTriangles())]) - 1
        turned = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        corners.append(points[rows[:, ::-1] if turned else rows])
    return np.concatenate(corners)


def turns_about(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(n,) winding numbers: solid angles of triangles (Van Oosterom and Strackee, 1983)."""
    turns = []
    for point in points:
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.sqrt(np.einsum("ij,ij->i", x, x)) for x in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
        turns.append(np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum())
    return np.array(turns) / (2.0 * np.pi)


def taken(family: Callable[[valid.Rng], Any], numbers: Iterable[int]) -> Tally:
    """Solids of a family, each in its own way, as a part of the stress counts them."""
    with Clock(Tally(f"valid solids, {family.__name__}")) as tally:
        for number in numbers:
            solid = valid.made(family, number)
            verdict = judged(solid, way_of(solid, number))
            tally.count += 1
            tally.wrong += bool(verdict.faults)
            tally.note(verdict.way, 1)
            if verdict.faults:
                fault = {"kind": "solid", "name": verdict.name, "way": verdict.way}
                tally.faults.append(fault | {"faults": verdict.faults})
    return tally
