"""What is worked out of a body is kept for other processes, and is the same bits as anew."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.arrays import disk_cache
from contiga.cache_folder import FOLDER
from contiga.errors import ContigaWarning
from contiga.geometry import body_key, body_mesh, faces
from contiga.geometry.face_mesh import FaceMesh
from contiga.masters import body as masters
from contiga.search import tables
from contiga.search.balls import radii as ball
from contiga.search.borders import openings
from contiga.search.sides import side_grid
from contiga.search.sweep import piece_lists


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(FOLDER, str(tmp_path / "kept"))
    return tmp_path / "kept"


def egg(width: float = 1.0) -> cg.Body:
    return cg.Body([cg.shapes.ellipsoid(axes=(1.5, width, 0.8))])


def test_balls_are_read_where_they_took_long(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    first = ball.balls_of(egg().surface.tables)
    assert len(list(folder.glob("balls-*"))) == 1
    other = ball.balls_of(egg(1.1).surface.tables)
    assert not np.array_equal(other.value, first.value)
    monkeypatch.setattr(ball._BALLS, "_build", None)  # which would not do
    body = egg()
    body.project(np.random.default_rng(0).normal(size=(50, 3)))  # points leave seeds in the tables
    again = ball.balls_of(body.surface.tables)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


def test_what_is_quick_is_not_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", np.inf)
    ball.balls_of(egg().surface.tables)
    assert not folder.exists()


def test_openings_are_those_of_the_same_faces(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(body_key, "MIN_PATCHES", 1)
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    first = egg().openings
    moved = egg().translated((1.0, 0.0, 0.0)).openings
    assert len(list(folder.glob("openings-*"))) == 2
    monkeypatch.setattr(openings, "_compute", None)
    assert egg().openings == first
    assert egg().translated((1.0, 0.0, 0.0)).openings == moved


def worked_out(body: cg.Body) -> list[Any]:
    """All that is kept of a body, but for balls and openings."""
    of_solid: list[Any] = []
    if body.closed:
        sides = side_grid.sides_of(body.surface.tables, body.surface.slit)
        of_solid = [sides, *body.mass_properties(2.0)]
    known = body.surface.tables
    seeds = known.seeds._replace(leaf=known.seeds.leaf[:0])  # points leave some there
    return [body.bounds(), body.trim_tables, known._replace(seeds=seeds), *of_solid]


def leaves(value: Any) -> Iterator[Any]:
    """What named tuples in named tuples hold."""
    for part in value:
        if isinstance(part, tuple | list):
            yield from leaves(part)
        else:
            yield part


@pytest.mark.parametrize("make", [egg, holed_plate])
def test_what_is_read_is_to_kernels_what_was_built(
    make: Callable[[], cg.Body], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(body_key, "MIN_PATCHES", 1)
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    monkeypatch.setattr(side_grid._SIDES, "_min_elements", 1)
    first = worked_out(make())
    for module, builder in (
        (faces, "bounds_of"),
        (faces, "build_trim_tables"),
        (tables, "_build"),
        (masters, "body_moments"),
    ):
        monkeypatch.setattr(module, builder, None)
    monkeypatch.setattr(side_grid._SIDES, "_build", None)
    body = make()
    again = worked_out(body)
    assert body.surface.tables.trims is body.trim_tables
    for one, other in zip(leaves(first), leaves(again), strict=True):
        assert numba.typeof(one) == numba.typeof(other)
        assert np.asarray(one).tobytes() == np.asarray(other).tobytes()


def test_small_bodies_leave_the_disk_alone(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    worked_out(egg())
    assert not folder.exists()


def test_lists_of_pieces_are_read_where_they_took_long(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    monkeypatch.setattr(piece_lists._LISTS, "_min_elements", 1)
    first = piece_lists.lists_of(egg().surface.tables, piece_lists.MIN_PATHS)
    assert len(list(folder.glob("lists-*"))) == 1
    monkeypatch.setattr(piece_lists._LISTS, "_build", None)  # which would not do
    again = piece_lists.lists_of(egg().surface.tables, piece_lists.MIN_PATHS)
    assert len(first.pieces) > 0
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


def test_a_mesh_is_read_with_its_warning(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(body_key, "MIN_PATCHES", 1)
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    monkeypatch.setattr(body_mesh._Mesher, "_halve_parts", lambda *of: False)
    monkeypatch.setattr(FaceMesh, "_triangulate", lambda face: (np.zeros(0, dtype=bool), False))
    with pytest.warns(ContigaWarning, match="egg: the borders of face 0 cross each other"):
        first = egg().renamed("egg").tessellate(0.1)
    monkeypatch.setattr(body_mesh, "_Mesher", None)  # which would not do
    with pytest.warns(ContigaWarning, match="other: the borders of face 0 cross each other"):
        again = egg().renamed("other").tessellate(0.1)
    assert again.name == "other"
    assert np.array_equal(first.vertices, again.vertices)
    assert np.array_equal(first.triangles, again.triangles)
