"""The benchmarks run, small; their table says what is reached, what is not, and what is unknown."""

from __future__ import annotations

import json
from pathlib import Path
from time import thread_time

import numpy as np
import pytest
from benchmarks import __main__ as benchmarks
from benchmarks import (
    machine,
    matter,
    matter_steps,
    operations,
    run_scenes,
    runs,
    shells,
    startup,
    stepping,
)
from benchmarks.rooms import ROOMS, RoomClock
from benchmarks.scene import moved, points, surface
from benchmarks.sizes import SMALL
from benchmarks.table import Row, lines_of

MISSING = Path("nowhere") / "part.step"


@pytest.fixture
def without_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """What reads CAD, or runs the demo, takes longer than a test may."""
    monkeypatch.setattr(stepping, "NIST", MISSING)
    monkeypatch.setattr(stepping, "HEADFORM", MISSING)
    monkeypatch.setattr(startup, "PART", MISSING)


def test_all_parts_run_and_are_written_down(
    without_files: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "deep" / "bench.json"
    benchmarks.main(["--small", "--all", "-o", str(out)])
    data = json.loads(out.read_text(encoding="utf-8"))
    rows = {row["work"]: row for row in data["rows"]}
    assert len(rows) == len(data["rows"]) == 23
    assert rows[stepping.PART.work]["note"] == "not measured: part.step is not there"
    assert rows[startup.SECOND.work]["passed"] is None
    measured = [row for row in rows.values() if row["value"] is not None]
    assert {stepping.SPHERE.work, stepping.FREE.work} <= {row["work"] for row in measured}
    assert all(row["value"] > 0.0 for row in measured)
    assert data["machine"]["threads"] >= 1
    assert data["limits"]["gigabytes"] > 0.0
    printed = capsys.readouterr().out
    assert all(work in printed for work in rows)


def test_a_goal_is_passed_failed_or_unknown() -> None:
    least = Row("fast", "×", 2.0, 2.5, at_least=True)
    most = Row("dear", "ns", 5.0, 6.0)
    unknown = most._replace(value=None)
    assert [row.passed for row in (least, most, unknown)] == [True, False, None]
    lines = lines_of([least, most, unknown])
    assert [line.split()[-1] for line in lines[1:]] == ["pass", "FAIL", "–"]


def test_the_table_of_matter_is_made() -> None:
    lines = matter.run(side=2)
    assert len(lines) == 8
    assert lines[0].startswith("tet4 neo-Hooke ")
    assert "scikit-fem" in lines[-1]


def test_the_table_of_shells_is_made() -> None:
    lines = shells.run(side=2)
    assert len(lines) == 3
    assert lines[0].split()[:4] == ["elastic", "36", "Gauss", "points,"]
    assert lines[2].startswith(("Kratos' Shell3pElement takes ", "beside Kratos: not measured: "))


def test_the_table_of_whole_steps_of_matter_is_made() -> None:
    lines = matter_steps.run(side=2, sheet_side=20, block_side=3, bag_side=4)
    assert len(lines) == 7
    assert lines[0].startswith("800 tri3, 8% of the nodes in contact: a whole step takes ")
    assert lines[2].startswith("27 hex8 of foam, 0% of the nodes in contact: a whole step takes ")
    assert lines[3].startswith("bag of 192 tri3, ")
    assert lines[4].startswith("tet4 neo-Hooke: ")
    assert "forces differ by " in lines[-1] or "not measured" in lines[-1]


def test_whole_runs_are_told_by_room_beside_their_kernels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_scenes, "STEPS", 12)
    out = tmp_path / "runs.json"
    lines = runs.run((100,), 4, lambda name: name.startswith("sphere"), out)
    data = json.loads(out.read_text(encoding="utf-8"))
    (run,) = data["runs"]
    assert run["name"] == "sphere, 100 nodes"
    assert run["steps"] == 12
    assert run["touching"] > 0.0
    assert list(run["rooms"]) == data["rooms"] == list(ROOMS)
    assert min(run["rooms"].values()) > 0.0
    assert 0.0 < run["kernels"] < run["whole"] == pytest.approx(sum(run["rooms"].values()))
    assert len(lines) == 2
    assert lines[1].startswith("sphere, 100 nodes ")


def test_time_in_a_room_is_not_counted_in_that_which_it_is_in() -> None:
    clock = RoomClock()

    def work(seconds: float) -> None:
        end = thread_time() + seconds
        while thread_time() < end:
            pass

    with clock("search"):
        with clock.inside("sides"):
            work(0.02)
        with clock("area"):  # a stage, and no room
            work(0.01)
    spent = clock.read()
    assert 0.02 <= spent["sides"] < 0.03
    assert 0.01 <= spent["search"] < 0.02
    assert spent["forces"] == 0.0


def test_an_unknown_part_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        benchmarks.main(["trakced"])
    assert "no part is called 'trakced'; allowed: first, second" in capsys.readouterr().err


def test_operations_are_counted_from_the_kernels() -> None:
    counts = operations.counted()
    # 16 coefficients in each of x, y, z and w are read by fused products at the least.
    assert counts["record"] > 4 * 16 * 2
    assert counts["round"] > counts["record"]  # which has no Hessian to solve for


def test_a_still_point_needs_one_round_and_a_moved_one_more() -> None:
    patch = surface()
    uv = np.random.default_rng(0).uniform(0.2, 0.8, (64, 2))
    on = patch.evaluate(uv)
    assert operations.rounds(patch, on, uv) == 1.0
    assert operations.rounds(patch, moved(on, 1), uv) >= 2.0


def test_points_of_the_scene_lie_about_the_surface() -> None:
    near = points(surface(), 100, "shuffled")
    assert near.shape == (100, 3)
    assert np.ptp(near[:, :2], axis=0).min() > 0.5


def test_the_machine_is_said() -> None:
    assert {"processor", "cores", "numba"} <= set(machine.described())
    assert set(machine.limits(SMALL)) == {"gigabytes", "apart", "fused"}
