"""Contacts inside the steps of MuJoCo: what is taken and refused, histories, its own geoms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.couple import MujocoCoupling
from contiga.errors import ContigaWarning, InputError, RunError
from contiga.io.out.history import read_history

mujoco = pytest.importorskip("mujoco")

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
POINT = cg.Slave([[0.0, 0.0, -1.05]], area=[1.0])
CONTACT = cg.Contact(BALL, POINT, law=cg.PenaltyLaw(100.0))
FREE = '<freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
INSIDE = '<geom name="{}" type="sphere" size="{}" mass="0"/>'
FLOOR = '<geom name="floor" type="plane" size="9 9 1" pos="0 0 -1"/>'


def model_of(
    ball: str = "", plate: str = "", *, option: str = "", rest: str = "", world: str = ""
) -> Any:
    """A model of two free bodies without gravity, with what is written into each."""
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 0 0" timestep="0.01" {option}/><worldbody>{world}
        <body name="ball">{FREE}{ball}</body><body name="plate">{FREE}{plate}</body>
        </worldbody>{rest}</mujoco>"""
    )


def coupled(model: Any, **given: Any) -> MujocoCoupling:
    """The ball falls on the point, which the plate carries, if nothing else is given."""
    data = given.pop("data", None) or mujoco.MjData(model)
    data.qvel[2] = -1.0
    options = {
        "masters": {"ball": BALL},
        "slaves": {"point": (POINT, "plate")},
        "contacts": [CONTACT],
        **given,
    }
    return MujocoCoupling(model, data, **options)


def test_a_version_whose_forces_are_wrong_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")
    monkeypatch.setattr(mujoco, "mj_versionString", lambda: "4.0.0")
    with pytest.raises(InputError, match=r"mujoco: .*wrong Hessian.*'4\.0\.0'.*mujoco!=4\.0\.0"):
        MujocoCoupling(model, mujoco.MjData(model), masters={}, slaves={}, contacts=[])


def test_forces_act_where_they_are_wherever_moments_are_taken_about() -> None:
    """Of a body that turns, on a point off its middle."""
    courses = []
    point = cg.Slave([[0.3, 0.0, -1.0]], area=[1.0])
    for ball in (BALL, BALL.with_reference_point([0.5, 0.2, -0.3])):
        model = model_of()
        data = mujoco.MjData(model)
        data.qvel[3:6] = [1.0, -2.0, 3.0]
        coupling = coupled(
            model,
            data=data,
            masters={"ball": ball},
            slaves={"point": (point, "plate")},
            contacts=[cg.Contact(ball, point, law=cg.PenaltyLaw(100.0))],
        )
        coupling.run(0.15)
        courses.append((*data.qvel, coupling.critical_step))
    assert np.isfinite(courses[0]).all()  # still in contact
    assert np.abs(courses[0][9:12]).max() > 0.01
    np.testing.assert_allclose(courses[1], courses[0], rtol=1e-9, atol=1e-12)


def test_bodies_exchange_their_velocities() -> None:
    coupling = coupled(model_of())
    result = coupling.run(1.0)
    assert result.history["max_penetration"].max() == pytest.approx(0.0707, rel=0.01)  # v √(μ/k)
    assert coupling.data.qvel[[2, 8]] == pytest.approx([0.0, -1.0], abs=3e-3)
    assert result.history["plate.z"][-1] < -0.3
    assert result.contacts["ball-point"].n_contact == 0
    assert result.energy.kinetic == pytest.approx(0.5, rel=3e-3)
    assert abs(result.energy.error) < 2e-3
    assert not coupling.data.qfrc_applied.any()


