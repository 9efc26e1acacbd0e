"""The examples of docstrings: they say what they print, and all that users call has one."""

from __future__ import annotations

import doctest
import importlib
import inspect
import re
from pathlib import Path

import pytest

import contiga as cg
from contiga.statuses import Advised

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src"
MODULES = sorted(
    ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")
    for path in (SOURCE / "contiga").rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)
SEEN_ELSEWHERE = {
    *("Master", "AreaMethod", "AreaInput", "Areas", "LawOutput"),
    *("FrictionInput", "FrictionOutput"),
    *("Case", "SystemState", "Result", "StoredResult", "Comparison", "Study", "Wrap"),
}
"""Protocols, and records that users are given: they stand on pages and with what makes them."""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files that examples read: a box of CAD, a cube as a mesh, the case of the README."""
    import meshio
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    folder = tmp_path_factory.mktemp("files")
    writer = STEPControl_Writer()
    box = BRepPrimAPI_MakeBox(20.0, 30.0, 40.0).Shape()
    writer.Transfer(box, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(folder / "part.step"))
    square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    corners = [[x, y, z] for z in (0.0, 1.0) for x, y in square]
    meshio.write(folder / "pad.vtu", meshio.Mesh(corners, [("hexahedron", [list(range(8))])]))
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    case = re.search(r"```toml\n(.*?)```", readme, re.S)
    assert case is not None
    (folder / "case.toml").write_text(case.group(1), encoding="utf-8")
    return folder


@pytest.mark.parametrize("name", MODULES)
def test_examples_print_what_they_say(
    name: str, files: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(files)
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert tried > 0
    assert failed == 0, capsys.readouterr().out


def test_all_that_users_call_has_an_example() -> None:
    public = {name: getattr(cg, name) for name in cg.__all__ if name != "__version__"}
    advised = {n for n, v in public.items() if inspect.isclass(v) and issubclass(v, Advised)}
    without = {
        name
        for name, value in public.items()
        if ">>> " not in (value.__doc__ or "")
        # a room may leave it to what stands in it
        and not (inspect.ismodule(value) and ">>> " in inspect.getsource(value))
    }
    assert without == advised | SEEN_ELSEWHERE


def test_no_example_is_skipped() -> None:
    sources = (SOURCE / "contiga").rglob("*.py")
    assert [path for path in sources if "doctest:" in path.read_text(encoding="utf-8")] == []
