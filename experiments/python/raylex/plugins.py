"""Integrators, textures and sample filters written in Python.

They are in the same registries as C++ plugins: scenes and jobs use them by name, and light path expressions, studies
and all outputs work with them. raylex calls them with arrays of a batch, some hundred rows, from one thread at a time.
They are slow (experiments/docs/measured.md has figures) and serve to try an idea before it is written in C++
(experiments/docs/extending.md). Equal seeds give equal bits if a class draws all numbers from the batch and keeps no
state between calls.

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
    """The points at which a texture is evaluated, one row per point."""

    uv: "np.ndarray"
    """float32 (points, 2): texture coordinates"""
    position: "np.ndarray"
    """float32 (points, 3): in the space that the texture was defined in"""
    normal: "np.ndarray"
    """float32 (points, 3): geometric unit normal; 0 if unknown"""
    services: "TextureServices"
    """``services.write(name, values)`` writes to a channel at points that the camera sees"""

    def __len__(self):
        return self.uv.shape[0]


def _defaults(made):
    """Returns {parameter: default} of the constructor of a class."""
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
    """Registers a class as an integrator. ``integrate(self, batch)`` handles a :class:`Batch`. The arguments of
    ``__init__``, each with a default, are its parameters; max_depth= sets a parameter ``maxdepth``. Registering the
    name again replaces it."""
    return _decorator(_raylex._register_integrator, name, "integrate")


def texture(name):
    """Registers a class as a texture, for scenes: ``Texture "x" "spectrum" "NAME"``. ``evaluate(self, at)`` receives
    :class:`TexturePoints` and returns (points, 3) for "spectrum" textures (in the rendering space, not clamped),
    (points,) for "float" ones."""
    return _decorator(_raylex._register_texture, name, "evaluate")


def sample_filter(name):
    """Registers a class as a sample filter. ``apply(self, samples)`` changes :class:`Samples` in place. A class
    attribute ``keeps_splits = True`` declares that it scales the beauty and all its layers alike; otherwise partitions
    are not declared."""
    return _decorator(_raylex._register_sample_filter, name, "apply")
