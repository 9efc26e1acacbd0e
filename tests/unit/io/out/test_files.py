"""Files appear whole or not at all; folders of somebody else are left alone."""

from __future__ import annotations

import pytest

from contiga.errors import OutputError
from contiga.io.out.files import atomic_write, clear_temporaries, open_folder, write_json


def test_file_appears_only_at_the_end_of_the_block(tmp_path):
    path = tmp_path / "a.csv"
    with atomic_write(path) as temporary:
        temporary.write_text("new")
        assert not path.exists()
        assert temporary.parent == path.parent
        assert temporary.suffix == ".csv"
    assert path.read_text() == "new"
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]


def test_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")

    def fail():
        with atomic_write(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize("name", ["missing/a.csv", "folder", "file/a.csv"])
def test_a_place_that_cannot_be_written_is_refused_at_once(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match=name.partition("/")[0]), atomic_write(tmp_path / name):
        pytest.fail("the block must not run")


def test_a_json_file_can_be_read_by_a_person(tmp_path):
    write_json(tmp_path / "a.json", {"what": "Länge", "value": 1.5})
    text = (tmp_path / "a.json").read_text(encoding="utf-8")
    assert text == '{\n  "what": "Länge",\n  "value": 1.5\n}\n'


def test_a_folder_is_made_once_and_known_again_by_its_files(tmp_path):
    folder = tmp_path / "deep" / "out"
    assert open_folder(folder, ("ours.csv",), "run")
    assert not open_folder(folder, ("ours.csv",), "run")
    (folder / "ours.csv").touch()
    (folder / "note.txt").touch()
    assert not open_folder(folder, ("ours.csv",), "run")
    assert sorted(path.name for path in folder.iterdir()) == ["note.txt", "ours.csv"]


def test_a_folder_of_somebody_else_is_left_alone(tmp_path):
    (tmp_path / "note.txt").touch()
    with pytest.raises(OutputError, match="not of a reproduction"):
        open_folder(tmp_path, ("ours.csv",), "reproduction")
    with pytest.raises(OutputError, match="is a file"):
        open_folder(tmp_path / "note.txt", ("ours.csv",), "reproduction")


def test_an_older_file_is_kept_where_it_is_asked_for(tmp_path):
    path, before = tmp_path / "a.txt", tmp_path / "b.txt"
    for text in ("one", "two", "three"):
        with atomic_write(path, before) as temporary:
            temporary.write_text(text)
    assert (path.read_text(), before.read_text()) == ("three", "two")
    with pytest.raises(ValueError, match="no"), atomic_write(path, before):
        raise ValueError("no")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "b.txt"]
    assert (path.read_text(), before.read_text()) == ("three", "two")


def test_what_killed_processes_left_is_removed_and_nothing_else(tmp_path):
    with atomic_write(tmp_path / "[a].h5.part") as temporary:
        (tmp_path / "left").write_text(temporary.name)
    mine = (tmp_path / "left").read_text()
    kept = (".[a].h5.0123.part", ".b.h5.01234567.part", ".[a].h5.0123456g.part", "[a].h5.part")
    for name in (mine, *kept):
        (tmp_path / name).touch()
    clear_temporaries(tmp_path, ["[a].h5.part", "missing.csv"])
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted((*kept, "left"))
