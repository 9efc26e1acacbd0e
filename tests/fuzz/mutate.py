"""Ways to damage a file, all drawn from the generator handed in: a number names a file."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eEdD][-+]?\d+)?")
_REFERENCE = re.compile(rb"#\d+")
_ODD_NUMBERS = (
    *(b"0", b"-1", b"1", b"2", b"255", b"65536", b"2147483647", b"2147483648", b"-2147483649"),
    *(b"4294967295", b"9223372036854775807", b"99999999999999999999", b"1e9", b"1e15", b"1e18"),
    *(b"1e-30", b"1e30", b"1e154", b"1e300", b"-1e300", b"1e308", b"1e400", b"1e-400"),
    *(
        b"nan",
        b"NaN",
        b"inf",
        b"-inf",
        b"0.0",
        b"-0.0",
        b"5e-324",
        b"1e",
        b"",
        b"x",
        b"1,5",
        b"--1",
    ),
)
_ODD_WORDS = tuple(
    bytes.fromhex(text)
    for text in (
        *("ffffffff", "ffffff7f", "00000080", "7fffffff", "80000000", "00000000", "00000100"),
        *("ffffffffffffffff", "ffffffffffffff7f", "7fffffffffffffff", "000000000000f07f"),
        *("000000000000f87f", "0000000000000080", "7ff0000000000000", "0100000000000000"),
    )
)

Change = Callable[[bytes, np.random.Generator], bytes]


def _at(data: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(0, len(data) + 1))


def _stretch(data: bytes, rng: np.random.Generator) -> tuple[int, int]:
    start = _at(data, rng)
    return start, min(len(data), start + int(2.0 ** rng.uniform(0.0, 10.0)))


def change_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Some bytes become any others."""
    array = bytearray(data)
    for _ in range(int(rng.integers(1, 12))):
        if array:
            array[int(rng.integers(len(array)))] = int(rng.integers(256))
    return bytes(array)


def flip_bits(data: bytes, rng: np.random.Generator) -> bytes:
    """Some bits turn over."""
    array = bytearray(data)
    for _ in range(int(rng.integers(1, 12))):
        if array:
            array[int(rng.integers(len(array)))] ^= 1 << int(rng.integers(8))
    return bytes(array)


def zero(data: bytes, rng: np.random.Generator) -> bytes:
    """A stretch becomes zeros."""
    a, b = _stretch(data, rng)
    return data[:a] + bytes(b - a) + data[b:]


def double(data: bytes, rng: np.random.Generator) -> bytes:
    """A stretch comes twice."""
    a, b = _stretch(data, rng)
    return data[:b] + data[a:b] + data[b:]


def drop(data: bytes, rng: np.random.Generator) -> bytes:
    """A stretch is gone."""
    a, b = _stretch(data, rng)
    return data[:a] + data[b:]


def swap(data: bytes, rng: np.random.Generator) -> bytes:
    """Two stretches change places."""
    a, b, c, d = np.sort([*_stretch(data, rng), *_stretch(data, rng)])
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def cut(data: bytes, rng: np.random.Generator) -> bytes:
    """The end is gone."""
    return data[: _at(data, rng)]


def insert(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes that do not belong there."""
    at = _at(data, rng)
    return data[:at] + rng.bytes(int(rng.integers(1, 40))) + data[at:]


def odd_number(data: bytes, rng: np.random.Generator) -> bytes:
    """One number of a text becomes an odd one."""
    result = list(_NUMBER.finditer(data))
    if not result:
        return odd_word(data, rng)
    match = result[int(rng.integers(len(result)))]
    odd = _ODD_NUMBERS[int(rng.integers(len(_ODD_NUMBERS)))]
    if rng.random() < 0.3:  # of the same width, which fixed columns ask for
        odd = odd[: len(match[0])].rjust(len(match[0]))
    return data[: match.start()] + odd + data[match.end() :]


def odd_word(data: bytes, rng: np.random.Generator) -> bytes:
    """One binary number becomes an odd one."""
    word = _ODD_WORDS[int(rng.integers(len(_ODD_WORDS)))]
    at = _at(data, rng) // 4 * 4
    return data[:at] + word + data[at + len(word) :]


def other_reference(data: bytes, rng: np.random.Generator) -> bytes:
    """One entity of a STEP file names another one."""
    result = list(_REFERENCE.finditer(data))
    if not result:
        return odd_number(data, rng)
    match, other = (result[int(k)] for k in rng.integers(len(result), size=2))
    return data[: match.start()] + other[0] + data[match.end() :]


def _lines(change: Callable[[list[bytes], np.random.Generator], None]) -> Change:
    def changed(data: bytes, rng: np.random.Generator) -> bytes:
        lines = data.splitlines(keepends=True)
        if lines:
            change(lines, rng)
        return b"".join(lines)

    return changed


@_lines
def drop_lines(lines: list[bytes], rng: np.random.Generator) -> None:
    """Some lines are gone."""
    at = int(rng.integers(len(lines)))
    del lines[at : at + int(rng.integers(1, 4))]


@_lines
def double_lines(lines: list[bytes], rng: np.random.Generator) -> None:
    """Some lines come twice."""
    at = int(rng.integers(len(lines)))
    lines[at:at] = lines[at : at + int(rng.integers(1, 4))]


@_lines
def swap_lines(lines: list[bytes], rng: np.random.Generator) -> None:
    """Two lines change places."""
    a, b = (int(k) for k in rng.integers(len(lines), size=2))
    lines[a], lines[b] = lines[b], lines[a]


CHANGES: tuple[Change, ...] = (
    *(change_bytes, flip_bits, zero, double, drop, swap, cut, insert),
    *(odd_number, odd_number, odd_number, odd_word, other_reference, other_reference),
    *(drop_lines, double_lines, swap_lines),
)


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """`data` after one change, seldom two or three."""
    for _ in range(1 + int(rng.geometric(0.7) - 1) % 3):
        data = CHANGES[int(rng.integers(len(CHANGES)))](data, rng)
    return data
