"""Pairs of leaves that come near each other are those that all pairs, tried one by one, tell."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.borders.test_crossings import bent_pipe

import contiga as cg
from contiga.search.borders import crossings
from contiga.search.borders.crossings import near_leaves
from contiga.search.hierarchy import build
from contiga.search.hierarchy.table_types import Tables
from contiga.search.tables import tables_of

BODIES = {
    "a disc and a cylinder": lambda: cg.Body([cg.shapes.disc(), cg.shapes.cylinder()]),
    "a pipe through itself": lambda: cg.Body([bent_pipe(0.2)]),
    "a saddle": lambda: cg.Body([cg.shapes.saddle()]),
}


def by_all_pairs(tables: Tables, within: float) -> set[tuple[int, int]]:
    """Pairs of leaves of faces that no axis of their plates separates, found without the tree."""
    face = np.flatnonzero(tables.leaves["element"] >= 0)
    plates = tables.plates[face]
    i, j = np.triu_indices(len(face), 1)
    one, two = plates[i], plates[j]
    off = two["middle"] - one["middle"]
    meet = np.linalg.norm(off, axis=1) <= one["radius"] + two["radius"] + within
    for axis in (one["normal"], two["normal"], one["x"], one["y"], two["x"], two["y"]):
        way = axis / np.maximum(np.linalg.norm(axis, axis=1), 1e-300)[:, None]
        reach = within + one["departure"] + two["departure"]
        for side in (one["x"], one["y"], two["x"], two["y"]):
            reach = reach + np.abs((side * way).sum(axis=1))
        meet &= np.abs((off * way).sum(axis=1)) <= reach + 1e-12
    return set(zip(face[i[meet]].tolist(), face[j[meet]].tolist(), strict=True))


@pytest.mark.parametrize("within", [0.0, 0.05])
@pytest.mark.parametrize("name", BODIES)
def test_near_leaves_are_those_of_all_pairs_whose_boxes_meet(
    name: str, within: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(build, "FLATNESSES", (0.2,))  # fewer leaves, of which all pairs are tried
    tables = tables_of(BODIES[name]())
    pairs = near_leaves(tables, within)
    found = set(map(tuple, np.sort(pairs, axis=1).tolist()))
    assert len(found) == len(pairs)
    wanted = by_all_pairs(tables, within)
    assert found <= wanted
    # The tree's boxes tell some pairs apart that plates do not: these are farther off than that.
    places = crossings.leaf_boxes(tables).mean(axis=1)
    body = BODIES[name]()
    for a, b in sorted(wanted - found)[:200]:
        ends = [
            body.patches[tables.leaves["patch"][k]].evaluate(places[None, k])[0] for k in (a, b)
        ]
        assert np.linalg.norm(ends[1] - ends[0]) > within
    assert len(found) > 0.8 * len(wanted)


def test_there_is_room_for_more_pairs_than_are_reckoned_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tables = tables_of(cg.Body([bent_pipe(0.2)]))
    usual = near_leaves(tables)
    monkeypatch.setattr(crossings, "PAIRS_PER_LEAF", 1)
    assert len(usual) > len(tables.leaves)
    np.testing.assert_array_equal(near_leaves(tables), usual)
