"""A checkpoint serves the case that it is of, and no other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga import Simulation
from contiga.dynamics.prescribed import Moved, Translate
from contiga.dynamics.stepping import AutoSteps, GivenTimes
from contiga.errors import CheckpointError
from contiga.masters.body import Body
from contiga.simulation.model import ContactPart, OutputOptions

from .makers import Make, StopAfter


def _other_weights(s: Simulation) -> Simulation:
    (patch,) = s.bodies["ball"].body.patches
    weights = np.asarray(patch.weights).copy()
    weights[1, 1] *= 1.01
    other = cg.NurbsSurface(patch.degrees, patch.knots, patch.control_points, weights)
    return replace(s, bodies={"ball": s.bodies["ball"]._replace(body=Body([other]))})


def _other_options(s: Simulation) -> Simulation:
    (part,) = s.contacts
    contact = cg.Contact(part.contact.master, part.contact.slave, law=part.contact.law,
                         search="penetration")  # fmt: skip
    return replace(s, contacts=(ContactPart("dip", "ball", "sheet", contact),))


def _other_motion(s: Simulation) -> Simulation:
    moved = Translate([[0, 0, 0, 0], [12, 0.2, 0, -0.25]])
    return replace(s, bodies={"ball": s.bodies["ball"]._replace(motion=moved)})


def _other_thickness(s: Simulation) -> Simulation:
    old = s.slaves["sheet"]
    slave = cg.Slave(old.slave.points, old.slave.facets, thickness=np.full(225, 0.6))
    return replace(s, slaves={"sheet": old._replace(slave=slave)})


def _contact(**options: object) -> Callable[[Simulation], Simulation]:
    def change(s: Simulation) -> Simulation:
        (part,) = s.contacts
        old = part.contact
        given = {"law": old.law, **options}
        contact = cg.Contact(old.master, old.slave, **given)  # type: ignore[arg-type]
        return replace(s, contacts=(part._replace(contact=contact),))

    return change


def _other_way_of_the_slave(s: Simulation) -> Simulation:
    old = s.slaves["sheet"]
    aside = Translate([[0, 0, 0, 0], [6, 0.1, 0, 0], [12, 0, 0, 0]])
    moved = Moved(old.slave.points, aside)
    return replace(s, slaves={"sheet": old._replace(motion=moved)})


def _other_facets(s: Simulation) -> Simulation:
    old = s.slaves["sheet"].slave
    assert old.facets is not None
    slave = cg.Slave(
        old.points, old.facets[:-1], area=old.area, thickness=old.thickness, active=old.active
    )
    return replace(s, slaves={"sheet": s.slaves["sheet"]._replace(slave=slave)})


TABLE = [[0, 0], [0.1, 1.0], [1.0, 3.0]]


OTHERS = {
    "law's table": _contact(law=cg.StressLaw([[0, 0], [0.1, 1.1], [1.0, 3.0]], damping=0.2)),
    "law's number": _contact(law=cg.StressLaw(TABLE, damping=0.3)),
    "law's function": _contact(law=cg.StressLaw(lambda x: 10.0 * x, damping=0.2)),
    "depth": _contact(depth=0.4),
    "through": _contact(through="hold"),
    "area": _contact(area=cg.NodalArea()),
    "area's option": _contact(area=cg.FacetArea(on="master")),
    "facets": _other_facets,
    "way of the slave": _other_way_of_the_slave,
    "what is written": lambda s: replace(s, output=OutputOptions(every=2)),
    "when it is written": lambda s: replace(s, output=OutputOptions(interval=2.0)),
    "text": lambda s: replace(s, case_text="friction = 0.3\n"),
    "times": lambda s: replace(s, stepping=GivenTimes(1.5 * s.stepping.planned())),
    "weights": _other_weights,
    "options": _other_options,
    "motion": _other_motion,
    "thickness": _other_thickness,
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_checkpoint_of_another_case_is_told(
    simulation: Simulation, stop_after: StopAfter, stop: type[Exception], tmp_path: Path, what: str
) -> None:
    with pytest.raises(stop):
        simulation.run(tmp_path, progress=stop_after(4))
    before = sorted(path.name for path in tmp_path.iterdir())
    with pytest.raises(CheckpointError, match="another case") as error:
        OTHERS[what](simulation).run(tmp_path, resume=True)
    assert error.value.exit_code == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == before
    # The right case still goes on.
    assert len(simulation.run(tmp_path, resume=True).history["time"]) == 13


def test_equal_cases_built_twice_have_one_fingerprint(make: Make) -> None:
    assert make().fingerprint() == make().fingerprint()


def test_what_chooses_steps_tells(make: Make) -> None:
    def case(**options: float) -> str:
        return make(stepping=AutoSteps(0.0, 12.0, **options)).fingerprint()

    assert case(safety=0.9) == case() != case(safety=0.8)
    assert case(shortest=0.0) == case() != case(shortest=1e-3)


def test_what_is_only_told_of_a_case_tells_it_from_no_other(make: Make) -> None:
    def case(title: str, report: str, every: int) -> str:
        text = f'title = "{title}"\n\n[output]\nevery = {every}\nreport = {report}\n'
        return make(case_text=text).fingerprint()

    assert case("one", "true", 1) == case("another", "false", 1)
    assert case("one", "true", 1) != case("one", "true", 2)


def test_what_is_drawn_beside_a_run_tells_it_from_no_other(make: Make) -> None:
    """A test curve may be added to a run that has ended."""

    def case(top: str, tables: str, every: int = 1) -> str:
        text = f'title = "a"\n{top}\n[[sensor]]\nname = "s"\n{tables}\n[output]\nevery = {every}\n'
        return make(case_text=text).fingerprint()

    plot = '\n[[plot]]\nx = "time"\ny = "force"\n'
    test = '\n[[reference]]\nchannel = "force"\npoints = [\n  [0.0, 1.0],\n  [2.0, 3.0],\n]\n'
    bare = case("plot = []\nreference = []\n", "")
    assert bare == case("", "") == case("", plot + test) == case("plot = []\n", test + test)
    assert bare != case("", plot + test, 2)


def test_functions_are_told_apart_by_what_they_do(make: Make) -> None:
    def law(factor: float) -> cg.StressLaw:
        return cg.StressLaw(lambda x: np.where(x > 0.7, factor, 1.0) * x, thickness=0.5)

    def fingerprint(law: cg.StressLaw) -> str:
        return _contact(law=law)(make()).fingerprint()

    # They differ beyond every argument they are tried at: the closure tells.
    assert fingerprint(law(2.0)) == fingerprint(law(2.0))
    assert fingerprint(law(2.0)) != fingerprint(law(3.0))


def test_a_law_that_cannot_be_known_again_is_told(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    law = cg.StressLaw(TABLE)
    object.__setattr__(law, "guard", threading.Lock())
    simulation = _contact(law=law)(make())
    with pytest.raises(stop):
        simulation.run(tmp_path, progress=stop_after(4))
    with pytest.warns(cg.errors.ContigaWarning, match=r"lock is compiled: whether it is what it"):
        simulation.run(tmp_path, resume=True)


def test_a_folder_that_was_moved_is_the_same_case(make: Make, tmp_path: Path) -> None:
    def simulation(folder: Path) -> Simulation:
        text = f'geometry = {{ file = "{folder.as_posix()}/part.step" }}\n'
        return make(case_text=text, base_folder=folder)

    here, there = simulation(tmp_path / "here"), simulation(tmp_path / "there")
    assert here.fingerprint() == there.fingerprint()
    other = replace(here, case_text=here.case_text.replace("part.step", "other.step"))
    assert other.fingerprint() != here.fingerprint()
