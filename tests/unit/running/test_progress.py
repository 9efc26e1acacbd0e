"""The progress of a run as a line of text in a notebook."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest

from contiga.running import progress
from contiga.running.progress import progress_bar


class Output:
    """An output of a notebook that was displayed, and all that it has shown."""

    def __init__(self, line: dict[str, str]) -> None:
        self.shown = [line["text/plain"]]

    def update(self, line: dict[str, str], *, raw: bool) -> None:
        assert raw
        self.shown.append(line["text/plain"])


@pytest.fixture
def outputs(monkeypatch: pytest.MonkeyPatch) -> list[Output]:
    """The outputs of a notebook, whose packages stand in for those of IPython."""
    made: list[Output] = []

    def display(line: dict[str, str], *, raw: bool, display_id: bool) -> Output:
        assert raw
        assert display_id
        made.append(Output(line))
        return made[-1]

    module = ModuleType("IPython.display")
    module.display = display  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setitem(sys.modules, "rich", None)
    monkeypatch.setattr(progress, "in_notebook", lambda stream: True)
    monkeypatch.setattr(progress, "_PAUSE", 0.0)
    return made


def test_a_notebook_has_one_output_whose_last_state_replaces_the_others(
    outputs: list[Output],
) -> None:
    with progress_bar("Ball", quiet=False) as show:
        show(1, 4, "a long text about it")
        show(4, 4, "12 in contact")
    (output,) = outputs
    assert output.shown[0].startswith("Ball: 1/4, 25 %, ")
    assert output.shown[0].endswith("a long text about it")
    assert output.shown[-1] == "Ball: 4/4, 100 %, 12 in contact"


def test_nothing_is_shown_before_the_first_part_or_quietly(outputs: list[Output]) -> None:
    with progress_bar("Ball", quiet=False):
        pass
    with progress_bar("Ball", quiet=True) as show:
        show(1, 2, "")
    assert outputs == []
