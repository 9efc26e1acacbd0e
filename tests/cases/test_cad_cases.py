"""Real CAD pressed into clouds and meshes; truth is OpenCASCADE and what physics asks."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from contiga.records import ContactStatus as Is
from contiga.statuses import Feature

pytestmark = pytest.mark.usefixtures("kept")


@pytest.fixture(scope="session")
def occ() -> ModuleType:
    path = Path(__file__).with_name("occ.py")
    spec = importlib.util.spec_from_file_location("contiga_test_occ", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _case(body: str, slave: str, formats: tuple[str, ...] = ("csv",), steps: int = 20) -> str:
    return f"""
title = "CAD pressed into a cloud"
[units]
length = "mm"
mass = "g"
time = "ms"
[time]
end = {steps}.0
step = 1.0
[[body]]
name = "part"
{body}
[[slave]]
name = "pad"
{slave}
[[contact]]
master = "part"
slave = "pad"
area = {{ kind = "constant", value = 4.0 }}
law = {{ kind = "penalty", stiffness = 1.0 }}
[output]
every = 10
formats = {list(formats)}
report = false
"""


def _there_and_back(direction: list[float], depth: float, steps: int = 20) -> str:
    half = steps / 2
    way = (depth * np.array(direction)).tolist()
    return (
        f'{{ kind = "translate", table = [[0, 0, 0, 0], [{half}, {way[0]}, {way[1]}, {way[2]}], '
        f"[{steps}, 0, 0, 0]] }}"
    )


def _sample(run, k: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Some points in contact at step k: their rows, and where they are for the body."""
    state = run.states[k]
    rows = np.flatnonzero(state.in_contact)
    rows = np.random.default_rng(0).choice(rows, min(count, len(rows)), replace=False)
    return rows, state.points_B[rows]


def _agrees_with_occ(run, occ: ModuleType, path: Path, k: int, count: int) -> None:
    """Penetration against OpenCASCADE's distance to the same face: exact inside it, at edges to
    their tolerance."""
    rows, points = _sample(run, k, count)
    state = run.states[k]
    faces = occ.faces_of(occ.read_shape(path))
    assert len(faces) == len(run.body.patches)
    own = zip(points, state.patch[rows], strict=True)
    distance = np.array([occ.distance(point, faces[patch]) for point, patch in own])
    on_face = state.feature[rows] == Feature.FACE
    miss = np.abs(state.penetration[rows] - distance)
    assert (miss[on_face] <= 1e-9 * run.body.size).all()
    tolerance = max((edge.tolerance for edge in run.body.edges), default=0.0)
    assert (miss[~on_face] <= 2.0 * tolerance + 1e-9 * run.body.size).all()


def test_headform_face_pressed_into_a_pad(
    run_case: Callable, physics: Callable, data_dir: Path, occ: ModuleType
) -> None:
    """A hundred and twenty-three free-form faces, nose first, into the nodes of a pad mesh."""
    path = data_dir / "headface_MED_full.step"
    run = run_case(
        _case(
            f'geometry = {{ file = "{path}" }}\nmotion = {_there_and_back([0, 0, 1.0], 16.0)}',
            'points = { grid = { shape = "plane", width = 130, length = 120, nu = 53, nv = 49 }, '
            "transform = [{ translate = [0, -40, 118.2] }] }",
            ("csv", "vtkhdf"),
        )
    )
    physics(run)
    counts = run.history["n_contact"]
    assert counts[10] > 100
    assert counts[-1] == run.history["force"][-1] == 0
    # The face presses towards +z and the pad pushes back.
    assert (run.history["force_z"][1:20] > 0).all()
    # On the way back every point is where it was on the way in.
    for k in range(1, 10):
        there, back = run.states[k], run.states[20 - k]
        both = there.in_contact & back.in_contact
        same = np.abs(there.penetration - back.penetration)[both] < 1e-9
        assert both.sum() >= there.n_contact - 1
        assert same.mean() > 0.95
    for k in (2, 10):
        _agrees_with_occ(run, occ, path, k, 12)


def test_ship_bow_in_metres_pressed_into_a_cloud_in_millimetres(
    run_case: Callable, physics: Callable, data_dir: Path, occ: ModuleType
) -> None:
    path = data_dir / "dtmb5415_bulbous_bow.iges"
    run = run_case(
        _case(
            f'geometry = {{ file = "{path}" }}\nmotion = {_there_and_back([0, 1.0, 0], 60.0)}',
            'points = { sample = { shape = "plane", width = 1000, length = 700, nu = 60, nv = 45, '
            'axis = "y" }, transform = [{ translate = [-2500, 315, 20] }] }',
        )
    )
    physics(run, slides_off=True)
    assert run.body.unit == "mm"
    assert run.history["n_contact"][10] > 30
    assert run.history["n_contact"][-1] == 0
    _agrees_with_occ(run, occ, path, 10, 25)


