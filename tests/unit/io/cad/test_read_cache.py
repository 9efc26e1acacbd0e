"""CAD read before needs no reader, and says the same; other bytes, names and choices are read."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.cache_folder import FOLDER
from contiga.cli.info import rows_of
from contiga.errors import ContigaWarning, FileError
from contiga.io.cad import formats, read_cache, read_cad
from contiga_validation.rivals.headform import write_step


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Files that a reader was asked for, with entries in a folder of the test."""
    monkeypatch.setenv(FOLDER, str(tmp_path / "kept"))
    files: list[Path] = []
    read = read_cache.outcome_in_worker

    def reading(target: str, path: Path, *args: object, needs: str) -> Any:
        files.append(path)
        return read(target, path, *args, needs=needs)

    monkeypatch.setattr(read_cache, "outcome_in_worker", reading)
    return files


@pytest.fixture
def box(solids: ModuleType, tmp_path: Path) -> Path:
    path = tmp_path / "box.step"
    write_step(solids.block((0.0, 0.0, 0.0), (2.0, 3.0, 4.0)), path)
    return path


def test_a_file_is_read_once_for_what_is_asked_of_it(asked: list[Path], box: Path) -> None:
    first, second = (cg.read_cad(box, unit="cm") for _ in range(2))
    assert asked == [box]
    assert formats.is_cached(box)
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 3))
    assert (first.project(points).gap == second.project(points).gap).all()
    assert first.unit == second.unit == "cm"
    assert cg.read_cad(box, faces=1).patches  # of which other faces are kept
    assert len(cg.cad_parts(box)) == len(cg.cad_parts(box)) == 1
    assert asked == 3 * [box]


def test_other_bytes_or_another_name_are_read(asked: list[Path], box: Path) -> None:
    cg.read_cad(box)
    other = Path(shutil.copy(box, box.with_name("other.step")))
    assert cg.read_cad(other).name == "other"
    box.write_text(box.read_text() + "\n")
    assert not formats.is_cached(box)
    cg.read_cad(box)
    assert asked == [box, other, box]


def test_what_a_reader_warns_of_is_said_each_time(
    asked: list[Path], box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = read_cache.outcome_in_worker

    def warning(*args: Any, **named: Any) -> Any:
        return read(*args, **named)._replace(warnings=["a face was left out"])

    monkeypatch.setattr(read_cache, "outcome_in_worker", warning)
    for _ in range(2):
        with pytest.warns(ContigaWarning, match="a face was left out") as heard:
            cg.read_cad(box)
        assert [item.filename for item in heard] == [__file__]
    assert asked == [box]


def test_what_is_refused_is_not_kept(
    asked: list[Path], box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(read_cad, "MAX_COORDINATE", 1e-3)
    for _ in range(2):
        with pytest.raises(FileError, match="too far from the origin"):
            cg.read_cad(box)
    assert asked == [box, box]
    assert not formats.is_cached(box)


def test_a_reader_is_not_loaded_ahead_of_what_was_read(
    asked: list[Path], box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ahead: list[str] = []
    monkeypatch.setattr(formats, "prepare", ahead.append)
    formats.expect_cad(box)
    assert len(ahead) == 1
    cg.read_cad(box)
    formats.expect_cad(box)
    assert len(ahead) == 1
    formats.expect_cad(box, box.with_name("unknown.step"))
    assert len(ahead) == 2


def test_what_is_told_of_a_file_is_told_again(asked: list[Path], box: Path) -> None:
    told = [list(rows_of(box, faces=faces)) for faces in (False, True, False, True)]
    assert asked == [box]  # of which faces are listed, too
    assert told[:2] == told[2:]
    assert told[0] != told[1]
    assert ("patches", "6") in told[0]
    for k in range(2):
        assert read_cache.cached_answer(box, "a number", __file__, lambda k=k: k + 1) == 1


def test_what_has_warned_is_told_anew(asked: list[Path], box: Path) -> None:
    def warning() -> int:
        warnings.warn("a slit", ContigaWarning, stacklevel=2)
        return 1

    for _ in range(2):
        with pytest.warns(ContigaWarning, match="a slit"):
            assert read_cache.cached_answer(box, "a number", __file__, warning) == 1


def test_a_file_that_is_not_there_is_told_by_who_reads_it(asked: list[Path], box: Path) -> None:
    box.unlink()
    assert read_cache.cached_answer(box, "a number", __file__, lambda: 2) == 2
