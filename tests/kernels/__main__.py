"""``python -m tests.kernels``: write the list of kernels anew, from what the demo and scenes need.

All of them are compiled, in a folder of its own, by one process: some two minutes. It is needed
where kernels come, go or take other arguments; until then runs compile what is not listed where
they need it.
"""

from __future__ import annotations

import os
import sys
from tempfile import TemporaryDirectory


def main() -> int:
    """Write the list."""
    with TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder  # before numba is imported, which reads it then
        from tests.kernels import recording

        return recording.write()


if __name__ == "__main__":
    sys.exit(main())
