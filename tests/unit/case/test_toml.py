"""The resolved copy of a case reads back as the same case."""

from __future__ import annotations

import tomllib

from hypothesis import given
from hypothesis import strategies as st

from contiga.case.schema import parse_case
from contiga.case.toml import resolved_toml, value_text

FULL = """\
title = "quoted \\"title\\" \\u007f with ümlaut \\\\ and\\nline"
[units]
length = "mm"
mass = "kg"
time = "ms"
[time]
start = 0.1
end = 0.30000000000000004
step = 1e-3
[[body]]
name = "plate"
reference_point = [0, 0, 1]
geometry = { shape = "bumpy_plate", waves = [1, 2], transform = [{ rotate = { degrees = 30 } }] }
motion = { kind = "combine", motions = [
  { kind = "rotate", table = [[0, 0], [1, 90]], axis = [0, 1, 1] },
  { kind = "poses", table = [[0, 0, 0, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, 1, 0, 0]] } ] }
[[body]]
name = "net"
geometry = { flip = true, nurbs = { degrees = [1, 1], knots = [[0, 0, 1, 1], [0, 0, 1, 1]], \
weights = [[1, 1], [1, 2]], control_points = [[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]] } }
[[slave]]
name = "pad"
thickness = 2
points = { random = { box = [[0,0,0],[1,1,1]], n = 3, seed = 4 } }
motion = { kind = "translate", table = [[0, 0, 0, 0], [0.1, 0, 0, 1],
  [0.2, 0, 0, 3], [0.3, 0, 0, 4]] }
[[contact]]
master = "net"
slave = "pad"
type = "combined"
law = { kind = "stress", elastic = { points = [[0, 0], [1, 2]], extrapolation = "error" } }
master_law = { kind = "stress", elastic = 3, thickness = 1, damping = 0.5 }
area = { kind = "tributary" }
[output]
every = 3
formats = []
report = false
"""


def test_the_resolved_copy_is_the_same_case() -> None:
    case = parse_case(FULL)
    text = resolved_toml(case)
    again = parse_case(text)
    assert again.model_dump() == case.model_dump()
    assert resolved_toml(again) == text


def test_the_resolved_copy_says_what_was_left_out() -> None:
    data = tomllib.loads(resolved_toml(parse_case(FULL)))
    assert data["contact"][0]["on_edge"] == "release"
    assert data["body"][1]["motion"] == {"kind": "fixed"}


plain = st.recursive(
    st.text(st.characters(exclude_categories=["Cs"]))
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.booleans(),
    lambda inner: (
        st.lists(inner, max_size=5) | st.dictionaries(st.text("ab -é\"'", max_size=4), inner)
    ),
    max_leaves=20,
)


@given(plain)
def test_every_value_reads_back(value: object) -> None:
    assert tomllib.loads(f"x = {value_text(value)}")["x"] == value
