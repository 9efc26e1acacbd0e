"""Closed solids of OpenCASCADE and the data folder: closed meshes at every tolerance."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga import Body, shapes
from contiga.errors import GeometryError
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga_validation.rivals.rival_meshes import fewest_triangles

EXAMPLES = Path(__file__).parents[2] / "examples"


def faults(mesh: cg.TriMesh) -> dict[str, int]:
    """Counts of what a closed, oriented mesh has none of."""
    t = mesh.triangles.astype(np.int64)
    n = len(mesh.vertices)
    a, b = t.ravel(), np.roll(t, -1, axis=1).ravel()
    _, times = np.unique(np.minimum(a, b) * n + np.maximum(a, b), return_counts=True)
    directed = np.unique(a * n + b, return_counts=True)[1]
    return {
        "not used twice": int((times != 2).sum()),
        "same direction": int((directed != 1).sum()),
        "same corners": len(t) - len(np.unique(np.sort(t, axis=1), axis=0)),
        "no area": int((mesh.areas() <= 0.0).sum()),
    }


def solids() -> dict[str, object]:
    """Ten lines each."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeOffsetShape
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeBox,
        BRepPrimAPI_MakeCone,
        BRepPrimAPI_MakeCylinder,
        BRepPrimAPI_MakeSphere,
        BRepPrimAPI_MakeTorus,
    )
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    def rod(p, d, r, h):
        return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*p), gp_Dir(*d)), r, h).Shape()

    def block(a, b):
        return BRepPrimAPI_MakeBox(gp_Pnt(*a), gp_Pnt(*b)).Shape()

    def cut(a, b):
        return BRepAlgoAPI_Cut(a, b).Shape()

    def fillet(shape, radius):
        maker, edges = BRepFilletAPI_MakeFillet(shape), TopExp_Explorer(shape, TopAbs_EDGE)
        while edges.More():
            maker.Add(radius, TopoDS.Edge(edges.Current()))
            edges.Next()
        return maker.Shape()

    cube = block((0, 0, 0), (2, 3, 4))
    bored = block((-1, -1, -1), (1, 1, 1))
    for axis in np.eye(3).tolist():
        bored = cut(bored, rod([-2 * x for x in axis], axis, 0.4, 4))
    ends = BRepAlgoAPI_Fuse(rod((0, 0, 0), (0, 0, 1), 1, 1), rod((6, 0, 0), (0, 0, 1), 0.7, 1))
    link = BRepAlgoAPI_Fuse(ends.Shape(), block((0, -0.4, 0.2), (6, 0.4, 0.8))).Shape()
    link = cut(cut(link, rod((0, 0, -1), (0, 0, 1), 0.5, 3)), rod((6, 0, -1), (0, 0, 1), 0.3, 3))
    ball = BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, 0), 2.0).Shape()
    shell = BRepOffsetAPI_MakeOffsetShape()
    shell.PerformBySimple(fillet(cube, 0.3), 0.2)
    return {
        "filleted box": fillet(cube, 0.3),
        "slot": cut(cube, block((0.95, -1, 2), (1.05, 4, 5))),
        "cup": cut(rod((0, 0, 0), (0, 0, 1), 1, 2), rod((0, 0, 0.1), (0, 0, 1), 0.9, 3)),
        "bores": bored,
        "cone": BRepPrimAPI_MakeCone(1.0, 0.0, 2.0).Shape(),
        "lens": BRepAlgoAPI_Common(
            ball, BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, 3.9), 2.0).Shape()
        ).Shape(),
        "ball": ball,
        "torus": BRepPrimAPI_MakeTorus(2.0, 0.5).Shape(),
        "offset": shell.Shape(),
        "link": link,
    }


@pytest.fixture(scope="module")
def bodies(tmp_path_factory) -> dict[str, Body]:
    write = runpy.run_path(str(EXAMPLES / "make_headform.py"))["write_step"]
    folder = tmp_path_factory.mktemp("solids")
    values = {}
    for name, solid in solids().items():
        path = folder / f"{name.replace(' ', '_')}.step"
        write(solid, path)
        values[name] = cg.read_cad(path)
    return values


TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
NAMES = ("filleted box", "slot", "cup", "bores", "cone", "lens", "ball", "torus", "offset", "link")


@pytest.mark.parametrize("name", NAMES)
def test_a_closed_solid_has_a_closed_mesh_at_every_tolerance(bodies, name):
    body = bodies[name]
    off = []
    for tol in TOLERANCES:
        mesh = body.tessellate(tol * body.size)
        assert set(faults(mesh).values()) == {0}, (tol, faults(mesh))
        off.append(abs(mesh.volume() / body.volume() - 1.0))
        assert mesh.volume() > 0.0
    assert off[-1] < 1e-3
    assert off[-1] <= off[1]


