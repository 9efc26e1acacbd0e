"""Kernels that are kept name the classes of records that they were called with."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RECORD = "from typing import NamedTuple\n\nclass Pair(NamedTuple):\n    a: float\n    b: float\n"
KERNEL = (
    "from contiga.jit import kernel\n\n@kernel()\ndef total(pair):\n    return pair.a + pair.b\n"
)
RUN = """
import sys
from pathlib import Path

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from contiga.jit.stamps import PACKAGES

PACKAGES.append(folder / "tiny")
from tiny.{0} import Pair
from tiny.totals import total

print(total(Pair(1.0, 2.0)), sum(total.stats.cache_hits.values()))
"""


def test_a_kernel_is_compiled_anew_where_a_record_has_moved(tmp_path: Path) -> None:
    """Its own source is what it was, and so is the name of the file that it is kept in."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "totals.py").write_text(KERNEL)

    def run(module: str) -> str:
        program = [sys.executable, "-B", "-c", RUN.format(module), str(tmp_path)]
        return subprocess.run(program, capture_output=True, text=True, check=True).stdout

    (folder / "here.py").write_text(RECORD)
    assert run("here") == "3.0 0\n"
    assert run("here") == "3.0 1\n"
    (folder / "here.py").rename(folder / "there.py")
    assert run("there") == "3.0 0\n"
    assert run("there") == "3.0 1\n"
