"""Every CAD file of the data folder against OpenCASCADE and what is known of the files."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests import occ_solids
from tests.sample import full

import contiga as cg
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.trim_area import patch_areas, patch_volumes


class Known(NamedTuple):
    """What MANIFEST.md says of a file."""

    faces: int
    unit: str
    size: tuple[float, float, float]
    """Extent in the file's unit, to the digits given there."""
    trimmed: int | None


FILES = {
    "headface_MED_full.step": Known(123, "mm", (110.0, 103.0, 58.0), 37),
    "goteborg_hull.step": Known(3, "m", (6.1, 0.41, 0.77), 2),
    "nist_ctc_02_asme1_ap242.stp": Known(487, "mm", (680.0, 860.0, 400.0), None),
    "dtmb5415_bulbous_bow.iges": Known(1, "m", (1.05, 0.31, 0.77), 1),
    "occt_bearing.iges": Known(213, "mm", (0.10, 0.12, 0.03), 56),
}
SOME = [name for name in FILES if "nist" not in name]

pytestmark = pytest.mark.usefixtures("kept")


@lru_cache(maxsize=8)
def body_of(path: Path) -> cg.Body:
    """In millimetres, told to read it so where the file says otherwise."""
    return cg.read_cad(path, unit=None if FILES[path.name].unit == "mm" else "mm")


# Loose faces that face against the faces they touch.
TURNED = {"goteborg_hull.step": (1, 2)}


@lru_cache(maxsize=8)
def faces_of(path: Path) -> tuple[Any, ...]:
    """The TopoDS_Face of the file, in millimetres, in order."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    shape = occ_solids.plain_shape(path)
    faces = []
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    while explorer.More():
        face = TopoDS.Face(explorer.Current())
        turned = len(faces) in TURNED.get(path.name, ())
        faces.append(TopoDS.Face(face.Reversed()) if turned else face)
        explorer.Next()
    return tuple(faces)


def largest_tolerance(face: Any) -> float:
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    worst = 0.0
    explorer = TopExp_Explorer(face, TopAbs_ShapeEnum.TopAbs_EDGE)
    while explorer.More():
        worst = max(worst, BRep_Tool.Tolerance_s(TopoDS.Edge(explorer.Current())))
        explorer.Next()
    return worst


def occ_frame(face: Any, point: np.ndarray, near: tuple[float, float] | None) -> Any:
    """(uv, point, oriented normal) of OpenCASCADE's face at `near`, or at the foot of `point`."""
    from OCP.BRep import BRep_Tool
    from OCP.gp import gp_Pnt, gp_Vec
    from OCP.ShapeAnalysis import ShapeAnalysis_Surface
    from OCP.TopAbs import TopAbs_Orientation

    surface = BRep_Tool.Surface_s(face)
    uv = near
    if uv is None:
        foot = ShapeAnalysis_Surface(surface).ValueOfUV(gp_Pnt(*map(float, point)), 1e-7)
        uv = (foot.X(), foot.Y())
    place, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    surface.D1(*uv, place, du, dv)
    normal = np.cross([du.X(), du.Y(), du.Z()], [dv.X(), dv.Y(), dv.Z()])
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        normal = -normal
    return uv, np.array([place.X(), place.Y(), place.Z()]), normal


def random_uv(patch: cg.NurbsSurface, n: int, seed: int) -> np.ndarray:
    low, high = np.array(patch.domain).T
    return low + np.random.default_rng(seed).random((n, 2)) * (high - low)


def occ_uv(face: Any, patch: cg.NurbsSurface, uv: np.ndarray) -> tuple[float, float] | None:
    """The same parameters on OpenCASCADE's surface where it is a spline, else None."""
    from OCP.BRep import BRep_Tool
    from OCP.Geom import Geom_BSplineSurface
    from OCP.TopAbs import TopAbs_Orientation

    if not isinstance(BRep_Tool.Surface_s(face), Geom_BSplineSurface):
        return None
    u, v = map(float, uv)
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        u = sum(patch.domain[0]) - u
    return u, v


@pytest.mark.parametrize("name", FILES)
def test_faces_unit_and_size_are_those_of_the_manifest(data_dir, name):
    known = FILES[name]
    path = data_dir / name
    body = body_of(path) if known.unit == "mm" else cg.read_cad(path)
    assert len(body.patches) == known.faces
    assert body.unit == known.unit
    # Bounds come from Bézier points, which reach a little over a curved surface.
    extent = np.ptp(body.bounds(), axis=0)
    assert np.all(extent >= 0.97 * np.array(known.size))
    assert np.all(extent <= 1.12 * np.array(known.size))
    if known.trimmed is not None:
        assert sum(loops is not None for loops in body.trims) == known.trimmed


