"""`read_cad`: a CAD file becomes a `Body`."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path

from contiga.errors import ContigaWarning, FileError
from contiga.geometry.body import Body
from contiga.geometry.slits import ROUNDING
from contiga.geometry.summary import body_summary
from contiga.io.units import base_factor

__all__ = ["SUFFIXES", "body_summary", "read_cad"]

Reader = Callable[[Path, str | None, str | None], Body]
SUFFIXES = (".step", ".stp", ".iges", ".igs", ".3dm", ".xml")


def read_cad(path: str | Path, unit: str | None = None, *, file_unit: str | None = None) -> Body:
    """Read the faces of a CAD file as a body.

    STEP and IGES (OpenCASCADE), 3DM (rhino3dm) and G+Smo XML. Every face becomes a NURBS patch
    with its trimming loops as p-curves, in the file's order of faces, oriented as the file says
    (solids outward), placed as the assembly says. A face whose loops are the borders of a
    rectangle in (u, v) becomes an untrimmed patch cut down to it. Which faces share an edge is
    kept in ``Body.edges``.

    Parameters
    ----------
    path : the file; its suffix tells the format
    unit : length unit wanted, such as "mm"; None keeps the file's own
    file_unit : length unit of the file's numbers, where the file says none or the wrong one

    Returns
    -------
    Body
        ``Body.unit`` is `unit`, else the file's. Numbers of a file that says no unit are kept as
        they are, and ``Body.unit`` is None, unless `file_unit` is given.

    Raises
    ------
    FileError
        Missing, empty, damaged, of another format, without faces, of an unknown suffix.
    UnitError
        `unit`, `file_unit` or the file's own unit is no length unit.

    Warns
    -----
    ContigaWarning
        A face without extent is left out; a face whose loops do not close is kept whole; faces
        that share an edge are apart there by more than 1e-4 of the size: a slit, which the search
        bridges where the file's tolerances allow it.
    """
    file = Path(path)
    reader = _reader(file)
    for key, value in (("unit", unit), ("file_unit", file_unit)):
        if value is not None:
            base_factor(value, "length", key)
    _check_readable(file)
    body = reader(file, file_unit, unit)
    size = body.size
    if any(len(edge.uses) > 1 and edge.gap > ROUNDING * size for edge in body.edges):
        text = "; ".join(body.openings.flaws)
        warnings.warn(f"{file}: {text}", ContigaWarning, stacklevel=2)
    return body


def _reader(file: Path) -> Reader:
    suffix = file.suffix.lower()
    if suffix in (".step", ".stp", ".iges", ".igs"):
        from contiga.io.step_iges import read_step_iges

        return read_step_iges
    if suffix == ".3dm":
        from contiga.io.rhino import read_rhino

        return read_rhino
    if suffix == ".xml":
        from contiga.io.gismo import read_gismo

        return read_gismo
    close = get_close_matches(suffix, SUFFIXES, n=1)
    raise FileError(
        "not a CAD format contiga reads",
        where=str(file),
        found=file.suffix or file.name,
        allowed=", ".join(SUFFIXES),
        remedy=f"Did you mean {close[0]}?" if close else None,
    )


def _check_readable(file: Path) -> None:
    """Raise FileError unless `file` is a file with something in it that may be read."""
    if not file.exists():
        raise FileError("no such file", where=str(file))
    if not file.is_file():
        raise FileError("not a file", where=str(file))
    try:
        with file.open("rb") as stream:
            head = stream.read(1)
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(file)) from error
    if not head:
        raise FileError("the file is empty", where=str(file))
