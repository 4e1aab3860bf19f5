"""Integrators, textures and sample filters written in Python.

They stand behind the same registries as plugins in C++: scenes and jobs ask for them by name, light path expressions,
studies and every output work with them. They are called with arrays of a batch at a time, some hundred rows, one thread
at a time, and are slow: experiments/docs/measured.md says how slow. They are for trying an idea before it is written in
C++ (experiments/docs/extending.md). Same seed, same bits holds when they draw all numbers from the batch and keep
nothing between calls.

>>> @raylex.integrator("direct")
... class Direct:
...     def integrate(self, batch):
...         points = batch.trace()
...         batch.add_emission(points, 1)
...         batch.add_background(points, 1)
...         light = points.sample_light(batch.numbers(0, points.rows), batch.numbers_2d(1, points.rows))
...         f = points.evaluate(light.wi)
...         seen = light.visible() & (light.pdf > 0)
...         batch.add_light(points, f, light, f.value * light.radiance * (seen / np.maximum(light.pdf, 1e-30))[:, None])
>>> raylex.render("scene.pbrt", integrator="direct")
"""

import inspect
from typing import NamedTuple

from . import _raylex
from ._raylex import Batch, Evaluation, LightSamples, Points, Sample, Samples, TextureServices, load_plugin

__all__ = ["Batch", "Evaluation", "LightSamples", "Points", "Sample", "Samples", "TexturePoints", "TextureServices",
           "integrator", "load_plugin", "sample_filter", "texture"]


class TexturePoints(NamedTuple):
    """Where a texture is asked for: a row for each point."""

    uv: "np.ndarray"
    """float32 (points, 2): texture coordinates"""
    position: "np.ndarray"
    """float32 (points, 3): in the space that the texture was defined in"""
    normal: "np.ndarray"
    """float32 (points, 3): geometric, unit; 0 where it is not known"""
    services: "TextureServices"
    """``services.write(name, values)`` writes to a channel where the camera sees the points"""

    def __len__(self):
        return self.uv.shape[0]


def _defaults(made):
    """{parameter: default} of what makes an instance."""
    if not isinstance(made, type) or made.__init__ is object.__init__:
        return {}
    defaults = {}
    for name, parameter in list(inspect.signature(made.__init__).parameters.items())[1:]:
        if parameter.default is inspect.Parameter.empty:
            raise TypeError(f"{made.__name__}.__init__ takes {name!r} without a default; expected one, for its type")
        defaults[name] = parameter.default
    return defaults


def _decorator(register, name, method):
    def decorate(made):
        if not callable(getattr(made, method, None)):
            raise TypeError(f"{made.__name__} has no method {method}(); expected one")
        help = (made.__doc__ or "written in Python").strip().splitlines()[0]
        register(name, made, help, _defaults(made))
        return made
    return decorate


def integrator(name):
    """Registers a class as an integrator. ``integrate(self, batch)`` answers a :class:`Batch`; what ``__init__`` takes,
    each with a default, are its parameters. A parameter ``maxdepth`` is what max_depth= sets. Registering the name
    again replaces it."""
    return _decorator(_raylex._register_integrator, name, "integrate")


def texture(name):
    """Registers a class as a texture, for scenes: ``Texture "x" "spectrum" "NAME"``. ``evaluate(self, at)`` gets
    :class:`TexturePoints` and returns (points, 3) for "spectrum" textures (in the rendering space, not clamped),
    (points,) for "float" ones."""
    return _decorator(_raylex._register_texture, name, "evaluate")


def sample_filter(name):
    """Registers a class as a sample filter. ``apply(self, samples)`` changes :class:`Samples` in place. A class
    attribute ``keeps_splits = True`` says that it scales the beauty and all its layers alike; else partitions are not
    declared."""
    return _decorator(_raylex._register_sample_filter, name, "apply")
