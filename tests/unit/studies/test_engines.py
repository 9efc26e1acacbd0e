"""What runs the cases: chosen by what is asked for, refused where it cannot be."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from contiga.errors import InputError, MissingPackageError
from contiga.studies.engines import InTurn, cores, engine_for
from contiga.studies.row import DONE

from .conftest import base_in, case_at


def test_no_workers_run_the_cases_in_turn(folder: Path) -> None:
    with engine_for(base_in(folder), scheduler=None, workers=0, retries=3) as engine:
        assert isinstance(engine, InTurn)
        rows = list(engine.run([case_at(2, -2.0), case_at(1, -1.0)]))
    assert [(row.number, row.status) for row in rows] == [(2, DONE), (1, DONE)]


def test_dask_is_asked_for_by_its_extra(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(MissingPackageError, match=r"needs distributed.*contiga\[study\]"),
        engine_for(base_in(folder), scheduler=None, workers=2, retries=3),
    ):
        pass


@pytest.mark.parametrize("workers", [-1, True])
def test_a_number_of_workers_that_is_none_is_refused(workers: int, folder: Path) -> None:
    with (
        pytest.raises(InputError, match="whole number"),
        engine_for(base_in(folder), scheduler=None, workers=workers, retries=3),
    ):
        pass
    assert cores() >= 1
