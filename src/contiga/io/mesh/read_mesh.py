"""`read_mesh`: read a mesh or cloud file as a `Slave`.

What a file holds is kept: all its nodes, in its order. Nodes inside solids, or on no cell that was
asked for, are there but not active.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contiga.errors import FileError, MeshError
from contiga.extras import require
from contiga.io.mesh import abaqus, cloud_files, lsdyna, nastran, polygon_files
from contiga.io.mesh.layers import Layer, check_layer, peeled, with_middles
from contiga.io.mesh.raw import RawMesh, Selection, nodes_of, part_of, select
from contiga.io.naming import PartKeys, as_keys
from contiga.io.worker import read_in_worker
from contiga.records import FloatArray, IntArray
from contiga.slaves.cells import SHELLS
from contiga.slaves.checks import check_points
from contiga.slaves.elements import elements_of
from contiga.slaves.skin import CellBlock, mend_degenerate, skin
from contiga.slaves.slave import Slave


def read_mesh(
    path: str | Path,
    *,
    unit: str | None = None,
    file_unit: str | None = None,
    parts: PartKeys | None = None,
    sets: PartKeys | None = None,
    layer: Layer = "skin",
) -> Slave:
    """Read a mesh or a cloud as a slave.

    Meshes: OFF, OBJ, decks of LS-DYNA, Abaqus and Nastran, and what meshio reads (VTU, VTK, Gmsh,
    STL, PLY …). Facets of second-order cells are split through mid-side nodes; polygons of more
    than four corners are split, with a warning. Clouds: three columns in .csv, .xyz, .txt or .npy.
    Lines that are no edges of other cells are bars (`Slave.elements`); of lines alone their nodes
    are points that are active, without facets.

    Parameters
    ----------
    path : the file, its format told from its suffix
    unit : length unit wanted
    file_unit : that of the file, if it does not say it, as the header of a cloud may; without,
        its numbers are in `unit`
    parts : names or numbers of LS-DYNA parts, Abaqus sets, Gmsh physical groups or the like.
        The facets are the skin of the cells chosen. Of a set of nodes, all are active and the
        facets are those whose corners all belong to it, with the mid-side nodes between them.
    sets : the same; of the facets of `parts` those stay with all corners in one of these sets
    layer : "skin", or 1, the surface of solids; 2 that of what is left when all cells with a node
        on the skin are off, and so on; "all" makes nodes inside active too, which have no area

    Returns
    -------
    Slave
        All nodes of the file; facets None for a cloud. Thickness from `*SECTION_SHELL` and
        `*ELEMENT_SHELL_THICKNESS`, mass from `*ELEMENT_MASS`; None for files without.

    Raises
    ------
    FileError, MissingPackageError, UnitError
        The file is missing, unreadable or of no known kind; what reads it is not installed; a
        unit that is none.
    MeshError
        No nodes, a coordinate that is not finite, cells that do not fit, a part, set or layer that
        is not there or leaves nothing.

    Examples
    --------
    >>> pad = read_mesh("pad.vtu", unit="mm", file_unit="m")
    >>> len(pad), len(pad.facets), pad.points.max().tolist(), dict(pad.cells)
    (8, 12, 1000.0, {'hexahedron': 1})
    """
    path = Path(path)
    check_layer(layer)
    mesh = read_raw(path)
    file_unit = unit_of_file(mesh, file_unit, path)
    slave = slave_of(mesh, path, unit or file_unit, (parts, sets, layer))
    factor = _unit_factor(unit, file_unit, None if mesh.unit is None else str(path))
    return slave if factor == 1.0 else slave.scaled(factor)


def slave_of(
    mesh: RawMesh,
    path: Path,
    unit: str | None = None,
    chosen: tuple[PartKeys | None, PartKeys | None, Layer] = (None, None, "skin"),
) -> Slave:
    """Return a raw mesh as a slave; `chosen` are parts, sets and layer as for `read_mesh`.

    Raises
    ------
    MeshError
        As `read_mesh`.
    """
    where = str(path)
    parts, sets, layer = chosen
    check_points(mesh.points, where=where, ids=mesh.node_ids)
    selection = select(mesh, parts, where)
    cells = blocks = _chosen(mesh, selection)
    if isinstance(layer, int):
        blocks = peeled(mesh.points, blocks, layer, where)
    facets, active = _surface(mesh, blocks, selection, restricted=parts is not None, where=where)
    if layer == "all":
        active = _all_nodes(blocks, active, len(mesh.points))
    if sets is not None:
        masks = [with_middles(blocks, nodes_of(mesh, key, where)) for key in as_keys(sets)]
        facets, active = _within(facets, active, np.array(masks), where)
    return Slave(
        mesh.points,
        facets,
        thickness=_nodal_thickness(mesh, selection),
        mass=mesh.mass,
        active=active,
        name=path.stem,
        unit=unit,
        cells=_counts(cells),
        parts=[part_of(group, mesh.blocks) for group in mesh.groups],
        elements=elements_of(cells),
    )


def unit_of_file(mesh: RawMesh, given: str | None, path: Path) -> str | None:
    """Return the unit of the lengths of a file: its own, or the `given` one if it has none."""
    if mesh.unit is not None and given is not None and mesh.unit != given.strip():
        raise FileError(
            "the file says another unit than was given",
            where=str(path),
            found=mesh.unit,
            allowed=f"{given!r}, or none in the file",
            remedy="Leave out the unit: the file's holds",
        )
    return given if mesh.unit is None else mesh.unit


def read_raw(path: Path) -> RawMesh:
    """Return the mesh in the form of the file, read by the reader of its suffix."""
    if not path.exists():
        raise FileError("no such file", where=str(path), allowed="a mesh or cloud file")
    if not path.is_file():
        raise FileError("not a file", where=str(path), allowed="a mesh or cloud file")
    try:
        empty = path.stat().st_size == 0
        with path.open("rb"):
            pass
    except OSError as error:
        raise FileError(f"cannot be opened: {error.strerror}", where=str(path)) from error
    if empty:
        raise FileError("the file is empty", where=str(path), allowed="a mesh or cloud file")
    if path.suffix.lower() in cloud_files.SUFFIXES:
        return cloud_files.read_cloud(path)
    mesh: RawMesh = read_in_worker(f"contiga.io.mesh.{_reader(path)}", path)
    return mesh


def _reader(path: Path) -> str:
    """Return the module and function that read a suffix."""
    suffix = path.suffix.lower()
    if suffix in lsdyna.SUFFIXES:
        return "lsdyna:read_lsdyna"
    if suffix in abaqus.SUFFIXES:
        return "abaqus:read_abaqus"
    if suffix in nastran.SUFFIXES:
        return "nastran:read_nastran"
    if suffix in polygon_files.SUFFIXES:
        return "polygon_files:read_polygons"
    require(f"reading {path.suffix} files", "meshio")
    return "meshio_files:read_with_meshio"


def _unit_factor(unit: str | None, file_unit: str | None, where: str | None) -> float:
    from contiga.io.units import length_factor

    if unit is None or file_unit is None:
        given = unit or file_unit
        # The conversion to itself refuses a wrong name.
        return 1.0 if given is None else length_factor(given, given, where)
    return length_factor(file_unit, unit, where)


def _chosen(mesh: RawMesh, selection: Selection) -> list[CellBlock]:
    """Return the cells of a selection."""
    return [
        piece
        for block, mask in zip(mesh.blocks, selection.cells, strict=True)
        for piece in mend_degenerate(CellBlock(block.kind, block.nodes[mask]))
    ]


def _surface(
    mesh: RawMesh,
    blocks: list[CellBlock],
    selection: Selection,
    *,
    restricted: bool,
    where: str,
) -> tuple[IntArray | None, np.ndarray | None]:
    facets = skin(mesh.points, blocks)
    if selection.nodes is not None:
        nodes = with_middles(blocks, selection.nodes)
        facets = facets[nodes[facets].all(axis=1)]
        return (facets if len(facets) else None), nodes
    if len(facets):
        return facets, None
    bars = [block for block in blocks if block.kind == "line" and len(block.nodes)]
    if bars:
        return None, _all_nodes(bars, None, len(mesh.points))
    if restricted or any(len(block.nodes) for block in mesh.blocks):
        raise MeshError("the cells chosen have no surface", where=where, allowed="shells or solids")
    return None, None


def _within(
    facets: IntArray | None, active: np.ndarray | None, masks: np.ndarray, where: str
) -> tuple[IntArray | None, np.ndarray | None]:
    """Return the facets with all corners in one of some sets of nodes (k, n), and active points."""
    inside: np.ndarray = np.any(masks, axis=0)
    if active is not None:
        active = np.logical_and(active, inside)
    if facets is None:
        return None, inside if active is None else active
    facets = facets[masks[:, facets].all(axis=2).any(axis=0)]
    if not len(facets):
        raise MeshError(
            "no facet has all its corners in one of the sets",
            where=f"{where}, sets",
            allowed="sets of nodes or cells on the surface of the parts chosen",
        )
    return facets, active


def _all_nodes(blocks: list[CellBlock], active: np.ndarray | None, count: int) -> np.ndarray | None:
    """Return the nodes of the cells, with inner ones; a cloud or a set of nodes is unchanged."""
    if active is not None or not blocks:
        return active
    nodes = np.zeros(count, dtype=bool)
    for block in blocks:
        nodes[block.nodes] = True
    return nodes


def _nodal_thickness(mesh: RawMesh, selection: Selection) -> FloatArray | None:
    """Return the mean thickness of the shells at each node; 0 without a known thickness."""
    if mesh.thickness is None:
        return None
    total = np.zeros(len(mesh.points))
    count = np.zeros(len(mesh.points))
    for block, mask, values in zip(mesh.blocks, selection.cells, mesh.thickness, strict=True):
        if values is None or block.kind not in SHELLS:
            continue
        nodes = block.nodes[mask].ravel()
        weights = values[mask].ravel()
        known = weights > 0.0
        total += np.bincount(nodes[known], weights=weights[known], minlength=len(total))
        count += np.bincount(nodes[known], minlength=len(total))
    if not count.any():
        return None
    thickness: FloatArray = np.divide(total, count, out=np.zeros_like(total), where=count > 0)
    return thickness


def _counts(blocks: Sequence[CellBlock]) -> dict[str, int]:
    counts: dict[str, int] = {}
    for block in blocks:
        if len(block.nodes):
            counts[block.kind] = counts.get(block.kind, 0) + len(block.nodes)
    return counts
