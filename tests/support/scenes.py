"""Texts of scenes from Python's own values."""

import json
import re



def plane(axis, at):
    """The selection of all vertices on this plane."""
    return {"plane": {"axis": axis, "at": at}}


def tables(**sections):
    """The sections of a scene: a dictionary makes one table, a list of dictionaries a table for each."""
    text = "\n"
    for name, content in sections.items():
        for table in content if isinstance(content, list) else [content]:
            text += f"[[{name}]]\n" if isinstance(content, list) else f"[{name}]\n"
            text += "".join(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())
    return text


def _key(key):
    return key if re.fullmatch(r"[\w-]+", key) else json.dumps(key)


def _value(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)
