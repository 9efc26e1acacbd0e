"""MuJoCo's own contacts between bodies that contiga holds apart: switched off."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from contiga.errors import InputError

Pair = tuple[int, int]


def switch_off(model: Any, pairs: Iterable[Pair]) -> None:
    """See to it that geoms of two bodies do not touch: `model` is changed where that is needed.

    Pairs that the model excludes, or that cannot touch, are left as they are. Else the geoms of
    one of the two are switched off (contype and conaffinity 0), if they touch nothing besides.

    Raises
    ------
    InputError
        They touch other geoms too, or a pair is asked for by name: the model must say it.
    """
    wanted = sorted({(min(pair), max(pair)) for pair in pairs})
    for pair in wanted:
        _check_no_pair_by_name(model, pair)
    for pair in wanted:
        if not _touching(model, pair):
            continue
        for one in pair:
            geoms = _geoms(model, one)
            partners = {p[1 - p.index(one)] for p in wanted if one in p}
            if _touched(model, one) <= partners:
                model.geom_contype[geoms] = model.geom_conaffinity[geoms] = 0
                break
        else:
            raise InputError(
                "MuJoCo's own geoms of two coupled bodies touch each other, and others too",
                where="contacts",
                found=" and ".join(map(repr, _names(model, pair))),
                remedy=f"Write in the model: {_exclude(model, pair)}",
            )


def _geoms(model: Any, body: int) -> Any:
    """Numbers of the geoms of a body."""
    return np.flatnonzero(model.geom_bodyid == body)


def _names(model: Any, pair: Pair) -> list[str]:
    return [model.body(body).name or f"body {body}" for body in pair]


def _exclude(model: Any, pair: Pair) -> str:
    first, second = _names(model, pair)
    return f'<contact><exclude body1="{first}" body2="{second}"/></contact>'


def _touched(model: Any, body: int) -> set[int]:
    """Bodies whose geoms may touch those of `body`."""
    return {other for other in range(model.nbody) if _touching(model, (body, other))}


def _touching(model: Any, pair: Pair) -> bool:
    """Return whether MuJoCo would let geoms of two bodies touch, by their bits and kinship."""
    first, second = pair
    excluded = {(first << 16) + second, (second << 16) + first} & set(
        model.exclude_signature.tolist()
    )
    if first == second or excluded or _akin(model, pair):
        return False
    a, b = _geoms(model, first), _geoms(model, second)
    bits = model.geom_contype[a][:, None] & model.geom_conaffinity[b]
    back = model.geom_conaffinity[a][:, None] & model.geom_contype[b]
    return bool(((bits | back) != 0).any())


def _akin(model: Any, pair: Pair) -> bool:
    """Return whether two bodies are one, or parent and child, which MuJoCo leaves alone."""
    import mujoco

    welded = model.body_weldid
    a, b = (int(welded[body]) for body in pair)
    if a == b:
        return True
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT or 0 in (a, b):
        return False
    above = [int(welded[model.body_parentid[one]]) for one in (a, b)]
    return above[0] == b or above[1] == a


def _check_no_pair_by_name(model: Any, pair: Pair) -> None:
    """Pairs that are asked for by name touch whatever their bits."""
    for geoms in zip(model.pair_geom1, model.pair_geom2, strict=True):
        if {int(model.geom_bodyid[geom]) for geom in geoms} == set(pair):
            names = [model.geom(int(geom)).name or f"geom {geom}" for geom in geoms]
            raise InputError(
                "the model asks for a contact between geoms of two coupled bodies",
                where="contacts",
                found=" and ".join(map(repr, names)),
                remedy="Take its <pair> out of the model",
            )
