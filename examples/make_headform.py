"""Writes the headform of the first example as STEP; what it is made of stands in the module.

python make_headform.py headform.step
"""

from __future__ import annotations

import sys
from pathlib import Path

from contiga_validation.rivals.headform import headform, only_solid, write_step

if __name__ == "__main__":
    write_step(only_solid(headform()), Path(sys.argv[1] if len(sys.argv) > 1 else "headform.step"))
