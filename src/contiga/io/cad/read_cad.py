"""`read_cad`: read a CAD file as a `Body`."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from contiga.errors import ContigaWarning, FileError
from contiga.extras import require
from contiga.io.cad.formats import FORMATS, SUFFIXES, reader
from contiga.io.cad.parts import Solids, checked_solids, choice_of
from contiga.io.cad.read_cache import read_cached
from contiga.io.naming import PartKeys
from contiga.io.units import base_factor

if TYPE_CHECKING:
    from contiga.masters.body import Body

_BODY = "contiga.masters.body"
MAX_COORDINATE = 1e100
"""Largest coordinate that is read."""
MIN_SPLINE_DEGREE = 3
"""Smallest degree of patches that are checked for self-intersection: lower ones are arcs, lines."""


def read_cad(
    path: str | Path,
    *,
    unit: str | None = None,
    file_unit: str | None = None,
    parts: PartKeys | None = None,
    faces: int | Iterable[int] | None = None,
    solids: Solids | None = None,
) -> Body:
    """Read the faces of a CAD file, or of some of its parts, as a body.

    STEP, IGES, 3DM and G+Smo XML. Every face becomes a NURBS patch with its trimming loops as
    p-curves, in the file's order, orientation (solids outward) and placement. A face whose loops
    are the borders of a rectangle becomes an untrimmed patch. ``Body.edges`` lists the joints.

    Parameters
    ----------
    path : the file; its suffix determines the format
    unit : length unit of the body, such as "mm"; None for the unit of the file
    file_unit : length unit of the file's numbers, if the file states none or a wrong one
    parts : names or numbers (from 1) that `cad_parts` and ``contiga info`` list: names of parts,
        products, instances and assemblies; "arm/bolt" is the bolt of the arm
    faces : numbers of faces, from 1 in the file's order, in addition to those of `parts`
    solids : treatment of solids that touch or overlap. "union" unites them; if omitted, with a
        warning. "separate" keeps each, and the body is not closed (see `cad_parts`). "refuse"
        makes an error

    Returns
    -------
    Body
        ``Body.unit`` is `unit`, else the file's. Without that, and without `file_unit`, it is None,
        and numbers are kept as they are.

    Raises
    ------
    FileError
        Missing, empty, damaged, of another format, without faces, of an unknown suffix; it crashes
        its reader, or takes more than the time or memory of `contiga.io.limits`; `solids`.
    GeometryError
        `parts` or `faces` choose nothing; the message lists what the file has.
    MissingPackageError, UnitError
        The package that reads the format is not installed; a unit, also that of the file, is not
        a length unit.

    Warns
    -----
    ContigaWarning
        Faces are left out, kept whole, or separated by a slit; solids touch or overlap: see
        files.md.

    Examples
    --------
    >>> box = read_cad("part.step", unit="cm")  # 20 by 30 by 40 mm
    >>> len(box.patches), len(box.edges), box.closed, box.bounds()[1].round(6).tolist()
    (6, 12, True, [2.0, 3.0, 4.0])
    """
    file = Path(path)
    options = file_unit, unit, choice_of(parts, faces), checked_solids(solids)
    target = reader_of(file, "read", file_unit, unit)
    check = partial(check_body, file=file)
    body: Body = read_cached(target, file, *options, needs=_BODY, check=check)
    check_joints(body, file, solids)
    return body


def reader_of(file: Path, verb: str, file_unit: str | None, unit: str | None) -> str:
    """Return the target of `read_in_worker` for an existing, nonempty file of a known format.

    `verb` selects the function of the reader: "read" makes a `Body`, "list" an `Inventory`.

    Raises
    ------
    FileError, MissingPackageError, UnitError
        As `read_cad`.
    """
    suffix = file.suffix.lower()
    if suffix not in SUFFIXES:
        close = get_close_matches(suffix, SUFFIXES, n=1)
        raise FileError(
            "not a CAD format contiga reads",
            where=str(file),
            found=file.suffix or file.name,
            allowed=", ".join(SUFFIXES),
            remedy=f"Did you mean {close[0]}?" if close else None,
        )
    for key, value in (("unit", unit), ("file_unit", file_unit)):
        if value is not None:
            base_factor(value, "length", key)
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
    require(f"reading {suffix} files", *FORMATS[suffix].packages)
    return reader(suffix, verb)


def check_body(body: Body, file: Path) -> None:
    """Refuse bodies that cannot be computed with.

    Raises
    ------
    FileError
        A coordinate of a control point exceeds `MAX_COORDINATE`, or a patch of degree
        `MIN_SPLINE_DEGREE` or more crosses itself or another one of its piece.
    """
    from contiga.geometry.piece import piece_of

    for k, patch in enumerate(body.patches):
        largest = float(abs(patch.control_points).max())
        if largest > MAX_COORDINATE:
            raise FileError(
                "a control point is too far from the origin to compute with",
                where=f"{file}, patch {k}",
                found=largest,
                allowed=f"coordinates up to {MAX_COORDINATE:g}",
            )
    splines = [k for k, patch in enumerate(body.patches) if max(patch.degrees) >= MIN_SPLINE_DEGREE]
    # The whole body is checked anyway; if it has no crossing, no part of it has one.
    if not splines or body.openings.crossing is None:
        return
    checked = body if len(splines) == len(body.patches) else piece_of(body, splines)
    crossing = checked.openings.crossing
    if crossing is not None:
        a, b = (splines[k] for k in crossing.patches)
        raise FileError(
            "a face goes through itself: it has no side",
            where=f"{file}, patch {a}",
            found=str(crossing._replace(patches=(a, b))),
            allowed="faces that do not meet themselves",
            remedy="Make bends wider or cut it there in the program that wrote the file, "
            "or choose other parts",
        )


def check_joints(body: Body, file: Path, solids: Solids | None = None) -> None:
    """Warn of gaps at joints and of solids that nearly touch; refuse those that meet on request.

    Raises
    ------
    FileError
        Pieces of the body meet, and `solids` is "refuse".

    Warns
    -----
    ContigaWarning
        An edge of several faces has a gap above rounding; random points show pieces that are apart
        by less than `contiga.io.cad.near_solids.SLIT_TOL` of their size.
    """
    from contiga.geometry.slits import ROUNDING
    from contiga.io.cad.near_solids import slits_between

    size = body.size
    if any(len(edge.uses) > 1 and edge.gap > ROUNDING * size for edge in body.edges):
        text = "; ".join(body.openings.flaws)
        warnings.warn(f"{file}: {text}", ContigaWarning, stacklevel=3)
    slits = slits_between(body)
    if slits:
        warnings.warn(
            f"{file}: solids nearly touch: {'; '.join(map(str, slits))}. Points that slide over "
            "such a slit are pushed sideways: close it where the file was made",
            ContigaWarning,
            stacklevel=3,
        )
    if solids == "refuse" and body.openings.meetings:
        raise FileError(
            "solids touch or overlap",
            where=str(file),
            found="; ".join(map(str, body.openings.meetings)),
            allowed="solids that are apart",
            remedy="parts chooses some",
        )
