"""What is made once of a slave and a master is not made again while they do not change."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.spatial

import contiga as cg
from contiga.area import hull, regions
from contiga.area.kernels import touch_nb

X = np.linspace(-1.0, 1.0, 31)
POINTS = np.array([[x, y, 0.0] for x in X for y in X + 0.003])
INDEX = np.arange(len(POINTS)).reshape(31, 31)
FACETS = np.concatenate(
    [
        np.stack([INDEX[:-1, :-1], INDEX[1:, :-1], INDEX[1:, 1:]], -1).reshape(-1, 3),
        np.stack([INDEX[:-1, :-1], INDEX[1:, 1:], INDEX[:-1, 1:]], -1).reshape(-1, 3),
    ]
)


@pytest.fixture
def made(monkeypatch):
    """Names of the structures made, with the number of points or facets they are made of."""
    calls = []

    def watch(module, name, size):
        own = getattr(module, name)

        def counted(*args, **options):
            calls.append((name, size(*args)))
            return own(*args, **options)

        monkeypatch.setattr(module, name, counted)

    watch(scipy.spatial, "cKDTree", len)
    watch(scipy.spatial, "Delaunay", len)
    watch(touch_nb, "incidence", lambda facets, n: n)
    watch(hull, "grid_mesh", lambda *args: len(POINTS))
    watch(hull, "closing", lambda *args: len(POINTS))
    return calls


def stepped(area, facets):
    """Four steps of a sheet that sinks into a ball and slides over it."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=[0.0, 0.0, 0.8])])
    contact = cg.Contact(
        ball, cg.Slave(POINTS, facets), law=cg.PenaltyLaw(1.0), area=area, search="penetration"
    )
    state = contact.start(POINTS)
    assert state.total_area >= 0.0
    yield state
    for k in range(1, 5):
        state = contact.step(state, POINTS + np.array([0.02 * k, 0.0, 0.01 * k]), dt=1.0)
        assert state.total_area >= 0.0
        contact.outlines(state)
        yield state


METHODS = {
    "facets on the slave": (cg.FacetArea("slave"), FACETS, {"incidence": 1}),
    "facets on the master": (cg.FacetArea("master"), FACETS, {"incidence": 1}),
    "cloud at rest": (cg.CloudArea(), None, {"cKDTree": 2, "Delaunay": 1, "incidence": 1}),
    "cloud by feet": (cg.CloudArea(by="feet"), None, {"cKDTree": 1}),
    "hulls of a cloud": (
        cg.HullArea("auto", mapping="linear"),
        None,
        {"cKDTree": 1, "grid_mesh": 1},
    ),
    "hulls of facets": (cg.HullArea("auto", mapping="exact"), FACETS, {"incidence": 1}),
}


@pytest.mark.parametrize("what", METHODS)
def test_structures_of_the_whole_slave_are_made_once_a_contact(what, made):
    area, facets, once = METHODS[what]
    counts = []
    for state in stepped(area, facets):
        assert 0 < state.n_contact < 0.5 * len(POINTS)
        whole = [name for name, size in made if size >= len(POINTS) and name != "closing"]
        counts.append({name: whole.count(name) for name in set(whole)})
    assert counts == [once] * 5
    # A ball is one patch: how it closes is asked once, if at all.
    assert [name for name, _ in made].count("closing") <= 1


def test_clouds_by_feet_lay_out_only_what_touches_at_each_step(made):
    states = list(stepped(cg.CloudArea(by="feet"), None))
    sizes = [size for name, size in made if name == "Delaunay"]
    assert len(sizes) >= len(states)
    # The points in contact, and one ring of neighbours around them.
    assert max(sizes) < 2.0 * max(state.n_contact for state in states)


def test_two_contacts_in_turn_keep_what_each_was_given(made):
    coarse = cg.Slave(POINTS[::2])
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=[0.0, 0.0, 0.8])])
    contacts = [
        cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0), area=cg.CloudArea(), search="penetration")
        for slave in (cg.Slave(POINTS), coarse)
    ]
    made.clear()
    areas = [c.start(c.slave.points).total_area for _ in range(3) for c in contacts]
    assert not [name for name, size in made if size >= len(coarse)]
    assert areas[0::2] == [areas[0]] * 3
    assert areas[1::2] == [areas[1]] * 3
    assert areas[1] == pytest.approx(areas[0], rel=0.02)


def test_regions_take_the_structure_they_are_given(made):
    graph = regions.neighbours_of(POINTS)
    mesh = regions.topology_of(FACETS, len(POINTS))
    before = len(made)
    rows = np.flatnonzero(np.abs(POINTS[:, 0]) > 0.5).astype(np.int32)
    for structure in (graph, mesh, graph, mesh):
        assert regions.regions(structure, rows, POINTS).max() == 1
    assert len(made) == before
