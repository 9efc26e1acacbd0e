"""A good case, and how a wrong one made from it is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.case.schema import load_case
from contiga.errors import CaseError, InputError

GOOD = """\
title = "Cloud pressed into a plate"
[units]
length = "mm"
mass = "kg"
time = "ms"
[time]
end = 13.0
step = 1.0
[[body]]
name = "plate"
geometry = { shape = "bumpy_plate", width = 2.0, waves = 1 }
motion = { kind = "fixed" }
[[slave]]
name = "cylinder"
points = { sample = { shape = "cylinder", radius = 0.2, nu = 5, nv = 6 } }
motion = { kind = "translate", table = [[0, 0, 0, 0], [13, 0, 0, -1.3]] }
[[contact]]
master = "plate"
slave = "cylinder"
law = { kind = "force", curve = [[0, 0], [1, 0.5]] }
area = { kind = "constant", value = 0.1 }
[output]
every = 1
"""

GEOMETRY = '{ shape = "bumpy_plate", width = 2.0, waves = 1 }'
FIXED = 'motion = { kind = "fixed" }'
MOVE = '{ kind = "translate", table = [[0, 0, 0, 0], [13, 0, 0, -1.3]] }'
POINTS = '{ sample = { shape = "cylinder", radius = 0.2, nu = 5, nv = 6 } }'
LAW = '{ kind = "force", curve = [[0, 0], [1, 0.5]] }'
AREA = '{ kind = "constant", value = 0.1 }'


def swap(name: str, old: str, new: str, *pieces: str, kind: type[InputError] = CaseError):
    return pytest.param(old, new, pieces, kind, id=name)


def refused(folder: Path, old: str, new: str, pieces: tuple[str, ...], kind: type) -> None:
    """Assert that the good case with `new` for `old` is refused in one message with `pieces`."""
    assert old in GOOD
    path = folder / "case.toml"
    path.write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(kind) as caught:
        load_case(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    for piece in pieces:
        assert piece in message
    assert caught.value.exit_code == 2
    assert "pydantic" not in message
    assert "<" not in message.replace("allowed: <", "")
