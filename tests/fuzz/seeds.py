"""Small sound files of every format that is read, each in a folder of its own."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from tests.fuzz.texts import CASES, CLOUDS, DECKS, GISMO

# What meshio can neither write small nor read for us, or needs packages for that are not ours.
_NOT_WRITTEN = {"svg", "wkt", "tetgen", "exodus", "cgns", "dolfin-xml"}
_VARIANTS: dict[str, tuple[dict[str, Any], ...]] = {
    "vtu": ({"binary": False}, {"binary": True, "compression": None}, {"compression": "zlib"}),
    "gmsh": ({"binary": False}, {"binary": True}, {"binary": False, "fmt_version": "2.2"}),
    "stl": ({"binary": False}, {"binary": True}),
    "ply": ({"binary": False}, {"binary": True}),
    "vtk": ({"binary": False}, {"binary": True}),
    "xdmf": ({"data_format": "XML"}, {"data_format": "Binary"}, {"data_format": "HDF"}),
    "ansys": ({"binary": False}, {"binary": True}),
    "flac3d": ({"binary": False}, {"binary": True}),
}
_BESIDE = (".h5", ".bin")
"""Files that belong to another one, where there is another."""
_STEP_DATE = re.compile(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d")
_IGES_DATE = re.compile(rb"\d{8}\.\d{6}")


def write_seeds(folder: Path, only: str = "") -> list[Path]:
    """Write the files, or find them written; those whose name contains `only`."""
    done = folder / "done"
    if not done.is_file():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        _write_texts(folder)
        _write_shapes(folder)
        _write_rhino(folder)
        _write_meshes(folder)
        done.touch()
    values = [
        min(place.glob("seed.*"), key=lambda path: path.suffix in _BESIDE)
        for place in sorted(folder.iterdir())
        if place.is_dir() and only in place.name
    ]
    if not values:
        raise SystemExit(f"no seed is called {only!r}")
    return values


def _place(folder: Path, name: str, suffix: str) -> Path:
    place = folder / name
    place.mkdir()
    return place / f"seed{suffix}"


def _write_texts(folder: Path) -> None:
    for name, text in DECKS.items():
        path = _place(folder, f"deck-{name}", ".k")
        path.write_text(text, encoding="utf-8")
        if "part.k" in text:
            (path.parent / "part.k").write_text(DECKS["shells"], encoding="utf-8")
    for name, text in GISMO.items():
        _place(folder, f"gismo-{name}", ".xml").write_text(text, encoding="utf-8")
    for name, text in CLOUDS.items():
        _place(folder, f"cloud-{name}", ".csv").write_text(text, encoding="utf-8")
    np.save(_place(folder, "cloud-array", ".npy"), np.arange(30.0).reshape(10, 3))
    for name, text in CASES.items():
        path = _place(folder, f"case-{name}", ".toml")
        path.write_text(text, encoding="utf-8")
        (path.parent / "ball.xml").write_text(GISMO["patch"], encoding="utf-8")
        (path.parent / "motion.csv").write_text(CLOUDS["table"], encoding="utf-8")
        for k in range(2):
            (path.parent / f"pad_{k}.csv").write_text(CLOUDS["plain"], encoding="utf-8")


def _shapes() -> Iterator[tuple[str, Any]]:
    """Solids of OpenCASCADE: planes and a cylinder, a sphere cut open, a fillet, loose faces."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeBox,
        BRepPrimAPI_MakeCylinder,
        BRepPrimAPI_MakeSphere,
        BRepPrimAPI_MakeTorus,
    )
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS, TopoDS_Compound

    box = BRepPrimAPI_MakeBox(10.0, 20.0, 5.0).Shape()
    bore = gp_Ax2(gp_Pnt(5.0, 10.0, -1.0), gp_Dir(0.0, 0.0, 1.0))
    yield "bore", BRepAlgoAPI_Cut(box, BRepPrimAPI_MakeCylinder(bore, 3.0, 7.0).Shape()).Shape()
    ball = BRepPrimAPI_MakeSphere(4.0).Shape()
    yield "ball", BRepAlgoAPI_Cut(ball, BRepPrimAPI_MakeBox(9.0, 9.0, 9.0).Shape()).Shape()
    yield "torus", BRepPrimAPI_MakeTorus(5.0, 2.0).Shape()
    fillet = BRepFilletAPI_MakeFillet(box)
    edges = TopExp_Explorer(box, TopAbs_ShapeEnum.TopAbs_EDGE)
    fillet.Add(1.0, TopoDS.Edge(edges.Current()))
    yield "fillet", fillet.Shape()
    both = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(both)
    builder.Add(both, ball)
    builder.Add(both, box)
    yield "pair", both


