"""What a study costs: ``python -m benchmarks.studies [CASES]``, ten minutes for 100.

Cases by `contiga run`, one process after the other; the same as a study on two workers, while none
and while ten of them are killed; what goes by outside of the runs; the page of 10,000 rows.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from contiga.studies.cases import cases_of
from contiga.studies.on_dask import OnDask, local_client
from contiga.studies.one_case import Base, run_one
from contiga.studies.page import page_data, page_of
from contiga.studies.row import DONE, Row
from contiga.studies.spec import StudySpec, study_of
from contiga.studies.table import Table, table_of

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
WORKERS, KILLS, ROWS = 2, 10, 10_000
SET = {
    "time.end": 8.0,
    "slave.pad.points.grid.nu": 15,
    "slave.pad.points.grid.nv": 15,
    "output.report": False,
    "output.formats": ["csv"],
}
SPEED = "body.head.motion.velocity[2]"


def study(count: int) -> StudySpec:
    """Heads at so many speeds on a coarse pad."""
    data = {
        "base": "06_head_on_pad.toml",
        "collect": ["head_cg.HIC15", "max(force)", "max(max_penetration)", "energy_error"],
        "set": SET,
        "variable": [{"name": "speed", "key": SPEED, "low": -8.0, "high": -4.0, "count": count}],
    }
    return study_of(data, EXAMPLES / "study.toml")


def base_of(found: StudySpec, folder: Path) -> Base:
    """What the cases have in common."""
    assert found.base is not None
    text = Path(found.base).read_text(encoding="utf-8")
    folder.mkdir()
    return Base(text, found.base, str(folder), found.quantities)


def one_after_the_other(found: StudySpec, folder: Path) -> None:
    """Each by a command of its own."""
    for case in cases_of(found):
        settings = [f"--set={k}={str(v).lower()}" for k, v in case.settings.items()]
        settings = [one.replace("'", '"') for one in settings]
        run = [sys.executable, "-m", "contiga", "run", str(found.base), "--quiet", *settings]
        subprocess.run([*run, "-o", str(folder / case.name)], check=True)


def on_workers(found: StudySpec, folder: Path, kills: int = 0) -> tuple[list[Row], float]:
    """The rows, and the seconds from start to end of the cluster."""
    base, rows, killed = base_of(found, folder), list[Row](), 0
    cases = cases_of(found)
    begun = time.perf_counter()
    with local_client(WORKERS) as client:
        for row in OnDask(client, base, found.retries).run(cases):
            rows.append(row)
            if killed < kills and len(rows) * kills >= len(cases) * (killed + 0.5):
                pids = list(client.run(os.getpid).values())
                os.kill(pids[killed % len(pids)], signal.SIGKILL)
                killed += 1
    assert killed == kills
    return rows, time.perf_counter() - begun


def seconds_of_run(folder: Path) -> float:
    """That a run took by itself."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return float(summary["timings"]["total"])


def table(found: StudySpec, rows: list[Row]) -> Table:
    """Of the rows."""
    return table_of(rows, found.labels, list(found.quantities))


def timed(work: Callable[[], object]) -> float:
    """Seconds."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def page_of_many(folder: Path) -> tuple[int, int]:
    """Bytes of a page of so many rows, and of what is in it beside the script of the figures."""
    from plotly.offline import get_plotlyjs

    found, rng = study(2), np.random.default_rng(1)
    base = base_of(found, folder)
    rows = [
        Row(k + 1, DONE, "", {"speed": s}, dict.fromkeys(found.quantities, s * 100.0), 1.0)
        for k, s in enumerate(rng.uniform(-8.0, -4.0, ROWS).tolist())
    ]
    page = page_of(found, page_data(found, base, table(found, rows), rows), rows, b"")
    (folder / "study.html").write_text(page, encoding="utf-8")
    return len(page.encode()), len(page.encode()) - len(get_plotlyjs().encode())


def main(count: int) -> None:
    """Print all of it."""
    found = study(count)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run_one(base_of(found, folder / "warm"), cases_of(found)[0])  # kernels compiled or loaded
        print(f"load of the machine {os.getloadavg()[0]:.1f}")
        rows, study_seconds = on_workers(found, folder / "study")
        alone = timed(lambda: one_after_the_other(found, folder / "alone"))
        print(
            f"{count} cases by contiga run: {alone:.1f} s, {WORKERS} workers {study_seconds:.1f} s"
        )
        print(f"share {study_seconds / alone:.2f}; load now {os.getloadavg()[0]:.1f}")
        busy = sum(seconds_of_run(folder / "study" / "cases" / f"{r.number:04d}") for r in rows)
        print(f"a run {busy / count:.2f} s, of what its summary says")
        print(f"overhead {(WORKERS * study_seconds - busy) / count:.3f} s a case, start included")
        again, seconds = on_workers(found, folder / "killed", KILLS)
        same = table(found, again) == table(found, rows)
        print(
            f"{KILLS} workers killed: {seconds:.1f} s, the table {'the same' if same else 'OTHER'}"
        )
        whole, own = page_of_many(folder / "page")
        print(f"page of {ROWS} rows: {whole / 1e6:.1f} MB, {own / 1e6:.2f} MB without plotly.js")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
