"""Protocol of the faces that measures and meshes read: `Faces`, which imports them."""

from __future__ import annotations

from typing import Protocol

from contiga.arrays.digest import Digest
from contiga.geometry.edges import BodyEdge
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import Loop, TrimTables
from contiga.records import FloatArray

Trims = tuple[tuple[Loop, ...] | None, ...]
"""Per patch None, or its loops of p-curves."""


class FacesLike(Protocol):
    """The members of `Faces` that measures and meshes read."""

    @property
    def name(self) -> str: ...
    @property
    def patches(self) -> tuple[NurbsSurface, ...]: ...
    @property
    def trims(self) -> Trims: ...
    @property
    def edges(self) -> tuple[BodyEdge, ...]: ...
    @property
    def trim_tables(self) -> TrimTables: ...
    @property
    def size(self) -> float: ...
    @property
    def unit(self) -> str | None: ...
    @property
    def pieces_apart(self) -> bool: ...
    def bounds(self) -> FloatArray: ...
    def digest(self, digest: Digest) -> None: ...
