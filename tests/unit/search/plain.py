"""Tables of a body that are made at once, even without the compiler."""

from __future__ import annotations

import contiga as cg
from contiga.elements.element_arrays import Elements
from contiga.elements.extraction import elements_of
from contiga.elements.neighbours import join
from contiga.search.certify.neighbourhoods import with_neighbourhoods
from contiga.search.hierarchy.table_types import Tables
from contiga.search.tables import tables_of


def elements(body: cg.Body) -> Elements:
    """Its elements, whose sides are not joined."""
    return elements_of(body, body.trim_tables)[0]


def joined(body: cg.Body) -> Tables:
    """Its elements and their neighbours; what else the search knows is that of a plane."""
    trims = body.trim_tables
    own, grid = elements_of(body, trims)
    grid = join(own, grid, body)
    plane = tables_of(cg.Body([cg.shapes.plane()]))
    return plane._replace(elements=own, grid=grid, trims=trims)


def tracking_tables_of(body: cg.Body) -> Tables:
    """Its tables, with what certificates of tracked feet need."""
    return with_neighbourhoods(tables_of(body))
