"""OpenCASCADE asked directly: an independent reader and measure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np


def read_shape(path: Path) -> Any:
    """The shape of a STEP or IGES file, in millimetres."""
    from OCP.IGESControl import IGESControl_Reader
    from OCP.STEPControl import STEPControl_Reader

    iges = path.suffix.lower() in (".igs", ".iges")
    reader = IGESControl_Reader() if iges else STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return reader.OneShape()


def faces_of(shape: Any) -> list[Any]:
    """The faces in the order of the file."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    faces = []
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    while explorer.More():
        faces.append(explorer.Current())
        explorer.Next()
    return faces


def distance(point: np.ndarray, face: Any) -> float:
    """Distance of a point to a face, its trims obeyed."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt

    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, point))).Vertex()
    return float(BRepExtrema_DistShapeShape(vertex, face).Value())


def inside(shape: Any, points: np.ndarray) -> np.ndarray:
    """Which points lie inside a solid."""
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_State

    classifier = BRepClass3d_SolidClassifier(shape)
    values = []
    for point in points:
        classifier.Perform(gp_Pnt(*map(float, point)), 1e-9)
        values.append(classifier.State() == TopAbs_State.TopAbs_IN)
    return np.array(values)