def test_a_slave_falls_on_a_master_that_stands_in_the_world() -> None:
    model = model_of()
    model.opt.gravity[2] = -2.0
    above = cg.Slave([[0.0, 0.0, 1.05]], area=[1.0])
    coupling = coupled(
        model,
        masters={"anvil": (BALL, "world")},
        slaves={"plate": above},
        contacts={"strike": cg.Contact(BALL, above, law=cg.PenaltyLaw(400.0))},
    )
    history = coupling.run(0.5).history
    deepest = history["max_penetration"].max()
    # What falls from rest: m g (gap + λ) = k λ²/2.
    assert 2.0 * (0.05 + deepest) == pytest.approx(200.0 * deepest**2, rel=0.02)
    assert "world.x" not in history


def test_weights_do_work_on_all_bodies() -> None:
    model = model_of()
    model.opt.gravity[2] = -2.0
    history = coupled(model).run(0.04).history
    time = history["time"]
    fallen = history["ball.z"][0] - history["ball.z"] + history["plate.z"][0] - history["plate.z"]
    np.testing.assert_allclose(history["energy.external"], 2.0 * fallen, atol=1e-12)
    np.testing.assert_allclose(history["plate.az"], -2.0, rtol=1e-12)
    np.testing.assert_allclose(history["plate.vz"], -2.0 * (time + 0.005), rtol=1e-9)


def test_weights_that_change_do_the_work_they_do() -> None:
    """84 % of the energy was missing once gravity changed, and nothing said so."""
    model = model_of()

    def tilt(coupling: MujocoCoupling) -> None:
        t = coupling.data.time
        coupling.model.opt.gravity[:] = [0.0, 3.0 * np.sin(8.0 * t), -9.81 * np.cos(8.0 * t)]

    result = coupled(model).run(0.5, on_step=tilt)
    assert result.warnings == ()
    history = result.history
    error, kinetic = np.abs(history["energy.error"]).max(), history["energy.kinetic"].max()
    assert error < 2e-3 * kinetic


def test_an_energy_balance_error_is_warned_of() -> None:
    def heavier(coupling: MujocoCoupling) -> None:
        if coupling.data.time > 0.2:
            coupling.data.qvel[2] = 3.0

    with pytest.warns(ContigaWarning, match="energy balance: .* of the largest energy of .*, most"):
        result = coupled(model_of()).run(0.4, on_step=heavier)
    assert len(result.warnings) == 1


def test_one_run_is_the_same_bits_as_one_in_parts() -> None:
    seen = []
    whole = coupled(model_of()).run(0.6, on_step=lambda one: seen.append(one.data.time))
    assert len(seen) == len(whole.history["time"]) == 61
    parts = coupled(model_of())
    first = parts.run(0.2)
    assert first.history["time"][-1] == pytest.approx(0.2)
    assert np.isfinite(first.history["energy.kinetic"]).all()
    second = parts.run(0.6)
    for name, column in whole.history.items():
        if name != "wall_time":
            assert column.tobytes() == second.history[name].tobytes(), name
            assert column[:21].tobytes() == first.history[name].tobytes(), name
    assert whole.history["n_contact"].dtype == np.int64
    assert repr(whole).startswith("MujocoResult(steps 60, end 0.6, contacts ball-point")
    assert "masters ball" in repr(parts)


def test_to_start_again_forgets_what_was() -> None:
    coupling = coupled(model_of())
    coupling.run(0.3)
    mujoco.mj_resetData(coupling.model, coupling.data)
    with pytest.raises(RunError, match="set back"):
        coupling.step()
    coupling.data.qvel[2] = -1.0
    coupling.start()
    assert coupling.result().history["time"].tolist() == [coupling.data.time]
    assert coupling.contacts["ball-point"].energy.work == 0.0


def test_areas_are_measured_every_so_many_steps() -> None:
    history = coupled(model_of(), every=4).run(0.1).history
    assert np.flatnonzero(np.isfinite(history["area"])).tolist() == [0, 4, 8]


def test_the_history_is_a_table_and_a_file(tmp_path: Path) -> None:
    result = coupled(model_of()).run(0.1)
    table = result.to_pandas()
    assert table.index.name == "time"
    assert table["ball.z"].to_numpy().tolist() == result.history["ball.z"].tolist()
    result.write(tmp_path / "history.csv")
    read = read_history(tmp_path / "history.csv")
    assert read["energy.total"].tolist() == result.history["energy.total"].tolist()


