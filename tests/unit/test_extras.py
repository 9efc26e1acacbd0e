"""Optional packages: declared by what imports them, asked for by name, not missed without need.

Child processes see the standard library and the packages they are given, and no others: a
``sitecustomize`` stands in the way of all other imports, in their own children too.
"""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from contiga import extras
from contiga.errors import MissingPackageError
from contiga.extras import EXTRA_OF, PROJECT_OF, require

ROOT = Path(__file__).resolve().parents[2]
OURS = (ROOT / "src", Path(__file__).parent)
BARE = ("numpy", "numba", "llvmlite", "scipy")
BROUGHT_BY = {
    "pydantic_core": "pydantic",
    "PIL": "matplotlib",
    "cycler": "matplotlib",
    "llvmlite": "numba",
}
"""Packages that come with one which is declared."""
ONLY_HANDED_OVER = {"trimesh", "geomdl", "splinepy"}
"""Packages whose objects are made of ours, for users who have them: by `extras.imported`."""
IN_NOTEBOOKS = {"IPython"}
"""Packages that the process of every notebook has, and that are imported nowhere else."""
ONLY_READ = {"plotly"}
"""Packages that a file is taken from, and none of whose modules is imported."""

HIDING = """
import sys

ALLOWED = {allowed!r}


class Hide:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top in ALLOWED or top.startswith("_sysconfigdata") or top in sys.stdlib_module_names:
            return None
        raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)


sys.meta_path.insert(0, Hide())
"""
OWN = ("contiga", "contiga_validation", "sitecustomize", "bare_run")
# What Python needs to come up in an environment with editable packages.
STARTUP = ("_virtualenv", "_distutils_hack", "usercustomize")

CASE = """
title = "Ball and sheet"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 1.0, step = 0.5 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10.0 }
motion = { kind = "translate", table = [[0, 0, 0, 11], [1, 0, 0, 9]] }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 20, length = 20, nu = 5, nv = 5 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "force", curve = [[0, 0], [1, 10]] }
"""

Child = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="module")
def child(tmp_path_factory: pytest.TempPathFactory) -> Child:
    """Runs Python with nothing but the bare packages and those that it is given."""

    def run(*arguments: str, given: tuple[str, ...] = ()) -> subprocess.CompletedProcess[str]:
        folder = tmp_path_factory.mktemp("hidden")
        allowed = {*BARE, *OWN, *STARTUP, *given}
        (folder / "sitecustomize.py").write_text(HIDING.format(allowed=allowed), encoding="utf-8")
        path = os.pathsep.join(map(str, [folder, *OURS]))
        return subprocess.run(
            [sys.executable, *arguments],
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": path},
            cwd=folder,
        )

    return run


def test_everything_that_needs_no_extra_works_bare_with_the_same_bits(child: Child) -> None:
    code = "import json, sys; from bare_run import results; print(json.dumps(results()))"
    bare = child("-c", f"{code}; assert not set(sys.modules) & {set(EXTRA_OF)!r}")
    assert bare.returncode == 0, bare.stderr
    full = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, OURS))},
    )
    data = json.loads(bare.stdout)
    assert len(data) > 20
    assert data == json.loads(full.stdout)
    assert data["cloud"] == [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]
    assert data["gaps"][0] == pytest.approx(2.0 - 0.55 - 0.5)


