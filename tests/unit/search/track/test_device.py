"""Tracking on a GPU, as its simulator does it: the feet are those of the CPU."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numba import config, typeof
from numba.core import types
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.arrays import device as num_device
from contiga.errors import InputError
from contiga.records import Projection, SurfacePlaces, empty_projection
from contiga.search.tables import tables_of
from contiga.search.track import device
from contiga.search.track.kernels import row_nb
from contiga.search.track.project import track
from contiga.search.track.track_records import FlaggedFeet, PointMotion, RowStarts
from contiga.statuses import Status

PROGRAM = Path(__file__).with_name("simulated.py")
KNOTS = [0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0]
SEEDS, POINTS, STEPS, STEP = 4, 80, 3, 4e-3
LOST = 7
"""The row that has no foot to start from; the next one runs off to nowhere."""

Case = tuple[cg.Body, Projection, np.ndarray, list[np.ndarray]]


def random_patch(rng: np.random.Generator) -> cg.NurbsSurface:
    """A rational bicubic patch of nine elements, of about the size of one."""
    grid = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, 6)], indexing="ij"), axis=-1)
    net = np.concatenate([grid, rng.uniform(-0.1, 0.1, (6, 6, 1))], axis=2)
    net[..., :2] += rng.uniform(-0.03, 0.03, (6, 6, 2))
    return cg.NurbsSurface((3, 3), (KNOTS, KNOTS), net, weights=rng.uniform(0.5, 2.0, (6, 6)))


def case(seed: int) -> Case:
    """A body, feet on it, where their points are, and where these go on to in steps."""
    rng = np.random.default_rng(seed)
    body = cg.Body([random_patch(rng)]) if seed else holed_plate()
    patch = body.patches[0]
    uv = rng.uniform(0.05, 0.95, (POINTS, 2))
    before = patch.evaluate(uv) + rng.uniform(-0.02, 0.02, (POINTS, 1)) * patch.normal(uv)
    points = before + np.cumsum(STEP * rng.standard_normal((STEPS, POINTS, 3)), axis=0)
    feet = body.project(before)
    if seed == 1:
        feet.patch[LOST] = -1
        points[-1, LOST + 1] = np.nan
    return body, feet, before, list(points)


def by_the_cpu(given: Case) -> list[Projection]:
    body, feet, before, steps = given
    found = []
    for points in steps:
        out = empty_projection(len(points))
        track(tables_of(body), points, SurfacePlaces(feet.patch, feet.uv), out, before)
        found.append(out)
        feet, before = out, points
    return found


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Projection, Any, Projection]]:
    """Of every case and step the feet of the simulator, the rows that the CPU did, and the feet of
    the CPU, compiled."""
    if config.DISABLE_JIT:
        pytest.skip("the simulator is compared with compiled kernels")
    folder = tmp_path_factory.mktemp("simulated")
    cases = [case(seed) for seed in range(SEEDS)]
    given = [(tables_of(body), feet, before, steps) for body, feet, before, steps in cases]
    (folder / "case.pickle").write_bytes(pickle.dumps(given))
    run = subprocess.run(
        [sys.executable, str(PROGRAM), "case.pickle", "feet.pickle"],
        env=dict(os.environ) | {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        cwd=folder,
    )
    assert run.returncode == 0, run.stderr
    answered = pickle.loads((folder / "feet.pickle").read_bytes())
    wanted = [feet for given in cases for feet in by_the_cpu(given)]
    return [(*own, cpu) for own, cpu in zip(answered, wanted, strict=True)]


def test_feet_of_the_simulator_are_those_of_the_cpu(found) -> None:
    assert len(found) == SEEDS * STEPS
    for feet, _, cpu in found:
        for name in ("patch", "feature", "status", "certified"):
            np.testing.assert_array_equal(getattr(feet, name), getattr(cpu, name), err_msg=name)
        for name in ("uv", "point", "normal", "gap"):
            own, other = getattr(feet, name), getattr(cpu, name)
            np.testing.assert_allclose(own, other, rtol=0, atol=1e-12, err_msg=name)


def test_what_the_device_does_has_the_bits_of_the_cpu(found) -> None:
    """The text is the same, and nothing in the simulator fuses or reorders it."""
    for feet, rows, cpu in found:
        for own, other in zip(feet, cpu, strict=True):
            np.testing.assert_array_equal(np.delete(own, rows, 0), np.delete(other, rows, 0))


def test_most_rows_are_done_on_the_device_and_the_others_come_back(found) -> None:
    shares = [len(rows) / POINTS for _, rows, _ in found]
    assert max(shares[STEPS:]) < 0.1
    assert 0.0 < max(shares[:STEPS]) < 0.4  # by the hole
    first, _, last = found[STEPS : 2 * STEPS]
    assert LOST in first[1]
    assert LOST not in last[1]  # it has a foot by then
    assert LOST + 1 in last[1]
    assert last[0].status[LOST + 1] == Status.NOT_FINITE


def test_points_have_to_be_those_of_the_feet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device, "check_device", lambda: None)
    body = cg.Body([cg.shapes.plane()])
    with pytest.raises(InputError, match="one row a foot"):
        device.start(tables_of(body), body.project(np.zeros((3, 3))), np.zeros((4, 3)))


def test_nothing_starts_where_nothing_can_be_launched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(config, "ENABLE_CUDASIM", 0)
    monkeypatch.setattr(num_device, "cuda", None)
    body = cg.Body([cg.shapes.plane()])
    with pytest.raises(ImportError, match="numba-cuda"):
        device.start(tables_of(body), body.project(np.zeros((3, 3))), np.zeros((3, 3)))


@pytest.mark.parametrize("name", ["track_row", "pack_flags", "gather_row", "scatter_row"])
def test_rows_compile_for_a_gpu(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Where numba-cuda is installed, with libNVVM; a GPU is not needed for that."""
    pytest.importorskip("numba_cuda")
    from numba import cuda
    from numba.cuda import dispatcher
    from numba.cuda.cudadrv import nvvm

    if config.DISABLE_JIT or not nvvm.is_available():
        pytest.skip("nothing is compiled for a GPU")
    capability = (7, 5)
    there = SimpleNamespace(compute_capability=capability)
    monkeypatch.setattr(dispatcher, "get_current_device", lambda: there)
    monkeypatch.setattr(cuda, "to_device", lambda array: array)  # the types are those of the host
    body, feet, points, _ = case(0)
    rows, flags = np.zeros(3, np.int32), np.zeros(POINTS, np.uint8)
    starts = RowStarts(feet.patch, feet.uv, points, points)
    records = {
        "track_row": (
            device.flat(tables_of(body)),
            PointMotion(points, points),
            FlaggedFeet(feet, flags),
        ),
        "pack_flags": (flags, flags),
        "gather_row": (starts, rows, starts),
        "scatter_row": (feet, rows, feet),
    }[name]
    handed = num_device.resident(records)
    arguments = types.void(types.int64, typeof(handed))
    thread = num_device._threads_of(getattr(row_nb, name)).py_func
    code, _ = cuda.compile_ptx(thread, arguments, cc=capability)
    assert ".visible .entry" in code
