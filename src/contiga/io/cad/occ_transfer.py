"""Transfer of STEP and IGES files into OpenCASCADE: shapes, names, colours and the unit."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from contiga.errors import FileError
from contiga.io.cad.assemble import warn
from contiga.io.cad.cad_numbers import check_numbers
from contiga.io.cad.formats import IGES_SUFFIXES
from contiga.io.cad.occ_parts import Piece, new_document, pieces_of

_UNCERTAINTY = re.compile(
    rb"UNCERTAINTY_MEASURE_WITH_UNIT\s*\(\s*LENGTH_MEASURE\s*\(\s*([\d.+\-Ee]+)\s*\)"
)
_IGES_UNITS = {1: "in", 2: "mm", 4: "ft", 5: "mile", 6: "m", 7: "km", 8: "thou", 9: "um"}
_IGES_UNITS |= {10: "cm", 11: "microinch"}
_UNUSED_MODES = ("Layer", "GDT", "Mat", "Props", "View", "SHUO", "Meta", "ProductMeta")
"""Modes of a STEP reader that are switched off, because they take time."""


class Transfer(NamedTuple):
    """The result of OpenCASCADE's transfer."""

    pieces: list[Piece]
    unit: str | None
    """Length unit the file states, None if it states none."""
    accuracy: float
    """Distance of equal points according to the file, in its unit; 0 if it states none."""


def transfer_file(path: Path) -> Transfer:
    """Return the pieces of a STEP or IGES file, in millimetres, with its unit and accuracy.

    Raises
    ------
    FileError
        The file does not match its suffix, or is damaged; a number is not finite.

    Warns
    -----
    ContigaWarning
        A STEP file has parts in several length units.
    """
    check_numbers(path)
    is_iges = path.suffix.lower() in IGES_SUFFIXES
    return _transfer_iges(path) if is_iges else _transfer_step(path)


def _transfer_step(path: Path) -> Transfer:
    """Transfer a STEP file, with its first length unit and the largest uncertainty it states.

    Without any, unit None and accuracy 0. Several units give a warning. Another or a damaged file
    is a `FileError`.
    """
    from OCP.collections import Sequence_TCollection_AsciiString
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Reader

    with path.open("rb") as file:
        head = file.read(4096)
    if b"ISO-10303-21" not in head:
        raise FileError(
            "not a STEP file",
            where=str(path),
            found=head[:24].decode("latin-1"),
            allowed="a file that begins with ISO-10303-21;",
        )
    reader = STEPCAFControl_Reader()
    for mode in _UNUSED_MODES:
        getattr(reader, f"Set{mode}Mode")(False)
    Interface_Static.SetIVal_s("read.stepcaf.subshapes.name", 1)  # of solids inside a product
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise FileError("the STEP file cannot be read: it is damaged", where=str(path))
    names = [Sequence_TCollection_AsciiString() for _ in range(3)]
    reader.ChangeReader().FileUnits(*names)
    units = list(dict.fromkeys(name.ToCString() for name in names[0]))
    if len(units) > 1:
        warn(f"{path}: parts in several length units {units}; {units[0]} is taken as the file's")
    document = new_document()
    reader.Transfer(document)
    uncertainties = map(float, _UNCERTAINTY.findall(path.read_bytes()))
    accuracy = max(uncertainties, default=0.0)
    return Transfer(pieces_of(document), units[0] if units else None, accuracy)


def _transfer_iges(path: Path) -> Transfer:
    """Transfer an IGES file; unit (None if unknown) and accuracy come from its global section.

    Another or a damaged file is a `FileError`.
    """
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESCAFControl import IGESCAFControl_Reader

    with path.open("rb") as file:
        first = file.readline(200).rstrip(b"\r\n")
    if len(first) < 73 or first[72:73] not in b"SBC":
        raise FileError(
            "not an IGES file",
            where=str(path),
            found=first[:24].decode("latin-1"),
            allowed="80-column lines with S in column 73 of the first",
        )
    reader = IGESCAFControl_Reader()
    reader.SetLayerMode(False)
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise FileError("the IGES file cannot be read: it is damaged", where=str(path))
    header = reader.IGESModel().GlobalSection()
    unit = _IGES_UNITS.get(header.UnitFlag())
    if unit is None and header.UnitName() is not None:
        unit = header.UnitName().ToCString().strip() or None
    document = new_document()
    reader.Transfer(document)
    return Transfer(pieces_of(document), unit, float(header.Resolution()))