@pytest.fixture(scope="module")
def casting(data_dir: Path) -> Path:
    return data_dir / "nist_ctc_02_asme1_ap242.stp"


@pytest.mark.full
def test_casting_pressed_into_a_cloud(
    run_case: Callable, physics: Callable, casting: Path, occ: ModuleType
) -> None:
    """A machined solid of 487 faces: in contact is what lies inside, at every step."""
    run = run_case(
        _case(
            f'geometry = {{ file = "{casting}" }}\nmotion = {_there_and_back([0, 0, 1.0], 8.0)}',
            "points = { random = { box = [[-345, -45, 40.5], [345, 825, 48]], n = 6000, "
            "seed = 1 } }",
        )
    )
    physics(run)
    assert run.body.surface.closed
    assert run.history["n_contact"][10] > 100
    assert run.history["n_contact"][-1] == 0
    shape = occ.read_shape(casting)
    rng = np.random.default_rng(2)
    for k in (4, 10, 15):
        state = run.states[k]
        on = np.flatnonzero(state.in_contact)
        off = np.flatnonzero(~state.in_contact)
        near = off[run.body.project(state.points_B[off]).gap < 2.0]
        rows = np.concatenate([rng.permutation(on)[:20], rng.permutation(near)[:20]])
        expected = occ.inside(shape, state.points_B[rows])
        np.testing.assert_array_equal(state.in_contact[rows], expected)
    _agrees_with_occ(run, occ, casting, 10, 12)


@pytest.mark.full
def test_casting_meets_a_cloud_all_around_it(
    run_case: Callable, physics: Callable, casting: Path
) -> None:
    """The casting shakes inside a cloud that fills its pockets: intersection and inside agree."""
    table = "[[0, 0, 0, 0], [5, 3, 2, -2], [10, -2, -3, 3], [15, 2, 3, 1], [20, 0, 0, 0]]"
    text = _case(
        f'geometry = {{ file = "{casting}" }}\nmotion = {{ kind = "translate", table = {table} }}',
        "points = { random = { box = [[-345, -45, -365], [345, 825, 45]], n = 4000, seed = 3 } }",
    )
    run = run_case(text)
    physics(run, corners=True)
    inner_at_start = run.body.contains(run.states[0].points_B)
    for state in run.states[1:]:
        inside = run.body.contains(state.points_B)
        fresh = ~inner_at_start
        assert not (state.status == Is.SLID_OFF).any()
        # Those that began inside are left out; the others are in contact where they are inside.
        np.testing.assert_array_equal(state.in_contact[fresh], inside[fresh])
    assert run.history["n_contact"].max() > 100


@pytest.mark.full
def test_points_go_right_through_the_casting(
    run_case: Callable, physics: Callable, casting: Path
) -> None:
    """Shaken by more than its walls are thick: points that come out at the far side are free."""
    table = "[[0, 0, 0, 0], [5, 30, 20, -20], [10, -20, -30, 30], [15, 20, 30, 10], [20, 0, 0, 0]]"
    text = _case(
        f'geometry = {{ file = "{casting}" }}\nmotion = {{ kind = "translate", table = {table} }}',
        "points = { random = { box = [[-345, -45, -365], [345, 825, 45]], n = 2000, seed = 3 } }",
    )
    run = run_case(text)
    physics(run, corners=True)
    through = 0
    for last, state in zip(run.states[:-1], run.states[1:], strict=True):
        on = np.flatnonzero(state.in_contact)
        assert (run.body.project(state.points_B[on]).gap <= 0.0).all()
        left = np.flatnonzero(state.status == Is.RELEASED)
        gap = ((state.points_B[left] - last.points_B[left]) * last.normal[left]).sum(axis=1)
        through += int((last.penetration[left] - gap > 1.0).sum())
    assert through > 50, "points that were still deep below the face they came in by"


def test_bearing_of_loose_faces_pressed_from_above_keeps_its_points(
    run_case: Callable, physics: Callable, data_dir: Path, occ: ModuleType
) -> None:
    """213 IGES faces given one by one: points pass from face to face, none slides off between."""
    path = data_dir / "occt_bearing.iges"
    text = _case(
        f'geometry = {{ file = "{path}" }}\nmotion = {_there_and_back([0, 0, 1.0], 0.004)}',
        "points = { random = { box = [[-0.045, -0.065, 0.0315], [0.05, 0.05, 0.033]], n = 3000, "
        "seed = 4 } }",
    )
    run = run_case(text)
    physics(run)
    assert run.history["n_contact"][10] > 100
    assert run.history["n_contact"][-1] == 0
    _agrees_with_occ(run, occ, path, 10, 12)
