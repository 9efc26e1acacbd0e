"""`python -m tests.newest [TEST …]`: quick tests with the newest Python beside the one at hand.

It is looked for on the PATH and among the versions of pyenv; where there is none, a line says so.
It gets a virtual environment of its own under out/newest. The tests are of what depends on Python
and on code compiled for it: how kernels are compiled, kept and called, the arrays and poses that
they take, laws, and contact, which needs the search. Compiling for them takes some two minutes,
once. Long tests are left out.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "out" / "newest"
MINORS = range(14, 10, -1)
"""Of Python 3, the newest first: those that the hosted workflow tries, and what is between them."""
EXTRAS = "cad,case"
NEEDED = ("pytest", "hypothesis")
QUICK = tuple(f"tests/unit/{room}" for room in ("jit", "arrays", "rigid", "laws", "contact"))


class Other(NamedTuple):
    """A Python of this machine."""

    minor: int
    path: str

    @property
    def name(self) -> str:
        """Version."""
        return f"3.{self.minor}"


def found() -> Other | None:
    """The newest that is not of the version that runs this."""
    for minor in MINORS:
        if minor == sys.version_info.minor:
            continue
        for path in _candidates(f"3.{minor}"):
            code = "import sys, ensurepip; print(sys.version_info.minor)"
            asked = subprocess.run([path, "-c", code], capture_output=True, text=True, check=False)
            if asked.returncode == 0 and asked.stdout.strip() == str(minor):
                return Other(minor, path)
    return None


def _candidates(version: str) -> list[str]:
    """What may be of that version: a name on the PATH may lead nowhere, as those of pyenv do."""
    named = shutil.which(f"python{version}")
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    kept = sorted(pyenv.glob(f"versions/{version}*/bin/python"))
    return [*([named] if named else []), *map(str, kept)]


def main(tests: list[str]) -> int:
    """Make its environment, where it is older than pyproject.toml, and run them."""
    other = found()
    if other is None:
        print("no other Python of 3.11 to 3.14 is on this machine: one version is tried")
        return 0
    folder = PLACE / other.name
    python, stamp = folder / "bin" / "python", folder / "installed"
    project = ROOT / "pyproject.toml"
    if not stamp.is_file() or stamp.stat().st_mtime < project.stat().st_mtime:
        subprocess.run([other.path, "-m", "venv", "--clear", str(folder)], check=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "-e", f"{ROOT}[{EXTRAS}]", *NEEDED], check=True)
        stamp.touch()
    print(f"tests with Python {other.name}")
    run = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not long"]
    return subprocess.run([*run, *(tests or QUICK)], cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
