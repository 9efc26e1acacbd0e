"""`read_mesh`: read a mesh or cloud file as a `Slave`.

The slave has all nodes of the file, in its order. Nodes inside solids, or on no selected cell, are
not active, unless `layer` is "all".
"""

from __future__ import annotations

from itertools import chain
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

_READERS = {
    "lsdyna:read_lsdyna": lsdyna.SUFFIXES,
    "abaqus:read_abaqus": abaqus.SUFFIXES,
    "nastran:read_nastran": nastran.SUFFIXES,
    "polygon_files:read_polygons": polygon_files.SUFFIXES,
}
"""Suffixes by module and function of their reader; meshio reads all others."""
OWN_SUFFIXES = (*chain.from_iterable(_READERS.values()), *cloud_files.SUFFIXES)
"""Suffixes that are read without meshio."""


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
    Lines that are not edges of other cells are bars (`Slave.elements`); if there are only lines,
    their nodes are active points, without facets.

    Parameters
    ----------
    path : the file; its suffix determines the format
    unit : length unit of the result
    file_unit : unit of the file, if it does not state one, as the header of a cloud may; without
        it the file's numbers are in `unit`
    parts : names or numbers of LS-DYNA parts, Abaqus sets, Gmsh physical groups or the like.
        The facets are the skin of the selected cells. For a set of nodes, all its nodes are active
        and the facets have all corners in it, with the mid-side nodes between them.
    sets : the same; facets of `parts` remain if all their corners are in one of these sets
    layer : "skin", or 1, the surface of solids; 2 the surface that remains when all cells with a
        node on the skin are removed, and so on; "all" makes inner nodes active, too, with no area,
        unless `parts` selects sets of nodes

    Returns
    -------
    Slave
        All nodes of the file; facets None for a cloud. Thickness from `*SECTION_SHELL` and
        `*ELEMENT_SHELL_THICKNESS`, mass from `*ELEMENT_MASS`; None for files without. Named after
        the file; its unit is `unit`, else that of the file.

    Raises
    ------
    FileError, MissingPackageError, UnitError
        The file is missing, unreadable or of an unknown kind; the package that reads it is not
        installed; an unknown unit.
    MeshError
        No nodes, a coordinate that is not finite, cells that do not fit, a part, set or layer that
        does not exist or leaves nothing.

    Examples
    --------
    >>> pad = read_mesh("pad.vtu", unit="mm", file_unit="m")
    >>> len(pad), len(pad.facets), pad.points.max().tolist(), dict(pad.cells)
    (8, 12, 1000.0, {'hexahedron': 1})
    """
    from contiga.io.units import length_factor

    path = Path(path)
    check_layer(layer)
    mesh = read_raw(path)
    file_unit = unit_of_file(mesh, file_unit, path)
    slave = slave_of(mesh, path, unit or file_unit, (parts, sets, layer))
    # With one unit alone the conversion to itself refuses a wrong name.
    from_unit, to_unit = file_unit or unit, unit or file_unit
    if from_unit is None or to_unit is None:
        return slave
    factor = length_factor(from_unit, to_unit, None if mesh.unit is None else str(path))
    return slave if factor == 1.0 else slave.scaled(factor)


def slave_of(
    mesh: RawMesh,
    path: Path,
    unit: str | None = None,
    chosen: tuple[PartKeys | None, PartKeys | None, Layer] = (None, None, "skin"),
) -> Slave:
    """Return a raw mesh as a slave named after its file; coordinates stay as they are.

    `chosen` are parts, sets and layer as for `read_mesh`; `unit` is only noted. Hexahedra with
    their fourth node five times become tetrahedra. `Slave.cells` counts the selected cells of all
    layers.

    Raises
    ------
    MeshError
        As `read_mesh`.
    """
    where = str(path)
    parts, sets, layer = chosen
    check_points(mesh.points, where=where, ids=mesh.node_ids)
    selection = select(mesh, parts, where)
    cells = blocks = [
        piece
        for block, mask in zip(mesh.blocks, selection.cells, strict=True)
        for piece in mend_degenerate(CellBlock(block.kind, block.nodes[mask]))
    ]
    if isinstance(layer, int):
        blocks = peeled(mesh.points, blocks, layer, where)
    facets, active = _surface(mesh, blocks, selection, restricted=parts is not None, where=where)
    if layer == "all" and active is None and blocks:
        active = _nodes_mask(blocks, len(mesh.points))
    if sets is not None:
        masks = np.array(
            [with_middles(blocks, nodes_of(mesh, key, where)) for key in as_keys(sets)]
        )
        inside: np.ndarray = np.any(masks, axis=0)
        if active is not None:
            active = np.logical_and(active, inside)
        elif facets is None:
            active = inside
        if facets is not None:
            facets = facets[masks[:, facets].all(axis=2).any(axis=0)]
            if not len(facets):
                raise MeshError(
                    "no facet has all its corners in one of the sets",
                    where=f"{where}, sets",
                    allowed="sets of nodes or cells on the surface of the parts chosen",
                )
    counts: dict[str, int] = {}
    for block in cells:
        if len(block.nodes):
            counts[block.kind] = counts.get(block.kind, 0) + len(block.nodes)
    return Slave(
        mesh.points,
        facets,
        thickness=_nodal_thickness(mesh, selection),
        mass=mesh.mass,
        active=active,
        name=path.stem,
        unit=unit,
        cells=counts,
        parts=[part_of(group, mesh.blocks) for group in mesh.groups],
        elements=elements_of(cells),
    )


def unit_of_file(mesh: RawMesh, unit: str | None, path: Path) -> str | None:
    """Return the unit of the lengths of a file, or if it states none `unit`, which may be None.

    Raises
    ------
    FileError
        The file states another name of a unit than `unit`.
    """
    if mesh.unit is not None and unit is not None and mesh.unit != unit.strip():
        raise FileError(
            "the file says another unit than was given",
            where=str(path),
            found=mesh.unit,
            allowed=f"{unit!r}, or none in the file",
            remedy="Leave out the unit: the file's holds",
        )
    return unit if mesh.unit is None else mesh.unit


def read_raw(path: Path) -> RawMesh:
    """Return the mesh in the form of the file, read by the reader of its suffix.

    All but clouds are read in a worker process, within the limits of `contiga.io.limits`.

    Raises
    ------
    FileError, MeshError
        The file is missing, empty or cannot be opened; its reader refuses it.
    MissingPackageError
        The package that reads the format is not installed.
    """
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
    suffix = path.suffix.lower()
    if suffix in cloud_files.SUFFIXES:
        return cloud_files.read_cloud(path)
    reader = next((name for name, suffixes in _READERS.items() if suffix in suffixes), None)
    if reader is None:
        require(f"reading {path.suffix} files", "meshio")
        reader = "meshio_files:read_with_meshio"
    mesh: RawMesh = read_in_worker(f"contiga.io.mesh.{reader}", path)
    return mesh


def _surface(
    mesh: RawMesh,
    blocks: list[CellBlock],
    selection: Selection,
    *,
    restricted: bool,
    where: str,
) -> tuple[IntArray | None, np.ndarray | None]:
    """Return the facets (m, 3) of cells, or None, and the mask (n,) of active nodes.

    The mask is None if the nodes of the facets are active, or all points if there are none
    either. If sets of nodes are selected, their nodes are active, with mid-side nodes, and facets
    have all corners among them. Of lines alone, the nodes are active.

    Raises
    ------
    MeshError
        Neither facets nor lines, although the mesh has cells or parts are selected (`restricted`).
    """
    facets = skin(mesh.points, blocks)
    if selection.nodes is not None:
        nodes = with_middles(blocks, selection.nodes)
        facets = facets[nodes[facets].all(axis=1)]
        return (facets if len(facets) else None), nodes
    if len(facets):
        return facets, None
    bars = [block for block in blocks if block.kind == "line" and len(block.nodes)]
    if bars:
        return None, _nodes_mask(bars, len(mesh.points))
    if restricted or any(len(block.nodes) for block in mesh.blocks):
        raise MeshError("the cells chosen have no surface", where=where, allowed="shells or solids")
    return None, None


def _nodes_mask(blocks: list[CellBlock], count: int) -> np.ndarray:
    """Return a mask (count,) of the nodes of cells."""
    nodes = np.zeros(count, dtype=bool)
    for block in blocks:
        nodes[block.nodes] = True
    return nodes


def _nodal_thickness(mesh: RawMesh, selection: Selection) -> FloatArray | None:
    """Return the thickness (n,) at each node, the mean of the selected shells that have one there.

    It is 0 at other nodes, and None if no shell has any.
    """
    if mesh.thickness is None:
        return None
    total = np.zeros(len(mesh.points))
    count = np.zeros(len(mesh.points))
    for block, mask, values in zip(mesh.blocks, selection.cells, mesh.thickness, strict=True):
        if values is None or block.kind not in SHELLS:
            continue
        nodes = block.nodes[mask].ravel()
        weights = values[mask].ravel()
        has_value = weights > 0.0
        total += np.bincount(nodes[has_value], weights=weights[has_value], minlength=len(total))
        count += np.bincount(nodes[has_value], minlength=len(total))
    if not count.any():
        return None
    thickness: FloatArray = np.divide(total, count, out=np.zeros_like(total), where=count > 0)
    return thickness
