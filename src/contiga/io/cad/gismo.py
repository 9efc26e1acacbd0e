"""G+Smo XML: tensor-product B-spline and NURBS surfaces, through the standard library.

Coefficients come one row a point, the first direction fastest; weights are not multiplied in.
The format carries no length unit.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from contiga.errors import FileError, GeometryError
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import Assembly, warn
from contiga.io.cad.parts import (
    ALL,
    Choice,
    FaceLabel,
    Inventory,
    PartLabel,
    Solids,
    chosen_faces,
)
from contiga.io.cad.stitch import coincident_sides
from contiga.io.cad.unite_body import unite_pieces
from contiga.io.units import length_factor, short_name
from contiga.masters.body import Body
from contiga.records import FloatArray

SURFACES = ("TensorBSpline2", "TensorNurbs2")


def read_gismo(
    path: Path,
    file_unit: str | None,
    unit: str | None,
    choice: Choice = ALL,
    solids: Solids | None = None,
) -> Body:
    """Return the surfaces of a G+Smo file as one body; see `contiga.io.cad.read_cad.read_cad`.

    Patches that share a whole side, with the same parameters up to direction, share an edge.

    Raises
    ------
    FileError
        Not XML, not G+Smo, no surface, a coefficient that is not a number, a surface whose parts
        do not fit together; closed pieces meet, and `solids` is "refuse".

    Warns
    -----
    ContigaWarning
        Geometry of other kinds is left out; closed pieces that meet were united or kept.
    """
    body, _ = _read_surfaces(path, file_unit, unit, choice)
    union = unite_pieces(body, body.pieces, solids, str(path))
    if union.message:
        warn(f"{path}: closed pieces {union.message}")
    return union.body


def list_gismo(
    path: Path, file_unit: str | None, unit: str | None, solids: Solids | None = None
) -> Inventory:
    """Return the inventory of a G+Smo file: one part, because the format names none.

    Closed pieces that meet are treated as in `read_gismo`; the message about them is in the
    inventory, not a warning.
    """
    body, label = _read_surfaces(path, file_unit, unit, ALL)
    union = unite_pieces(body, body.pieces, solids, str(path))
    return Inventory(union.body, [k + 1 for k in union.origin], [label], {}, union.message)


def _read_surfaces(
    path: Path, file_unit: str | None, unit: str | None, choice: Choice
) -> tuple[Body, PartLabel]:
    """Return the chosen surfaces as a body with shared edges, and the label of all of them.

    Lengths are scaled if both units are given; the body has a unit only with `file_unit`. Geometry
    of other kinds is left out, with a warning.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise FileError(f"not well-formed XML ({error})", where=str(path)) from error
    if root.tag != "xml":
        raise FileError(
            "not a G+Smo file", where=str(path), found=root.tag, allowed="the root element <xml>"
        )
    scale = 1.0
    if file_unit is not None and unit is not None:
        scale = length_factor(file_unit, unit, str(path))
    surfaces = []
    ignored_kinds = set()
    for number, element in enumerate(root.iter("Geometry")):
        kind = element.get("type", "")
        if kind in SURFACES:
            surfaces.append(_surface(element, scale, f"{path}, geometry {number}"))
        else:
            ignored_kinds.add(kind)
    if ignored_kinds:
        warn(f"{path}: geometry of type {', '.join(sorted(ignored_kinds))} was left out")
    faces = tuple(FaceLabel(k + 1, "NURBS") for k in range(len(surfaces)))
    label = PartLabel(1, "faces", faces)
    chosen = chosen_faces([label], choice, str(path))
    surfaces = [surface for k, surface in enumerate(surfaces, start=1) if k in chosen]
    assembly = Assembly(str(path))
    loops, edges = coincident_sides(surfaces)
    for surface, (loop, sides) in zip(surfaces, loops, strict=True):
        assembly.add_whole(surface, loop, sides)
    unit_name = short_name(unit or file_unit) if file_unit else None
    return assembly.body(path.stem, edges.get, unit_name), label


def _surface(element: ElementTree.Element, scale: float, where: str) -> NurbsSurface:
    """Return the surface of a <Geometry>, points times `scale`; planar ones get z = 0.

    Anything missing, not a number or of a wrong length is a `FileError`.
    """
    vectors = list(element.iter("KnotVector"))
    coefs = element.find("coefs")
    if len(vectors) != 2 or coefs is None:
        raise FileError(
            "a surface needs two knot vectors and coefs", where=where, found=len(vectors)
        )
    knots = [_numbers(vector, where) for vector in vectors]
    degrees = [_whole_number(vector, "degree", where) for vector in vectors]
    dimension = _whole_number(coefs, "geoDim", where)
    n, m = (len(U) - p - 1 for U, p in zip(knots, degrees, strict=True))
    values = _numbers(coefs, where)
    if dimension not in (2, 3) or n < 1 or m < 1 or values.size != n * m * dimension:
        raise FileError(
            "the number of coefs does not fit the knots",
            where=where,
            found=values.size,
            allowed=f"{n} · {m} points of 2 or 3 coordinates",
        )
    points = np.zeros((m, n, 3))
    points[..., :dimension] = values.reshape(m, n, dimension)
    weights: FloatArray | None = None
    node = element.find(".//weights")
    if node is not None:
        weights = _numbers(node, where)
        if weights.size != n * m:
            raise FileError(
                "one weight a point", where=where, found=weights.size, allowed=f"{n * m}"
            )
        weights = weights.reshape(m, n).T
    try:
        return NurbsSurface(
            (degrees[0], degrees[1]),
            (knots[0], knots[1]),
            points.transpose(1, 0, 2) * scale,
            weights,
        )
    except GeometryError as error:
        raise FileError(str(error), where=where) from error


def _numbers(element: ElementTree.Element, where: str) -> FloatArray:
    try:
        return np.array((element.text or "").split(), dtype=np.float64)
    except ValueError as error:
        raise FileError(
            f"<{element.tag}> holds something other than numbers", where=where
        ) from error


def _whole_number(element: ElementTree.Element, key: str, where: str) -> int:
    text = element.get(key, "")
    if not text.isdigit():
        raise FileError(f"<{element.tag}> needs a whole {key}", where=where, found=text)
    return int(text)
