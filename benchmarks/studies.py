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


def base_of(spec: StudySpec, folder: Path) -> Base:
    """What the cases have in common."""
    assert spec.base is not None
    text = Path(spec.base).read_text(encoding="utf-8")
    folder.mkdir()
    return Base(text, spec.base, str(folder), spec.quantities)


def alone(spec: StudySpec, case: StudyCase, folder: Path) -> float:
    """Return the seconds of a case run by its own command."""
    settings = [f"--set={key}={json.dumps(value)}" for key, value in case.settings.items()]
    run = [sys.executable, "-m", "contiga", "run", str(spec.base), "--quiet", *settings]
    started = time.perf_counter()
    subprocess.run([*run, "-o", str(folder / case.name)], check=True)
    return time.perf_counter() - started


def in_turn(spec: StudySpec, folder: Path) -> tuple[list[Row], float, float, float]:
    """Return the rows of all cases, seconds to start workers, seconds a case on them, and alone.

    Every fifth case is also run alone.
    """
    base, rows, cases = base_of(spec, folder / "study"), list[Row](), cases_of(spec)
    together, single = 0.0, list[float]()
    started = time.perf_counter()
    with local_client(WORKERS) as client:
        engine = OnDask(client, base, spec.retries)
        start = time.perf_counter() - started
        for first in range(0, len(cases), BLOCK):
            block = cases[first : first + BLOCK]
            started = time.perf_counter()
            rows += engine.run(block)
            together += time.perf_counter() - started
            single += [alone(spec, case, folder / "alone") for case in block[::5]]
    return rows, start, together / len(cases), float(np.mean(single))


def killed(spec: StudySpec, folder: Path) -> list[Row]:
    """Return the rows while workers are killed one after the other, at even intervals."""
    base, rows, kills = base_of(spec, folder), list[Row](), 0
    cases = cases_of(spec)
    with local_client(WORKERS) as client:
        for row in OnDask(client, base, spec.retries).run(cases):
            rows.append(row)
            if kills < KILLS and len(rows) * KILLS >= len(cases) * (kills + 0.5):
                pids = list(client.run(os.getpid).values())
                os.kill(pids[kills % len(pids)], signal.SIGKILL)
                kills += 1
    assert kills == KILLS
    return rows


def seconds_of_run(folder: Path) -> float:
    """Return the seconds of a run from its summary."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return float(summary["timings"]["total"])


def table(spec: StudySpec, rows: list[Row]) -> Table:
    """Return the table of the rows."""
    return table_of(rows, spec.labels, list(spec.quantities))


def page_of_many(folder: Path) -> tuple[int, int]:
    """Return the bytes of a page of `ROWS` rows, and those without the script of the figures."""
    from plotly.offline import get_plotlyjs

    spec, rng = study(2), np.random.default_rng(1)
    base = base_of(spec, folder)
    rows = [
        Row(k + 1, DONE, "", {"speed": s}, dict.fromkeys(spec.quantities, s * 100.0), 1.0)
        for k, s in enumerate(rng.uniform(-8.0, -4.0, ROWS).tolist())
    ]
    page = page_of(spec, page_data(spec, base, table(spec, rows), rows), rows, b"")
    (folder / "study.html").write_text(page, encoding="utf-8")
    return len(page.encode()), len(page.encode()) - len(get_plotlyjs().encode())


def main(count: int) -> None:
    """Print all measurements."""
    spec = study(count)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run_one(base_of(spec, folder / "warm"), cases_of(spec)[0])  # kernels compiled or loaded
        print(f"load of the machine {os.getloadavg()[0]:.1f}", flush=True)
        rows, start, together, single = in_turn(spec, folder)
        share = (together + start / count) / single
        print(f"workers started in {start:.1f} s")
        print(f"a case by contiga run {single:.2f} s, of {WORKERS} workers {together:.2f} s")
        print(f"share {share:.2f}; load now {os.getloadavg()[0]:.1f}", flush=True)
        homes = [folder / "study" / "cases" / f"{row.number:04d}" for row in rows]
        busy = float(np.mean([seconds_of_run(home) for home in homes]))
        print(
            f"a run by itself {busy:.2f} s; overhead {WORKERS * together - busy:.3f} s", flush=True
        )
        same = table(spec, killed(spec, folder / "killed")) == table(spec, rows)
        print(f"{KILLS} workers killed: the table is {'the same' if same else 'ANOTHER'}")
        page_bytes, data_bytes = page_of_many(folder / "page")
        print(
            f"page of {ROWS} rows: {page_bytes / 1e6:.1f} MB, "
            f"{data_bytes / 1e6:.2f} MB without plotly.js"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
