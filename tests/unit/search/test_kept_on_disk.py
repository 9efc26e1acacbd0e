"""Touching balls and openings are kept for other processes, and are the same bits as anew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.cache_folder import FOLDER
from contiga.search.balls import radii as ball
from contiga.search.borders import openings
from contiga.search.hierarchy import kept


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(FOLDER, str(tmp_path / "kept"))
    return tmp_path / "kept"


def egg(width: float = 1.0) -> cg.Body:
    return cg.Body([cg.shapes.ellipsoid(axes=(1.5, width, 0.8))])


def test_balls_are_read_where_they_took_long(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept, "LONG", -1.0)
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
    monkeypatch.setattr(kept, "LONG", np.inf)
    ball.balls_of(egg().surface.tables)
    assert not folder.exists()


def test_openings_are_those_of_the_same_faces(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(openings, "MANY", 1)
    first = egg().openings
    moved = egg().translated((1.0, 0.0, 0.0)).openings
    assert len(list(folder.glob("openings-*"))) == 2
    monkeypatch.setattr(openings, "_found", None)
    assert egg().openings == first
    assert egg().translated((1.0, 0.0, 0.0)).openings == moved
