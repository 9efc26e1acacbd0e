"""Workers that may be used: by what they answer, whatever goes wrong there."""

from __future__ import annotations

from errno import EACCES
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from contiga.errors import InputError

from .conftest import base_in

on_dask = pytest.importorskip("contiga.studies.on_dask")


class Client:
    """Of a scheduler that tells of one worker, which answers by itself."""

    def __init__(self, answer: Any = None, seconds: int = 0) -> None:
        self._answer, self._left = answer, seconds
        self.waits = 0

    def scheduler_info(self, n_workers: int) -> Any:
        return {"workers": {"tcp://a:1": {"host": "a"}}}

    def wait_for_workers(self, _: int) -> None:
        self.waits += 1

    def run(self, asked: Any, folder: str, workers: list[str], on_error: str) -> Any:
        self._left -= 1
        return {one: OSError("lost") if self._left >= 0 else asked(folder) for one in workers}


def test_a_folder_that_may_not_be_looked_at_is_not_seen(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> bool:
        raise PermissionError(EACCES, "Permission denied")

    monkeypatch.setattr(Path, "is_dir", refused)
    engine = on_dask.OnDask(Client(), base_in(folder), retries=0)
    with pytest.raises(InputError, match="does not see the folder"):
        engine._workers()


def test_workers_that_are_told_of_and_lost_are_waited_for(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pauses: list[float] = []
    monkeypatch.setattr(on_dask, "sleep", pauses.append)
    monkeypatch.setattr(on_dask, "Event", lambda name, client: SimpleNamespace(name=name))
    (folder / "out").mkdir()
    client = Client(seconds=3)
    engine = on_dask.OnDask(client, base_in(folder), retries=0)
    assert list(engine._hosts({})) == ["a"]
    assert (client.waits, len(pauses)) == (4, 3)
