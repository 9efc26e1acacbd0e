"""Marks of tuples that are handed by reference need no compiler."""

from __future__ import annotations

import subprocess
import sys


def test_a_mark_does_not_load_the_compiler():
    code = (
        "import sys; import contiga.handed as h\n"
        "@h.by_reference\nclass T(tuple): pass\n"
        "assert T in h.HANDED and 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
