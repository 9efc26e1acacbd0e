"""Studies on processes: the rows of one after the other, whoever is killed; the examples, small."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.studies import on_dask
from contiga.studies.cases import StudyCase
from contiga.studies.engines import InTurn, engine_for
from contiga.studies.on_dask import OnDask, local_client
from contiga.studies.one_case import Base, run_one
from contiga.studies.quantities import quantity_of
from contiga.studies.row import DONE, LOST, Row
from contiga.studies.table import table_of

ROOT = Path(__file__).resolve().parents[2]
CASE = """
title = "Ball on a sheet"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 4.0, step = 0.05 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10.0, centre = [0, 0, 10.5] }
mass = { total = 1000.0 }
motion = { kind = "free", velocity = [0.3, 0.1, -1.0] }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 20, length = 20, nu = 9, nv = 9 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "stress", thickness = 20.0, elastic = [[0, 0], [0.1, 1.0]] }
friction = { kind = "coulomb", static = 0.3 }
[output]
formats = ["csv"]
report = false
"""
COLLECT = ("max(force)", "end(ball.vz)", "max(max_penetration)", "energy_error")
KEY = "body.ball.motion.velocity[2]"


def base_in(folder: Path) -> Base:
    """Of cases in a folder."""
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    (folder / "out").mkdir(exist_ok=True)
    found = {text: quantity_of(text) for text in COLLECT}
    return Base(CASE, str(folder / "case.toml"), str(folder / "out"), found)


def cases(count: int) -> list[StudyCase]:
    """The ball at so many speeds."""
    speeds = np.linspace(-2.0, -0.5, count).tolist()
    return [StudyCase(k, {"speed": v}, {KEY: v}) for k, v in enumerate(speeds, start=1)]


def told(rows: list[Row]) -> dict[str, list[object]]:
    """The table, which the seconds are no part of."""
    return table_of(rows, ["speed"], COLLECT).columns


@pytest.fixture(scope="module")
def in_turn(tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    """Eight cases one after the other."""
    return list(InTurn(base_in(tmp_path_factory.mktemp("in_turn"))).run(cases(8)))


@pytest.mark.slow
def test_workers_that_are_killed_change_nothing(in_turn: list[Row], tmp_path: Path) -> None:
    killed: list[int] = []
    rows: list[Row] = []
    with local_client(2) as client:
        for row in OnDask(client, base_in(tmp_path), retries=3).run(cases(8)):
            rows.append(row)
            if len(rows) in (1, 3, 6):  # and who is at it, with what it has at hand
                pid = next(iter(client.run(os.getpid).values()))
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
    assert len(set(killed)) == 3
    assert all(row.status == DONE for row in rows)
    assert told(rows) == told(in_turn)


@pytest.mark.slow
def test_a_case_that_kills_its_workers_is_a_row_and_the_rest_go_on(
    in_turn: list[Row], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def deadly(base: Base, case: StudyCase, *_: object) -> Row:
        if case.number == 2:
            os._exit(1)
        return run_one(base, case)

    monkeypatch.setattr(on_dask, "run_one", deadly)
    with local_client(1) as client:
        rows = list(OnDask(client, base_in(tmp_path), retries=1).run(cases(8)[:4]))
    by = {row.number: row for row in rows}
    assert (by[2].status, by[2].message) == (LOST, "its worker was lost 2 times")
    others = [row for row in in_turn if row.number in (1, 3, 4)]
    assert told([by[k] for k in (1, 3, 4)]) == told(others)


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """A scheduler with a worker, as a user starts them."""
    run = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    file = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    own = ["--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
    with subprocess.Popen([*run, *own], **quiet) as one:  # type: ignore[call-overload]
        run = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1"]
        run += ["--no-dashboard", "--scheduler-file", str(file)]
        env = os.environ | {"NUMBA_NUM_THREADS": "1"}
        with subprocess.Popen(run, env=env, **quiet) as two:  # type: ignore[call-overload]
            try:
                import json
                import time

                while not file.is_file():
                    time.sleep(0.1)
                yield json.loads(file.read_text(encoding="utf-8"))["address"]
            finally:
                two.terminate()
                one.terminate()


@pytest.mark.slow
def test_a_scheduler_that_runs_already_is_used_by_its_address(
    in_turn: list[Row], tmp_path: Path, scheduler: str
) -> None:
    base = base_in(tmp_path)
    with engine_for(base, scheduler=scheduler, workers=None, retries=1) as engine:
        rows = list(engine.run(cases(8)[:3]))
    assert told(rows) == told(in_turn[:3])


def test_an_address_nobody_answers_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_dask, "_ANSWER_SECONDS", 1)
    base = base_in(tmp_path)
    for address in ("tcp://127.0.0.1:9", "nonsense://x"):
        with (
            pytest.raises(InputError, match="no scheduler answers") as caught,
            engine_for(base, scheduler=address, workers=None, retries=1),
        ):
            pass
        assert address in str(caught.value)
    with (
        pytest.raises(InputError, match="has its own workers"),
        engine_for(base, scheduler="tcp://127.0.0.1:9", workers=2, retries=1),
    ):
        pass
