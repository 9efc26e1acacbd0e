"""What the continuous integration runs with the oldest numba is there."""

from __future__ import annotations

import re

from tests import oldest


def test_the_oldest_is_that_of_the_requirements_and_its_tests_are_there() -> None:
    assert re.fullmatch(r"numba==0\.\d+\.\d+", oldest.oldest())
    assert all((oldest.ROOT / test).is_file() for test in oldest.QUICK)
