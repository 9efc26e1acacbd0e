"""The union of closed pieces of a body that touch or overlap, as for solids of a STEP file.

`contiga.io.cad.unite` unites solids of OpenCASCADE; here the pieces of a body of any source become
such solids, and the faces of the union patches of a body again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import GeometryError
from contiga.extras import require
from contiga.geometry.piece import piece_of
from contiga.io.cad.assemble import Assembly, merge_bodies, warn
from contiga.io.cad.occ_parts import NO_ATTRIBUTES, Piece
from contiga.io.cad.occ_solids import Solid, hollow_out, solid_of, volume_of
from contiga.io.cad.parts import Solids
from contiga.io.cad.sew import SewnEdges, subshapes
from contiga.io.cad.step_iges import edge_of, gather
from contiga.io.cad.unite import (
    Meeting,
    Numbered,
    between,
    contact_distance,
    inside,
    meeting_boxes,
    meeting_message,
    middle,
    place_faces,
    separate_message,
)
from contiga.masters.body import Body
from contiga.records import IndexArray

SIZE = 4096.0
"""Size to which a body is scaled for OpenCASCADE, whose tolerances are lengths."""

Patches = tuple[int, ...]
Describe = Callable[[Sequence[Patches]], str]


class United(NamedTuple):
    """A body whose closed pieces were checked, and the changes."""

    body: Body
    """The body with its pieces united, or the original one."""
    origin: list[int]
    """Original patch of each patch, which is or contains it, ascending."""
    met: list[list[Patches]]
    """Original patches of pieces that touch or overlap one another."""
    message: str
    """Message about them, "" if there are none."""


def unite(*bodies: Body) -> Body:
    """Unite bodies: closed pieces that touch or overlap are fused by OpenCASCADE.

    A point is inside if it is inside any piece. A piece is a set of patches connected by edges; a
    piece that faces inward is a cavity of the piece around it. Pieces that touch nothing stay as
    they are. Pass bodies that share whole edges, such as tiles, as separate arguments.

    Returns
    -------
    Body
        Named after the first, in its unit and about its reference point.

    Raises
    ------
    GeometryError
        No bodies, or units that differ.
    MissingPackageError
        Pieces come near each other, and OpenCASCADE is not installed (extra ``cad``).

    Warns
    -----
    ContigaWarning
        OpenCASCADE cannot unite some pieces, which stay as they are; the text says where they meet.

    Examples
    --------
    >>> import contiga as cg
    >>> box = [cg.shapes.sphere(radius=1.0, centre=(x, 0.0, 0.0)) for x in (0.0, 1.0)]
    >>> two = cg.Body(box)
    >>> two.closed
    False
    >>> both = cg.unite(two)  # two balls of 4/3 pi less the lens of 5/12 pi that they share
    >>> both.closed, round(both.volume() / math.pi, 6)
    (True, 2.25)
    """
    units = {body.unit for body in bodies}
    if len(units) != 1:
        raise GeometryError(
            "bodies to be united have one length unit" if units else "there is nothing to unite",
            where="unite",
            found=sorted(map(str, units)),
        )
    first = bodies[0]
    merged = merge_bodies(list(bodies), Path(first.name), first.unit)
    starts = np.cumsum([0, *(len(body.patches) for body in bodies)])
    pieces = [
        start + piece for start, body in zip(starts, bodies, strict=False) for piece in body.pieces
    ]
    union = unite_pieces(merged, pieces, "union", first.name)
    if union.message:
        warn(f"{first.name}: pieces {union.message}")
    return union.body.renamed(first.name).with_reference_point(first.reference_point)


def _patch_numbers(groups: Sequence[Patches]) -> str:
    return " and ".join(
        f"patch {min(group)}" if len(group) == 1 else f"patches {min(group)} to {max(group)}"
        for group in groups
    )


def unite_pieces(
    body: Body,
    pieces: Sequence[IndexArray],
    solids: Solids | None,
    where: str,
    *,
    accuracy: float = 0.0,
    describe: Describe = _patch_numbers,
) -> United:
    """Return the body with its closed pieces united if they touch or overlap.

    It stays the same object if no boxes meet, nothing is to be united, or OpenCASCADE makes no
    sound union; the message then says so. Else patches follow the order of those they come from.

    Parameters
    ----------
    body : the body
    pieces : patches of each piece; open ones are left alone
    solids : treatment of pieces that meet, as for `read_cad`
    where : for messages
    accuracy : distance up to which pieces touch, length
    describe : function from patches to the words for their pieces

    Raises
    ------
    FileError
        Pieces meet, and `solids` is "refuse".
    MissingPackageError
        Pieces are to be united, and OpenCASCADE is not installed.
    """
    all_patches = list(range(len(body.patches)))
    boxes = {k: piece_of(body, piece.tolist()).bounds() for k, piece in enumerate(pieces)}
    scale = scale_of(body)
    scaled = {k: scale * box for k, box in boxes.items()}
    groups = meeting_boxes(scaled, contact_distance(scaled, accuracy * scale))
    if not groups or solids == "separate":
        met = [[tuple(pieces[k].tolist()) for k in group] for group in groups]
        places = [Meeting(tuple(group), between(boxes, group)).describe(1.0) for group in groups]
        texts = [f"{describe(group)} {place}" for group, place in zip(met, places, strict=True)]
        return United(body, all_patches, met, separate_message(texts) if met else "")
    require("uniting pieces that touch or overlap", "OCP")
    from contiga.io.cad.occ_geometry import quiet

    with quiet():
        members = sorted(k for group in groups for k in group)
        parts = as_solids(body, [pieces[k].tolist() for k in members], scale)
        rows = [Piece("solid", part.shape, part.faces, NO_ATTRIBUTES, [], (), ()) for part in parts]
        owner = [patch for part in parts for patch in part.patches]
        placed = place_faces(rows, range(1, len(owner) + 1), accuracy * scale, solids)
        met = [[tuple(sorted(parts[k].patches)) for k in m.pieces] for m in placed.meetings]
        places = [m.describe(1.0 / scale) for m in placed.meetings]
        texts = [f"{describe(group)} {place}" for group, place in zip(met, places, strict=True)]
        message = meeting_message(placed, texts, solids, where)
        if not (met and placed.is_sound):
            return United(body, all_patches, met, message)
        replaced = {patch for group in met for piece in group for patch in piece}
        faces = [(owner[n - 1], face) for n, face in placed.faces if owner[n - 1] in replaced]
        new, origin = as_patches(faces, placed.shape, scale, where, body.unit)
    unchanged = [k for k in all_patches if k not in replaced]
    origin += unchanged
    order = np.argsort(origin, kind="stable").tolist()
    bodies = [new, piece_of(body, unchanged)] if unchanged else [new]
    merged = merge_bodies(bodies, Path(where), body.unit)
    return United(piece_of(merged, order), [origin[k] for k in order], met, message)


def scale_of(body: Body) -> float:
    """Return the power of two that brings the size of a body nearest to `SIZE`, by ratio."""
    return float(2.0 ** round(math.log2(SIZE / body.size)))


def as_solids(body: Body, pieces: Sequence[Sequence[int]], scale: float) -> list[Solid]:
    """Return the closed pieces as solids of OpenCASCADE, lengths · `scale`, by their first patch.

    A piece that faces inward is cut out of the smallest solid around a point of it; without one, or
    if the cut fails, it is left out. So are pieces of which no solid can be made.
    """
    outward: list[Solid] = []
    cavities: list[Solid] = []
    for patches in pieces:
        solid = solid_of(body, patches, scale)
        if solid is not None:
            (outward if piece_of(body, patches).volume() > 0.0 else cavities).append(solid)
    outward.sort(key=lambda solid: volume_of(solid.shape))
    for cavity in cavities:
        point = np.array([middle(subshapes(cavity.shape, "EDGE")[0])])
        for k, solid in enumerate(outward):
            if inside([solid.shape], point)[0] == 1.0:
                outward[k] = hollow_out(solid, cavity) or solid
                break
    return sorted(outward, key=lambda solid: min(solid.patches))


def as_patches(
    faces: Sequence[Numbered], shape: Any, scale: float, where: str, unit: str | None
) -> tuple[Body, list[int]]:
    """Return faces of OpenCASCADE, lengths divided by `scale`, as a body, and the number of each.

    Edges are those of `shape`; faces without extent are left out, with a warning.
    """
    assembly, edges = Assembly(where), SewnEdges(shape)
    numbers = gather(assembly, faces, edges, 1.0 / scale, f"{where}, patch")
    return assembly.body(where, partial(edge_of, edges, 1.0 / scale, 0.0), unit), numbers
