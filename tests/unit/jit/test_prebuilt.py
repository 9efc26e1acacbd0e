"""Installed kernels are used where they fit, all of them or none, and a line says which."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest
from tests.tiny_wheel import LEVEL, unpacked

from contiga.jit import prebuilt
from contiga.jit.prebuilt import CODE, MANIFEST, Manifest, choice, digest_of

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
POSIX = pytest.mark.skipif(os.name != "posix", reason="modes are POSIX's")


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpacked(tmp_path_factory.mktemp("wheel"))


@pytest.fixture
def package(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the kernels, which is all that is installed."""
    copy = tmp_path / "site" / original.name
    shutil.copytree(original, copy)
    monkeypatch.setattr(sys, "path", [str(copy.parent)])
    return copy


def reason() -> str:
    """Why the kernels are not used."""
    chosen = choice.__wrapped__()
    assert chosen.prebuilt is None
    head, _, tail = chosen.text.partition(" is not used: ")
    assert head.startswith("kernels are compiled on this machine; contiga_kernels in ")
    assert "\n" not in tail
    return tail


def rewritten(package: Path, of: str = LEVEL.name, **fields: Any) -> None:
    """The manifest of a level with other fields, and whole."""
    file = package / of / MANIFEST
    manifest = Manifest(**json.loads(file.read_text()))._replace(**fields)
    digest = digest_of(manifest, (package / of / CODE).read_bytes())
    file.write_text(json.dumps(manifest._replace(digest=digest)._asdict()))


def test_kernels_that_fit_are_used(package: Path) -> None:
    chosen = choice.__wrapped__()
    assert chosen.prebuilt is not None
    level = chosen.prebuilt.manifest.level
    assert chosen.text == f"kernels are those of contiga_kernels in {package}: {level}"
    assert len(chosen.prebuilt.manifest.places) == 3
    assert chosen.prebuilt.versions("nobody.knows-1") == {}


def test_without_any_it_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    (tmp_path / "contiga_kernels").mkdir()  # no package
    text = "kernels are compiled on this machine; contiga_kernels is not installed"
    assert choice.__wrapped__() == (None, text, False)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"python": "cpython-39"}, "it was compiled for Python cpython-39, and this is cpython-"),
        ({"numba": "0.1.2"}, f"compiled for numba 0.1.2, and this is {numba.__version__}"),
        ({"llvmlite": "0.1.2"}, "it was compiled for llvmlite 0.1.2, and this is "),
        ({"target": ["vax-dec-ultrix", "vax", ""]}, "for system vax-dec-ultrix, and this is "),
        ({"features": ["ink", "quill"]}, "and this processor lacks ink, quill"),
        ({"stamp": "0"}, "it was compiled from other sources of contiga than these"),
        ({"sources": ["nobody_nb.py"]}, "it was compiled from other sources of contiga than these"),
        ({"sources": []}, "it was compiled from other sources of contiga than these"),
    ],
)
def test_kernels_of_another_kind_are_not_used(
    fields: dict[str, Any], text: str, package: Path
) -> None:
    rewritten(package)
    assert choice.__wrapped__().prebuilt is not None
    rewritten(package, **fields)
    assert text in reason()


def level(package: Path, name: str, features: str, needs: list[str]) -> None:
    """The same kernels as those of another level."""
    shutil.copytree(package / LEVEL.name, package / name)
    system = prebuilt.compiled_for()[0]
    rewritten(package, name, target=[system, name, features], features=needs)


