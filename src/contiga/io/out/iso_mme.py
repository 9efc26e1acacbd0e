"""Signals in ISO/TS 13499 (ISO-MME): a folder of text files, one per channel.

    TEST/TEST.mme              about the test
    TEST/Channel/TEST.chn      the list of channels
    TEST/Channel/TEST.001 …    one channel: a head of "name :value" lines, then a number a line

A channel's code has 16 characters: test object, position, main location (4), fine locations
(3 × 2), physical dimension (2), direction and filter class.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.errors import FileError, InputError, OutputError
from contiga.io.naming import closest, listed
from contiga.io.out.files import write_text
from contiga.records import FloatArray

EDITION = "1.6"
_NONE = "NOVALUE"
_WIDTH = 28
_CODE = re.compile(r"[A-Z0-9?]{16}")
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
MAX_CHANNELS = 999


class MmeChannel(NamedTuple):
    """A signal at equal intervals."""

    code: str
    """Code of 16 characters."""
    name: str
    unit: str
    """Unit in the format's notation, such as ``m/(s*s)``."""
    start: float
    """Time of the first sample, s."""
    interval: float
    """Time between samples, s."""
    values: FloatArray
    """(n,) values."""
    filter: str = _NONE
    """Channel frequency class, such as "1000"."""


def write_mme(
    folder: Path, test: str, channels: Sequence[MmeChannel], *, title: str, comment: str = ""
) -> Path:
    """Write a test into a new folder of its name in `folder`; return that folder.

    `folder` is made if it does not exist. Channels are numbered from 001 in their order.

    Raises
    ------
    InputError
        The test has no valid file name, a code is invalid or not unique, or there is no channel or
        more than 999.
    OutputError
        The folder exists already, or it cannot be written; nothing is left then.
    """
    if not _NAME.fullmatch(test):
        raise InputError(
            "is not a test name", where="test", found=test, allowed="letters, digits, _ - ."
        )
    _check_codes(channels)
    out = folder / test
    try:
        folder.mkdir(parents=True, exist_ok=True)
        out.mkdir()  # never an existing folder: on an error it is removed as a whole
    except OSError as error:
        raise OutputError(
            f"the folder cannot be made: {error.strerror}", where=str(out), allowed="a new folder"
        ) from error
    try:
        (out / "Channel").mkdir()
        about = [
            ("Data format edition number", EDITION),
            ("Laboratory name", _NONE),
            ("Laboratory test ref. number", test),
            ("Customer name", _NONE),
            ("Customer test ref. number", _NONE),
            ("Title", title),
            ("Medium No./number of media", "1/1"),
            ("Timestamp", _NONE),
            ("Type of the test", "Simulation"),
            ("Subtype of the test", _NONE),
            ("Regulation", _NONE),
            ("Comments", comment),
        ]
        write_text(out / f"{test}.mme", _lines(about))
        contents = [
            ("Instrumentation standard", _NONE),
            ("Number of channels", str(len(channels))),
        ]
        for k, channel in enumerate(channels, start=1):
            write_text(out / "Channel" / f"{test}.{k:03d}", _channel(channel))
            contents.append((f"Name of channel {k:03d}", f"{channel.code} / {channel.name}"))
        write_text(out / "Channel" / f"{test}.chn", _lines(contents))
    except BaseException:
        shutil.rmtree(out, ignore_errors=True)
        raise
    return out


def _check_codes(channels: Sequence[MmeChannel]) -> None:
    """Refuse no channels, more than `MAX_CHANNELS`, and codes that are invalid or repeated."""
    if not 0 < len(channels) <= MAX_CHANNELS:
        raise InputError(
            "must be some channels",
            where="channels",
            found=len(channels),
            allowed=f"1 … {MAX_CHANNELS}",
        )
    names: dict[str, str] = {}
    for code, name in ((channel.code, channel.name) for channel in channels):
        if not _CODE.fullmatch(code):
            fault = f"is not a channel code, of {name!r}"
        elif code in names:
            fault = f"is there twice, of {names[code]!r} and of {name!r}"
        else:
            names[code] = name
            continue
        raise InputError(
            fault, where="code", found=code, allowed="16 capital letters and digits, each once"
        )


