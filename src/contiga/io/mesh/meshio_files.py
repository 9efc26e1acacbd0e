"""Meshes read by meshio, with its failures as errors of contiga."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.errors import FileError, InputError, MeshError
from contiga.io.mesh.gmsh_groups import physical_groups
from contiga.io.mesh.polygons import Blocks, blocks_of
from contiga.io.mesh.raw import Group, RawMesh
from contiga.records import FloatArray
from contiga.slaves.cells import N_NODES, SHELLS, SOLIDS
from contiga.slaves.skin import CellBlock

# Cell data with the part number of each cell, by format.
_PART_NUMBERS = (
    "gmsh:physical",
    "nastran:ref",
    "medit:ref",
    "avsucd:material",
    "cell_tags",
    "su2:tag",
    "netgen:index",
    "ugrid:ref",
    "flac3d:group",
    "tetgen:ref",
    "part",
    "part_id",
    "PartId",
)
_BAR = "line"
_IGNORED_KINDS = ("vertex", _BAR)
"""Prefixes of kinds that are left out; straight lines are kept as bars."""
_MAX_MESSAGE_LENGTH = 300
# meshio's readers of these never end on damaged files: wkt hangs in a regular expression, and
# tetgen opens its two files itself.
_EXCLUDED_FORMATS = {"wkt", "tetgen"}
# These readers ask for line after line until they find a keyword that a truncated file does not
# have; but they accept an open file, which raises an error after so many reads.
_GUARDED_MODES = {"tecplot": "r", "mdpa": "rb", "ansys": "rb", "ply": "rb"}
_MAX_READS_AFTER_END = 1000


def warm_up() -> None:
    """Load what readers need, before their time counts."""
    import meshio  # noqa: F401


def suffixes() -> list[str]:
    """Return the suffixes, sorted, of meshio's formats, without those whose readers may hang."""
    import meshio

    formats_by_suffix = meshio.extension_to_filetypes.items()
    return sorted(
        suffix for suffix, formats in formats_by_suffix if not _EXCLUDED_FORMATS.issuperset(formats)
    )


