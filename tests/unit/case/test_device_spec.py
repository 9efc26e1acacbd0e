"""Devices of belts, slip rings and triggers in a case: what they make, and what check refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.belts import LoadLimiter, Pretensioner, Retractor, SlipRing
from contiga.case.describe import describe
from contiga.case.toml import resolved_toml
from contiga.errors import CaseError
from contiga.report.run_folder import read_run
from contiga.report.springs import device_table, slip_ring_table

CASE = """
[units]
length = "mm"
mass = "kg"
time = "ms"

[time]
end = 10.0
step = 0.1

[[body]]
name = "sled"
geometry = { shape = "sphere", radius = 10.0 }
motion = { kind = "acceleration", direction = "x", table = [[0, -0.1], [10, -0.1]] }

[[body]]
name = "mass"
geometry = { shape = "sphere", radius = 10.0 }
mass = { total = 40.0 }
motion = { kind = "free", hold = ["y", "z", "rx", "ry", "rz"] }

[[sensor]]
name = "crash"
body = "sled"
trigger = { channel = "ax", below = -0.05, for = 1.0, delay = 2.0 }

[[sensor]]
name = "gap"
between = ["sled", "mass"]
trigger = { above = 1e3 }

[[sensor]]
name = "blind"
body = "mass"

[[spring]]
name = "lower"
between = ["ground", "sled"]
at = [[0, 0, -500], [0, 0, 0]]
curve = 0.3
retractor = { spool = 0.005, lock = { trigger = "crash", rate = 1.0 }, film = [[0, 0], [30, 8]] }
limiter = { force = [4.0, 4.0, 5.0], travel = [0, 150, 160] }
pretensioner = { trigger = "crash", pull = [[0, 0], [7, 80]] }

[[spring]]
name = "upper"
between = ["sled", "mass"]
at = [[0, 0, 0], [200, 0, 0]]
curve = [[0, 0], [10, 3], [20, 9]]
release = { trigger = "gap" }

