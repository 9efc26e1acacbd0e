"""Kernels are kept in the user's folder, or in the next one that can be written to, or nowhere."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numba
import pytest

from contiga import cache_folder
from contiga.cache_folder import DAY, trim
from contiga.jit import folder as at
from contiga.jit.folder import kernel_folder, remove_kernels

TINY = """
from contiga.jit import kernel


@kernel()
def twice(x):
    return 2 * x
"""
RUN = """
import sys

sys.path.insert(0, sys.argv[1])
from pathlib import Path

from contiga.jit.folder import kernel_folder
from contiga.jit.stamps import PACKAGES

PACKAGES.append(Path(sys.argv[1]) / "tiny")
from tiny.twice_nb import twice

print(twice(21), sum(twice.stats.cache_hits.values()), kernel_folder())
"""
POSIX = pytest.mark.skipif(os.name != "posix", reason="modes are POSIX's")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A home, and a folder for temporary files beside it, in which nothing is yet."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(at, "user_folder", lambda: tmp_path / "home" / ".cache" / "contiga")
    at._kernel_folder.cache_clear()
    yield tmp_path / "home"
    at._kernel_folder.cache_clear()


def twice(folder: Path, **environment: str) -> list[str]:
    """What a fresh process says: the result, how often the code came from a file, the folder."""
    (folder / "tiny").mkdir(parents=True, exist_ok=True)
    (folder / "tiny" / "__init__.py").touch()
    (folder / "tiny" / "twice_nb.py").write_text(TINY)
    env = {k: v for k, v in os.environ.items() if not k.startswith(("NUMBA_", "XDG_"))}
    run = [sys.executable, "-c", RUN, str(folder)]
    found = subprocess.run(run, env=env | environment, capture_output=True, text=True, check=True)
    return found.stdout.split(maxsplit=2)


def test_it_is_the_users_alone(home: Path) -> None:
    folder = kernel_folder()
    assert folder == home / ".cache" / "contiga" / "kernels"
    if os.name == "posix":
        assert folder.stat().st_mode & 0o077 == folder.parent.stat().st_mode & 0o077 == 0


def test_the_folder_that_numba_is_given_goes_first(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "named")
    assert kernel_folder() == tmp_path / "named" / "contiga"
    assert not home.exists()


def test_where_there_is_no_home_it_is_among_temporary_files(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(at, "user_folder", lambda: None)
    folder = kernel_folder()
    assert folder is not None
    assert folder.parent == tmp_path / "temporary"


@pytest.mark.parametrize("named", ["", "file/folder"])
def test_a_home_that_cannot_be_written_to_is_passed_over(
    named: str, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home.touch()  # a file, where a folder would have to be
    (tmp_path / "file").touch()
    monkeypatch.setattr(numba.config, "CACHE_DIR", named and str(tmp_path / named))
    folder = kernel_folder()
    assert folder is not None
    assert folder.parent == tmp_path / "temporary"


@POSIX
def test_what_others_may_write_to_is_passed_over(home: Path, tmp_path: Path) -> None:
    own = home / ".cache" / "contiga" / "kernels"
    own.mkdir(parents=True)
    own.chmod(0o777)
    folder = kernel_folder()
    assert folder is not None
    assert folder.parent == tmp_path / "temporary"
    folder.chmod(0o777)
    at._kernel_folder.cache_clear()
    assert kernel_folder() is None


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="where homes are, is Linux's")
def test_a_process_without_any_folder_compiles_and_keeps_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    nowhere = {"HOME": str(tmp_path / "file"), "TMPDIR": str(tmp_path / "file")}
    code = f"import sys, tempfile\n\ntempfile.tempdir = sys.argv[2]\n{RUN}"
    (tmp_path / "tiny").mkdir()
    (tmp_path / "tiny" / "twice_nb.py").write_text(TINY)
    env = {k: v for k, v in os.environ.items() if not k.startswith(("NUMBA_", "XDG_"))} | nowhere
    run = [sys.executable, "-c", code, str(tmp_path), nowhere["TMPDIR"]]
    for _ in range(2):
        found = subprocess.run(run, env=env, capture_output=True, text=True, check=True)
        assert found.stdout.split() == ["42", "0", "None"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="where homes are, is Linux's")
def test_two_installations_of_the_same_sources_share_their_kernels(tmp_path: Path) -> None:
    home = {"HOME": str(tmp_path / "home")}
    where = str(tmp_path / "home" / ".cache" / "contiga" / "kernels")
    assert twice(tmp_path / "one", **home) == ["42", "0", f"{where}\n"]
    assert twice(tmp_path / "other", **home) == ["42", "1", f"{where}\n"]


def entries(folder: Path, *names: str, age: float) -> None:
    """The files of kernels, of 100 bytes each, that were not asked for since `age` s."""
    now = cache_folder.time()
    for name in names:
        for ending in ("nbi", "1.nbc"):
            file = folder / f"{name}-0123456789abcdef.py311.{ending}"
            file.write_bytes(bytes(100))
            os.utime(file, (now - age, now - age))


def left(folder: Path) -> set[str]:
    return {file.name.partition("-")[0] for file in folder.iterdir()}


def test_kernels_that_were_not_used_the_longest_make_room(tmp_path: Path) -> None:
    for days, name in enumerate("abcd"):
        entries(tmp_path, f"{name}_nb.f", age=days * DAY)
    (tmp_path / "notes-of-a-user.txt").touch()
    cache_folder.mark_used(tmp_path / "d_nb.f-0123456789abcdef.py311.nbi")
    assert trim(tmp_path, at.SUFFIXES, 500) == ["c_nb.f0123456789abcdef", "b_nb.f0123456789abcdef"]
    assert left(tmp_path) == {"a_nb.f", "d_nb.f", "notes"}
    assert len(list(tmp_path.iterdir())) == 5


def test_all_are_removed_and_counted(home: Path) -> None:
    folder = kernel_folder()
    assert folder is not None
    entries(folder, "a_nb.f", "b_nb.g", age=0.0)
    (folder / f"{at.RECORD}-0123456789abcdef.json").touch()
    (folder / "kernels.lock").touch()
    assert remove_kernels() == 2
    assert left(folder) == {"kernels.lock"}
    assert remove_kernels() == 0
