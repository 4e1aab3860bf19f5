"""raylex.render: converts keyword arguments to a job for the program's reader."""

import difflib
import inspect
import os

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


def job_text(scene, *, spp=None, seed=None, threads=None, resolution=None, crop=None, max_depth=None, integrator=None,
             sampler=None, filter=None, lpe=None, dialect="renderman", aovs=(), channels=None, light_groups=False,
             shipped=False, partitions=None, beauty=None, statistics=None, sample_filters=(), cryptomatte=(), time=None,
             until_error=None, plugins=(), output=None, atlas=None, job=None):
    """Returns the job of :func:`render` with the same arguments, as TOML, which ``raylex render`` accepts as a file."""
    file = scene.file if isinstance(scene, _raylex.Scene) else os.fspath(scene)
    tables = {
        "plugins": _names(plugins) or None,
        "scene": {"file": file},
        "render": {"spp": spp, "seed": seed, "threads": threads, "crop": crop, "max_depth": max_depth,
                   "resolution": resolution, "beauty": beauty, "time": _seconds(time)},
        "integrator": _entity(integrator),
        "sampler": _entity(sampler),
        "filter": _entity(filter),
        "channels": {"aovs": _names(aovs) or None, "cryptomatte": _names(cryptomatte) or None,
                     "light_groups": light_groups or None, "shipped_partition": shipped or None,
                     "statistics": {k: _names(v) for k, v in statistics.items()} if statistics else None},
        "output": {"file": None if output is None else os.fspath(output)},
        "atlas": atlas if atlas is None or isinstance(atlas, dict) else {"file": os.fspath(atlas)},
        "adaptive": None if until_error is None else {"error": until_error},
        "channel": _channels(lpe, dialect, channels),
        "partition": _partitions(partitions),
        "sample_filter": [_entity(each) for each in sample_filters],
    }
    for name, value in (job or {}).items():
        given = tables.get(name)
        tables[name] = {**given, **value} if isinstance(given, dict) and isinstance(value, dict) else value
    return text_of({name: value for name, value in tables.items() if value not in ({}, [])})


def render(scene, *, progress=None, **arguments):
    """Renders a scene to an :class:`Image`.

    :param scene: a pbrt-v4 file or a :class:`Scene`
    :param spp: samples per pixel; by default the scene's
    :param seed: seed of the sampler; equal seeds give equal bits for any number of threads
    :param threads: number of threads; 0: all cores
    :param resolution: (width, height) in pixels
    :param crop: (x0, y0, x1, y1): renders only this rectangle
    :param max_depth: maximum number of scattering events of a path
    :param integrator, sampler, filter: a type, or {"type": ..., parameter: value}
    :param lpe: {layer: light path expression}; if the channels share no path, a layer 'rest' is added and the sum is
        proved
    :param dialect: dialect of the expressions, 'renderman' or 'osl'
    :param aovs: geometric AOVs by name: 'Nn', 'P', 'z', 'albedo', ...
    :param channels: {name: type}: layers that plugins write to; a type is 'float', 'rgb', 'point', 'normal', 'vector' or
        'integer'
    :param light_groups: True: adds a layer for each light group
    :param shipped: True: adds the layers of the shipped partition
    :param partitions: {name: [channels]} or {name: {"channels": [...], "rest": layer, "of": channel}}; proved before a
        ray is traced
    :param beauty: False: simulates only the light that the layers need
    :param statistics: {channel: ['mse', 'variance', 'even', 'odd']}: layers CHANNEL_mse ...
    :param sample_filters: types, or {"type": ..., parameter: value}
    :param cryptomatte: kinds of cryptomattes: 'object', 'material', 'asset'
    :param time: time limit in seconds, or as '5m'
    :param until_error: 0.01: samples each pixel until its standard error is 1 % of its value
    :param plugins: files of C++ plugins
    :param output: an OpenEXR file that is written as well
    :param atlas: a file for the path atlas (:class:`raylex.Atlas`), or {"file": ..., "by": "label,lobe,group", "length": 12,
        "budget": "2GiB"}
    :param job: further tables of a job, {"exr": {"light": "half zip"}, ...}; experiments/docs/rendering/jobs.md
        lists every key
    :param progress: called a few times a second with a :class:`Progress`; returning False ends the render
    :raises RaylexError: invalid input, with file and line; ``render()`` stands for the text of :func:`job_text`
    :raises Exception: an exception of a callback, or KeyboardInterrupt; its attribute ``image`` is the image rendered
        so far
    """
    if progress is not None and not callable(progress):
        raise TypeError(f"progress is {progress!r}; expected a function that takes a Progress")
    known = inspect.signature(job_text).parameters
    for name in arguments:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise TypeError(f"render() has no argument '{name}'" + (f"; did you mean '{near[0]}'?" if near else ""))
    return _raylex._render(job_text(scene, **arguments), scene if isinstance(scene, _raylex.Scene) else None, progress)
