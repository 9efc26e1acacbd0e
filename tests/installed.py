"""`python -m tests.installed`: the wheel, installed away from the clone, runs the demo.

Other packages are those of the interpreter that runs this. The history has the bits of out/demo,
where `make demo` has left one.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests import same_history

ROOT = Path(__file__).resolve().parents[1]
CASE = ROOT / "examples" / "01_headform.toml"
DEMO = ROOT / "out" / "demo"
WHERE = "import contiga, contiga_validation as v; print(contiga.__file__, v.__file__, sep='\\n')"


def main() -> int:
    """Build it, install it, run it."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "wheel", "--no-deps", "-w", name, str(ROOT)], check=True)
        (wheel,) = folder.glob("contiga-*.whl")
        target = folder / "installed"
        subprocess.run([*pip, "install", "--no-deps", "--target", target, wheel], check=True)
        environment = os.environ | {"PYTHONPATH": str(target)}

        def python(*arguments: str) -> str:
            return subprocess.run(
                [sys.executable, *arguments],
                cwd=folder,
                env=environment,
                check=True,
                stdout=subprocess.PIPE,
                text=True,
            ).stdout

        for file in python("-c", WHERE).splitlines():
            if not Path(file).is_relative_to(target):
                print(f"{file} is not of the wheel", file=sys.stderr)
                return 1
        out = folder / "out"
        python("-m", "contiga", "run", str(CASE), "-o", str(out))
        if not (out / "report.html").is_file():
            print("the run of the wheel has left no report", file=sys.stderr)
            return 1
        if not (DEMO / "history.csv").is_file():
            return 0
        return same_history.main([str(DEMO), str(out)])


if __name__ == "__main__":
    sys.exit(main())