def touching(model: Any) -> int:
    """How many contacts of its own MuJoCo finds."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return int(data.ncon)


BOTH = {"ball": INSIDE.format("in ball", 1.0), "plate": INSIDE.format("in plate", 0.9)}


def test_geoms_that_only_touch_each_other_are_switched_off() -> None:
    model = model_of(**BOTH)
    assert touching(model) > 0
    coupled(model)
    assert touching(model) == 0


def test_geoms_that_touch_others_too_are_left_to_the_model() -> None:
    model = model_of(**BOTH, world=FLOOR)
    bits = model.geom_contype.copy()
    with pytest.raises(InputError, match='<exclude body1="ball" body2="plate"/>'):
        coupled(model)
    assert model.geom_contype.tolist() == bits.tolist()
    excluded = model_of(
        **BOTH, world=FLOOR, rest='<contact><exclude body1="ball" body2="plate"/></contact>'
    )
    coupled(excluded)
    assert excluded.geom_contype.tolist() == bits.tolist()
    # The floor is for one of them alone: the other's geoms can go.
    one = BOTH["plate"].replace("/>", ' contype="2" conaffinity="2"/>')
    own = model_of(BOTH["ball"].replace("/>", ' contype="3" conaffinity="3"/>'), one, world=FLOOR)
    coupled(own)
    assert dict(zip(["floor", "in ball", "in plate"], own.geom_contype, strict=True)) == {
        "floor": 1,
        "in ball": 3,
        "in plate": 0,
    }


def test_pairs_that_the_model_asks_for_are_refused() -> None:
    rest = '<contact><pair geom1="in ball" geom2="in plate"/></contact>'
    with pytest.raises(InputError, match=r"'in ball' and 'in plate'.*<pair>"):
        coupled(model_of(**BOTH, rest=rest))


def test_parent_and_child_are_left_as_they_are() -> None:
    """MuJoCo never lets them touch."""
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody>{FLOOR}<body name="ball">{FREE}{BOTH["ball"]}
        <body name="plate"><joint/>{BOTH["plate"]}<inertial pos="0 0 0" mass="1"
        diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""
    )
    coupled(model)
    assert model.geom_contype.tolist() == [1, 1, 1]


def test_a_step_that_is_too_long_is_refused() -> None:
    law = cg.PenaltyLaw(1e6)
    given = {"contacts": [cg.Contact(BALL, POINT, law=law)]}
    with pytest.raises(RunError, match=r"longer than the critical one of the contacts, 0\.00141"):
        coupled(model_of(), **given).run(1.0)
    with pytest.warns(ContigaWarning, match="energy balance"):
        coupled(model_of(), **given, allow_unstable=True).run(0.1)


def test_damping_shortens_the_critical_step() -> None:
    """Decay rate c/m and ω² of the reduced mass: 2 / (γ + √(γ² + ω²))."""
    law = cg.StressLaw(100.0, thickness=1.0, damping=4.0)
    coupling = coupled(model_of(), contacts=[cg.Contact(BALL, POINT, law=law)])
    coupling.run(0.08)
    assert coupling.contacts["ball-point"].n_contact == 1
    decay, square = 4.0 * 2.0, 100.0 * 2.0
    exact = 2.0 / (decay + np.sqrt(decay**2 + square))
    assert coupling.critical_step == pytest.approx(exact, rel=1e-6)


def test_several_contacts_carry_their_names() -> None:
    other = cg.Slave([[0.0, 0.0, -1.1]], area=[1.0])
    coupling = coupled(
        model_of(),
        slaves={"point": (POINT, "plate"), "other": (other, "world")},
        contacts=[CONTACT, cg.Contact(BALL, other, law=cg.PenaltyLaw(100.0))],
    )
    history = coupling.run(0.3).history
    assert history["ball-point.force"].max() > 0.0
    assert history["ball-other.force"].max() > 0.0
    assert set(coupling.contacts) == {"ball-point", "ball-other"}


@pytest.mark.parametrize("steps", [0, 5])
def test_bad_states_of_mujoco_end_the_run(
    steps: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where MuJoCo writes its log
    coupling = coupled(model_of())
    coupling.start()
    for _ in range(steps):
        coupling.step()
    coupling.data.qvel[0] = np.nan
    with pytest.raises(RunError, match="found its state to be bad"):
        coupling.step()


OTHER = cg.Contact(BALL, cg.Slave([[0.0, 0.0, 5.0]], area=[1.0]), law=cg.PenaltyLaw(1.0))
WRONG: Mapping[str, tuple[dict[str, Any], str]] = {
    "no such body": (
        {"masters": {"bal": BALL}},
        r"masters\['bal'\]: the MuJoCo model has no body of this name.*'world', 'ball', 'plate'",
    ),
    "slave on no body": (
        {"slaves": {"point": (POINT, "table")}},
        r"slaves\['point'\]: the MuJoCo model has no body.*found 'table'",
    ),
    "body by number": ({"slaves": {"point": (POINT, 2)}}, "no body of this name; found 2"),
    "idle slave": (
        {"slaves": {"point": (POINT, "plate"), "world": cg.Slave([[0.0, 0.0, 9.0]])}},
        "slaves: a slave has no contact; found 'world'",
    ),
    "contact of others": ({"contacts": [OTHER]}, "its slave is none of"),
    "no contact": ({"contacts": []}, "there must be contacts"),
    "contact twice": ({"contacts": [CONTACT, CONTACT]}, "Two of one pair need names"),
    "one contact": ({"contacts": CONTACT}, "contacts: must be several"),
    "list of masters": ({"masters": [BALL]}, "masters: must be given by name"),
    "slave as master": ({"masters": {"ball": POINT}}, r"masters\['ball'\].*found 'Slave'"),
    "master as slave": ({"slaves": {"plate": BALL}}, r"slaves\['plate'\].*found 'Body'"),
    "one body": ({"slaves": {"point": (POINT, "ball")}}, "on one body.*'ball' and 'ball'"),
    "every": ({"every": 0}, "every: must be a whole number"),
}


@pytest.mark.parametrize("what", WRONG)
def test_wrong_parts_are_refused(what: str) -> None:
    given, message = WRONG[what]
    with pytest.raises(InputError, match=message):
        coupled(model_of(), **given)


def test_wrong_models_are_refused() -> None:
    model = model_of()
    with pytest.raises(InputError, match="data are those of another model"):
        coupled(model, data=mujoco.MjData(model_of()))
    with pytest.raises(InputError, match="model: must be a compiled model; found 'str'"):
        MujocoCoupling("arm.xml", None, masters={}, slaves={}, contacts=[])
    with pytest.raises(InputError, match="data: must be MuJoCo's data"):
        MujocoCoupling(model, None, masters={}, slaves={}, contacts=[])
    with pytest.raises(InputError, match=r"RK4.*implicitfast"):
        coupled(model_of(option='integrator="RK4"'))
    coupling = coupled(model)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(InputError, match="RK4"):
        coupling.run(1.0)


def test_a_mocap_body_is_refused() -> None:
    world = '<body name="driven" mocap="true"/>'
    with pytest.raises(InputError, match="mocap"):
        coupled(model_of(world=world), slaves={"driven": POINT})


@pytest.mark.parametrize("end", [0.0, -1.0, np.inf, np.nan, "1", True])
def test_ends_that_are_none_are_refused(end: Any) -> None:
    with pytest.raises(InputError, match=r"^end: "):
        coupled(model_of()).run(end)


def test_nothing_is_there_before_the_start() -> None:
    coupling = coupled(model_of())
    assert coupling.contacts == {}
    with pytest.raises(InputError, match="nothing was started"):
        coupling.result()
    with pytest.raises(InputError, match="nothing was started"):
        assert coupling.critical_step
