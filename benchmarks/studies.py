"""What a study costs: ``python -m benchmarks.studies [CASES]``, ten minutes for 100.

Some cases by `contiga run`, one process after the other, and more of them on two workers, in turn,
so that both meet the same load of the machine; what goes by outside of the runs; the table while
ten workers are killed; the page of 10,000 rows.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from contiga.studies.cases import StudyCase, cases_of
from contiga.studies.on_dask import OnDask, local_client
from contiga.studies.one_case import Base, run_one
from contiga.studies.page import page_data, page_of
from contiga.studies.row import DONE, Row
from contiga.studies.spec import StudySpec, study_of
from contiga.studies.table import Table, table_of

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
WORKERS, KILLS, ROWS, BLOCK = 2, 10, 10_000, 20
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
        "base": "pad.toml",
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


def alone(found: StudySpec, case: StudyCase, folder: Path) -> float:
    """Seconds of a case by a command of its own."""
    settings = [f"--set={key}={json.dumps(value)}" for key, value in case.settings.items()]
    run = [sys.executable, "-m", "contiga", "run", str(found.base), "--quiet", *settings]
    begun = time.perf_counter()
    subprocess.run([*run, "-o", str(folder / case.name)], check=True)
    return time.perf_counter() - begun


def in_turn(found: StudySpec, folder: Path) -> tuple[list[Row], float, float, float]:
    """The rows of all cases; seconds to start the workers, and seconds a case: on the workers, and
    alone of every fifth."""
    base, rows, cases = base_of(found, folder / "study"), list[Row](), cases_of(found)
    together, single = 0.0, list[float]()
    begun = time.perf_counter()
    with local_client(WORKERS) as client:
        engine = OnDask(client, base, found.retries)
        start = time.perf_counter() - begun
        for first in range(0, len(cases), BLOCK):
            block = cases[first : first + BLOCK]
            begun = time.perf_counter()
            rows += engine.run(block)
            together += time.perf_counter() - begun
            single += [alone(found, case, folder / "alone") for case in block[::5]]
    return rows, start, together / len(cases), float(np.mean(single))


def killed(found: StudySpec, folder: Path) -> list[Row]:
    """The rows while workers are killed, one after the other and evenly."""
    base, rows, kills = base_of(found, folder), list[Row](), 0
    cases = cases_of(found)
    with local_client(WORKERS) as client:
        for row in OnDask(client, base, found.retries).run(cases):
            rows.append(row)
            if kills < KILLS and len(rows) * KILLS >= len(cases) * (kills + 0.5):
                pids = list(client.run(os.getpid).values())
                os.kill(pids[kills % len(pids)], signal.SIGKILL)
                kills += 1
    assert kills == KILLS
    return rows


def seconds_of_run(folder: Path) -> float:
    """That a run took by itself."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return float(summary["timings"]["total"])


def table(found: StudySpec, rows: list[Row]) -> Table:
    """Of the rows."""
    return table_of(rows, found.labels, list(found.quantities))


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
        print(f"load of the machine {os.getloadavg()[0]:.1f}", flush=True)
        rows, start, together, single = in_turn(found, folder)
        share = (together + start / count) / single
        print(f"workers started in {start:.1f} s")
        print(f"a case by contiga run {single:.2f} s, of {WORKERS} workers {together:.2f} s")
        print(f"share {share:.2f}; load now {os.getloadavg()[0]:.1f}", flush=True)
        homes = [folder / "study" / "cases" / f"{row.number:04d}" for row in rows]
        busy = float(np.mean([seconds_of_run(home) for home in homes]))
        print(
            f"a run by itself {busy:.2f} s; overhead {WORKERS * together - busy:.3f} s", flush=True
        )
        same = table(found, killed(found, folder / "killed")) == table(found, rows)
        print(f"{KILLS} workers killed: the table is {'the same' if same else 'ANOTHER'}")
        whole, own = page_of_many(folder / "page")
        print(f"page of {ROWS} rows: {whole / 1e6:.1f} MB, {own / 1e6:.2f} MB without plotly.js")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
