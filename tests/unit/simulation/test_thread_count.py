"""The number of threads changes no bit of a whole run."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.sample import full

from contiga.io.out.history import read_history
from contiga.io.out.vtkhdf import read_fields

CASE = """
title = "Torus falls on a cloud"
[units]
length = "m"
mass = "kg"
time = "s"
[time]
end = 10.0
step = 1.0
[[body]]
name = "ring"
geometry = { shape = "torus", major = 2.0, minor = 0.5 }
[body.motion]
kind = "combine"
motions = [
  { kind = "rotate", axis = [1, 1, 0], table = [[0, 0], [10, 40]] },
  { kind = "translate", table = [[0, 0, 0, 0.9], [10, 0.3, 0, -0.1]] },
]
[[slave]]
name = "cloud"
points = { random = { box = [[-2.8, -2.8, -0.6], [2.8, 2.8, 0.2]], n = 6000, seed = 3 } }
[[contact]]
master = "ring"
slave = "cloud"
search = "SEARCH"
law = { kind = "force", curve = [[0, 0], [1, 5]] }
area = { kind = "constant", value = 0.01 }
[output]
report = false
"""
PROGRAM = """
import sys
import numba
import contiga as cg

for threads in (1, 2):
    numba.set_num_threads(threads)
    cg.run(cg.load_case(sys.argv[1]), out=f"{sys.argv[2]}/{threads}")
"""


def _run(case: Path, out: Path) -> None:
    """With one thread, then with two."""
    environment = os.environ | {"NUMBA_NUM_THREADS": "2"}
    command = [sys.executable, "-c", PROGRAM, str(case), str(out)]
    subprocess.run(command, env=environment, check=True, timeout=300)


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core")
@pytest.mark.parametrize("search", ["intersection", *full("penetration")])
def test_one_and_two_threads_give_the_same_bits(tmp_path: Path, search: str) -> None:
    case = tmp_path / "case.toml"
    case.write_text(CASE.replace("SEARCH", search))
    outs = [tmp_path / str(threads) for threads in (1, 2)]
    _run(case, tmp_path)
    for threads, out in zip((1, 2), outs, strict=True):
        text = (out / "summary.json").read_text()
        assert f'"threads": {threads}' in text
    a, b = (read_history(out / "history.csv") for out in outs)
    assert a["n_contact"].max() > 300
    for name in a:
        if name != "wall_time":
            np.testing.assert_array_equal(a[name], b[name], err_msg=name)
    first, second = (read_fields(out / "fields.vtkhdf") for out in outs)
    for k in range(len(first.times)):
        for name in first.names:
            digests = {
                hashlib.sha256(f.data(k, name).tobytes()).hexdigest() for f in (first, second)
            }
            assert len(digests) == 1, (k, name)
