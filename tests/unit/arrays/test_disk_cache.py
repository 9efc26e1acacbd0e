"""What is kept on the disk is found again, unless it is damaged, another's, or of other sources."""

from __future__ import annotations

import os
import pickle
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from contiga.arrays import disk_cache
from contiga.arrays.disk_cache import DiskCache
from contiga.cache_folder import FOLDER, cache_folder


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(FOLDER, str(tmp_path / "kept"))
    return tmp_path / "kept"


def entry(folder: Path) -> Path:
    """The only one."""
    (path,) = folder.iterdir()
    return path


def test_what_was_put_is_found_by_its_key_alone(folder: Path) -> None:
    cache = DiskCache("some", __file__)
    assert cache.get("a") is None
    cache.put("a", np.arange(3.0))
    assert DiskCache("some", __file__).get("a").tolist() == [0.0, 1.0, 2.0]
    assert cache.get("b") is None
    assert DiskCache("others", __file__).get("a") is None
    if os.name == "posix":
        assert folder.stat().st_mode & 0o077 == 0


def test_sources_that_change_make_another_entry(folder: Path, tmp_path: Path) -> None:
    source = tmp_path / "maker.py"
    for text, before in (("x = 1\n", None), ("x = 22\n", None), ("x = 1\n", "x = 1\n")):
        source.write_text(text)
        cache = DiskCache("some", source)
        assert cache.get("a") == before
        cache.put("a", text)


@pytest.mark.parametrize("cut", [slice(0, -1), slice(0, 10), slice(0, 0), slice(1, None)])
def test_a_damaged_entry_is_none_and_goes(folder: Path, cut: slice) -> None:
    cache = DiskCache("some", __file__)
    cache.put("a", list(range(100)))
    path = entry(folder)
    path.write_bytes(path.read_bytes()[cut])
    assert cache.get("a") is None
    assert not path.exists()


@pytest.mark.skipif(os.name != "posix", reason="modes are POSIX's")
@pytest.mark.parametrize("of", ["file", "folder"])
def test_what_others_may_have_written_is_not_opened(folder: Path, of: str) -> None:
    cache = DiskCache("some", __file__)
    cache.put("a", 1)
    (entry(folder) if of == "file" else folder).chmod(0o777)
    assert cache.get("a") is None


@pytest.mark.skipif(os.name != "posix", reason="modes are POSIX's")
def test_what_is_written_is_found_whatever_the_process_allows_others(folder: Path) -> None:
    before = os.umask(0o002)
    try:
        cache = DiskCache("some", __file__)
        cache.put("a", 1)
        assert cache.get("a") == 1
        folder.chmod(0o775)
        cache.put("b", 2)
    finally:
        os.umask(before)
    entry(folder)  # and no other: it would not be opened


def test_an_entry_that_cannot_be_marked_as_asked_for_is_found(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(path: Path) -> None:
        raise PermissionError(path)

    cache = DiskCache("some", __file__)
    cache.put("a", 1)
    monkeypatch.setattr(os, "utime", refused)
    assert cache.get("a") == cache.get("a") == 1


def test_what_a_killed_process_has_left_goes_after_a_day(folder: Path) -> None:
    folder.mkdir(mode=0o700)
    for name in ("old.new", "young.new"):
        (folder / name).touch()
    os.utime(folder / "old.new", (1.0, 1.0))
    DiskCache("some", __file__).put("a", 1)
    assert sorted(path.suffix for path in folder.iterdir()) == [".kept", ".new"]


def test_no_more_entries_are_kept_than_may_be(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(disk_cache, "MAX_ENTRIES", 3)
    for k in range(6):
        DiskCache("some", __file__).put(str(k), k)
    assert len(list(folder.iterdir())) == 3


def test_what_cannot_be_opened_is_none(folder: Path) -> None:
    cache = DiskCache("some", __file__)
    cache.put("a", 1)
    content = pickle.dumps(Gone())
    entry(folder).write_bytes(sha256(content).digest() + content)
    assert cache.get("a") is None


class Gone:
    """Pickled as what no module has any more."""

    def __reduce__(self) -> tuple[object, ...]:
        return getattr, ("text", "no_such_thing")


def test_what_was_not_asked_for_the_longest_goes_first(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(disk_cache, "MAX_BYTES", 4_500)
    cache = DiskCache("some", __file__)
    for k, key in enumerate("abcd"):
        cache.put(key, bytes(1_000))
        newest = max(folder.iterdir(), key=lambda path: path.stat().st_mtime_ns)
        os.utime(newest, ns=(k, k))
    assert cache.get("a") is not None  # which is now
    cache.put("e", bytes(1_000))
    assert [cache.get(key) is None for key in "abcde"] == [False, True, False, False, False]


@pytest.mark.parametrize("named", ["", "0"])
def test_none_is_kept_where_none_is_wanted(named: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER, named)
    cache = DiskCache("some", __file__)
    cache.put("a", 1)
    assert cache_folder() is None
    assert cache.get("a") is None


def test_what_cannot_be_written_is_not_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(FOLDER, str(tmp_path / "file"))
    cache = DiskCache("some", __file__)
    cache.put("a", 1)
    cache.put("a", lambda: None)  # no pickle either
    assert cache.get("a") is None


def test_without_the_variable_it_is_a_folder_of_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(FOLDER)
    folder = cache_folder()
    assert folder is not None
    assert folder.name == "contiga"


def test_what_is_too_large_is_not_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "MAX_BYTES", 4 * 600_000)
    cache = DiskCache("some", __file__)
    for count, is_kept in ((2, True), (3, False)):
        cache.put(str(count), [np.ones((5, 5_000)) for _ in range(count)])
        assert (cache.get(str(count)) is not None) is is_kept


def test_what_took_long_is_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache, built = DiskCache("some", __file__), list[str]()

    def build() -> list[str]:
        built.append("again")
        return list(built)

    monkeypatch.setattr(disk_cache, "MIN_SECONDS", float("inf"))
    assert [len(cache.get_or_build("a", build)) for _ in range(2)] == [1, 2]
    monkeypatch.setattr(disk_cache, "MIN_SECONDS", -1.0)
    assert [len(cache.get_or_build(None, build)) for _ in range(2)] == [3, 4]
    assert not folder.exists()
    assert [len(cache.get_or_build("a", build)) for _ in range(2)] == [5, 5]
