"""Meshes read by meshio, with its failures as errors of ours."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import FileError, InputError, MeshError
from contiga.io.mesh.gmsh_groups import physical_groups
from contiga.io.mesh.guarded import GuardedFile, GuardedText
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
_PASSED_OVER = ("vertex", _BAR)
"""Prefixes of kinds that are left out; straight lines are kept as bars."""
_MESSAGE_LENGTH = 300
# meshio's readers of these never end on damaged files: wkt is lost in a regular expression and
# tetgen opens its two files itself.
_NOT_READ = {"wkt", "tetgen"}
# These ask for line after line at the end of a file cut short, but take an open file.
_SPINNING = {"tecplot": "r", "mdpa": "rb", "ansys": "rb", "ply": "rb"}


def warm_up() -> None:
    """Load what readers need, before their time counts."""
    import meshio  # noqa: F401


def suffixes() -> list[str]:
    """Return the file suffixes that can be read."""
    import meshio

    known = meshio.extension_to_filetypes.items()
    return sorted(ending for ending, formats in known if not _NOT_READ.issuperset(formats))


def read_with_meshio(path: Path) -> RawMesh:
    """Return points, cells and groups of any format that meshio reads.

    meshio prints, on some errors ends the program and on some damaged files never ends; here
    nothing is printed and every failure is a `FileError` with what meshio had to say.

    Raises
    ------
    FileError
        meshio could not make sense of the file, or no reader knows its suffix.
    MeshError
        The mesh has cells of a kind that has no facets here.
    """
    _refuse_unknown(path)
    mesh = _read(path)
    try:
        return _raw_mesh(mesh, path)
    except (ValueError, IndexError, KeyError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise _unreadable(path, f"its arrays do not fit together ({error})") from error


def _refuse_unknown(path: Path) -> None:
    from contiga.io.cad import formats
    from contiga.io.mesh import cloud_files, lsdyna

    known = suffixes()
    # meshio knows double endings too (.vol.gz).
    if path.suffix.lower() not in known and "".join(path.suffixes[-2:]).lower() not in known:
        raise FileError(
            "no format of meshes has this suffix",
            where=str(path),
            found=path.suffix,
            allowed=" ".join([*lsdyna.SUFFIXES, *cloud_files.SUFFIXES, *known]),
            remedy=f"CAD ({' '.join(formats.SUFFIXES)}) is read by read_cad, or in a case by "
            "geometry = { file = … }",
        )


def _raw_mesh(mesh: Any, path: Path) -> RawMesh:
    points = _three_columns(np.asarray(mesh.points), path)
    blocks: list[CellBlock] = []
    places: list[_Place] = []
    for block in mesh.cells:
        made = _blocks(block, points, path)
        places.append(_Place(len(blocks), made))
        blocks += made.blocks
    return RawMesh(points, tuple(blocks), tuple(_groups(mesh, places, len(blocks))))


def _read(path: Path) -> Any:
    """Return the meshio mesh, from the first format with this suffix that fits."""
    import meshio

    endings = ("".join(path.suffixes[-2:]).lower(), path.suffix.lower())
    formats = next(f for e in endings if (f := meshio.extension_to_filetypes.get(e)))
    # Gmsh is the likelier of the two formats with suffix .msh.
    failures = []
    for file_format in sorted(formats, key=lambda name: name != "gmsh"):
        heard = io.StringIO()
        try:
            with (
                contextlib.redirect_stdout(heard),
                contextlib.redirect_stderr(heard),
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
        except (Exception, SystemExit) as error:
            # Readers fail in their own ways (KeyError, struct.error …) on bad files.
            failures.append(f"{heard.getvalue()} {_words(error)}")
    raise _unreadable(path, " ".join(failures[0].split())[:_MESSAGE_LENGTH])


@contextlib.contextmanager
def _source(path: Path, file_format: str) -> Iterator[Any]:
    """Provide meshio's source: the path, or a guarded file for readers that hang at its end."""
    mode = _SPINNING.get(file_format)
    if mode is None:
        yield path
        return
    with GuardedFile(io.FileIO(path)) as binary:
        if mode == "rb":
            yield binary
        else:
            yield GuardedText(binary, encoding="utf-8", errors="replace")


def _unreadable(path: Path, said: str) -> FileError:
    return FileError(
        f"cannot be read as {path.suffix}: {said}" if said else "cannot be read",
        where=str(path),
        allowed="a complete, undamaged mesh file whose content fits its suffix",
        remedy="What another program opens it can save anew, as .vtu, .msh, .inp or .stl",
    )


