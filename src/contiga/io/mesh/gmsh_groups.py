"""Physical groups of Gmsh's formats 4.0 and 4.1, which meshio does not return completely.

meshio 5.3 leaves blocks of cells that are in no group out of its list of groups, which then fits
no more (``Mesh.SaveAll`` with some groups), and keeps the first only of several groups.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

_KEY = "gmsh:physical"


@contextlib.contextmanager
def physical_groups() -> Iterator[None]:
    """Let meshio give each cell all its physical groups, 0 for none, within the block."""
    try:
        from meshio.gmsh import _gmsh40, _gmsh41

        readers = [(module, module._read_elements) for module in (_gmsh40, _gmsh41)]
    except (ImportError, AttributeError):  # another meshio reads them in its own way
        yield
        return
    for module, reader in readers:
        module._read_elements = _with_all_groups(reader)
    try:
        yield
    finally:
        for module, reader in readers:
            module._read_elements = reader


def _with_all_groups(reader: Callable[..., Any]) -> Callable[..., Any]:
    def read(stream: Any, point_tags: Any, physical_tags: Any, *more: Any) -> Any:
        """Read entities; `physical_tags` has their groups by dimension and entity."""
        cells, data, *rest = reader(stream, point_tags, physical_tags, *more)
        if _KEY in data:
            data[_KEY] = [
                _numbers(len(block.data), physical_tags[block.dim][entity[0]])
                for block, entity in zip(cells, data["gmsh:geometrical"], strict=True)
            ]
        return cells, data, *rest

    return read


def _numbers(count: int, groups: list[int]) -> Any:
    """Return the groups (count, k) of an entity for each of its cells."""
    return np.broadcast_to(np.array(groups or [0], dtype=np.int64), (count, max(len(groups), 1)))
