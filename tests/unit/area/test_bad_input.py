"""What cannot be measured: refused with a message before the run, or a defined zero."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from tests.command import Command

import contiga as cg
from contiga.errors import InputError

PLATE = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
HALVES = cg.Body([cg.shapes.plane(width=2.0, length=4.0, centre=[x, 0, 0]) for x in (-1.0, 1.0)])
GRID = np.array(
    [[x, y, -0.1] for x in np.linspace(-0.5, 0.5, 5) for y in np.linspace(-0.5, 0.5, 5)]
)


@cache
def mesh() -> cg.TriMesh:
    return PLATE.tessellate(0.1)


def contact(area, points=GRID, facets=None, body=PLATE):
    return cg.Contact(
        body,
        cg.Slave(points, facets),
        law=cg.StressLaw(1.0, thickness=1.0),
        area=area,
        weights="area",
        search="penetration",
    )


IMPOSSIBLE = {
    "an unknown method": (lambda: cg.HullArea("spectral"), "clusters: unknown method"),
    "a method that is no name": (lambda: cg.HullArea(2.5), "clusters: unknown method"),
    "no method": (lambda: cg.HullArea(None), "clusters: unknown method"),
    "no clusters": (lambda: cg.HullArea(0), "clusters: clusters are counted from 1"),
    "truth for a number": (lambda: cg.HullArea(True), "clusters: clusters are counted from 1"),
    "k of nothing": (lambda: cg.HullArea("kmeans", k=0), "k: clusters are counted from 1"),
    "a radius of nothing": (lambda: cg.HullArea("dbscan", eps=0.0), "eps: the radius must be"),
    "a negative radius": (lambda: cg.HullArea("dbscan", eps=-1.0), "eps: the radius must be"),
    "a radius without end": (lambda: cg.HullArea("dbscan", eps=np.inf), "eps: the radius must"),
    "a radius that is no number": (lambda: cg.HullArea(eps="wide"), "eps: the radius must be"),
    "a radius that is not used": (lambda: cg.HullArea("auto", eps=-1.0), "eps: the radius must"),
    "P_min of nothing": (lambda: cg.HullArea(min_points=0), "min_points: points are counted"),
    "an unknown mapping": (lambda: cg.HullArea(mapping="cubic"), "mapping: unknown mapping"),
    "a tolerance of nothing": (lambda: cg.HullArea(tolerance=0.0), "tolerance: a tolerance must"),
    "a side that is none": (lambda: cg.FacetArea("both"), "on: unknown side"),
    "a side of a cloud": (lambda: cg.CloudArea("both"), "on: unknown side"),
    "positions that are none": (lambda: cg.CloudArea(by="now"), "by: unknown positions"),
    "a bridge below the spacing": (lambda: cg.CloudArea(bridge=0.5), "bridge: bridge must be"),
    "a bridge that is no number": (lambda: cg.CloudArea(bridge="far"), "bridge: bridge must be"),
    "a facet of no point": (
        lambda: contact(cg.FacetArea(), facets=[[0, 1, 2], [0, 1, 77]]),
        r"facet 1 names a point that is not there; found \[0, 1, 77\]; allowed: 0 to 24",
    ),
    "a negative facet": (
        lambda: contact(cg.FacetArea(), facets=[[0, 1, -1]]),
        "facet 0 names a point that is not there",
    ),
    "facets of a cloud": (lambda: contact(cg.FacetArea()), "area: the slave has no facets"),
    "a cloud of one point": (
        lambda: contact(cg.CloudArea(), GRID[:1]),
        "area: one point has no area of its own",
    ),
    "a line on no profile": (
        lambda: contact(cg.CloudArea(), GRID[:5]),
        "area: the points lie on a line, the master is no profile",
    ),
    "a line on a mesh": (
        lambda: contact(cg.CloudArea(), GRID[:5], body=mesh()),
        "area: the points lie on a line",
    ),
    "several sheets at rest": (
        lambda: contact(cg.CloudArea(), np.concatenate([GRID @ np.diag([1, 1, 0]) + [0, 0, z]
                                                        for z in (0.0, 1.0, 2.0)])[:, [0, 2, 1]]),
        "not a graph over its best-fit plane",
    ),
    "hulls on a mesh": (lambda: contact(cg.HullArea(), body=mesh()), r"\(u, v\) of a patch"),
    "feet on a mesh": (
        lambda: contact(cg.CloudArea(by="feet"), body=mesh()),
        r"\(u, v\) of a patch, which a mesh does not have",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", IMPOSSIBLE)
def test_it_is_refused_before_the_first_step(what):
    make, says = IMPOSSIBLE[what]
    with pytest.raises(InputError, match=says):
        make()


CASE = """
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = 1.0, step = 0.5 }}
output = {{ report = false }}
[[body]]
name = "ball"
geometry = {{ shape = "sphere", radius = 10.0 }}
motion = {{ kind = "translate", table = [[0, 0, 0, 11], [1, 0, 0, 9]] }}
[[slave]]
name = "sheet"
points = {points}
[[contact]]
master = "ball"
slave = "sheet"
law = {{ kind = "force", curve = [[0, 0], [1, 10]] }}
area = {area}
"""
SHEET = '{ grid = { shape = "plane", width = 20, length = 20, nu = 9, nv = 9 } }'
CORNERS = "OFF\n4 {} 0\n-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n3 0 1 2\n"
REFUSED = {
    "unknown method": (
        '{ kind = "hull", clusters = "spectral" }', SHEET,
        "contact[0].area.clusters: unknown method of clustering; found 'spectral'",
    ),
    "no clusters": (
        '{ kind = "hull", clusters = 0 }', SHEET,
        "contact[0].area.clusters: clusters are counted from 1; found 0",
    ),
    "half a cluster": (
        '{ kind = "hull", clusters = 2.5 }', SHEET,
        "contact[0].area.clusters: must be a method or a number of clusters; found 2.5",
    ),
    "k of nothing": (
        '{ kind = "hull", clusters = "kmeans", k = 0 }', SHEET,
        "contact[0].area.k: clusters are counted from 1; found 0",
    ),
    "a radius of nothing": (
        '{ kind = "hull", clusters = "dbscan", eps = 0.0 }', SHEET,
        "contact[0].area.eps: is too small; found 0.0; allowed: > 0",
    ),
    "a facet of no point": (
        '{ kind = "facet" }', '{ file = "bad.off" }',
        "bad.off, line 8: a face names a node that is not there; found 7; allowed: 0 to 3",
    ),
    "facets of a cloud": (
        '{ kind = "facet" }', "{ coordinates = [[0, 0, 0], [1, 0, 0], [0, 1, 0]] }",
        "contact[0].area: the slave has no facets to measure",
    ),
    "a line on no profile": (
        '{ kind = "cloud" }', "{ coordinates = [[0, 0, 0], [1, 0, 0], [2, 0, 0]] }",
        "contact[0].area: the points lie on a line, the master is no profile",
    ),
}  # fmt: skip


def command(monkeypatch, capsys, folder, area, points):
    """Exit code and error output of a run."""
    (folder / "bad.off").write_text(CORNERS.format(2) + "3 0 2 7\n", encoding="utf-8")
    (folder / "flat.off").write_text(CORNERS.format(3) + "3 0 2 2\n3 1 1 1\n", encoding="utf-8")
    case = folder / "case.toml"
    case.write_text(CASE.format(points=points, area=area), encoding="utf-8")
    run = Command(monkeypatch, capsys, "run")
    code, _, err = run(case, "-o", folder / "out", "--quiet")
    return code, err


@pytest.mark.parametrize("what", REFUSED)
def test_a_case_with_it_stops_with_one_message_and_writes_nothing(
    what, monkeypatch, capsys, tmp_path
):
    area, points, says = REFUSED[what]
    code, err = command(monkeypatch, capsys, tmp_path, area, points)
    assert code == 2
    assert err.startswith("contiga: error: ")
    assert err.count("\n") == 1
    assert says in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("area", "points"),
    [
        ('{ kind = "hull", clusters = 1000 }', SHEET),
        ('{ kind = "facet" }', '{ file = "flat.off" }'),
        ('{ kind = "hull", mapping = "exact" }', "{ coordinates = [[0, 0, 0], [1, 0, 0]] }"),
    ],
)
def test_a_case_with_more_clusters_than_points_or_no_area_runs(
    area, points, monkeypatch, capsys, tmp_path
):
    code, _ = command(monkeypatch, capsys, tmp_path, area, points)
    assert code == 0
    assert (tmp_path / "out" / "history.csv").exists()


EVERY = {
    "facets": (cg.FacetArea(), True),
    "cloud at rest": (cg.CloudArea(), False),
    "cloud by feet": (cg.CloudArea(by="feet"), False),
    **{
        f"hulls, {clusters}, {mapping}": (cg.HullArea(clusters, mapping=mapping), False)
        for clusters in ("auto", 3, "dbscan", "meanshift", "hdbscan")
        for mapping in ("linear", "exact")
    },
}


@pytest.mark.parametrize("what", EVERY)
def test_no_contact_is_no_area_no_region_no_pressure_and_no_place(what):
    area, with_facets = EVERY[what]
    facets = np.array([[0, 5, 6], [0, 6, 1]]) if with_facets else None
    free = contact(area, GRID + np.array([0.0, 0.0, 1.0]), facets)
    state = free.start(free.slave.points)
    assert state.n_contact == state.n_clusters == state.total_area == 0
    assert state.mean_pressure == state.max_pressure == 0.0
    assert not state.total_force.any()
    assert np.isnan(state.centre_of_pressure).all()
    assert len(free.outlines(state).clusters) == 0


@pytest.mark.parametrize("mapping", ["linear", "exact"])
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_more_clusters_than_points_are_points_without_area(n, mapping):
    # Each point is its own cluster, whose hull is a point.
    many = contact(cg.HullArea(7, mapping=mapping), GRID[:n])
    state = many.start(many.slave.points)
    assert state.n_clusters == n
    assert state.total_area == 0.0
    assert not state.total_force.any()


@pytest.mark.parametrize("mapping", ["linear", "exact"])
@pytest.mark.parametrize(("clusters", "kept"), [("auto", 1), (1, 1), ("dbscan", 1)])
def test_hulls_of_points_on_several_patches_are_drawn_on_each_and_added(clusters, kept, mapping):
    # 0.5 by 1 on one side, 0.25 by 1 on the other: the points at x = 0 are of one patch only.
    area = cg.HullArea(clusters, mapping=mapping, eps=0.4, min_points=3)
    both = contact(area, GRID, body=HALVES)
    state = both.start(both.slave.points)
    assert state.n_clusters == kept
    assert state.total_area == pytest.approx(0.75, rel=1e-12)
    assert len(both.outlines(state).clusters) == 2
