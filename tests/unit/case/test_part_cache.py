"""Parts that cases have in common are made once, and what was made gives the same bits."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

import contiga as cg
from contiga.case.build import build, run
from contiga.case.part_cache import PartCache
from contiga.case.schema import Case, parse_case

from .test_columns import FREE, HEAD

CASE = HEAD.replace("MOTION", FREE)


def case(**settings: object) -> Case:
    """With other values."""
    return parse_case(CASE, set={key.replace("__", "."): v for key, v in settings.items()})


def test_the_same_table_gives_the_same_part() -> None:
    cache = PartCache()
    one = build(case(), parts=cache)
    two = build(case(body__ball__motion__velocity=[0, 0, -2]), parts=cache)
    assert one.bodies["ball"].body is two.bodies["ball"].body
    other = build(case(body__ball__geometry__radius=9.0), parts=cache)
    assert other.bodies["ball"].body is not one.bodies["ball"].body
    again = build(case(), parts=cache)
    assert again.bodies["ball"].body is one.bodies["ball"].body


def test_what_is_placed_by_others_is_placed_anew() -> None:
    cache = PartCache()
    placed = {"on": "sheet", "direction": [0, 0, -1], "gap": 1.0}
    lows = []
    for gap in (1.0, 2.0):
        set_ = {"body__ball__geometry__place": {**placed, "gap": gap}}
        lows.append(build(case(**set_), parts=cache).bodies["ball"].body.bounds()[0, 2])
    assert lows[1] - lows[0] == 1.0


def test_parts_in_common_give_the_bits_of_parts_made_anew() -> None:
    cache = PartCache()
    run(case(body__ball__motion__velocity=[0, 0, -2]), parts=cache)
    kept, fresh = run(case(), parts=cache).history, cg.run(case()).history
    for name in fresh:
        if not name.endswith("wall_time"):
            assert np.array_equal(kept[name], fresh[name], equal_nan=True), name


def test_a_file_that_has_changed_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "points.csv"
    text = CASE.replace(
        'points = { grid = { shape = "plane", width = 20, length = 20, nu = 5, nv = 5 } }',
        f'points = {{ file = "{file}" }}\narea = 1.0\n',
    )
    cache = PartCache()
    counts = []
    for rows in ("0,0,0\n", "0,0,0\n1,0,0\n"):
        file.write_text("x,y,z\n" + rows, encoding="utf-8")
        os.utime(file, ns=(len(rows), len(rows)))
        counts.append(len(build(parse_case(text), parts=cache).slaves["sheet"].slave))
    assert counts == [1, 2]


def test_what_was_not_asked_for_the_longest_is_let_go() -> None:
    cache, made = PartCache(max_parts=2), []

    def part(radius: float) -> None:
        spec = case(body__ball__geometry__radius=radius).body[0].geometry
        cache.part(spec, "ball", "mm", lambda: made.append(radius))

    for radius in (1.0, 2.0, 1.0, 3.0, 1.0, 2.0):
        part(radius)
    assert made == [1.0, 2.0, 3.0, 2.0]
