"""Kernels become a wheel that pip installs, the same one on any machine."""

from __future__ import annotations

import base64
import csv
import os
import platform
import subprocess
import sys
import sysconfig
from hashlib import sha256
from pathlib import Path
from zipfile import ZipFile

import numba
import pytest
from tests.tiny_wheel import LEVEL, LISTED, compiled, written

from contiga.errors import RunError
from contiga.version import __version__
from contiga.warmup import pack

ABOUT = f"contiga_kernels-{__version__}.dist-info"


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> dict[int, str]:
    return compiled(tmp_path_factory.mktemp("kept"))


def test_pip_installs_it_and_can_remove_it(kept: dict[int, str], tmp_path: Path) -> None:
    wheel = written(kept, tmp_path / "dist")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    where = ["--no-deps", "--no-index", "--target", str(tmp_path / "site")]
    subprocess.run([*pip, *where, str(wheel)], check=True)
    assert {path.name for path in (tmp_path / "site").iterdir()} == {"contiga_kernels", ABOUT}
    with ZipFile(wheel) as archive:
        rows = list(csv.reader(archive.read(f"{ABOUT}/RECORD").decode().splitlines()))
        assert {name for name, *_ in rows} == set(archive.namelist())
        for name, digest, size in rows:
            content = archive.read(name)
            whole = base64.urlsafe_b64encode(sha256(content).digest()).rstrip(b"=").decode()
            own = name.endswith("RECORD")
            assert (digest, size) == (("", "") if own else (f"sha256={whole}", str(len(content))))
        tag = wheel.stem.split("-", 2)[2]
        assert f"\nTag: {tag}\n" in archive.read(f"{ABOUT}/WHEEL").decode()
        assert numba.__version__ in archive.read(f"{ABOUT}/METADATA").decode()


def test_the_same_kernels_are_the_same_wheel(kept: dict[int, str], tmp_path: Path) -> None:
    one, other = (written(kept, tmp_path / name) for name in ("one", "other"))
    assert one.name == other.name
    assert one.read_bytes() == other.read_bytes()
    assert [file.name for file in one.parent.iterdir()] == [one.name]


def test_the_name_is_that_of_this_python(kept: dict[int, str], tmp_path: Path) -> None:
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    abi = f"{version}{getattr(sys, 'abiflags', '')}"
    name = written(kept, tmp_path).name
    assert name.startswith(f"contiga_kernels-{__version__}-{version}-{abi}-")


@pytest.mark.parametrize(
    ("system", "machine", "tag"),
    [
        ("linux-x86_64", "x86_64", "linux_x86_64"),
        ("linux-aarch64", "aarch64", "linux_aarch64"),
        ("win-amd64", "AMD64", "win_amd64"),
        ("macosx-10.13-universal2", "arm64", "macosx_11_0_arm64"),
        ("macosx-10.13-universal2", "x86_64", "macosx_10_13_x86_64"),
        ("macosx-14.0-arm64", "arm64", "macosx_14_0_arm64"),
        ("macosx-15-arm64", "arm64", "macosx_15_0_arm64"),
    ],
)
def test_the_name_is_that_of_the_system(
    system: str, machine: str, tag: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sysconfig, "get_platform", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
    assert pack._platform_tag() == tag


@pytest.mark.parametrize(
    ("machine", "names"),
    [
        ("x86_64", ["x86-64-v3", "x86-64-v4"]),
        ("AMD64", ["x86-64-v3", "x86-64-v4"]),
        ("arm64", ["generic"]),
    ],
)
def test_levels_are_those_of_the_kind_of_processor(
    machine: str, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platform, "machine", lambda: machine)
    assert [level.name for level in pack.levels()] == names


def test_of_numbas_settings_only_the_level_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_OPT", "0")
    monkeypatch.setenv("NUMBA_CPU_NAME", "vax")
    found = pack.environment(pack.X86[1], tmp_path)
    own = {name: value for name, value in found.items() if name.startswith("NUMBA_")}
    level = {"NUMBA_CPU_NAME": "x86-64-v4", "NUMBA_CPU_FEATURES": "-prefer-256-bit"}
    assert own == level | {"NUMBA_CACHE_DIR": str(tmp_path)}
    assert found["PATH"] == os.environ["PATH"]


@pytest.mark.parametrize("row", range(len(LISTED.kernels)))
def test_a_kernel_that_was_not_kept_is_named(
    row: int, kept: dict[int, str], tmp_path: Path
) -> None:
    other = kept[(row + 1) % len(LISTED.kernels)]
    for lost in (kept | {row: ""}, kept | {row: other}):
        with pytest.raises(RunError, match=rf"\.{LISTED.kernels[row].name} was compiled and"):
            written(lost, tmp_path)
    assert not list(tmp_path.iterdir())


def test_sources_that_change_meanwhile_are_noticed(
    kept: dict[int, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = pack.sources()
    assert {"geometry/kernels/basis_nb.py", "jit/cache.py", "warmup/kernels.json"} <= set(
        before.files
    )
    monkeypatch.setattr(pack, "stamp_of_files", lambda _: "another")
    with pytest.raises(RunError, match="have changed while they were compiled"):
        pack.write_wheel({LEVEL: kept}, before, tmp_path)
    assert not list(tmp_path.iterdir())
