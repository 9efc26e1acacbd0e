"""A sample of the damaged files: each is read, or refused with a message."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_damaged_files_are_read_or_refused_and_nothing_else(tmp_path):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
    folder = tmp_path / "fuzz"
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz", "--count", "50", "--jobs", "2", "--folder", folder],
        cwd=ROOT,
        env=env,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    counts = dict(re.findall(r"'(read|refused)': (\d+)", done.stdout.splitlines()[-1]))
    # Both are seen: neither are all files left sound, nor is everything refused.
    assert int(counts["read"]) > 7
    assert int(counts["refused"]) > 16
    assert int(counts["read"]) + int(counts["refused"]) == 50
