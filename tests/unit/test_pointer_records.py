"""Marks of tuples that are passed by pointer need no compiler."""

from __future__ import annotations

import subprocess
import sys


def test_a_mark_does_not_load_the_compiler():
    code = (
        "import sys; import contiga.pointer_records as h\n"
        "@h.pass_by_pointer\nclass T(tuple): pass\n"
        "assert T in h.PASSED_BY_POINTER and 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
