"""What is kept of a body lives as long as its tables."""

from __future__ import annotations

import gc

import contiga as cg
from contiga.search.hierarchy.table_cache import TableCache
from contiga.search.tables import tables_of


def counting(built):
    def build(tables, *how):
        built.append(how)
        return len(built)

    return TableCache(build)


def test_it_is_built_once_a_body():
    built = []
    kept, bodies = counting(built), [cg.Body([cg.shapes.torus()]) for _ in range(2)]
    answers = [kept.of(tables_of(body), "so") for body in (*bodies, *bodies)]
    assert answers == [1, 2, 1, 2]
    assert built == [("so",), ("so",)]
    # Tables put together anew are those of the same body.
    assert kept.of(tables_of(bodies[0])._replace(), "so") == 1


def test_it_is_built_where_enough_was_asked_or_it_is_there():
    built = []
    kept, tables = counting(built), tables_of(cg.Body([cg.shapes.torus()]))
    assert [kept.if_pays(tables, 40, 100) for _ in range(3)] == [None, None, 1]
    assert kept.if_pays(tables, 0, 10**9) == 1
    other = tables_of(cg.Body([cg.shapes.sphere()]))
    assert kept.of(other) == 2
    assert kept.if_pays(other, 1, 100) == 2


def test_it_is_forgotten_with_the_body():
    built = []
    kept, body = counting(built), cg.Body([cg.shapes.torus()])
    kept.if_pays(tables_of(body), 5, 1)
    del body
    gc.collect()
    assert kept._results == kept._uses == {}