def read_with_meshio(path: Path) -> RawMesh:
    """Return points, cells and groups of any format that meshio reads.

    Points in a plane get z = 0; vertices and curved lines are left out. Groups are those of
    `_groups`. meshio prints, on some errors ends the program and on some damaged files never ends;
    here nothing is printed and every failure is a `FileError` with meshio's message.

    Raises
    ------
    FileError
        meshio cannot read the file, lacks a package for it, or no reader knows its suffix.
    MeshError
        Points of other than two or three coordinates; cells of a kind without facets, of a wrong
        number of nodes, or of a node that does not exist.
    """
    known_suffixes = suffixes()
    # meshio knows double suffixes too (.vol.gz).
    last, last_two = path.suffix.lower(), "".join(path.suffixes[-2:]).lower()
    if last not in known_suffixes and last_two not in known_suffixes:
        from contiga.io.cad import formats
        from contiga.io.mesh.read_mesh import OWN_SUFFIXES

        own_suffixes = [suffix for suffix in OWN_SUFFIXES if suffix not in known_suffixes]
        raise FileError(
            "no format of meshes has this suffix",
            where=str(path),
            found=path.suffix,
            allowed=" ".join([*own_suffixes, *known_suffixes]),
            remedy=f"CAD ({' '.join(formats.SUFFIXES)}) is read by read_cad, or in a case by "
            "geometry = { file = … }",
        )
    mesh = _read(path, (last_two, last))
    try:
        columns = np.asarray(mesh.points)
        if columns.size == 0:
            columns = np.empty((0, 3))
        if columns.ndim != 2 or columns.shape[1] not in (2, 3):
            raise MeshError(
                "points must have two or three coordinates", where=str(path), found=columns.shape
            )
        points = np.zeros((len(columns), 3))
        points[:, : columns.shape[1]] = columns
        pieces = [_split_block(block, points, path) for block in mesh.cells]
        blocks = tuple(block for piece in pieces for block in piece.blocks)
        return RawMesh(points, blocks, tuple(_groups(mesh, pieces)))
    except (ValueError, IndexError, KeyError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise _unreadable(path, f"its arrays do not fit together ({error})") from error


def _read(path: Path, endings: tuple[str, str]) -> Any:
    """Return meshio's mesh by the first format that reads it, of those with the first known ending.

    Raises
    ------
    FileError
        No format reads it; the message is that of the first one tried. A package is missing.
    """
    import meshio

    formats = next(f for e in endings if (f := meshio.extension_to_filetypes.get(e)))
    # Gmsh is the likelier of the two formats with suffix .msh.
    failures = []
    for file_format in sorted(formats, key=lambda name: name != "gmsh"):
        output = io.StringIO()
        try:
            with (
                contextlib.redirect_stdout(output),
                contextlib.redirect_stderr(output),
                warnings.catch_warnings(),
                np.errstate(all="ignore"),
                _source(path, file_format) as source,
                physical_groups() if file_format == "gmsh" else contextlib.nullcontext(),
            ):
                warnings.simplefilter("ignore")
                return meshio.read(source, file_format)
        except ImportError as error:
            raise FileError(
                f"reading {path.suffix} files needs a package that is not installed",
                where=str(path),
                remedy=f"{error}",
            ) from error
        except SystemExit:
            failures.append(f"{output.getvalue()} ")
        except Exception as error:
            # Readers fail in their own ways (KeyError, struct.error …) on bad files.
            failures.append(f"{output.getvalue()} {type(error).__name__} {error}")
    raise _unreadable(path, " ".join(failures[0].split())[:_MAX_MESSAGE_LENGTH])


@contextlib.contextmanager
def _source(path: Path, file_format: str) -> Iterator[Any]:
    """Provide what meshio reads: the path, or a guarded file for readers that hang at its end."""
    mode = _GUARDED_MODES.get(file_format)
    if mode is None:
        yield path
        return
    with _GuardedFile(io.FileIO(path)) as binary:
        if mode == "rb":
            yield binary
        else:
            yield _GuardedText(binary, encoding="utf-8", errors="replace")


class _GuardedFile(io.BufferedReader):
    """A binary file that raises EOFError when it is read again and again after its end."""

    _n_empty = 0

    def readline(self, size: int | None = -1, /) -> bytes:
        line = super().readline(size)
        self._n_empty = _count_empty_reads(self._n_empty, line)
        return line

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        self._n_empty = _count_empty_reads(self._n_empty, data)
        return data


class _GuardedText(io.TextIOWrapper):
    """A text file that raises EOFError when it is read again and again after its end."""

    _n_empty = 0

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        line = super().readline(size)
        self._n_empty = _count_empty_reads(self._n_empty, line)
        return line


def _count_empty_reads(count: int, data: bytes | str) -> int:
    """Return the count of reads without data in a row, with this one; 0 if this one has data.

    More than `_MAX_READS_AFTER_END` are an EOFError.
    """
    if data:
        return 0
    if count >= _MAX_READS_AFTER_END:
        raise EOFError("the file ends too early")
    return count + 1


def _unreadable(path: Path, reason: str) -> FileError:
    return FileError(
        f"cannot be read as {path.suffix}: {reason}" if reason else "cannot be read",
        where=str(path),
        allowed="a complete, undamaged mesh file whose content fits its suffix",
        remedy="What another program opens it can save anew, as .vtu, .msh, .inp or .stl",
    )


def _split_block(block: Any, points: FloatArray, path: Path) -> Blocks:
    """Return the blocks for a block of meshio: one, up to two for polygons, none for some kinds.

    Straight lines are kept as bars; vertices and curved lines have no block. Polygons of more than
    four corners are split, with a warning.

    Raises
    ------
    MeshError
        A kind without facets, an array that does not fit the kind, a node that does not exist.
    """
    kind = str(block.type)
    if kind.startswith(_IGNORED_KINDS) and kind != _BAR:
        return Blocks((), ())
    if kind == "polygon":
        rows = [np.asarray(row, dtype=np.int64) for row in block.data]
        for row in rows:
            check_cells("polygon", row[None, :], len(points), str(path))
        return blocks_of(points, [row.tolist() for row in rows], str(path))
    if kind not in N_NODES:
        raise MeshError(
            "cells of a kind that has no facets here",
            where=str(path),
            found=kind,
            allowed=", ".join([*SHELLS, "polygon", *SOLIDS]),
            remedy="Save the mesh with linear or quadratic cells.",
        )
    nodes = np.asarray(block.data, dtype=np.int64)
    if len(nodes) == 0:
        nodes = nodes.reshape(0, N_NODES[kind])
    if nodes.shape != (len(nodes), N_NODES[kind]):
        raise MeshError(
            f"a {kind} has {N_NODES[kind]} nodes",
            where=str(path),
            found=f"an array of shape {nodes.shape}",
        )
    check_cells(kind, nodes, len(points), str(path))
    return Blocks((CellBlock(kind, nodes),), (np.arange(len(nodes)),))


def check_cells(kind: str, nodes: NDArray[np.int64], n_points: int, where: str) -> None:
    """Refuse cells (m, k) that name a missing node.

    Raises
    ------
    MeshError
        A node is negative or not below `n_points`; the first such cell is named.
    """
    outside = np.flatnonzero(((nodes < 0) | (nodes >= n_points)).any(axis=1))
    if len(outside):
        raise MeshError(
            f"{kind} {int(outside[0])} (counted from 0) names a node that is not there",
            where=where,
            found=nodes[outside[0]].tolist(),
            allowed=f"0 to {n_points - 1}",
        )


def _groups(mesh: Any, pieces: list[Blocks]) -> Iterator[Group]:
    """Yield groups by number, ascending, then named sets of cells, then sets of nodes.

    Numbers are those of the first of `_PART_NUMBERS` that the mesh has; Gmsh numbers its physical
    groups separately by dimension, and 0 stands for no group there. Sets of cells with the name of
    a numbered group are skipped. `pieces` are the blocks made of each block of meshio.
    """
    key = next((key for key in _PART_NUMBERS if key in mesh.cell_data), None)
    by_dimension = key == "gmsh:physical"
    rows_by_number: dict[tuple[int, int], list[NDArray[Any] | None]] = {}
    numbered_blocks = () if key is None else zip(mesh.cells, mesh.cell_data[key], strict=True)
    for k, (block, numbers) in enumerate(numbered_blocks):
        if not pieces[k].blocks:
            continue
        values = np.asarray(numbers).reshape(len(block.data), -1).astype(np.int64)
        dimension = int(block.dim) if by_dimension else 0
        for value in np.unique(values):
            if by_dimension and value == 0:
                continue
            chosen = rows_by_number.setdefault((dimension, int(value)), [None] * len(pieces))
            chosen[k] = np.flatnonzero((values == value).any(axis=1))
    titles = {}
    if by_dimension:
        titles = {(int(dim), int(n)): str(name) for name, (n, dim) in mesh.field_data.items()}
    names: set[str | None] = set()
    for (dimension, value), chosen in sorted(rows_by_number.items()):
        names.add(titles.get((dimension, value)))
        yield Group(value, titles.get((dimension, value)), _cells_of(pieces, chosen))
    for name, rows_by_block in mesh.cell_sets.items():
        if name in names or name.startswith("gmsh:"):
            continue
        # meshio may give fewer rows than blocks, and None for a block without cells of the set.
        rows_of_set: list[NDArray[Any] | None] = [None] * len(pieces)
        for k, rows in zip(range(len(pieces)), rows_by_block, strict=False):
            rows_of_set[k] = None if rows is None else np.asarray(rows, dtype=np.int64)
        yield Group(None, str(name), _cells_of(pieces, rows_of_set))
    for name, nodes in mesh.point_sets.items():
        yield Group(None, str(name), None, np.asarray(nodes, dtype=np.int64))


def _cells_of(
    pieces: list[Blocks], chosen: Sequence[NDArray[Any] | None]
) -> tuple[NDArray[Any], ...]:
    """Return the rows (k,) in each block of `pieces` that come from `chosen`.

    `chosen` has the rows in each block of meshio, None for no rows.
    """
    empty: NDArray[Any] = np.empty(0, dtype=np.int64)
    return tuple(
        rows
        for piece, cells in zip(pieces, chosen, strict=True)
        for rows in (piece.rows(cells) if cells is not None else [empty] * len(piece.blocks))
    )
