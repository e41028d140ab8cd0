"""TOML text of Python values. The standard library reads TOML but does not write it."""

import json
import math
import numbers
from collections.abc import Mapping
from typing import Any

import numpy as np


def value_text(value: Any) -> str:
    """The value as TOML on one line.

    Numbers are written so that they read back as the same number. Arrays of NumPy are lists, and mappings
    are inline tables, in which None is left out.
    """
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        number = float(value)
        if math.isnan(number):
            return "nan"
        if math.isinf(number):
            return "inf" if number > 0 else "-inf"
        return repr(number)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if hasattr(value, "__fspath__"):
        return value_text(value.__fspath__())
    if isinstance(value, np.ndarray):
        return value_text(value.tolist())
    if isinstance(value, dict):
        entries = [f"{key_text(k)} = {value_text(v)}" for k, v in value.items() if v is not None]
        return "{ " + ", ".join(entries) + " }" if entries else "{}"
    if isinstance(value, (list, tuple, range)):
        return "[" + ", ".join(value_text(entry) for entry in value) + "]"
    raise TypeError(f"{value!r} of the type {type(value).__name__} has no place in a scene")


def key_text(key: str) -> str:
    """The key of a table, in quotation marks where it needs them."""
    if key and all(c.isascii() and (c.isalnum() or c in "_-") for c in key):
        return key
    return value_text(key)


def document_text(tables: Mapping[str, Any]) -> str:
    """A mapping of sections as TOML: a section is a mapping, or a list of mappings."""
    text = ""
    for name, table in tables.items():
        entries = table if isinstance(table, (list, tuple)) else [table]
        brackets = "[[{}]]\n" if isinstance(table, (list, tuple)) else "[{}]\n"
        for entry in entries:
            text += brackets.format(key_text(name))
            for key, value in entry.items():
                if value is not None:
                    text += f"{key_text(key)} = {value_text(value)}\n"
            text += "\n"
    return text
