"""Physical groups of Gmsh's formats 4.0 and 4.1, which meshio does not return completely.

meshio 5.3 omits blocks of cells that are in no group from its list of groups, which then no longer
matches the cells (``Mesh.SaveAll`` with some groups), and keeps only the first of several groups.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

_KEY = "gmsh:physical"


@contextlib.contextmanager
def physical_groups() -> Iterator[None]:
    """Let meshio give each cell all its physical groups, 0 for none, within the block.

    Functions of meshio's modules for formats 4.0 and 4.1 are replaced in this process, and put back
    at the end. With a meshio that lacks them nothing happens.
    """
    try:
        from meshio.gmsh import _gmsh40, _gmsh41

        readers = [(module, module._read_elements) for module in (_gmsh40, _gmsh41)]
    except (ImportError, AttributeError):  # another version of meshio works differently
        yield
        return
    for module, reader in readers:
        module._read_elements = partial(_read_elements, reader)
    try:
        yield
    finally:
        for module, reader in readers:
            module._read_elements = reader


def _read_elements(
    reader: Callable[..., Any], stream: Any, point_tags: Any, physical_tags: Any, *options: Any
) -> Any:
    """Return what meshio's reader returns, with all groups of each block in its cell data.

    `physical_tags` has groups by dimension and entity; a block gets an array (cells, groups).
    """
    cells, data, *entities = reader(stream, point_tags, physical_tags, *options)
    if _KEY in data:
        data[_KEY] = []
        for block, entity in zip(cells, data["gmsh:geometrical"], strict=True):
            groups = physical_tags[block.dim][entity[0]] or [0]
            rows = np.array(groups, dtype=np.int64)
            data[_KEY].append(np.broadcast_to(rows, (len(block.data), len(groups))))
    return cells, data, *entities
