"""raylex.render: converts keyword arguments to a job for the program's reader."""

import difflib
import inspect
import os
import re

from . import _raylex
from ._toml import text_of


def _names(value):
    """Returns a list of names; a single name becomes a list of one."""
    return [value] if isinstance(value, str) else list(value)


def _channels(lpe, dialect, declared=None):
    tables = [{"name": name, "type": kind} for name, kind in (declared or {}).items()]
    pairs = list(lpe.items() if isinstance(lpe, dict) else lpe or ())
    if not all(isinstance(pair, (tuple, list)) and len(pair) == 2 and all(isinstance(each, str) for each in pair)
               for pair in pairs):
        raise TypeError(f"lpe is {lpe!r}; expected {{name: expression, ...}}")
    for name, expression in pairs:
        table = {"name": name, "lpe": expression}
        for known in ("osl", "renderman"):
            if expression.startswith(known + ":"):
                table.update(lpe=expression[len(known) + 1:], dialect=known)
        tables.append({"dialect": dialect, **table})
    return tables


def _partitions(partitions):
    tables = []
    for name, what in (partitions or {}).items():
        tables.append({"name": name, **(what if isinstance(what, dict) else {"channels": _names(what)})})
    return tables


def _entity(value):
    return {"type": value} if isinstance(value, str) else value


def _seconds(time):
    return time if time is None or isinstance(time, str) else f"{time}s"


# How arguments become values of a job's keys; all others are the values themselves.
_CONVERSIONS = {
    "aovs": _names,
    "cryptomatte": _names,
    "plugins": _names,
    "integrator": _entity,
    "sampler": _entity,
    "filter": _entity,
    "sample_filters": lambda filters: [_entity(each) for each in filters],
    "statistics": lambda statistics: {name: _names(kinds) for name, kinds in statistics.items()},
    "partitions": _partitions,
    "time": _seconds,
}
_OBJECT = "a type, or {'type': ..., parameter: value}"
# The forms of arguments that differ from the values of flags.
_FORMS = {
    "output": "without it, no file is written",
    "time": "seconds, or text such as '5m'",
    "integrator": _OBJECT,
    "sampler": _OBJECT,
    "filter": _OBJECT,
    "sample_filters": "a list; of each, " + _OBJECT,
    "resolution": "(width, height)",
    "crop": "(x0, y0, x1, y1)",
    "lpe": "{layer: light path expression}",
    "partitions": "{name: [layers]} or {name: {'channels': [layers], 'rest': layer, 'of': layer}}",
    "beauty": "False",
    "channels": "{name: type}",
    "statistics": "{layer: ['mse', 'variance', 'even', 'odd']}",
    "passes": "[{'method': integrator, 'takes': class, 'spp': N, parameter: value}, ...]",
    "atlas": "file, or {'file': ..., 'by': 'label,lobe,group', 'length': 12, 'budget': '2GiB'}",
}
_SETTINGS = {name: (key, help) for name, key, help in _raylex._settings()}


def job_text(scene, *, job=None, **arguments):
    """Returns the job of :func:`render` with the same arguments, as TOML, which ``raylex render`` accepts as a file."""
    for name in arguments:
        if name not in _SETTINGS:
            near = difflib.get_close_matches(name, [*_SETTINGS, "job", "progress", "scene"], 1)
            raise TypeError(f"render() has no argument '{name}'" + (f"; did you mean '{near[0]}'?" if near else ""))
    given = {name: value for name, value in arguments.items() if value is not None}
    tables = {
        "scene": {"file": scene.file if isinstance(scene, _raylex.Scene) else os.fspath(scene)},
        "channel": _channels(given.pop("lpe", None), given.pop("dialect", "renderman"), given.pop("channels", None)),
    }
    for name, value in given.items():
        table, _, key = _SETTINGS[name][0].removesuffix(".NAME").partition(".")
        value = _CONVERSIONS.get(name, lambda value: value)(value)
        if key and not (name == "atlas" and isinstance(value, dict)):
            tables.setdefault(table, {})[key] = value
        else:
            tables[table] = value
    for name, value in (job or {}).items():
        known = tables.get(name)
        tables[name] = {**known, **value} if isinstance(known, dict) and isinstance(value, dict) else value
    return text_of({name: value for name, value in tables.items() if value not in ({}, [])})


def render(scene, *, progress=None, **arguments):
    if progress is not None and not callable(progress):
        raise TypeError(f"progress is {progress!r}; expected a function that takes a Progress")
    return _raylex._render(job_text(scene, **arguments), scene if isinstance(scene, _raylex.Scene) else None, progress)


def _describe():
    keyword = inspect.Parameter.KEYWORD_ONLY
    render.__signature__ = inspect.Signature(
        [inspect.Parameter("scene", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
        + [inspect.Parameter(name, keyword, default=None) for name in (*_SETTINGS, "job", "progress")])
    lines = ["Renders a scene to an :class:`Image`.", "", ":param scene: a pbrt-v4 file or a :class:`Scene`"]
    for name, (_, help) in _SETTINGS.items():
        plain = re.sub(r"--([a-z-]+)", lambda match: match[1].replace("-", "_"), help)
        lines.append(f":param {name}: " + (f"{_FORMS[name]}: " if name in _FORMS else "") + plain)
    lines += [
        ":param job: further tables of a job, {'exr': {'light': 'half zip'}, ...}; "
        "experiments/docs/rendering/settings.md lists the keys",
        ":param progress: called a few times a second with a :class:`Progress`; returning False ends the render",
        ":raises RaylexError: invalid input, with file and line; ``render()`` stands for the text of :func:`job_text`",
        ":raises Exception: an exception of a callback, or KeyboardInterrupt; its attribute ``image`` is the image "
        "rendered so far"]
    render.__doc__ = "\n".join(lines)


_describe()
