"""HDF5 files are whole, or seen not to be; room for what they grow by is asked for before."""

from __future__ import annotations

import os
from errno import ENOSPC
from pathlib import Path

import h5py
import numpy as np
import pytest

from contiga.errors import FileError, OutputError
from contiga.io.out import full_disk, hdf5
from contiga.io.out.hdf5 import (
    ReadFile,
    close_file,
    is_sealed,
    open_file,
    set_aside,
    whole_file,
)


def write(path: Path, value: float, **options: object) -> Path:
    with whole_file(path, **options) as file:  # type: ignore[arg-type]
        file["x"] = np.full(3, value)
    return path


@pytest.mark.parametrize("sealed", [False, True])
def test_a_file_is_there_once_it_is_whole(tmp_path: Path, sealed: bool) -> None:
    path = write(tmp_path / "a.h5", 1.0, sealed=sealed)
    with pytest.raises(RuntimeError), whole_file(path, sealed=sealed):
        raise RuntimeError
    with h5py.File(path) as file:
        assert file["x"][:].tolist() == [1.0] * 3
    assert [one.name for one in tmp_path.iterdir()] == ["a.h5"]
    assert is_sealed(path) == sealed


def test_bytes_of_a_sealed_file_count_wherever_they_stand(tmp_path: Path) -> None:
    path = write(tmp_path / "a.h5", 1.0, sealed=True)
    content = path.read_bytes()
    for at in (*range(0, 90, 3), *range(90, len(content), 41)):
        with path.open("r+b") as file:
            file.seek(at)
            file.write(bytes([content[at] ^ (1 << at % 8)]))
        assert not is_sealed(path)
        path.write_bytes(content)
    assert is_sealed(path)
    for other in (b"", content[:-1], content + b"\0", content[:512], content[512:]):
        path.write_bytes(other)
        assert not is_sealed(path)


def test_an_older_file_is_kept(tmp_path: Path) -> None:
    for value in (1.0, 2.0):
        write(tmp_path / "a.h5", value, sealed=True, before=tmp_path / "b.h5")
    for name, value in (("a.h5", 2.0), ("b.h5", 1.0)):
        assert is_sealed(tmp_path / name)
        with open_file(tmp_path / name, "r") as file:
            assert file["x"][0] == value


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="the system sets no room aside")
def test_room_that_was_not_needed_is_given_back(tmp_path: Path) -> None:
    path = write(tmp_path / "a.h5", 1.0)
    file = open_file(path, "r+")
    set_aside(file, 5_000_000, path)
    assert path.stat().st_size >= 5_000_000
    file["y"] = np.arange(1000.0)
    close_file(file, path)
    assert path.stat().st_size < 20_000
    with h5py.File(path) as file:
        assert file["y"][-1] == 999.0


def test_a_file_that_cannot_be_flushed_is_closed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.h5", 1.0)
    file = open_file(path, "r+")

    class Full:
        """The file on a disk that is full."""

        def flush(self) -> None:
            raise OSError(ENOSPC, "No space left on device")

        def close(self) -> None:
            file.close()

    with pytest.raises(OSError, match="No space"):
        close_file(Full(), path)
    assert not file


def test_room_that_is_not_there_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.h5", 1.0)
    content = path.read_bytes()
    monkeypatch.delattr(os, "posix_fallocate", raising=False)
    usage = full_disk.shutil.disk_usage(tmp_path)
    monkeypatch.setattr(full_disk.shutil, "disk_usage", lambda _: usage._replace(free=1_000))
    with open_file(path, "r+") as file, pytest.raises(OutputError, match="the disk is full"):
        set_aside(file, 10, path)
    assert path.read_bytes() == content


@pytest.mark.parametrize(("mode", "kind"), [("r", FileError), ("r+", OutputError)])
def test_what_is_no_file_of_hdf5_is_told(tmp_path: Path, mode: str, kind: type[Exception]) -> None:
    (tmp_path / "a.h5").write_text("text")
    with pytest.raises(kind, match="cannot be opened as HDF5"):
        open_file(tmp_path / "a.h5", mode)


def test_a_file_is_opened_for_each_read_or_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = []
    file = ReadFile(write(tmp_path / "a.h5", 1.0))
    monkeypatch.setattr(hdf5, "open_file", lambda *way: opened.append(way) or open_file(*way))

    def read_twice() -> None:
        for _ in range(2):
            with file.arrays() as array:
                assert array("x")[:].tolist() == [1.0] * 3

    read_twice()
    assert len(opened) == 2
    with file.held():
        read_twice()
    assert len(opened) == 3
    write(tmp_path / "a.h5", 1.0).unlink()  # nothing is held any more
    with pytest.raises(FileError), file.arrays():
        pass
