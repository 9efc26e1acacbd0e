"""Fields files of programs that end: what was appended stays, a full disk is told of."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from contiga.io.out.vtkhdf import FieldsWriter, read_fields


def test_a_program_that_dies_leaves_the_steps_it_appended(tmp_path):
    path = tmp_path / "f.vtkhdf"
    program = (
        "import os, numpy as np\n"
        "from contiga.io.out.vtkhdf import FieldsWriter, Part\n"
        f"writer = FieldsWriter({str(path)!r}, [Part('a', 'slave', 4, None)])\n"
        "for i in range(5):\n"
        "    writer.append(float(i), np.full((4, 3), float(i)), {'x': np.full(4, float(i))})\n"
        "os._exit(9)\n"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 9
    series = read_fields(path)
    assert series.times.tolist() == [0, 1, 2, 3, 4]
    assert (series.points(4) == 4.0).all()
    assert FieldsWriter.reopen(path, 5).n_steps == 5


def test_a_program_that_dies_in_a_step_leaves_those_before(tmp_path):
    path = tmp_path / "f.vtkhdf"
    program = (
        "import os, numpy as np\n"
        "from contiga.io.out import vtkhdf, vtkhdf_layout\n"
        "own = vtkhdf_layout.Growing.put\n"
        "def put(self, start, values):\n"
        "    if writer.n_steps == 3 and self is writer._steps['Steps/Values']:\n"
        "        os._exit(9)\n"
        "    own(self, start, values)\n"
        "vtkhdf_layout.Growing.put = put\n"
        f"writer = vtkhdf.FieldsWriter({str(path)!r}, [vtkhdf.Part('a', 'slave', 4, None)])\n"
        "for i in range(5):\n"
        "    writer.append(float(i), np.full((4, 3), float(i)), {'x': np.full(4, float(i))})\n"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 9
    series = read_fields(path)
    assert series.times.tolist() == [0, 1, 2]
    assert (series.points(2) == 2.0).all()
    with FieldsWriter.reopen(path, 3) as writer:
        writer.append(3.0, np.full((4, 3), 3.0), {"x": np.full(4, 3.0)})
    assert read_fields(path).data(3, "x").tolist() == [3.0] * 4


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process are POSIX's")
def test_a_disk_that_is_full_is_told_of_and_the_process_lives(tmp_path):
    """HDF5 lost a file that it could not write to the end, and its process with it."""
    path = tmp_path / "f.vtkhdf"
    program = (
        "import gc, resource, signal, numpy as np\n"
        "from contiga.errors import OutputError\n"
        "from contiga.io.out.vtkhdf import FieldsWriter, Part, read_fields\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]\n"
        "for limit in (3_000, 60_000, 300_000, 1_100_000, 1_200_000, 1_500_000):\n"
        f"    path, done = {str(path)!r} + str(limit), 0\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))\n"
        "    try:\n"
        "        with FieldsWriter(path, [Part('a', 'slave', 5000, None)]) as writer:\n"
        "            for done in range(9):\n"
        "                writer.append(done, np.random.default_rng(done).random((5000, 3)))\n"
        "    except OutputError as error:\n"
        "        print(error, flush=True)\n"
        "    gc.collect()\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))\n"
        "    if limit > 3_000:\n"
        "        assert len(read_fields(path).times) == done\n"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")
    told = ran.stdout.splitlines()
    assert len(told) == 6
    assert all(line.startswith(f"{path}") for line in told)
    assert all("the file is larger than may be. Make room" in line for line in told)
