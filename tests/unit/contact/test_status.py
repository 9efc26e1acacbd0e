"""What becomes of points, in the numbers of kernels and in the names of users."""

from __future__ import annotations

from contiga.contact.kernels import status_nb
from contiga.records import ContactStatus


def test_the_numbers_of_kernels_are_those_of_the_statuses() -> None:
    numbers = {name: n for name, n in vars(status_nb).items() if name.isupper()}
    assert numbers
    for name, number in numbers.items():
        assert ContactStatus[name] == number
        assert type(number) is int
