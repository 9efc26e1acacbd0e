"""A full disk is one message, whoever comes upon it; what is something else stays as it is."""

from __future__ import annotations

from errno import EACCES, EDQUOT, ENOSPC
from pathlib import Path

import pytest

from contiga.errors import OutputError
from contiga.io.out.files import atomic_write, write_text
from contiga.io.out.full_disk import check_room, full_disk, full_disk_errors

OF_HDF5 = "Can't flush cache (file write failed: errno = 28, error message = 'No space left')"


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(ENOSPC, "No space left on device"), "the disk is full"),
        (OSError(EDQUOT, "Disk quota exceeded"), "the disk quota is used up"),
        (RuntimeError(OF_HDF5), "the disk is full"),
    ],
)
def test_it_is_told_by_number(error: Exception, said: str) -> None:
    caught = pytest.raises(OutputError, match=rf"^a\.h5: {said}\. Make room on it$")
    with caught, full_disk_errors("a.h5"):
        raise error


def test_other_errors_stay_as_they_are() -> None:
    assert full_disk(RuntimeError("errno = 13"), "a") is None
    assert full_disk(ValueError("28"), "a") is None
    with pytest.raises(PermissionError), full_disk_errors("a"):
        raise PermissionError(EACCES, "no")


def test_nothing_half_written_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_text(tmp_path / "a.txt", "old")

    def full() -> None:
        with atomic_write(tmp_path / "a.txt") as temporary:
            temporary.write_text("half")
            raise OSError(ENOSPC, "No space left on device")

    with pytest.raises(OutputError, match=r"a\.txt: the disk is full"):
        full()
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


def test_room_is_asked_for_before(tmp_path: Path) -> None:
    check_room(tmp_path / "a.h5", 1000)
    with pytest.raises(OutputError, match=r"a\.h5: the disk is full; found '.* MB left'; allowed"):
        check_room(tmp_path / "a.h5", 10**18)
