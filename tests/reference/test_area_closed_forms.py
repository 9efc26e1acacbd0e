"""Contact areas against closed forms, with the order in which they are reached.

The scenes on the master are those of the benchmark, whose table the pages quote.
"""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import contiga as cg

ERRORS = SimpleNamespace(
    **runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "area_errors.py"))
)
SCENES = {scene.name: scene for scene in ERRORS.scenes()}
AREAS = [name for name, scene in SCENES.items() if not scene.force]
REGIONS = {"two discs": 2, "caps of two balls": 2, "saddle": 2}


def scenes_on_the_slave():
    """The areas of the slave itself, where they differ from those on the master."""
    cap = SCENES["ball in a plane"]._replace(name="cap of a ball in a plane", exact=0.4 * np.pi)
    r, c = 0.8, 0.22  # a ball in a hollow one, touching where it comes through the wall
    own = 2 * np.pi * r * ((r * r - 1.0 - c * c) / (2 * c) + c + r)
    inner = SCENES["ball in a hollow ball"]._replace(name="cap in a hollow ball", exact=own)
    discs = 2 * np.pi * (0.25 - 0.35**2)
    under = SCENES["caps of two balls"]._replace(name="discs under two balls", exact=discs)
    ring = 4 * np.pi * np.sqrt(0.16 - 0.09)
    round_torus = SCENES["ring of a torus"]._replace(name="annulus under a torus", exact=ring)
    r, c = 0.7, 0.4
    strip = 2.0 * np.arccos(-((r * r - 1.0 - c * c) / (2 * c) + c) / r) * r * 1.1
    rod = SCENES["cylinder in a trough"]._replace(name="skin in a trough", exact=strip)
    for scene in (cap, inner, under, round_torus, rod):
        yield scene._replace(side="slave")


def orders(scene, area):
    """Least-squares order over the five sizes, and the error of the last."""
    errors = [ERRORS.error(scene, area, n) for n in ERRORS.REFINED]
    return -np.polyfit(np.log(ERRORS.REFINED), np.log(errors), 1)[0], errors[-1]


@pytest.mark.parametrize("name", SCENES)
def test_facets_on_the_master_are_of_second_order_over_four_refinements(name):
    order, last = orders(SCENES[name], cg.FacetArea("master"))
    assert order >= 1.9
    assert last < 1e-3


@pytest.mark.parametrize("scene", list(scenes_on_the_slave()), ids=lambda s: s.name)
def test_facets_on_the_slave_are_of_second_order_over_four_refinements(scene):
    order, last = orders(scene, cg.FacetArea())
    assert order >= 1.9
    assert last < 1e-3


@pytest.mark.parametrize("name", AREAS)
def test_regions_are_counted_and_their_areas_add_up(name):
    scene = SCENES[name]
    slave = ERRORS.mesh(scene, ERRORS.SHIFTS[0], 40)
    for area in (cg.FacetArea(), cg.HullArea("auto", mapping="exact")):
        state = ERRORS.touch(scene, slave, area)
        assert state.n_clusters == REGIONS.get(name, 1)
        parts = [state.area[state.clusters == k].sum() for k in range(state.n_clusters)]
        assert sum(parts) == pytest.approx(state.total_area, rel=1e-14)
        # The two regions of a scene are alike.
        assert parts == pytest.approx([parts[0]] * len(parts), rel=0.05)


@pytest.mark.parametrize("name", AREAS)
def test_facets_are_closer_than_the_hulls_of_the_thesis_at_equal_point_count(name):
    keys = ("facets", "cloud, rest", "cloud, feet", "hull, linear", "hull, exact")
    errors = {key: ERRORS.error(SCENES[name], ERRORS.METHODS[key]) for key in keys}
    print(name + ":", ", ".join(f"{key} {e:.3%}" for key, e in errors.items()))
    hulls = min(errors["hull, linear"], errors["hull, exact"])
    assert 3.0 * errors["facets"] < hulls
    assert 2.0 * errors["cloud, rest"] < hulls
    assert 2.0 * errors["cloud, feet"] < hulls


def test_other_areas_make_a_larger_error_of_the_force_on_a_winkler_foundation():
    # σ = k λ/t over the plane: the force is k/t times the volume of penetration.
    scene = SCENES["Winkler force"]
    h, (k, t) = 0.2, ERRORS.WINKLER
    assert scene.exact == pytest.approx(k / t * np.pi * h * h * (1.0 - h / 3.0))
    keys = ("facets", "hull, linear", "hull, exact", "constant")
    errors = {key: ERRORS.error(scene, ERRORS.METHODS[key]) for key in keys}
    print("errors of the force:", ", ".join(f"{key} {e:.3%}" for key, e in errors.items()))
    assert 10.0 * errors["facets"] < errors["hull, linear"] < errors["constant"]


def test_force_of_a_ball_master_on_a_winkler_layer():
    # The slave deforms: σ over the flat layer along the ball's normals, F_z = k/t π d h².
    h, (k, t) = 0.2, ERRORS.WINKLER
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    exact = -k / t * np.pi * (1.0 - h) * h * h
    scene = ERRORS.Scene(
        "layer", ball, ERRORS.lifted(lambda x, y: h - 1.0), (0.66, 0.66), exact, True, "slave"
    )
    order, last = orders(scene, cg.FacetArea())
    assert order >= 1.9
    assert last < 1e-3


@pytest.mark.parametrize("on", ["master", "slave"])
def test_plate_larger_than_its_master_touches_all_of_it(on):
    body = cg.Body([cg.shapes.plane(width=1.0, length=0.7)])
    sheet = ERRORS.lifted(lambda x, y: -0.05)
    scene = ERRORS.Scene("plate", body, sheet, (1.0, 1.0), 0.7, False, on)
    # Only where a corner of the master falls inside a facet is anything lost.
    order, last = orders(scene, cg.FacetArea())
    assert order >= 1.8
    assert last < 3e-4
