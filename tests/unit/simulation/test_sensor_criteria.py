"""Criteria of sensors in runs whose motion and forces are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import contiga as cg
from contiga.case.columns import columns_of_case, criteria_of_case
from contiga.case.schema import parse_case
from contiga.errors import InputError
from contiga.simulation.sensor import ALL_CRITERIA, Criterion
from contiga.simulation.sensor_criteria import OF_ACCELERATION, OF_SIGNALS, check_criteria

BALL = cg.Body([cg.shapes.sphere(radius=0.1)])
SI = ("m", "kg", "s")
MM = ("mm", "g", "ms")
SIZE = {SI: (1.0, 1.0, 1.0), MM: (1e3, 1e3, 1e3)}
"""Of a metre, a kilogram and a second."""


def run_of(units: tuple[str, str, str], sensors: list[object], **more: object) -> dict[str, dict]:
    own = {"slaves": {}, "contacts": [], "end": 0.1 * SIZE[units][2], "units": units}
    own |= {"step": 1e-4 * SIZE[units][2]} | more
    return cg.Simulation(sensors=sensors, **own).run()  # type: ignore[arg-type]


def test_each_criterion_that_a_sensor_takes_is_evaluated_on_its_own_signal() -> None:
    own = {name: one for name, one in ALL_CRITERIA.items() if one.filter is not None}
    assert set(OF_SIGNALS) == set(own)
    assert set(OF_ACCELERATION) == set(ALL_CRITERIA) - set(own)
    assert all(one.columns for one in own.values())
    assert all(ALL_CRITERIA[name].measures == ("acceleration",) for name in OF_ACCELERATION)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        (Criterion(), "'new': filter.*found None.*OF_ACCELERATION"),
        (Criterion(filter="CFC60"), "'new': filter.*found 'CFC60'.*OF_SIGNALS"),
        (Criterion(filter="FIR100"), "'new': filter.*not known.*FIR100.*'CFC60', 'CFC180'"),
    ],
)
def test_a_row_that_no_function_evaluates_is_refused(row: Criterion, words: str) -> None:
    of_other_table = {"new"}
    tables = (set(), of_other_table) if row.filter is None else (of_other_table, set())
    with pytest.raises(InputError, match=words):
        check_criteria({"new": row}, *tables)


@pytest.mark.parametrize("units", [SI, MM])
def test_bric_of_a_steady_spin_about_the_axes_of_the_head(units: tuple[str, str, str]) -> None:
    """A ball spins evenly about an axis askew to its own."""
    metre, kilogram, second = SIZE[units]
    ball = cg.Body([cg.shapes.sphere(radius=0.1 * metre)])
    turn = Rotation.from_euler("zyx", [0.7, 0.2, -0.4]).as_matrix()
    spin = turn @ [0.5 * 66.25, -56.45, 0.0] / second
    inertia = kilogram * metre**2 * np.eye(3)
    motion = cg.motion.Free(mass=kilogram, inertia=inertia, spin=spin)
    sensor = cg.Sensor(
        "cg", "head", axes="body", measures=["acceleration", "spin"], criteria=["BrIC"]
    )
    result = run_of(units, [sensor], bodies={"head": (ball, motion)})
    actual = result.summary["sensors"]["cg"]["criteria"]["BrIC"]
    # its body's axes are the world's at the start
    w = np.array([result.history[f"cg.w{axis}"][0] for axis in "xyz"]) * second
    np.testing.assert_allclose(w, spin * second, rtol=1e-9)
    assert actual["value"] == pytest.approx(cg.criteria.bric([w]).value, rel=1e-6)
    assert "unit" not in actual


@pytest.mark.parametrize("units", [SI, MM])
def test_bric_of_a_top_whose_axes_tumble(units: tuple[str, str, str]) -> None:
    """Euler: about its own z even, about x and y a turn of (I_3 − I_1) / I_1 · ω_z.

    In the world's axes, with which it agrees at the start, the greatest spins are others.
    """
    metre, kilogram, second = SIZE[units]
    across, along, rate = 12.0, 35.0, 0.6 * 35.0  # rad/s
    inertia = kilogram * metre**2 * np.diag([1.0, 1.0, 1.6])
    spin = np.array([across, 0.0, along]) / second
    ball = cg.Body([cg.shapes.sphere(radius=0.1 * metre)])
    motion = cg.motion.Free(mass=kilogram, inertia=inertia, spin=spin)
    sensor = cg.Sensor("cg", "head", axes="body", measures=["spin"], criteria=["BrIC"])
    result = run_of(
        units, [sensor], bodies={"head": (ball, motion)}, end=0.3 * second, step=5e-4 * second
    )
    h = result.history
    angle = rate * h["time"] / second
    truth = np.array([across * np.cos(angle), across * np.sin(angle), along + 0.0 * angle])
    w = np.array([h[f"cg.w{axis}"] for axis in "xyz"]) * second
    np.testing.assert_allclose(w, truth, atol=1e-3 * along)
    actual = result.summary["sensors"]["cg"]["criteria"]["BrIC"]["value"]
    greatest = np.array([across, across, along]) / (66.25, 56.45, 42.87)
    assert actual == pytest.approx(np.linalg.norm(greatest), rel=3e-3)


def pulled(units: tuple[str, str, str], rate: float, sensors: list[object]) -> cg.Result:
    """Two points that a table drives, joined by a spring of 1 kN/m off their line.

    The second goes away from the first along z at `rate` metres a second, from 0.5 m above it.
    """
    metre, kilogram, second = SIZE[units]
    ball = cg.Body([cg.shapes.sphere(radius=0.1 * metre)])
    head = cg.Body([cg.shapes.sphere(radius=0.1 * metre, centre=(0, 0, 0.5 * metre))])
    away = cg.motion.Translate([[0, 0, 0, 0], [0.1 * second, 0, 0, 0.1 * rate * metre]])
    free = cg.motion.Free(mass=kilogram, inertia=kilogram * metre**2 * np.eye(3),
                          hold=["x", "y", "z", "rx", "ry", "rz"])  # fmt: skip
    x = 0.02 * metre
    spring = cg.Spring(
        ["head", "torso"],
        at=[[x, 0, 0.4 * metre], [x, 0, 0.1 * metre]],
        curve=1e3 * kilogram / second**2,
    )
    bodies = {"torso": (ball, free), "head": (head, away)}
    return run_of(units, sensors, bodies=bodies, springs=[spring])


def between(name: str, units: tuple[str, str, str], **more: object) -> cg.RelativeSensor:
    metre = SIZE[units][0]
    own = {"at": [[0, 0, 0.1 * metre], [0, 0, 0.4 * metre]]} | more
    return cg.RelativeSensor(name, ["torso", "head"], **own)  # type: ignore[arg-type]


@pytest.mark.parametrize("units", [SI, MM])
@pytest.mark.parametrize("rate", [30.0, -30.0])
def test_nij_and_femur_force_of_a_spring_that_is_stretched(
    units: tuple[str, str, str], rate: float
) -> None:
    metre, kilogram, second = SIZE[units]
    neck = between("neck", units, measures=["force", "moment"], criteria=["Nij"], dummy="HIII-5")
    femur = between("femur", units, measures=["force"], criteria=["femur"])
    result = pulled(units, 0.05 * rate, [neck, femur])
    newton = kilogram * metre / second**2
    end = 1e3 * 0.1 * 0.05 * rate  # N
    h = result.history
    assert h["neck.fz"][-1] / newton == pytest.approx(end, rel=1e-9)
    assert h["neck.my"][-1] / (newton * metre) == pytest.approx(-0.02 * end, rel=1e-9)
    assert h["neck.f"][-1] / newton == pytest.approx(abs(end), rel=1e-9)
    told = result.summary["sensors"]
    # both grow evenly, and a filter without a phase follows
    found, limits = told["neck"]["criteria"]["Nij"], cg.criteria.HYBRID_III_5
    axial = abs(end) / (limits.tension if rate > 0 else limits.compression)
    bent = 0.02 * abs(end) / (limits.extension if rate > 0 else limits.flexion)
    assert found["value"] == pytest.approx(axial + bent, rel=1e-3)
    assert found["mode"] == ("NTE" if rate > 0 else "NCF")
    assert found["end"] == pytest.approx(0.1 * second, rel=0.01)
    share = told["femur"]["criteria"]["femur"]
    assert share["peak"] == pytest.approx(max(0.0, -end), abs=0.2)
    times = np.linspace(0.0, 0.1, 1001)
    truth = cg.criteria.femur_force(end / 0.1 * times, times)
    assert share["value"] == pytest.approx(truth.ratio, rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("units", [SI, MM])
def test_vc_of_a_chest_that_is_pressed_evenly(units: tuple[str, str, str]) -> None:
    """From 0.3 m at 2 m/s: V C grows to 1.3 · 2 · 0.2 / 0.229 m/s; what is drawn apart has none."""
    chest = between("chest", units, measures=["distance"], criteria=["VC"])
    side = between("side", units, measures=["distance"], criteria=["VC"], dummy="EuroSID")
    told = pulled(units, -2.0, [chest, side]).summary["sensors"]
    actual = told["chest"]["criteria"]["VC"]
    assert actual["unit"] == "m/s"
    assert actual["value"] == pytest.approx(1.3 * 2.0 * 0.2 / 0.229, rel=0.01)
    assert told["side"]["criteria"]["VC"]["value"] == pytest.approx(2.0 * 0.2 / 0.14, rel=0.01)


@pytest.mark.parametrize("steps", [1, 2, 3, 4])
def test_a_run_of_few_steps_ends_with_what_it_can_tell(steps: int) -> None:
    chest = between("chest", SI, measures=["distance"], criteria=["VC"])
    neck = between("neck", SI, measures=["force", "moment"], criteria=["Nij", "femur"])
    free = cg.motion.Free(mass=1.0, inertia=np.eye(3))
    spring = cg.Spring(["torso", "head"], at=[[0, 0, 0.1], [0, 0, 0.4]], curve=1.0)
    away = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, 2]])
    middle = cg.Sensor("cg", "head", axes="body", measures=["spin"], criteria=["BrIC"])
    told = run_of(
        SI, [chest, neck, middle], bodies={"torso": (BALL, free), "head": (BALL, away)},
        springs=[spring], end=1e-4 * steps,
    ).summary["sensors"]  # fmt: skip
    assert ("VC" in told["chest"]["criteria"]) == (steps >= 4)
    assert set(told["neck"]["criteria"]) == {"Nij", "femur"}
    assert set(told["cg"]["criteria"]) == {"BrIC"}


def test_the_3ms_value_of_a_chest_counts_all_stretches() -> None:
    """Two pushes of 2 ms at 50 and 40 g: held for 3 ms together at 40, and alone at nothing."""
    g = 9.80665
    table = [[0, 0], [0.01, 0], [0.01001, 50 * g], [0.012, 50 * g], [0.01201, 0], [0.02, 0],
             [0.02001, 40 * g], [0.022, 40 * g], [0.02201, 0], [1, 0]]  # fmt: skip
    push = [[t, f, 0.0, 0.0] for t, f in table]
    free = cg.motion.Free(mass=1.0, inertia=np.eye(3))
    sensor = cg.Sensor("chest", "torso", criteria=["3ms", "chest3ms"])
    result = run_of(
        SI, [sensor], bodies={"torso": (BALL, free)}, loads=[cg.Load("torso", force=push)],
        end=0.03, step=1e-5,
    )  # fmt: skip
    actual = result.summary["sensors"]["chest"]["criteria"]
    assert actual["chest3ms"]["value"] == pytest.approx(40.0, rel=1e-3)
    assert actual["chest3ms"]["unit"] == "g"
    assert actual["3ms"]["value"] < 1.0


def test_steps_are_short_enough_for_the_filters_of_criteria() -> None:
    neck = between("neck", SI, measures=["force", "moment"], criteria=["Nij"])
    metre = {"units": SI, "end": 0.5}
    spring = cg.Spring(["torso", "head"], at=[[0, 0, 0.1], [0, 0, 0.4]], curve=1.0)
    free = cg.motion.Free(mass=1.0, inertia=np.eye(3))
    bodies = {"torso": (BALL, free), "head": (BALL, free)}
    own = {"bodies": bodies, "springs": [spring], "slaves": {}, "contacts": [], **metre}
    result = cg.Simulation(sensors=[neck], step="auto", **own).run()
    assert np.diff(result.history["time"]).max() <= 1.0 / 6000.0 * (1.0 + 1e-6)
    result = cg.Simulation(sensors=[neck], step=0.01, **own).run()
    assert "Nij" not in result.summary["sensors"]["neck"]["criteria"]
    assert any("too long for CFC600" in text for text in result.summary["warnings"])


@pytest.mark.parametrize(
    ("kind", "options", "words"),
    [
        ("point", {"criteria": ["BrIC"], "axes": "body"}, 'about the spin.*Add "spin"'),
        ("point", {"criteria": ["BrIC"], "measures": ["spin"]}, "axes of a body.*world"),
        ("point", {"criteria": ["Nij"]}, "criteria.*not known.*Nij.*HIC15.*BrIC"),
        ("pair", {"criteria": ["BrIC"]}, "criteria.*not known.*BrIC.*VC.*Nij.*femur"),
        ("pair", {"criteria": ["VC"], "measures": ["angle"]}, 'about the distance.*Add "distance"'),
        ("pair", {"criteria": ["Nij"], "measures": ["force"]}, 'Add "moment"'),
        ("pair", {"criteria": ["femur"], "measures": ["force"]}, "two points apart"),
        ("pair", {"criteria": ["VC"], "dummy": "HIII-95"}, "dummy.*HIII-95.*EuroSID"),
        (
            "pair",
            {"criteria": ["Nij"], "measures": ["force", "moment"], "dummy": "EuroSID"},
            "has no neck",
        ),
    ],
)
def test_criteria_without_what_they_are_about_are_refused(
    kind: str, options: dict[str, object], words: str
) -> None:
    make = {"point": cg.Sensor, "pair": cg.RelativeSensor}[kind]
    with pytest.raises(InputError, match=words):
        make("s", "a" if kind == "point" else ["a", "b"], **options)  # type: ignore[arg-type]


def test_a_cut_without_springs_is_refused() -> None:
    sensor = cg.RelativeSensor("s", ["a", "b"], measures=["force"])
    free = cg.motion.Free(mass=1.0, inertia=np.eye(3))
    bodies = {"a": (BALL, free), "b": (BALL, free)}
    with pytest.raises(InputError, match=r"sensors\[0\]: measures: .*none is between the two"):
        run_of(SI, [sensor], bodies=bodies)


CASE = """
units = { length = "m", mass = "kg", time = "s" }
time = { end = 0.02, step = 1e-4 }
[[body]]
name = "torso"
geometry = { shape = "sphere", radius = 0.1 }
mass = { total = 30.0 }
motion = { kind = "free" }
[[body]]
name = "head"
geometry = { shape = "sphere", radius = 0.1, centre = [0, 0, 0.5] }
mass = { total = 4.5 }
motion = { kind = "free", velocity = [0, 0, 2.0], spin = [0, 20.0, 0] }
[[slave]]
name = "floor"
points = { coordinates = [[0, 0, -1], [1, 0, -1]] }
area = 1.0
[[contact]]
master = "torso"
slave = "floor"
law = { kind = "penalty", stiffness = 1.0 }
[[spring]]
name = "neck spring"
between = ["torso", "head"]
at = [[0, 0, 0.1], [0, 0, 0.4]]
curve = 1e5
[[sensor]]
name = "head_cg"
body = "head"
axes = "body"
measures = ["acceleration", "spin"]
filter = "CFC1000"
criteria = ["HIC15", "BrIC"]
bands = { BrIC = { limits = [0.71, 1.05], names = ["good", "fair", "poor"] } }
[[sensor]]
name = "neck"
between = ["torso", "head"]
at = [[0, 0, 0.1], [0, 0, 0.4]]
measures = ["force", "moment", "distance"]
criteria = ["Nij", "VC"]
dummy = "HIII-5"
"""


def test_a_case_file_asks_for_them() -> None:
    case = parse_case(CASE)
    assert criteria_of_case(case) == ["head_cg.HIC15", "head_cg.BrIC", "neck.VC", "neck.Nij"]
    result = cg.build(case).run()
    told = [name for name in columns_of_case(case) if name.startswith(("head_cg", "neck."))]
    assert len(told) == 11 + 9
    assert set(told) <= set(result.history)
    told = result.summary["sensors"]
    assert told["head_cg"]["criteria"]["BrIC"]["band"] == "good"
    assert told["head_cg"]["criteria"]["BrIC"]["value"] == pytest.approx(20.0 / 56.45, rel=0.05)
    assert set(told["neck"]["criteria"]) == {"Nij", "VC"}