def test_the_highest_level_that_a_processor_has_is_taken(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    level(package, "x86-64-v8", "-prefer-256-bit", ["sse2", "ink"])
    level(package, "x86-64-v9", "", ["sse2", "ink", "quill"])
    system = prebuilt.compiled_for()[0]

    def taken(processor: str, features: str) -> str:
        monkeypatch.setattr(prebuilt, "compiled_for", lambda: (system, processor, features))
        chosen = choice.__wrapped__()
        return chosen.prebuilt.manifest.level if chosen.prebuilt else chosen.text

    lowest = ",".join(f"+{name}" for name in LEVEL.needs)
    assert taken("any", f"{lowest},-avx512f") == LEVEL.name
    assert taken("any", f"{lowest},+sse2,+ink,+quill") == "x86-64-v9"
    assert taken("znver9", f"{lowest},+sse2,+ink,+avx512f") == "x86-64-v8"
    assert taken("any", f"{lowest},+sse2,+ink,+avx512f") == LEVEL.name  # its vectors are shorter
    shutil.rmtree(package / LEVEL.name)
    assert taken("any", "+sse2,+ink").endswith(
        ": it is for x86-64-v8, and this processor lacks vectors of 512 bits"
    )
    assert taken("any", "-ink").endswith(
        ": it is for x86-64-v8, and this processor lacks sse2, ink"
    )
    shutil.rmtree(package / "x86-64-v8")
    shutil.rmtree(package / "x86-64-v9")
    assert taken("any", lowest).endswith(": it holds no kernels")


def test_those_of_another_version_of_a_system_are_used(package: Path, monkeypatch: Any) -> None:
    here = prebuilt.compiled_for()
    monkeypatch.setattr(
        prebuilt, "compiled_for", lambda: ("arm64-apple-darwin25.1.0", here[1], here[2])
    )
    rewritten(package, target=["arm64-apple-darwin22.6.0", "generic", ""])
    assert choice.__wrapped__().prebuilt is not None


def cut(file: Path, size: int) -> None:
    file.write_bytes(file.read_bytes()[:size])


def altered(file: Path, at: int) -> None:
    content = bytearray(file.read_bytes())
    content[at] ^= 1
    file.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [
        lambda package: cut(package / LEVEL.name / CODE, 0),
        lambda package: cut(package / LEVEL.name / CODE, -1),
        lambda package: altered(package / LEVEL.name / CODE, 0),
        lambda package: altered(package / LEVEL.name / CODE, -1),
        lambda package: cut(package / LEVEL.name / MANIFEST, 0),
        lambda package: cut(package / LEVEL.name / MANIFEST, 100),
        lambda package: altered(package / LEVEL.name / MANIFEST, -4),
        lambda package: (package / LEVEL.name / MANIFEST).write_text("[]"),
        lambda package: (package / LEVEL.name / MANIFEST).write_text("{}"),
        lambda package: (package / LEVEL.name / MANIFEST).write_bytes(b"\xff\xfe"),
        lambda package: (package / LEVEL.name / MANIFEST).write_text("[" * 10000),
    ],
)
def test_damaged_ones_are_not_used(damage: Callable[[Path], Any], package: Path) -> None:
    damage(package)
    assert reason().endswith(" damaged")


def test_no_bit_of_the_manifest_may_change(package: Path) -> None:
    whole = (package / LEVEL.name / MANIFEST).read_bytes()
    for at in range(0, len(whole), 97):
        altered(package / LEVEL.name / MANIFEST, at)
        assert reason()
        (package / LEVEL.name / MANIFEST).write_bytes(whole)


@pytest.mark.parametrize("name", [CODE, MANIFEST])
def test_a_file_that_is_not_there_is_named(name: str, package: Path) -> None:
    (package / LEVEL.name / name).unlink()
    assert re.fullmatch(rf"its files cannot be read \(.*{re.escape(name)}.*\)", reason())


@POSIX
@pytest.mark.parametrize("part", ["..", ".", "", MANIFEST, CODE])
def test_what_others_may_write_to_is_not_used(part: str, package: Path) -> None:
    inside = "" if part.startswith(".") else LEVEL.name
    path = (package / inside / part).resolve()
    path.chmod(path.stat().st_mode | 0o002)
    assert reason() == f"others may write to {path}"


