"""Studies on processes: the rows of one after the other, whoever is killed; the examples, small."""

from __future__ import annotations

import json
import math
import os
import runpy
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from socketserver import BaseRequestHandler, TCPServer
from threading import Thread
from typing import Any

import numpy as np
import pytest
from tests.sample import FULL

import contiga as cg
from contiga.errors import InputError
from contiga.studies import on_dask
from contiga.studies.cases import StudyCase
from contiga.studies.engines import InTurn, engine_for
from contiga.studies.on_dask import OnDask, local_client
from contiga.studies.one_case import Base, run_one
from contiga.studies.quantities import quantity_of
from contiga.studies.row import DONE, LOST, Row
from contiga.studies.spec import StudySpec, study_of
from contiga.studies.study import run_study
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
COUNT, KILLS = (8, (1, 3, 6)) if FULL else (4, (1, 2))
"""Cases, and how many are done when a worker is killed."""
COLLECT = ("max(force)", "end(ball.vz)", "max(max_penetration)", "energy_error")
KEY = "body.ball.motion.velocity[2]"


def base_in(folder: Path) -> Base:
    """Of cases in a folder."""
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    (folder / "out").mkdir(exist_ok=True)
    values = {text: quantity_of(text) for text in COLLECT}
    return Base(CASE, str(folder / "case.toml"), str(folder / "out"), values)


def cases(count: int) -> list[StudyCase]:
    """The ball at so many speeds."""
    speeds = np.linspace(-2.0, -0.5, count).tolist()
    return [StudyCase(k, {"speed": v}, {KEY: v}) for k, v in enumerate(speeds, start=1)]


def told(rows: list[Row]) -> dict[str, list[object]]:
    """The table, which the seconds are no part of."""
    return table_of(rows, ["speed"], COLLECT).columns