def _words(error: BaseException) -> str:
    return "" if isinstance(error, SystemExit) else f"{type(error).__name__} {error}"


def _three_columns(points: NDArray[Any], path: Path) -> FloatArray:
    if points.size == 0:
        return np.empty((0, 3))
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise MeshError(
            "points must have two or three coordinates", where=str(path), found=points.shape
        )
    full = np.zeros((len(points), 3))
    full[:, : points.shape[1]] = points
    return full


class _Place(NamedTuple):
    """Places of the cells of one of meshio's blocks."""

    first: int
    """Number of the first block made from it."""
    made: Blocks

    def put(self, cells: NDArray[Any], into: list[NDArray[Any]]) -> None:
        """Set the rows of the blocks that come from some of the cells."""
        for k, rows in enumerate(self.made.rows(cells)):
            into[self.first + k] = rows


def _blocks(block: Any, points: FloatArray, path: Path) -> Blocks:
    """Return the blocks for a block of meshio's.

    They are one or two for polygons, none for curved lines, and else one.
    """
    kind = str(block.type)
    if kind.startswith(_PASSED_OVER) and kind != _BAR:
        return Blocks((), ())
    if kind == "polygon":
        rows = [np.asarray(row, dtype=np.int64) for row in block.data]
        for row in rows:
            check_cells("polygon", row[None, :], len(points), str(path))
        return blocks_of(points, [row.tolist() for row in rows], str(path))
    piece = _block(kind, block, len(points), path)
    return Blocks((piece,), (np.arange(len(piece.nodes)),))


def _block(kind: str, block: Any, n_points: int, path: Path) -> CellBlock:
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
    check_cells(kind, nodes, n_points, str(path))
    return CellBlock(kind, nodes)


def check_cells(kind: str, nodes: NDArray[np.int64], n_points: int, where: str) -> None:
    """Refuse a cell that names a missing node."""
    outside = np.flatnonzero(((nodes < 0) | (nodes >= n_points)).any(axis=1))
    if len(outside):
        raise MeshError(
            f"{kind} {int(outside[0])} (counted from 0) names a node that is not there",
            where=where,
            found=nodes[outside[0]].tolist(),
            allowed=f"0 to {n_points - 1}",
        )


def _groups(mesh: Any, places: list[_Place], n_blocks: int) -> Iterator[Group]:
    """Yield physical groups and part numbers, then sets of cells, then sets of nodes."""
    taken: set[str] = set()
    for key in _PART_NUMBERS:
        if key in mesh.cell_data:
            for group in _groups_by_number(mesh, key, places, n_blocks):
                if group.name is not None:
                    taken.add(group.name)
                yield group
            break
    for name, per_block in mesh.cell_sets.items():
        if name in taken or name.startswith("gmsh:"):
            continue
        kept: list[NDArray[Any]] = [np.empty(0, dtype=np.int64)] * n_blocks
        for place, rows in zip(places, per_block, strict=False):
            if rows is not None:
                place.put(np.asarray(rows, dtype=np.int64), kept)
        yield Group(None, str(name), tuple(kept))
    for name, nodes in mesh.point_sets.items():
        yield Group(None, str(name), None, np.asarray(nodes, dtype=np.int64))


def _groups_by_number(mesh: Any, key: str, places: list[_Place], n_blocks: int) -> Iterator[Group]:
    """Yield groups from the part numbers of the cells.

    Gmsh numbers them apart by dimension; 0 stands for no group.
    """
    by_dimension = key == "gmsh:physical"
    groups: dict[tuple[int, int], list[NDArray[Any]]] = {}
    for block, numbers, place in zip(mesh.cells, mesh.cell_data[key], places, strict=True):
        if not place.made.blocks:
            continue
        values = np.asarray(numbers).reshape(len(block.data), -1).astype(np.int64)
        dimension = int(block.dim) if by_dimension else 0
        for value in np.unique(values):
            if by_dimension and value == 0:
                continue
            empty = [np.empty(0, dtype=np.int64)] * n_blocks
            rows = groups.setdefault((dimension, int(value)), empty)
            place.put(np.flatnonzero((values == value).any(axis=1)), rows)
    names = {}
    if by_dimension:
        names = {(int(dim), int(n)): str(name) for name, (n, dim) in mesh.field_data.items()}
    for (dimension, value), rows in sorted(groups.items()):
        yield Group(value, names.get((dimension, value)), tuple(rows))
