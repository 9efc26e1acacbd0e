"""`python -m tests.oldest [TEST …]`: tests with the oldest numba that `pyproject.toml` allows.

numba, and the numpy it wants, are put into a folder of their own that comes first when Python looks
for modules; all other packages are those of the interpreter that runs this. Without tests named it
is a minute's: how kernels are compiled, kept and called, and some of them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "out" / "oldest"
QUICK = (
    *("tests/unit/jit/test_dispatcher.py", "tests/unit/jit/test_reference.py"),
    "tests/unit/jit/test_scratch.py",
    *(
        "tests/unit/rigid/test_rigid.py",
        "tests/unit/arrays/test_fma.py",
        "tests/unit/arrays/test_sort.py",
    ),
)


def oldest() -> str:
    """The requirement with the lowest version of numba."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        wanted = tomllib.load(file)["project"]["dependencies"]
    (found,) = (re.fullmatch(r"numba>=([\d.]+)", one) for one in wanted if "numba" in one)
    assert found is not None
    return f"numba=={found[1]}"


def main(tests: list[str]) -> int:
    """Install it where it is not yet, and run them."""
    folder = PLACE / oldest()
    if not folder.is_dir():
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "--target", str(folder), oldest()], check=True)
    path = os.pathsep.join((str(folder), str(ROOT / "src"), str(ROOT)))
    run = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *(tests or QUICK)]
    return subprocess.run(run, env=os.environ | {"PYTHONPATH": path}, cwd=ROOT).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