@POSIX
def test_a_group_may_write_to_them_if_it_may_to_contiga(
    package: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (package / LEVEL.name / CODE).chmod(0o664)
    (tmp_path / "contiga").mkdir()
    monkeypatch.setattr(prebuilt, "stamp_of_files", lambda _: Manifest(**manifest).stamp)
    manifest = json.loads((package / LEVEL.name / MANIFEST).read_text())
    monkeypatch.setattr(prebuilt, "PACKAGE", tmp_path / "contiga")
    (tmp_path / "contiga").chmod(0o755)
    assert reason() == f"others may write to {package / LEVEL.name / CODE}"
    (tmp_path / "contiga").chmod(0o775)
    assert choice.__wrapped__().prebuilt is not None


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives away")
def test_those_of_another_user_are_not_used(package: Path) -> None:
    os.chown(package, 12345, -1)
    assert reason() == f"others may write to {package}"


@pytest.mark.parametrize(
    ("setting", "value", "text"),
    [
        ("CPU_NAME", "x86-64-v3", "NUMBA_CPU_NAME or NUMBA_CPU_FEATURES says what to compile for"),
        ("CPU_FEATURES", "", "NUMBA_CPU_NAME or NUMBA_CPU_FEATURES says what to compile for"),
        ("DISABLE_JIT", 1, "NUMBA_DISABLE_JIT is set"),
        (
            "USING_SVML",
            True,
            "numba uses functions of Intel's SVML here, with results of other bits",
        ),
    ],
)
def test_settings_of_numba_go_first(
    setting: str, value: Any, text: str, package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, setting, value)
    assert reason() == text


def test_they_may_be_switched_off(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(prebuilt.SWITCH, "0")
    assert reason() == "CONTIGA_KERNELS is 0"
    monkeypatch.setenv(prebuilt.SWITCH, "1")
    assert choice.__wrapped__().prebuilt is not None


TINY = """
from contiga.geometry.kernels.basis_nb import discrete_splines, find_span, refinement_rows
from contiga.jit import kernel


@kernel()
def both(knots, degree, count, refined):
    first, weights = refinement_rows(knots, degree, count, refined)
    span = find_span(knots, degree, count, refined[1])
    weights[0] = 0.0
    discrete_splines(knots, degree, span, refined, 1, -1, weights[0])
    return first, weights
"""
RUN = """
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])
import contiga.search.track.kernels.lanes_nb as lanes
from contiga.geometry.kernels.basis_nb import find_span, refinement_rows
from contiga.jit.folder import kernel_folder
from contiga.jit.prebuilt import choice
from contiga.jit.preload import is_missing, preload
from contiga.jit.stamps import PACKAGES

PACKAGES.append(Path(sys.argv[1]) / "tiny")
from tiny.both_nb import both

loaded = 0 if is_missing(refinement_rows) else preload([refinement_rows])
knots = np.array([0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0])
knots.flags.writeable = False
first, weights = both(knots, 2, 5, np.sort(np.append(knots, (0.1, 0.7))))
first_again, weights_again = refinement_rows(knots, 2, 5, np.sort(np.append(knots, (0.1, 0.7))))
compiled = sum(sum(k.stats.cache_misses.values()) for k in (find_span, refinement_rows))
print(json.dumps({
    "used": choice().prebuilt is not None, "text": choice().text, "lanes": lanes.BANK_WIDTH,
    "loaded": loaded, "compiled": compiled, "folder": kernel_folder() is not None,
    "both": sum(both.stats.cache_misses.values()), "bits": weights.tobytes().hex(),
    "bits again": weights_again.tobytes().hex(),
}))
"""


def said(folder: Path, *installed: Path, **environment: str) -> dict[str, Any]:
    """What a fresh process says."""
    (folder / "tiny").mkdir(exist_ok=True)
    (folder / "tiny" / "__init__.py").touch()
    (folder / "tiny" / "both_nb.py").write_text(TINY)
    env = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    env[prebuilt.SWITCH] = str(len(installed))
    env["PYTHONPATH"] = os.pathsep.join(map(str, (*installed, env.get("PYTHONPATH", ""))))
    run = [sys.executable, "-c", textwrap.dedent(RUN), str(folder)]
    done = subprocess.run(run, env=env | environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


def test_a_process_takes_them_and_compiles_what_is_not_among_them(
    original: Path, tmp_path: Path
) -> None:
    here = said(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "here"))
    assert (here["used"], here["compiled"], here["both"]) == (False, 2, 1)
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "there")}
    for compiled in (1, 0):  # what is compiled here is kept here
        found = said(tmp_path, original.parent, **cache)
        assert (found["used"], found["loaded"]) == (True, 1)
        assert (found["compiled"], found["both"]) == (0, compiled)
        assert found["lanes"] == 4
        assert (found["bits"], found["bits again"]) == (here["bits"], here["bits again"])
    kept = {file.name.split("-")[0] for file in (tmp_path / "there").rglob("*.nbc")}
    assert kept == {"both_nb.both"}
    # Without them the constants of kernels may be others: what was kept is of no use then.
    alone = said(tmp_path, **cache)
    assert alone["both"] == (0 if alone["lanes"] == 4 else 1)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="where homes are, is Linux's")
def test_they_are_used_where_no_folder_can_be_written_to(original: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    code = f"import tempfile; tempfile.tempdir = {str(tmp_path / 'file')!r}\n"
    (tmp_path / "sitecustomize.py").write_text(code)
    nowhere = {"HOME": str(tmp_path / "file"), "XDG_CACHE_HOME": ""}
    found = said(tmp_path, original.parent, tmp_path, **nowhere)
    assert not found["folder"]
    assert (found["used"], found["loaded"], found["compiled"], found["both"]) == (True, 1, 0, 1)


def test_a_process_with_damaged_ones_compiles_all(package: Path, tmp_path: Path) -> None:
    altered(package / LEVEL.name / CODE, 0)
    found = said(tmp_path, package.parent, NUMBA_CACHE_DIR=str(tmp_path / "kept"))
    assert (found["used"], found["compiled"]) == (False, 2)
    assert found["text"].endswith(" is not used: its files are damaged")