[[slip_ring]]
between = ["lower", "upper"]
friction = 0.2
"""


def case_of(folder: Path, old: str = "", new: str = "") -> cg.Case:
    assert CASE.count(old) == 1 or not old
    file = folder / "case.toml"
    file.write_text(CASE.replace(old, new) if old else CASE)
    return cg.load_case(file)


def test_a_case_makes_the_devices_that_it_names(tmp_path: Path) -> None:
    simulation = cg.build(case_of(tmp_path))
    lower, upper = simulation.springs["lower"], simulation.springs["upper"]
    retractor, limiter, pretensioner, release = lower.devices
    assert isinstance(retractor, Retractor)
    assert (retractor.trigger, retractor.rate) == ("crash", 1.0)
    np.testing.assert_array_equal(retractor.spool, [[0.0, 0.005]])
    np.testing.assert_array_equal(retractor.film, [[0, 0], [30, 8]])
    assert isinstance(limiter, LoadLimiter)
    np.testing.assert_array_equal(limiter.force, [4, 4, 5])
    np.testing.assert_array_equal(limiter.travel, [0, 150, 160])
    assert isinstance(pretensioner, Pretensioner)
    assert (pretensioner.trigger, release, upper.devices.release) == ("crash", None, "gap")
    (ring,) = simulation.slip_rings.values()
    assert isinstance(ring, SlipRing)
    assert (ring.name, ring.between, ring.friction) == ("lower-upper", ("lower", "upper"), 0.2)
    trigger = simulation.triggered[0].trigger
    assert trigger is not None
    assert (trigger.channel, trigger.sign, trigger.level) == ("ax", -1.0, -0.05)
    assert (trigger.lasting, trigger.delay) == (1.0, 2.0)


def test_the_resolved_case_is_the_same_case_and_is_said_in_words(tmp_path: Path) -> None:
    case = case_of(tmp_path)
    copy = tmp_path / "copy.toml"
    copy.write_text(resolved_toml(case))
    assert resolved_toml(cg.load_case(copy)) == resolved_toml(case)
    said = "\n".join(f"{key}: {text}" for key, text in describe(case))
    for text in (
        "retractor that locks by crash or above a pay-out of 1; load limiter 4 to 5; "
        "pretensioner fired by crash",
        "slip ring lower-upper: between lower and upper: friction 0.2",
        "fires with ax below -0.05 for 1, 2 later",
        "released by gap",
    ):
        assert text in said


def test_the_columns_of_a_case_are_those_of_its_run(tmp_path: Path) -> None:
    from contiga.case.columns import columns_of_case

    case = case_of(tmp_path)
    history = cg.build(case).run().history
    mine = {"crash", "gap", "blind", "lower", "upper", "lower-upper"}
    told = [name for name in history if name.rpartition(".")[0] in mine]
    assert sorted(told) == sorted(
        name for name in columns_of_case(case) if name.rpartition(".")[0] in mine
    )
    # Past −0.05 from the start on, for 1, and 2 later.
    assert history["crash.fired"].argmax() == 30


def test_the_report_tells_what_devices_did(tmp_path: Path) -> None:
    result = cg.build(case_of(tmp_path)).run(tmp_path / "out")
    run = read_run(tmp_path / "out")
    np.testing.assert_array_equal(
        run.slip_rings["lower-upper"]["slipped"], result.history["lower-upper.slipped"]
    )
    devices, rings = device_table(run), slip_ring_table(run)
    assert "3.0 ms" in devices or "3 ms" in devices
    assert "never" in devices
    assert "lower – upper" in rings
    assert (
        device_table(run._replace(springs={})) == slip_ring_table(run._replace(slip_rings={})) == ""
    )


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            'trigger = "crash", rate',
            'trigger = "crush", rate',
            r"spring\[0\].retractor.lock.trigger: no sensor of this name is defined; found 'crush'",
        ),
        (
            'pretensioner = { trigger = "crash"',
            'pretensioner = { trigger = "blind"',
            r"spring\[0\].pretensioner.trigger: this sensor has no trigger; found 'blind'",
        ),
        (
            'release = { trigger = "gap"',
            'release = { trigger = "bang"',
            r"spring\[1\].release.trigger: no sensor of this name",
        ),
        (
            '["lower", "upper"]',
            '["lower", "uper"]',
            r"slip_ring\[0\].between\[1\]: no spring of this name is defined; found 'uper'",
        ),
        ("friction = 0.2", "friction = -0.2", r"slip_ring\[0\].friction: .*found -0.2"),
        ("curve = 0.3\n", "", r"spring\[0\].curve: .*needs a curve or a damping"),
        ("curve = 0.3\n", "damping = 0.3\n", r"curve: is missing: a device needs webbing"),
        (
            "travel = [0, 150, 160]",
            "travel = [0, 160, 150]",
            r"spring\[0\].limiter.force: the values of travel go back or repeat",
        ),
        (
            "[4.0, 4.0, 5.0]",
            "[4.0, 5.0, 4.0]",
            r"spring\[0\].limiter.force: the force falls at row 2",
        ),
        (
            "[[0, 0], [30, 8]]",
            "[[0, 0], [30, 8], [40, 8]]",
            r"spring\[0\].retractor.film: what a film lets out",
        ),
        ('lock = { trigger = "crash", rate = 1.0 }', "lock = {}", r"retractor.lock: a retractor"),
        ("below = -0.05, for", "below = -0.05, above = 1.0, for", "has one threshold"),
        ("for = 1.0", "fro = 1.0", r"sensor\[0\].trigger.fro: unknown key; .*delay"),
        ('channel = "ax"', 'channel = "qx"', "the sensor has no such column; found 'qx'"),
        (
            'between = ["sled", "mass"]\nat = [[0, 0, 0]',
            'between = ["sled", "mass"]\nat = [[0, 0, 9]',
            "slip_ring 'lower-upper': between: its segments do not meet",
        ),
    ],
)
def test_what_is_wrong_is_told_by_its_key(tmp_path: Path, old: str, new: str, told: str) -> None:
    from contiga.errors import InputError

    with pytest.raises(InputError, match=told):
        cg.build(case_of(tmp_path, old, new))


def test_an_inflator_names_the_sensor_that_fires_it(tmp_path: Path) -> None:
    from contiga.case.gas_spec import GasSpec

    spec = GasSpec(
        slave="bag", inflator=[{"mass_rate": 1.0, "temperature": 300.0, "trigger": "crash"}]
    )
    assert spec.chamber(("m", "kg", "s"), list).inflators[0].trigger == "crash"
    with pytest.raises(CaseError, match=r"gas\[0\].inflator\[0\].trigger: no sensor of this name"):
        case_of(
            tmp_path,
            "[[slip_ring]]",
            '[[gas]]\nslave = "sled"\n'
            'inflator = [{ mass_rate = 1.0, temperature = 300.0, trigger = "bang" }]\n\n'
            "[[slip_ring]]",
        )
