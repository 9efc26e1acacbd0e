"""The binary hierarchy of boxes."""

from __future__ import annotations

import contiga as cg
from contiga.search.tables import tables_of


def test_inner_boxes_hold_their_children():
    tree = tables_of(cg.Body([cg.shapes.torus()])).tree
    for node in tree[tree["count"] == 0]:
        for child in tree[node["first"] : node["first"] + 2]:
            assert (node["low"] <= child["low"]).all()
            assert (child["high"] <= node["high"]).all()