@pytest.mark.parametrize("name", [*SOME, *full("nist_ctc_02_asme1_ap242.stp")])
def test_area_is_that_of_opencascade(data_dir, name):
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    path = data_dir / name
    body = body_of(path)
    theirs = []
    for face in faces_of(path):
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties, 1e-8)
        theirs.append(properties.Mass())
    ours = patch_areas(body)
    assert ours.sum() == pytest.approx(sum(theirs), rel=1e-6)
    # Face by face: OpenCASCADE counts what p-curves enclose beyond the surface's own border and
    # leaves loops open by their tolerance; both are within tolerance times the face's perimeter.
    slack = np.array([largest_tolerance(face) for face in faces_of(path)])
    perimeter = 8.0 * np.array([np.linalg.norm(np.ptp(p.bounds(), axis=0)) for p in body.patches])
    assert np.all(np.abs(ours - theirs) <= 1e-6 * np.array(theirs) + slack * perimeter)
    whole = np.array([loops is None for loops in body.trims])
    assert np.allclose(ours[whole], np.array(theirs)[whole], rtol=1e-7, atol=0.0)


@pytest.mark.parametrize("name", FILES)
def test_points_and_normals_are_those_of_opencascade(data_dir, name):
    path = data_dir / name
    body = body_of(path)
    size = body.size
    for k, (patch, face) in enumerate(zip(body.patches, faces_of(path), strict=True)):
        uv = random_uv(patch, 200 if len(body.patches) < 20 else 12, seed=k)
        points = patch.evaluate(uv)
        normals = patch.normal(uv)
        for row, point, normal in zip(uv, points, normals, strict=True):
            _, place, theirs = occ_frame(face, point, occ_uv(face, patch, row))
            assert np.linalg.norm(place - point) <= 1e-12 * size, (k, row)
            if np.linalg.norm(theirs) > 1e-9 * size:
                assert normal @ theirs > 0.999999 * np.linalg.norm(theirs), (k, row)


def test_solid_is_oriented_outward_with_the_volume_of_opencascade(data_dir):
    from OCP.BRepGProp import BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
    from OCP.gp import gp_Pnt

    path = data_dir / "nist_ctc_02_asme1_ap242.stp"
    body = body_of(path)
    origin = body.bounds().mean(axis=0)
    ours = patch_volumes(body, origin)
    place = gp_Pnt(*map(float, origin))
    theirs = []
    for face in faces_of(path):
        domain = BRepGProp_Domain(face)
        theirs.append(BRepGProp_Vinert(BRepGProp_Face(face), domain, place, 1e-9).Mass())
    assert ours.sum() > 0.0
    # Faces whose edges are off by micrometres differ by that much: see the areas.
    slack = np.array([largest_tolerance(face) for face in faces_of(path)])
    tight = slack < 1e-5
    assert tight.sum() > 250
    assert ours[tight].sum() == pytest.approx(np.array(theirs)[tight].sum(), rel=1e-8)
    assert ours.sum() == pytest.approx(sum(theirs), rel=5e-6)


@pytest.mark.parametrize("name", FILES)
def test_trims_classify_as_opencascade_does(data_dir, name):
    from OCP.gp import gp_Pnt2d
    from OCP.IntTools import IntTools_FClass2d
    from OCP.TopAbs import TopAbs_State

    path = data_dir / name
    body = body_of(path)
    tables = body.trim_tables
    tested = inside = 0
    for k, (patch, face) in enumerate(zip(body.patches, faces_of(path), strict=True)):
        if body.trims[k] is None:
            continue
        uv = random_uv(patch, 200 if len(body.patches) < 20 else 40, seed=k)
        ours = points_in_trim(tables, k, uv)
        points = patch.evaluate(uv)
        classifier = IntTools_FClass2d(face, 1e-9)
        for row, point, mine in zip(uv, points, ours, strict=True):
            at, _, _ = occ_frame(face, point, occ_uv(face, patch, row))
            state = classifier.Perform(gp_Pnt2d(*at), True)
            tested += 1
            inside += bool(mine)
            if mine != (state in (TopAbs_State.TopAbs_IN, TopAbs_State.TopAbs_ON)):
                assert distance_to_loops(body, k, point) <= largest_tolerance(face), (k, row)
    assert tested > 100
    assert 0.1 * tested < inside < 0.98 * tested


def distance_to_loops(body: cg.Body, k: int, point: np.ndarray) -> float:
    """From a point to the trimming loops of a face, sampled."""
    best = np.inf
    for loop in body.trims[k]:
        for curve in loop:
            t = np.linspace(*curve.domain, 2001)
            low, high = np.array(body.patches[k].domain).T
            uv = np.clip(curve.evaluate(t)[:, :2], low, high)
            on = body.patches[k].evaluate(uv)
            step = np.linalg.norm(np.diff(on, axis=0), axis=1).max()
            best = min(best, np.linalg.norm(on - point, axis=1).min() - 0.5 * step)
    return float(best)


