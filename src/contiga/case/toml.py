"""A case written as TOML, with every default filled in and every path absolute."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from contiga.case.schema import Case

_MAX_WIDTH = 80


def resolved_toml(case: Case) -> str:
    """Return the case as TOML text that reads back as the same case from any folder.

    The standard library reads TOML and does not write it; this writes what a case can hold:
    tables, lists of tables, text, numbers and truth values.
    """
    data = case.model_dump(exclude_none=True, by_alias=True)
    lines = []
    # A key that is no table would belong to the table before it.
    for key, value in sorted(data.items(), key=lambda item: _is_table(item[1])):
        if isinstance(value, dict):
            lines += ["", f"[{key}]", *_pairs(value)]
        elif _is_table(value):
            for table in value:
                lines += ["", f"[[{key}]]", *_pairs(table)]
        else:
            lines.append(f"{key} = {value_text(value)}")
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    """Return whether a value is written as a table, or as several."""
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], dict)
    )


def _pairs(table: Mapping[str, Any]) -> list[str]:
    texts = []
    for key, value in table.items():
        is_bare = key.replace("-", "_").isidentifier() and key.isascii()
        texts.append(f"{key if is_bare else value_text(key)} = {value_text(value)}")
    return texts


def value_text(value: Any) -> str:
    """Return a value as TOML text: a table inline, a long list of lists on several lines.

    Numbers are written such that they read back as the same bits.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # A basic string of TOML is one of JSON, but for this one character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_pairs(value)) + " }" if value else "{}"
    items = [value_text(item) for item in value]
    flat = "[" + ", ".join(items) + "]"
    nested = any(isinstance(item, list) for item in value)
    if nested and len(flat) > _MAX_WIDTH:
        return "[\n" + "".join(f"  {item},\n" for item in items) + "]"
    return flat