def _spline(shape: Any) -> Any:
    """A shape with B-splines instead of planes, cylinders and the like."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    return BRepBuilderAPI_NurbsConvert(shape).Shape()


def _write_shapes(folder: Path) -> None:
    from OCP.IGESControl import IGESControl_Writer
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    from contiga.io.cad.occ_geometry import quiet

    as_is = STEPControl_StepModelType.STEPControl_AsIs
    with quiet():
        for name, shape in _shapes():
            for kind, made in (("", shape), ("-nurbs", _spline(shape))):
                path = _place(folder, f"step-{name}{kind}", ".step")
                step = STEPControl_Writer()
                step.Transfer(made, as_is)
                step.Write(str(path))
                path.write_bytes(_STEP_DATE.sub(b"2000-01-01T00:00:00", path.read_bytes()))
                for solid in (0, 1):
                    iges = IGESControl_Writer("MM", solid)
                    iges.AddShape(made)
                    iges.ComputeModel()
                    path = _place(folder, f"iges{solid}-{name}{kind}", ".igs")
                    iges.Write(str(path))
                    path.write_bytes(_IGES_DATE.sub(b"20000101.000000", path.read_bytes()))


def _write_rhino(folder: Path) -> None:
    import rhino3dm as r

    origin = r.Point3d(0, 0, 0)
    tube = r.Cylinder(r.Circle(origin, 1.0), 2.0)
    box = r.Box(r.BoundingBox(origin, r.Point3d(1, 2, 3)))
    made = {
        "box": r.Brep.CreateFromBox(box),
        "cylinder": r.Brep.CreateFromCylinder(tube, True, True),
        "pipe": r.Extrusion.CreatePipeExtrusion(tube, 0.5, True, True),
        "sphere": r.NurbsSurface.CreateFromSphere(r.Sphere(origin, 2.0)),
    }
    for name, geometry in made.items():
        model = r.File3dm()
        model.Settings.ModelUnitSystem = r.UnitSystem.Millimeters
        model.Objects.Add(geometry)
        model.Write(str(_place(folder, f"rhino-{name}", ".3dm")), 7)


def _write_meshes(folder: Path) -> None:
    """A tetrahedron on a square of triangles, in all formats and variants meshio writes."""
    import meshio

    points = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.3, 0.3, 1.0], [2, 0, 0.5]], dtype=float
    )
    solid = ("tetra", np.array([[0, 1, 3, 4], [1, 2, 3, 4]]))
    shell = ("triangle", np.array([[0, 1, 2], [0, 2, 3], [1, 5, 2]]))
    endings = {kind: e for e, kinds in meshio.extension_to_filetypes.items() for kind in kinds}
    for kind, ending in sorted(endings.items()):
        if kind in _NOT_WRITTEN:
            continue
        for k, options in enumerate(_VARIANTS.get(kind, ({},))):
            for cells in ([solid], [shell], [solid, shell]):
                name = f"mesh-{kind}-{k}-{'-'.join(cell[0] for cell in cells)}"
                path = _place(folder, name, ending)
                with (
                    contextlib.redirect_stdout(io.StringIO()),
                    contextlib.redirect_stderr(io.StringIO()),
                    np.errstate(all="ignore"),
                ):
                    if not _written(meshio.Mesh(points, cells), path, kind, options):
                        shutil.rmtree(path.parent)


def _written(mesh: Any, path: Path, kind: str, options: dict[str, Any]) -> bool:
    """Whether meshio can write these cells in this format, and read them again."""
    import meshio

    try:
        meshio.write(path, mesh, file_format=kind, **options)
        points = meshio.read(path, file_format=kind).points
    except (Exception, SystemExit):  # each writer refuses in its own way what it cannot hold
        return False
    return path.is_file() and len(points) > 0
