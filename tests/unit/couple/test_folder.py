"""The output folder of a coupled run."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.couple import MujocoCoupling
from contiga.errors import MissingPackageError, OutputError

mujoco = pytest.importorskip("mujoco")

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
PAD = cg.Slave([[0, 0, -1.05], [1, 0, -1.05], [0, 1, -1.05]], [[0, 1, 2]])
XML = """<mujoco><option gravity="0 0 0" timestep="0.01"/><worldbody><body name="ball"><freejoint/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""


def coupling() -> MujocoCoupling:
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    data.qvel[2] = -1.0
    return MujocoCoupling(
        model,
        data,
        masters={"ball": BALL, "anvil": (BALL, "world")},
        slaves={"pad": (PAD, "world")},
        contacts=[cg.Contact(BALL, PAD, law=cg.PenaltyLaw(400.0))],
        sensors=[cg.Sensor("top", "ball", at=(0.0, 0.0, 1.0))],
        units=("m", "kg", "s"),
        every=5,
    )


def test_a_folder_is_read_as_that_of_a_simulation(tmp_path: Path) -> None:
    result = coupling().run(0.24, out=tmp_path / "out", title="Ball on a pad")
    stored = cg.open_result(tmp_path / "out")
    assert stored.finished
    assert stored.summary["title"] == "Ball on a pad"
    for name, column in result.history.items():
        np.testing.assert_array_equal(stored.history[name], column)
    np.testing.assert_array_equal(stored.sensors["top"]["vz"], result.of("top")["vz"])
    assert stored.summary["columns"]["top.az"] == "m/s²"
    fields = stored.fields
    assert fields is not None
    np.testing.assert_allclose(fields.times, [0.0, 0.05, 0.1, 0.15, 0.2, 0.24], atol=1e-12)
    at = result.history["ball.z"][10]
    centre = fields.points(2)[fields.rows("ball")].mean(axis=0)
    rest = fields.points(2)[fields.rows("anvil")].mean(axis=0)
    assert centre[2] - rest[2] == pytest.approx(at, abs=1e-12)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Ball on a pad" in page
    assert "top" in page


def test_a_run_that_fails_leaves_nothing(tmp_path: Path) -> None:
    def fail(running: MujocoCoupling) -> None:
        if running.data.time > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        coupling().run(0.2, out=tmp_path / "out", on_step=fail)
    assert not list((tmp_path / "out").iterdir())
    again = coupling().run(0.05, out=tmp_path / "out")
    assert len(again.history["time"]) == 6


def test_what_is_looked_at_in_between_is_not_written(tmp_path: Path) -> None:
    def look(running: MujocoCoupling) -> None:
        running.result()

    coupling().run(0.1, out=tmp_path / "out", on_step=look)
    fields = cg.open_result(tmp_path / "out").fields
    assert fields is not None
    np.testing.assert_allclose(fields.times, [0.0, 0.05, 0.1], atol=1e-12)


def test_packages_of_the_report_are_asked_for_at_the_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "plotly", None)
    steps: list[float] = []
    with pytest.raises(MissingPackageError, match="plotly"):
        coupling().run(0.02, out=tmp_path / "out", on_step=lambda c: steps.append(c.data.time))
    assert len(steps) <= 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("what", ["Fields", "names.clear_last_run"])
def test_a_folder_whose_files_cannot_be_opened_is_let_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    def fail(*_: object) -> None:
        raise OutputError("cannot be written")

    with monkeypatch.context() as patched:
        patched.setattr(f"contiga.couple.folder.{what}", fail)
        with pytest.raises(OutputError, match="cannot be written") as error:
            coupling().run(0.02, out=tmp_path / "out")
    assert not (tmp_path / "out" / "run.lock").exists()
    assert error.value  # its frames are there yet, with what they hold
    coupling().run(0.02, out=tmp_path / "out")


def test_what_a_killed_run_left_half_written_goes(tmp_path: Path) -> None:
    """Not what somebody may be writing of a report."""
    coupling().run(0.02, out=tmp_path / "out")
    left = [
        tmp_path / "out" / f".{name}" for name in ("summary.0123abcd.json", "report.0123abcd.html")
    ]
    for path in left:
        path.touch()
    coupling().run(0.02, out=tmp_path / "out")
    assert [path.exists() for path in left] == [False, True]


def test_a_folder_of_somebody_else_stays(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(OutputError):
        coupling().run(0.05, out=tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]