DOORS = {
    "STEP": ('cg.read_cad("part.step")', "cadquery-ocp-novtk", "cad"),
    "IGES": ('cg.read_cad("part.IGS")', "cadquery-ocp-novtk", "cad"),
    "3DM": ('cg.read_cad("part.3dm")', "rhino3dm", "cad"),
    "splitting": ("ball.split(([0, 0, 0], [0, 0, 1]))", "cadquery-ocp-novtk", "cad"),
    "mesh": ('cg.read_mesh("part.vtu")', "meshio", "mesh"),
    "master": ('cg.read_master("part.stl")', "meshio", "mesh"),
    "writing": ('cg.write_mesh("new.stl", ball.tessellate(0.1))', "meshio", "mesh"),
    "fields": (
        'import contiga.io.out.vtkhdf as v; v.read_fields(Path("part.step"))',
        "h5py",
        "mesh",
    ),
    "load_case": ('cg.load_case("case.toml")', "pydantic", "case"),
    "run": ('cg.run("case.toml")', "pydantic", "case"),
    "study": ('cg.study("case.toml", {}, [])', "pydantic", "case"),
    "unit": ('cg.read_mesh("part.csv", unit="furlong")', "pint", "case"),
    "report": (
        'import contiga.report as r; r.write_report("out")',
        "plotly and matplotlib",
        "report",
    ),
    "k-means": ("cg.HullArea(2)", "scikit-learn", "cluster"),
    "DBSCAN": ('cg.HullArea("dbscan")', "scikit-learn", "cluster"),
    "reproduce": (
        'from contiga_validation.reproduce import reproduce as r; r("new")',
        "matplotlib and pydantic and scikit-learn and cadquery-ocp-novtk",
        "report,case,cluster,cad",
    ),
    "verify": (
        'from contiga_validation.verify import verify as v; v("new")',
        "matplotlib",
        "report",
    ),
    "folder": ('import bare_run as b; b.dipping().run("new")', "h5py", "mesh"),
    "MuJoCo": (
        "import contiga.couple as c; c.MujocoCoupling(0, 0, masters={}, slaves={}, contacts=[])",
        "mujoco",
        "mujoco",
    ),
    "table": ("import bare_run as b; b.dipping().run().to_pandas()", "pandas", "pandas"),
    "to_meshio": ("ball.tessellate(0.1).to_meshio()", "meshio", "mesh"),
    "plot": ("import bare_run as b; b.dipping().run().plot()", "matplotlib", "report"),
}


def test_what_needs_an_extra_names_it(child: Child) -> None:
    lines = [
        "import json, contiga as cg",
        "from pathlib import Path",
        "from contiga.errors import MissingPackageError",
        "ball = cg.Body([cg.shapes.sphere(radius=1.0)])",
        "for f in ('step', 'IGS', '3dm', 'vtu', 'stl'): Path('part.' + f).write_text('some')",
        "Path('part.csv').write_text('0,0,0')",
        "said = {}",
    ]
    for name, (call, _, _) in DOORS.items():
        body = "; ".join(part.strip() for part in call.split(";"))
        lines += [
            f"try: {body}",
            f"except MissingPackageError as error: said[{name!r}] = str(error)",
        ]
    lines += ["said['left'] = [p.name for p in Path().glob('new*')]", "print(json.dumps(said))"]
    done = child("-c", "\n".join(lines))
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said.pop("left") == []
    assert set(said) == set(DOORS)
    for name, (_, packages, extra) in DOORS.items():
        assert f" needs {packages}, which " in said[name], name
        assert said[name].endswith(f'pip install "contiga[{extra}]"'), name


def one_line(done: subprocess.CompletedProcess[str]) -> str:
    """The only line that a command says, on the error stream, with exit code 2."""
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    return line


CLI = ("typer", "click", "shellingham", "rich", "pygments", "markdown_it", "mdurl", "annotated_doc")
CHECKS = (
    *("pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection"),
    *("pint", "flexcache", "flexparser", "platformdirs", "packaging"),
)


@pytest.mark.parametrize("command", [(), ("--version",), ("run", "case.toml"), ("info", "a.stl")])
def test_the_command_line_says_what_it_needs(child: Child, command: tuple[str, ...]) -> None:
    said = one_line(child("-m", "contiga", *command))
    assert said.startswith("contiga: error: the command line needs typer and rich and pydantic,")
    assert said.endswith('pip install "contiga[case]"')


def test_a_command_says_what_it_needs(child: Child, tmp_path: Path) -> None:
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    done = child("-m", "contiga", "info", str(tmp_path / "part.step"), given=CLI + CHECKS)
    said = one_line(done)
    assert said.startswith("contiga: error: reading .step files needs cadquery-ocp-novtk,")
    assert said.endswith('pip install "contiga[cad]"')