def places_on(body: Body, each: int) -> np.ndarray:
    """Points of all faces, trims obeyed."""
    rng, found = np.random.default_rng(3), []
    for k, patch in enumerate(body.patches):
        low, high = np.array(patch.domain).T
        uv = low + (high - low) * rng.random((each, 2))
        if body.trims[k] is not None:
            uv = uv[points_in_trim(body.trim_tables, k, np.ascontiguousarray(uv))]
        found.append(patch.evaluate(uv))
    return np.concatenate(found)


@pytest.mark.parametrize("name", ["filleted box", "bores", "cone", "lens", "torus", "offset"])
def test_no_place_of_a_solid_is_farther_than_the_tolerance(bodies, name):
    body = bodies[name]
    on = places_on(body, 3000)
    for tol in (1e-2, 1e-3, 1e-4):
        mesh = body.tessellate(tol * body.size)
        gap = np.abs(mesh.project(on).gap)
        assert gap.max() <= tol * body.size * (1.0 + 1e-6)


@pytest.fixture(scope="module")
def headform(tmp_path_factory) -> Body:
    made = runpy.run_path(str(EXAMPLES / "make_headform.py"))
    path = tmp_path_factory.mktemp("headform") / "headform.step"
    made["write_step"](made["only_solid"](made["headform"]()), path)
    return cg.read_cad(path)


@pytest.mark.parametrize("tol", [1e-1, 1e-2, 1e-3, 1e-4])
def test_the_headform_is_closed(headform, tol):
    body = headform
    mesh = body.tessellate(tol * body.size)
    assert set(faults(mesh).values()) == {0}, faults(mesh)


@pytest.mark.full
def test_a_part_of_the_data_folder_is_closed(data_dir):
    body = cg.read_cad(data_dir / "nist_ctc_02_asme1_ap242.stp")
    for tol in TOLERANCES:
        mesh = body.tessellate(tol * body.size)
        assert set(faults(mesh).values()) == {0}, (tol, faults(mesh))


@pytest.mark.parametrize("tol", [0.02, 0.006, 1e-4])
def test_faces_with_sharp_bends_end_and_keep_the_distance(data_dir, tol):
    body = cg.read_cad(data_dir / "goteborg_hull.step")
    mesh = body.tessellate(tol)
    assert 50 < len(mesh.triangles) < 40000
    assert np.abs(mesh.project(places_on(body, 5000)).gap).max() <= tol * (1.0 + 1e-6)


def test_the_border_of_one_face_alone_is_that_of_the_face(data_dir):
    """The curves of the file are 48 tolerances off it."""
    body = cg.read_cad(data_dir / "dtmb5415_bulbous_bow.iges")
    tol = 1e-5 * body.size
    mesh = body.tessellate(tol)
    assert np.abs(mesh.project(places_on(body, 20000)).gap).max() <= tol * (1.0 + 1e-6)


def test_a_blade_thinner_than_the_tolerance_has_a_volume(tmp_path):
    """Chords of its two arcs have the same ends: with one for each, nothing is between them."""
    from tests import occ_solids
    from tests.stress import solids as stress

    path = occ_solids.write(stress.RECIPES["blade"].make(), tmp_path / "blade.step")
    body = cg.read_cad(path)
    mesh = body.tessellate(0.1 * body.size)
    assert set(faults(mesh).values()) == {0}
    assert 0.5 * body.volume() < mesh.volume() < body.volume()


CURVED = {
    "sphere": shapes.sphere(),
    "torus": shapes.torus(),
    "ellipsoid": shapes.ellipsoid(axes=(3.0, 2.0, 1.0)),
    "bumpy": shapes.bumpy_plate(width=1.0, length=1.0, amplitude=0.04, waves=2),
}


@pytest.mark.parametrize("name", CURVED)
def test_no_more_than_twice_the_fewest_triangles(name):
    """The bound is that of Pottmann et al. for corners on the surface: no mesh has fewer.

    It holds for small distances; the waves of the plate are small beside coarser ones.
    """
    body = Body([CURVED[name]])
    tol = (1e-5 if name == "bumpy" else 1e-4) * body.size
    assert len(body.tessellate(tol).triangles) <= 2.0 * fewest_triangles(body, tol)


def test_straight_faces_get_triangles_between_their_borders_only():
    """Of a strip between n and n chords no mesh has fewer than 2 n triangles."""
    body = Body([shapes.cylinder(radius=1.0, height=2.0)])
    sag = 1e-4
    chords = np.pi / np.arccos(1.0 - sag)
    assert len(body.tessellate(sag).triangles) <= 2.0 * 1.1 * chords + 4


def test_a_tolerance_that_is_too_fine_is_refused_with_the_number():
    with pytest.raises(GeometryError, match=r"needs about .* triangles.*Take a larger one"):
        Body([shapes.sphere()]).tessellate(1e-9)
