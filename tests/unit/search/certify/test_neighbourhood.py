"""Bounds around the parts of elements: surroundings that feet do not leave unseen."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search import plain
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.arrays.codes import POLE
from contiga.records import empty_projection
from contiga.search.certify import neighbourhoods
from contiga.search.certify.neighbourhoods import build_neighbourhoods, with_neighbourhoods
from contiga.search.hierarchy.table_cache import TableCache
from contiga.search.tables import tables_of


def test_curvatures_around_every_part_of_a_torus_are_bounded():
    patch = cg.shapes.torus(major=3.0, minor=1.0)
    tables = tracking_tables_of(cg.Body([patch]))
    # towards the outward normal the rim bends by 1/4 at most inward, the hole by 1/2 outward
    curvature = tables.neighbourhoods["curvature"]
    assert (curvature[..., 1] >= 1.0 - 1e-9).all()
    assert (curvature[..., 1] < 2.5).all()
    assert (curvature[..., 0] < 1.2).all()
    assert (tables.neighbourhoods["room"] > 0.0).all()
    assert (tables.neighbourhoods["ends"] == 0).all()


def test_speeds_and_widths_hold_within_the_block():
    patch = cg.shapes.bumpy_plate(waves=2)
    tables = tracking_tables_of(cg.Body([patch]))
    rng = np.random.default_rng(0)
    for neighbourhood in rng.choice(tables.neighbourhoods.ravel(), 40):
        u0, u1, v0, v1 = neighbourhood["block"]
        uv = rng.uniform([u0, v0], [u1, v1], (100, 2)).clip(0.0, 1.0)
        D = patch.derivatives(uv, 1)
        u, v = D[:, 1, 0], D[:, 0, 1]
        speed = np.linalg.norm(u, axis=1).max(), np.linalg.norm(v, axis=1).max()
        area = np.linalg.norm(np.cross(u, v), axis=1)
        width = (area / np.linalg.norm(v, axis=1)).min(), (area / np.linalg.norm(u, axis=1)).min()
        assert (np.array(speed) <= neighbourhood["speed"] * (1.0 + 1e-9)).all()
        assert (np.array(width) >= neighbourhood["width"] * (1.0 - 1e-9)).all()


def test_the_border_of_a_sheet_ends_the_parts_beside_it():
    ends = tracking_tables_of(cg.Body([cg.shapes.saddle()])).neighbourhoods["ends"]
    assert ends.any()
    assert not ends.all()


@pytest.mark.interpreted
def test_parts_at_a_corner_where_smooth_elements_meet_have_room():
    """Four elements of a flat sheet: only the parts at its own border are next to an end."""
    knots = [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0]
    x, y = np.meshgrid(*2 * [[0.0, 0.25, 0.75, 1.0]], indexing="ij")
    sheet = cg.NurbsSurface((2, 2), (knots, knots), np.stack([x, y, 0.0 * x], axis=-1))
    kept = tracking_tables_of(cg.Body([sheet])).neighbourhoods.reshape(4, 4, 4)
    assert (kept["room"] > 0.1).all()
    inner = kept[0, 3, 3], kept[1, 3, 0], kept[2, 0, 3], kept[3, 0, 0]
    assert not any(neighbourhood["ends"].any() for neighbourhood in inner)


@pytest.mark.interpreted
def test_parts_about_a_smooth_pole_have_room_all_round():
    """Four elements of a flat disc about its middle, which is a side of each."""
    disc = cg.shapes.revolved(cg.shapes.line([0, 0, 0], [1, 0, 0]))
    kept = build_neighbourhoods(plain.joined(cg.Body([disc])))
    about = kept[kept["pole"] >= 0]
    assert len(about) == 4 * 12
    # The parts next to them end a quarter of the radius farther out.
    assert (about["room"] > 0.1).all()
    assert (about["room"] <= 0.25).all()
    assert not about["ends"].any()
    assert (kept["curvature"] < 1e-9).all()


def test_parts_away_from_the_apex_of_a_cone_have_room():
    """Its elements reach from there to the base: of four parts the two that are not beside it."""
    cone = cg.Body([cg.shapes.cone()])
    (side,) = np.unique(np.nonzero(tables_of(cone).elements.table["kind"] == POLE)[1])
    off = np.arange(4) if side & 1 == 0 else np.arange(4)[::-1]
    rows = tracking_tables_of(cone).neighbourhoods.reshape(-1, 4, 4)
    rows = rows if side < 2 else rows.transpose(0, 2, 1)
    bounded = np.isfinite(rows["curvature"]).all(axis=-1)
    assert bounded[:, off >= 2].all()
    assert not bounded[:, off < 2].any()
    assert (rows["room"][:, off >= 2] > 0.0).all()
    assert (rows["pole"] == -1).all()


@pytest.fixture
def built(monkeypatch):
    """How often neighbourhoods have been worked out."""
    built = []

    def build(tables):
        built.append(tables)
        return build_neighbourhoods(tables)

    monkeypatch.setattr(neighbourhoods, "_NEIGHBOURHOODS", TableCache(build))
    return built


def test_only_certificates_of_tracked_feet_ask_for_neighbourhoods(built):
    body, points = cg.Body([cg.shapes.torus()]), np.array([[3.0, 0.0, 0.1], [2.0, 0.5, 0.6]])
    feet = body.project(points)
    assert body.closed
    assert body.contains(points).tolist() == [False, False]
    surface, out = body.surface, empty_projection(2)
    surface.track(points + 0.01, feet.patch, feet.uv, out)
    assert built == []
    assert len(surface.tables.neighbourhoods) == 0
    for shift in (0.01, 0.02):
        body.project(points + shift, start=feet, mode="track")
        surface.track(points + shift, feet.patch, feet.uv, out, points)
    assert len(built) == 1
    tracked = with_neighbourhoods(tables_of(body))
    assert len(tracked.neighbourhoods) == len(tracked.elements.table)
    assert tracked.elements.table is tables_of(body).elements.table


def _press(body, **options):
    """Points pressed into the top of a body and moved on, by a contact with these options."""
    points = np.array([[x, y, 1.05] for x in (-0.2, 0.0, 0.2) for y in (-0.1, 0.1)])
    contact = cg.Contact(body, cg.Slave(points, area=np.ones(6)), law=cg.PenaltyLaw(1.0), **options)
    state = contact.start(points)
    for x in (0.0, 0.01, 0.02):
        state = contact.step(state, points - [x, 0.0, 0.15])
    assert state.in_contact.all()
    return state


def test_a_contact_asks_for_neighbourhoods_only_where_its_feet_are_tracked(built):
    body = cg.Body([cg.shapes.sphere()])
    default = _press(body)
    assert built == []
    assert len(body.surface.contact_tables.body.neighbourhoods) == 0
    tracked = _press(body, foot="tracked")
    assert len(built) == 1
    assert tracked.certified.all()
    np.testing.assert_allclose(tracked.penetration, default.penetration, atol=1e-12)


def test_a_contact_finds_the_same_bits_whether_they_are_there_or_not(built):
    first, second = cg.Body([cg.shapes.sphere()]), cg.Body([cg.shapes.sphere()])
    with_neighbourhoods(tables_of(second))
    states = [_press(body, foot="tracked") for body in (first, second)]
    for name in ("status", "certified", "penetration", "normal", "foot", "force"):
        here, there = (getattr(state, name) for state in states)
        np.testing.assert_array_equal(here, there, err_msg=name)
    assert len(built) == 2