@pytest.mark.parametrize("name", FILES)
def test_edges_lie_on_the_patches_that_use_them(data_dir, name):
    body = body_of(data_dir / name)
    size = body.size
    for edge in body.edges:
        ends = edge.curve.evaluate(np.array(edge.curve.domain))
        for use, span in zip(edge.uses, edge.spans, strict=True):
            patch = body.patches[use.patch]
            (u0, u1), (v0, v1) = patch.domain
            if use.loop >= 0:
                curve = body.trims[use.patch][use.loop][use.index]
                uv = curve.control_points[[0, -1], :2]
            elif use.index < 2:
                uv = np.array([[(u0, u1)[use.index], t] for t in span])
            else:
                uv = np.array([[t, (v0, v1)[use.index - 2]] for t in span])
            low, high = np.array(patch.domain).T
            on = patch.evaluate(np.clip(uv, low, high))
            if use.reversed:
                on = on[::-1]
            miss = np.linalg.norm(on - ends, axis=1).max()
            # What is measured is the distance to the curve; ends may lie off along it.
            assert miss <= 2.0 * max(edge.tolerance, edge.stated) + 1e-6 * size


def test_headface_is_one_open_shell_and_the_solid_has_no_free_edges(data_dir):
    face = body_of(data_dir / "headface_MED_full.step")
    assert sum(len(edge.uses) == 1 for edge in face.edges) > 0
    solid = body_of(data_dir / "nist_ctc_02_asme1_ap242.stp")
    assert all(len(edge.uses) == 2 for edge in solid.edges)


def test_hull_has_the_published_points(data_dir):
    body = cg.read_cad(data_dir / "goteborg_hull.step")
    lines = (data_dir / "goteborg_hull.reference_output.txt").read_text().splitlines()
    uv = [line.split("=")[1].split() for line in lines if "uv =" in line][::2]
    points = [line.split("=")[1].split() for line in lines if "q =" in line]
    low, high = np.array(body.patches[0].domain).T
    actual = body.patches[0].evaluate(np.clip(np.array(uv, dtype=float), low, high))
    assert len(points) == 11
    assert np.allclose(actual, np.array(points, dtype=float), rtol=0.0, atol=2e-9)


def test_bow_from_iges_is_face_0_of_the_hull_from_step(data_dir):
    bow = cg.read_cad(data_dir / "dtmb5415_bulbous_bow.iges", unit="m")
    hull = cg.read_cad(data_dir / "goteborg_hull.step", unit="m")
    a, b = bow.patches[0], hull.patches[0]
    assert a.degrees == b.degrees
    uv = random_uv(a, 500, seed=1)
    # The two files place the hull 97.097 mm apart in height.
    apart = b.evaluate(uv) - a.evaluate(uv)
    assert np.allclose(apart, [0.0, 0.0, 0.09709696], rtol=0.0, atol=1e-6)
    alike = points_in_trim(bow.trim_tables, 0, uv) == points_in_trim(hull.trim_tables, 0, uv)
    assert alike.mean() > 0.995
    assert patch_areas(bow)[0] == pytest.approx(patch_areas(hull)[0], rel=1e-4)


def test_loose_faces_of_the_bearing_are_joined(data_dir):
    # OpenCASCADE's own sewing leaves 25 edges free: those round the bottom, which has no face.
    bearing = cg.read_cad(data_dir / "occt_bearing.iges")
    free = [edge for edge in bearing.edges if len(edge.uses) == 1]
    assert len(free) == 25
    assert sum(len(edge.uses) == 2 for edge in bearing.edges) == 450
    ends = np.concatenate([edge.curve.evaluate(np.array(edge.curve.domain)) for edge in free])
    assert ends[:, 2].max() < 0.02 * np.ptp(bearing.bounds()[:, 2])


def test_file_unit_overrides_what_the_file_says(data_dir):
    path = data_dir / "occt_bearing.iges"
    as_said = cg.read_cad(path)
    metres = cg.read_cad(path, unit="mm", file_unit="m")
    assert metres.unit == "mm"
    assert np.allclose(metres.bounds(), 1000.0 * as_said.bounds(), rtol=1e-12)


def test_the_same_file_in_two_units_is_the_same_body(data_dir):
    path = data_dir / "goteborg_hull.step"
    metres, inches = cg.read_cad(path, unit="m"), cg.read_cad(path, unit="in")
    assert np.allclose(metres.bounds(), 0.0254 * inches.bounds(), rtol=1e-13)
    assert metres.area() == pytest.approx(0.0254**2 * inches.area(), rel=1e-9)


def test_teapot_has_32_patches_that_join(data_dir):
    teapot = cg.read_cad(data_dir / "utah_teapot_32bezier_gismo.xml")
    assert len(teapot.patches) == 32
    assert teapot.unit is None
    assert sum(len(edge.uses) == 2 for edge in teapot.edges) == 52