def _channel(channel: MmeChannel) -> str:
    """Return the text of the file of a channel."""
    head = [
        ("Test object number", channel.code[0]),
        ("Name of the channel", channel.name),
        ("Laboratory channel code", _NONE),
        ("Customer channel code", _NONE),
        ("Channel code", channel.code),
        ("Comments", _NONE),
        ("Location", _NONE),
        ("Dimension", channel.code[12:14]),
        ("Direction", channel.code[14]),
        ("Channel frequency class", channel.filter),
        ("Unit", channel.unit),
        ("Reference system", _NONE),
        ("Transducer type", _NONE),
        ("Pre-filter type", _NONE),
        ("Cut off frequency", _NONE),
        ("Channel amplitude class", _NONE),
        ("Sampling interval", repr(float(channel.interval))),
        ("Bit resolution", _NONE),
        ("Time of first sample", repr(float(channel.start))),
        ("Number of samples", str(len(channel.values))),
        ("Reference channel", "implicit"),
        ("Reference channel name", _NONE),
        ("Data source", "simulation"),
        ("Data status", "ok"),
    ]
    return _lines(head) + "".join(f"{value!r}\n" for value in channel.values.tolist())


def _lines(head: Iterable[tuple[str, str]]) -> str:
    # One line each, even if a title contains line ends.
    return "".join(f"{name:<{_WIDTH}}:{' '.join(value.split()) or _NONE}\n" for name, value in head)


def read_mme(path: Path, code: str | None = None) -> MmeChannel:
    """Read one channel of a test.

    Parameters
    ----------
    path : file of a channel, or of a test (.mme), whose channels are in the folder ``Channel``, in
        any case, beside it
    code : code of the channel, or its first characters, in any case; needed for a test of several
        channels, and ignored for the file of a channel

    Raises
    ------
    FileError
        One of the files cannot be read or has another format, a sample is not finite; the test has
        no such channel, or several.
    """
    if path.suffix.lower() != ".mme":
        return _read_channel(path)
    folder = next((p for p in path.parent.iterdir() if p.name.lower() == "channel"), None)
    files = [] if folder is None else sorted(folder.glob(f"{path.stem}.[0-9][0-9][0-9]"))
    if not files:
        raise FileError(
            "the test has no channel files",
            where=str(path),
            allowed=f"Channel/{path.stem}.001 and so on",
        )
    channels = [_read_channel(file) for file in files]
    matches = [c for c in channels if code is None or c.code.startswith(code.upper())]
    if len(matches) != 1:
        raise FileError(
            "which channel is meant?" if matches else "the test has no such channel",
            where=str(path),
            found=code,
            allowed=listed(channel.code for channel in matches or channels),
            remedy="Name its code" if code is None else closest(code, (c.code for c in channels)),
        )
    return matches[0]


def _read_channel(path: Path) -> MmeChannel:
    """Return the channel in a file of lines "name :value", then one number in each line.

    Numbers may have a decimal comma; blank lines are skipped. Of what the head lacks the time of
    the first sample is 0, texts are empty, and the filter is NOVALUE.

    Raises
    ------
    FileError
        It cannot be read, has no sampling interval above zero, fewer than two samples, or one that
        is not finite.
    """
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    head = {}
    for line in lines:
        name, colon, text = (part.strip() for part in line.partition(":"))
        if colon:
            head[name.lower()] = "" if text.upper() == _NONE else text
    begin = next((k for k, line in enumerate(lines) if line.strip() and ":" not in line), 0)
    values = []
    for k, line in enumerate(lines[begin:], begin + 1):
        if not line.strip():
            continue
        try:
            value = float(line.replace(",", "."))
        except ValueError:
            value = float("nan")
        if not isfinite(value):
            raise FileError(
                "a sample is not a finite number", where=f"{path}:{k}", found=line.strip()
            )
        values.append(value)
    try:
        interval = float(head["sampling interval"].replace(",", "."))
        start = float(head.get("time of first sample", "0").replace(",", "."))
    except (KeyError, ValueError) as error:
        raise FileError(
            "is not a channel of ISO-MME: it has no sampling interval", where=str(path)
        ) from error
    if not interval > 0.0 or len(values) < 2:
        raise FileError(
            "a channel needs a sampling interval above zero and two samples or more",
            where=str(path),
            found=f"{interval:g} s, {len(values)} samples",
        )
    return MmeChannel(
        head.get("channel code", ""),
        head.get("name of the channel", ""),
        head.get("unit", ""),
        start,
        interval,
        np.array(values),
        head.get("channel frequency class") or _NONE,
    )
