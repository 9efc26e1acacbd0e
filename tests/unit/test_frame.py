"""The frame of the project: a light import, public names that resolve, files where they belong."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

import contiga

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "src" / "contiga").rglob("*.py"))
_VARIABLE = re.compile(r"^(\w+) :=(.+)$", re.M)
EVIDENCE = sorted((ROOT / "src" / "contiga_validation").rglob("*.py"))
HEAVY = (
    *("OCP", "rhino3dm", "meshio", "lsdyna_mesh_reader", "h5py", "sklearn", "plotly"),
    *("matplotlib", "pydantic", "pint", "scipy", "rich", "typer", "dask"),
)


def test_import_contiga_loads_no_heavy_package() -> None:
    code = (
        "import sys; import contiga; "
        f"print(*sorted({{m.partition('.')[0] for m in sys.modules}} & set({HEAVY!r})))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == []


def test_a_pose_loads_nothing_of_what_deforms_and_motion_has_all_names() -> None:
    code = (
        "import sys; import contiga as cg; cg.motion.pose.translation([0.0, 0.0, 1.0]); "
        "assert not any(name.startswith('contiga.matter') for name in sys.modules); "
        "import contiga.dynamics as d, contiga.motion as m; from contiga.motion import Free; "
        "assert all(getattr(m, name) is getattr(d, name) for name in d.__all__); "
        "assert m.__all__ == d.__all__ and dir(m) == sorted(d.__all__); "
        "assert not hasattr(m, 'deforming_nodes') and not hasattr(m, '__path__')"
    )
    subprocess.run([sys.executable, "-I", "-c", code], check=True)


@pytest.mark.parametrize("name", contiga.__all__)
def test_public_name_resolves(name: str) -> None:
    assert getattr(contiga, name) is not None


def test_names_that_do_not_exist_are_attribute_errors() -> None:
    with pytest.raises(AttributeError, match="no_such_name"):
        contiga.no_such_name  # noqa: B018


def test_version_is_that_of_the_package() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        assert tomllib.load(file)["project"]["version"] == contiga.__version__
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {contiga.__version__}\n" in cited


def test_the_hosted_workflow_runs_what_make_runs_on_every_system() -> None:
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    make = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", "")
    tests = " ".join(workflow[: workflow.index("  installations:")].split())
    variables = {name: " ".join(value.split()) for name, value in _VARIABLE.findall(make)}
    assert f"PYTEST: python -m pytest -q -p no:cacheprovider {variables['TWO']} " in tests
    commands = re.findall(r"^\t(NUMBA\w+=\d) \$\(PYTEST\) \$\(TWO\) (.+)$", make, re.M)
    assert len(commands) == 4
    for setting, chosen in commands:
        selection = chosen.replace("$(ONE_THREAD)", variables["ONE_THREAD"])
        assert f"{setting} $PYTEST {selection}" in tests
    assert tests.count("$PYTEST") == len(commands)
    for tool in re.findall(
        r"^\t\$\(BIN\)/(\w.+)", make[make.index("\nlint:") : make.index("\nbench:")], re.M
    ):
        assert f" {tool} " in tests
    assert "os: [ubuntu-latest, macos-latest, windows-latest]" in tests
    assert tests.count("if: ") == 1  # the libraries of Linux: no test is left out anywhere
    with (ROOT / "pyproject.toml").open("rb") as file:
        oldest = tomllib.load(file)["project"]["requires-python"].removeprefix(">=")
    assert re.findall(r"python: \[\"([\d.]+)\", ", tests) == [oldest]


def test_kernels_import_only_numpy_numba_math_records_and_kernels() -> None:
    allowed = ("numpy", "numba", "math", "typing", "__future__")
    allowed += ("contiga.arrays", "contiga.rigid", "contiga.jit", "contiga.records")
    for path in SOURCES:
        if not is_kernel(path):
            continue
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith(("import ", "from ")):
                module = line.split()[1]
                kernel = module.startswith("contiga.") and module.endswith(("_nb", "_records"))
                assert kernel or module.startswith(allowed), f"{path.name}: {line}"


def test_no_inner_kernel_is_called_from_python() -> None:
    """They have no entry from there: a call would end the process."""
    inner = {
        f"{path.stem}.{node.name}"
        for path in SOURCES
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
        if any(ast.unparse(given).startswith("inner(") for given in node.decorator_list)
    }
    assert len(inner) > 300
    folders = ("src", "tests", "benchmarks", "docs", "examples")
    files = [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]
    for path in files:
        assert not inner & set(_kernels_in_python(path)), path


def _kernels_in_python(path: Path) -> Iterator[str]:
    """The kernels (file.name) that a file hands to Python: those it names outside of kernels.

    Other files may name them, as ``x_nb.name``, in functions that they compile with ``@njit``.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    modules, names = {}, {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            home = (node.module or "").rpartition(".")[2]
            for alias in node.names:
                modules[alias.asname or alias.name] = alias.name
                names[alias.asname or alias.name] = f"{home}.{alias.name}"
    parts = [node for node in tree.body if not getattr(node, "decorator_list", [])]
    if not is_kernel(path):
        yield from names.values()
        parts = [node for node in tree.body if not _is_compiled(node)]
    own = {node.name: f"{path.stem}.{node.name}" for node in tree.body if hasattr(node, "name")}
    for part in parts:
        for node in ast.walk(part):
            if isinstance(node, ast.Name):
                yield (names | own).get(node.id, "")
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                yield f"{modules.get(node.value.id)}.{node.attr}"


def _is_compiled(node: ast.stmt) -> bool:
    return isinstance(node, ast.FunctionDef) and [ast.unparse(d) for d in node.decorator_list] == [
        "njit"
    ]


def is_kernel(path: Path) -> bool:
    """Whether a file is one of kernels, by where it stands."""
    return path.parent.name == "kernels" and path.name != "__init__.py"


def named_tests(kernel: Path, tests: Path) -> list[str]:
    """Names of the test files that a kernel file may have: its own, or its family's."""
    words = kernel.stem.removesuffix("_nb").split("_")
    room = tests / kernel.parent.parent.relative_to(ROOT / "src" / "contiga")
    names = ["_".join(words[:k]) for k in range(len(words), 0, -1)]
    return [name for name in names if (room / f"test_{name}.py").is_file()]


def test_every_kernel_has_a_test_that_is_found_by_its_name() -> None:
    """`a_b_nb` of a room by `test_a_b.py` of the same room, or by its family's `test_a.py`."""
    kernels = [path for path in SOURCES if is_kernel(path)]
    assert len(kernels) > 60
    missing = [str(path) for path in kernels if not named_tests(path, ROOT / "tests" / "unit")]
    assert missing == []


def test_a_kernel_without_a_test_of_its_name_is_seen(tmp_path: Path) -> None:
    kernel = ROOT / "src" / "contiga" / "search" / "kernels" / "wide_edge_nb.py"
    (tmp_path / "search").mkdir()
    (tmp_path / "search" / "test_edge.py").touch()
    (tmp_path / "test_wide_edge.py").touch()
    assert named_tests(kernel, tmp_path) == []
    (tmp_path / "search" / "test_wide.py").touch()
    assert named_tests(kernel, tmp_path) == ["wide"]


def test_kernels_and_no_others_stand_in_folders_of_kernels() -> None:
    """Their names tell them from the public modules that call them."""
    for path in SOURCES:
        compiled = re.search(
            r"^@(njit|kernel|inner|inlined)\b", path.read_text(encoding="utf-8"), re.M
        )
        assert is_kernel(path) == path.name.endswith("_nb.py"), path
        assert is_kernel(path) or not compiled, path


@pytest.mark.parametrize(
    "room", sorted({p.parent for p in SOURCES if is_kernel(p)}), ids=lambda room: room.parent.name
)
def test_kernels_are_listed_in_reading_order(room: Path) -> None:
    """Each on those before it, so that whoever reads from the top knows all that is called."""
    doc = ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8"))) or ""
    listed = re.findall(r"^- (\w+_nb)\b", doc, re.M)
    assert sorted(listed) == sorted(path.stem for path in room.glob("*_nb.py"))
    for k, name in enumerate(listed):
        text = (room / f"{name}.py").read_text(encoding="utf-8")
        used = re.findall(rf"^from contiga\.{room.parent.name}\.kernels\.(\w+) import", text, re.M)
        assert set(used) <= set(listed[:k]), name


def test_decorators_come_from_one_place() -> None:
    given = {
        ast.unparse(decorator).partition("(")[0]
        for path in SOURCES
        if is_kernel(path)
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
        for decorator in node.decorator_list
    }
    assert given == {"kernel", "inner", "inlined", "intrinsic"}


def test_registry_hosts_are_named_nowhere() -> None:
    for path in (ROOT / "Makefile", ROOT / ".ci" / "run", ROOT / "pyproject.toml"):
        text = path.read_text(encoding="utf-8")
        assert "pypi" not in text.lower()
        assert "index-url" not in text