@pytest.fixture(scope="module")
def in_turn(tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    """Cases one after the other."""
    return list(InTurn(base_in(tmp_path_factory.mktemp("in_turn"))).run(cases(COUNT)))


def test_workers_that_are_killed_change_nothing(in_turn: list[Row], tmp_path: Path) -> None:
    killed: list[int] = []
    rows: list[Row] = []
    with local_client(2) as client:
        for row in OnDask(client, base_in(tmp_path), retries=3).run(cases(COUNT)):
            rows.append(row)
            if len(rows) in KILLS:  # and who is at it, with what it has at hand
                pid = next(iter(client.run(os.getpid).values()))
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
    assert len(set(killed)) == len(KILLS)
    assert all(row.status == DONE for row in rows)
    assert told(rows) == told(in_turn)


@pytest.mark.full
def test_a_case_that_kills_its_workers_is_a_row_and_the_rest_go_on(
    in_turn: list[Row], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def deadly(base: Base, case: StudyCase, *_: object) -> Row:
        if case.number == 2:
            os._exit(1)
        return run_one(base, case)

    monkeypatch.setattr(on_dask, "run_one", deadly)
    with local_client(1) as client:
        rows = list(OnDask(client, base_in(tmp_path), retries=1).run(cases(COUNT)[:4]))
    by = {row.number: row for row in rows}
    assert (by[2].status, by[2].message) == (LOST, "its worker was lost 2 times")
    others = [row for row in in_turn if row.number in (1, 3, 4)]
    assert told([by[k] for k in (1, 3, 4)]) == told(others)


@pytest.mark.full
def test_workers_are_asked_when_they_first_work_and_may_be_lost_meanwhile(
    in_turn: list[Row], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that comes later and has another version gets no case, one that dies costs its own."""
    other = tmp_path / "other"
    rows: list[Row] = []
    base = base_in(tmp_path)

    def sees(folder: str) -> tuple[bool, str]:
        if os.environ.get("CONTIGA_TEST_DIES"):
            os._exit(1)
        version = os.environ.get("CONTIGA_TEST_VERSION", cg.__version__)
        return Path(folder).is_dir(), version

    monkeypatch.setattr(on_dask, "_sees", sees)

    def ran(*args: Any, **more: Any) -> Row:
        if os.environ.get("CONTIGA_TEST_VERSION"):
            other.touch()
        return run_one(*args, **more)

    monkeypatch.setattr(on_dask, "run_one", ran)

    def work() -> None:
        with local_client(1) as client:
            for row in OnDask(client, base, retries=3).run(cases(COUNT)):
                rows.append(row)
                if len(rows) == 2:
                    joined(client)

    def joined(client: Any) -> None:
        cluster = client.cluster
        first = cluster.worker_spec[0]
        for name in ("CONTIGA_TEST_VERSION", "CONTIGA_TEST_DIES"):
            env = {**first["options"]["env"], name: "0.0.9"}
            cluster.worker_spec[name] = {**first, "options": {**first["options"], "env": env}}
        cluster.sync(cluster._correct_state)
        client.wait_for_workers(3, timeout=60)

    with pytest.warns(cg.errors.ContigaWarning) as told_of:
        work()
    assert told(rows) == told(in_turn)
    assert not other.exists()
    said = [str(one.message) for one in told_of]
    assert any("another version of contiga" in text and "gets no case" in text for text in said)


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
                while not file.is_file():
                    time.sleep(0.1)
                yield json.loads(file.read_text(encoding="utf-8"))["address"]
            finally:
                two.terminate()
                one.terminate()


@pytest.mark.full
def test_a_scheduler_that_runs_already_is_used_by_its_address(
    in_turn: list[Row], tmp_path: Path, scheduler: str
) -> None:
    base = base_in(tmp_path)
    with engine_for(base, scheduler=scheduler, workers=None, retries=1) as engine:
        rows = list(engine.run(cases(COUNT)[:3]))
    assert told(rows) == told(in_turn[:3])


@contextmanager
def somebody_else() -> Iterator[str]:
    """The address of a server that is none of Dask's."""

    class Answer(BaseRequestHandler):
        def handle(self) -> None:
            self.request.sendall(b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n" * 9)

    with TCPServer(("127.0.0.1", 0), Answer) as server:
        thread = Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"tcp://127.0.0.1:{server.server_address[1]}"
        server.shutdown()
        thread.join()


def test_an_address_nobody_answers_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_dask, "_ANSWER_SECONDS", 1)
    # A client without a scheduler prints a traceback when it goes: none is made.
    monkeypatch.setattr(on_dask, "Client", lambda *_, **__: pytest.fail("a client is made"))
    base = base_in(tmp_path)
    for address in ("tcp://127.0.0.1:9", "nonsense://x", "nonsense"):
        with (
            pytest.raises(InputError, match="no scheduler answers") as caught,
            engine_for(base, scheduler=address, workers=None, retries=1),
        ):
            pass
        assert address in str(caught.value)
    with (
        somebody_else() as address,
        pytest.raises(InputError, match="no scheduler answers"),
        engine_for(base, scheduler=address, workers=None, retries=1),
    ):
        pass
    with (
        pytest.raises(InputError, match="has its own workers"),
        engine_for(base, scheduler="tcp://127.0.0.1:9", workers=2, retries=1),
    ):
        pass


def small(
    name: str, folder: Path, over: dict[str, Any], **more: Any
) -> tuple[StudySpec, dict[str, Any]]:
    """An example study with less of everything, and what it sets for all cases."""
    for file in (ROOT / "examples").glob("*.toml"):
        shutil.copy(file, folder)
    data = tomllib.loads((folder / name).read_text(encoding="utf-8"))
    quick = {"output.report": False, "output.formats": ["csv"], **over}
    return study_of({**data, "set": quick, **more}, folder / name), quick


@pytest.mark.full
def test_heads_hit_the_bonnet_where_rays_say(tmp_path: Path) -> None:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt

    make = runpy.run_path(str(ROOT / "examples" / "make_bonnet.py"))
    step = tmp_path / "generated" / "bonnet.step"
    make["main"](step, 500.0)
    part = make["bonnet"]()
    body = cg.read_cad(step)
    for spacing, holes in ((500.0, 0), (60.0, 1)):
        found = make["targets"](body, spacing)
        nx, ny = round(720.0 / spacing) + 1, round(1120.0 / spacing) + 1
        assert (len(found) < nx * ny) == bool(holes)
        for point in found[:: max(1, len(found) // 12)]:
            vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point.tolist())).Vertex()
            assert BRepExtrema_DistShapeShape(part, vertex).Value() < 1e-6
    corner, size = np.split(np.array(make["SLOT"]), 2)
    off = np.abs(found[:, :2] - corner - 0.5 * size)
    assert not (off < 0.5 * size).all(axis=1).any()

    coarse = {"slave.skin.points.tolerance": 8.0, "time.end": 5.0, "output.every": 99}
    study, quick = small("bonnet_study.toml", tmp_path, coarse)
    done = run_study(study, tmp_path / "out", workers=0)
    assert len(done.rows) == 6
    assert not done.failed
    assert (tmp_path / "out" / "map.png").is_file()
    assert '"type":"mesh3d"' in done.page.read_text(encoding="utf-8")
    values = done.rows[1].values
    at = {
        "translate[0]": values["x"] - 97 * math.cos(math.radians(65)),
        "translate[1]": values["y"],
        "translate[2]": values["z"] + 97 * math.sin(math.radians(65)),
    }
    keys = {f"body.head.geometry.transform[0].{key}": value for key, value in at.items()}
    alone = cg.run(cg.load_case(tmp_path / "bonnet.toml", set={**quick, **keys}))
    hic = alone.summary["sensors"]["head_cg"]["criteria"]["HIC15"]["value"]
    assert done.rows[1].collected["head_cg.HIC15"] == hic > 1.0


@pytest.mark.full
def test_a_pad_is_found_within_its_limit(tmp_path: Path) -> None:
    coarse = {f"slave.pad.points.grid.{n}": 9 for n in ("nu", "nv")}
    goal = {"minimise": "head_cg.HIC15", "subject_to": ["max(max_penetration) <= 45"]}
    study, quick = small(
        "pad_study.toml",
        tmp_path,
        {**coarse, "time.end": 14.0, "time.step": 0.14, "sensor[0].filter": "CFC60"},
        goal={**goal, "trials": 8, "batch": 4},
    )
    done = run_study(study, tmp_path / "out", workers=0)
    assert done.best is not None
    columns = done.table.columns
    within = [depth <= 45.0 for depth in columns["max(max_penetration)"]]
    hics = [h for h, inside in zip(columns["head_cg.HIC15"], within, strict=True) if inside]
    assert 0 < len(hics) < 8
    assert done.best.collected["head_cg.HIC15"] == min(hics)
    values = done.best.values
    law = "contact[0].law.elastic"
    alone = cg.load_case(
        tmp_path / "pad.toml",
        set={
            **quick,
            "slave.pad.thickness": values["thickness"],
            f"{law}[1][1]": values["plateau"],
            f"{law}[2][1]": values["plateau"] * values["rise"],
            f"{law}[3][1]": values["plateau"] * values["rise"] + 1.2,
        },
    )
    history = cg.run(alone).history
    assert history["max_penetration"].max() == done.best.collected["max(max_penetration)"]
