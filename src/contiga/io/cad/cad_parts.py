"""`cad_parts`: the contents of a CAD file, part by part."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from contiga.display import Facts, line_of, table_of
from contiga.io.cad.parts import FaceLabel, Solids, titled
from contiga.io.cad.read_cache import read_cached
from contiga.io.cad.read_cad import check_body, check_joints, reader_of

if TYPE_CHECKING:
    from contiga.io.cad.parts import Inventory
    from contiga.masters.body import Body

_SUMMARY = "contiga.masters.body_summary"


class CadPart(NamedTuple):
    """A part of a CAD file: its name, place and colour there, and its faces as a body.

    >>> import contiga as cg
    >>> part = cg.cad_parts("part.step")[0]
    >>> part.number, part.kind, part.faces[0].kind, part.body.closed
    (1, 'solid', 'plane', True)
    """

    number: int
    """Number of the part, from 1, in the file's order."""
    name: str | None
    """Its own name, or that of its product; None if the file gives none."""
    place: str
    """Names of its instances from the outside in, as "left arm/bolt 2"; "" outside assemblies."""
    kind: str
    """"solid", "shell", or "faces": connected faces that are not a shell."""
    colour: str | None
    """Colour "#rrggbb"; None if the file gives none."""
    faces: tuple[FaceLabel, ...]
    """Its faces in the file; a face without area is no patch of `body`."""
    body: Body
    """The part alone, at its place, as `read_cad` reads it."""

    @property
    def title(self) -> str:
        """Name and place in the assembly: "bolt (left arm/bolt 2)"; "" without either."""
        return titled(self.name, self.place)

    def _facts(self) -> Facts:
        where = [("in", self.place)] if self.place else []
        return [("number", self.number), *where, ("kind", self.kind), ("faces", len(self.faces))]

    def __repr__(self) -> str:
        return line_of("CadPart", self._facts(), self.name or "")

    def _repr_html_(self) -> str:
        return table_of("CadPart", self._facts(), self.name or "")


class CadFile(NamedTuple):
    """A CAD file as a whole and part by part."""

    body: Body
    """All of it, as `read_cad` reads it."""
    numbers: list[int]
    """Number of the face in the file for each patch of `body`."""
    parts: tuple[CadPart, ...]
    message: str
    """Message about solids that touch or overlap, "" if none do."""


def cad_parts(
    path: str | Path, *, unit: str | None = None, file_unit: str | None = None
) -> tuple[CadPart, ...]:
    """Return the parts of a CAD file: solids, shells that bound none, and loose faces.

    A part of an assembly is listed once for each instance, at its place. Loose faces that share
    edges make one part. A part whose faces all have no extent is left out. Solids that touch or
    overlap stay separate bodies: nothing is united.

    Parameters
    ----------
    path, unit, file_unit : as for `read_cad`

    Returns
    -------
    tuple of `CadPart`, in the file's order

    Raises
    ------
    FileError, MissingPackageError, UnitError
        As `read_cad`.

    Examples
    --------
    >>> import contiga as cg
    >>> for part in cg.cad_parts("part.step", unit="cm"):
    ...     print(part.number, part.kind, part.body.closed, round(part.body.volume(), 6))
    1 solid True 24.0
    """
    return read_cad_file(path, unit=unit, file_unit=file_unit, solids="separate").parts


def read_cad_file(
    path: str | Path,
    *,
    unit: str | None = None,
    file_unit: str | None = None,
    solids: Solids | None = None,
) -> CadFile:
    """Return a whole file with its parts; parameters and errors as for `read_cad`.

    Parts without a patch are left out. A part that is joined to others is read alone; the single
    part of a file is the whole body, with its name. Slits give warnings as in `read_cad`.
    """
    file = Path(path)
    inventory: Inventory = read_cached(
        reader_of(file, "list", file_unit, unit),
        file,
        file_unit,
        unit,
        solids,
        needs=_SUMMARY,
        check=lambda inventory: check_body(inventory.body, file),
    )
    check_joints(inventory.body, file)
    from contiga.geometry.piece import piece_of  # after the worker has started

    patches: dict[int, list[int]] = {part.number: [] for part in inventory.parts}
    owner = {face.number: part.number for part in inventory.parts for face in part.faces}
    for k, number in enumerate(inventory.numbers):
        patches[owner[number]].append(k)
    parts = []
    for label in inventory.parts:
        if len(inventory.parts) == 1:
            body: Body | None = inventory.body
        elif label.number in inventory.apart:  # joined to others: the reader has read it alone
            body = inventory.apart[label.number].renamed(label.title)
        elif patches[label.number]:
            body = piece_of(inventory.body, patches[label.number]).renamed(label.title)
        else:
            body = None
        if body is not None:
            place = "/".join(label.place)
            part = CadPart(
                label.number, label.name, place, label.kind, label.colour, label.faces, body
            )
            parts.append(part)
    return CadFile(inventory.body, inventory.numbers, tuple(parts), inventory.message)