def test_a_run_says_before_it_starts_that_its_report_cannot_be_written(
    child: Child, tmp_path: Path
) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    command = ("-m", "contiga", "run", str(tmp_path / "case.toml"), "-o", str(tmp_path / "out"))
    said = one_line(child(*command, given=(*CLI, *CHECKS, "h5py")))
    assert "report = false" in said
    assert said.endswith('pip install "contiga[report]"')
    assert not (tmp_path / "out").exists()
    (tmp_path / "case.toml").write_text(CASE + "[output]\nreport = false\n")
    done = child(*command, "--quiet", given=(*CLI, *CHECKS, "h5py"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "history.csv").is_file()


def test_what_is_there_is_not_asked_for() -> None:
    apart = {"pyvista", "imageio_ffmpeg"}  # tests that need these are skipped without them
    require("this test", *(set(EXTRA_OF) - apart))


def test_all_that_is_missing_is_named_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    for name in ("OCP", "rhino3dm", "h5py"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, "sklearn", None)  # what Python itself takes for "not there"
    with pytest.raises(MissingPackageError) as caught:
        require("This", "OCP", "rhino3dm", "h5py", "sklearn")
    assert str(caught.value) == (
        "This needs cadquery-ocp-novtk and rhino3dm and h5py and scikit-learn, which are not "
        'installed. Install what is missing with: pip install "contiga[cad,mesh,cluster]"'
    )
    assert caught.value.exit_code == 2
    assert isinstance(caught.value, ImportError)


@pytest.fixture(scope="module")
def project() -> dict[str, object]:
    with (ROOT / "pyproject.toml").open("rb") as file:
        data: dict[str, object] = tomllib.load(file)["project"]
    return data


def names_of(requirements: list[str]) -> set[str]:
    """The projects that requirements ask for."""
    return {re.match(r"[\w-]+", line).group() for line in requirements}  # type: ignore[union-attr]


def test_every_extra_is_that_of_its_packages(project: dict[str, object]) -> None:
    declared = project["optional-dependencies"]
    wanted: dict[str, set[str]] = {}
    for module, extra in EXTRA_OF.items():
        wanted.setdefault(extra, set()).add(PROJECT_OF.get(module, module))
    assert {extra: names_of(declared[extra]) for extra in wanted} == wanted  # type: ignore[index]
    (whole,) = declared["all"]  # type: ignore[index]
    # For those who have them: of commands films as .mp4 alone need one. What rates brings many
    # packages, and reports draw their curves without it.
    apart = {"mujoco", "pyvista", "film", "rating"}
    assert set(re.findall(r"\w+", whole)) == {"contiga", *wanted} - apart
    for extra in apart:
        assert set(declared[extra]) <= set(declared["test"])  # type: ignore[index]
    others = set(declared) - {*wanted, "all"}  # type: ignore[call-overload]
    assert others == {"bench", "check", "docs", "test"}


def test_all_that_is_imported_is_declared_and_nothing_else(project: dict[str, object]) -> None:
    files = (ROOT / "src").rglob("*.py")
    foreign = {name for path in files for name in imported(path)} - set(sys.stdlib_module_names)
    foreign = {BROUGHT_BY.get(name, name) for name in foreign} - {"contiga", "contiga_validation"}
    bare = names_of(project["dependencies"])  # type: ignore[arg-type]
    assert bare == {"numpy", "numba", "scipy"}
    assert foreign | ONLY_READ == bare | set(EXTRA_OF) | ONLY_HANDED_OVER | IN_NOTEBOOKS
    assert not foreign & ONLY_READ


def imported(path: Path) -> Iterator[str]:
    """Packages that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "imported":
            names = [n.value for n in ast.walk(node.args[1]) if isinstance(n, ast.Constant)]
            yield from (str(name).partition(".")[0] for name in names)
