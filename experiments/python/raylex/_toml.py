"""Converts Python values to the TOML of a job, the only format of render requests."""

import json
import os
from collections.abc import Mapping


def _string(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value, where):
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(float(value))  # "1e-05", "inf" and "nan" are valid TOML; NumPy 2 writes "np.float64(...)" itself
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_string(k)} = {_value(v, where)}" for k, v in value.items()) + "}"
    if hasattr(value, "tolist"):
        return _value(value.tolist(), where)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(each, where) for each in value) + "]"
    raise TypeError(f"{where} is {value!r}; expected a bool, number, string, list or dict")


def _is_tables(value):
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(each, Mapping) for each in value)


def text_of(tables):
    """Returns TOML for `tables`: {key: value}, {table: {key: value}}, {table: [{key: value}, ...]}. Omits None."""
    top, rest = [], []
    for name, value in tables.items():
        if value is None:
            continue
        if isinstance(value, Mapping):
            rest.append(f"[{_string(name)}]")
            rest += [f"{_string(k)} = {_value(v, f'{name}[{k!r}]')}" for k, v in value.items() if v is not None]
        elif _is_tables(value):
            for each in value:
                rest.append(f"[[{_string(name)}]]")
                rest += [f"{_string(k)} = {_value(v, f'{name}[{k!r}]')}" for k, v in each.items() if v is not None]
        else:
            top.append(f"{_string(name)} = {_value(value, name)}")
    return "\n".join(top + rest) + "\n"
