"""raylex: light transport driven by light path expressions, from Python.

>>> import raylex
>>> image = raylex.render("scene.pbrt", spp=64, lpe={"caustics": "CDS+L"})
>>> image["caustics"].shape
(480, 640, 3)
>>> all(image.verify())
True

All light is scene-linear in the rendering space of the scene. Rows of images start at the top. Lengths are in world
units. ``raylex.lpe`` is the algebra of expressions. ``raylex.Atlas`` makes layers after the render.
``raylex.experiment`` runs studies. ``raylex.plugins`` documents integrators, textures and sample filters in Python.
"""

import os as _os
import sys as _sys

from .errors import RaylexError

_flags = _sys.getdlopenflags()
_sys.setdlopenflags(_flags | _os.RTLD_GLOBAL)  # C++ plugins link to symbols of this module
try:
    from . import _raylex
finally:
    _sys.setdlopenflags(_flags)

from . import atlases, experiment, lpe, notebook, plugins  # noqa: E402
from ._raylex import Atlas, Image, Progress, Scene, SceneBuilder, Verdict, load_plugin  # noqa: E402
from .images import Layer, Rebuild, compare, error_image, metrics, mix, picture, read  # noqa: E402
from .plugins import integrator, sample_filter, texture  # noqa: E402
from .rendering import render  # noqa: E402

__version__ = _raylex.version
__all__ = ["Atlas", "Image", "Layer", "Progress", "RaylexError", "Rebuild", "Scene", "SceneBuilder", "Verdict",
           "atlases", "compare", "error_image", "experiment", "integrator", "load_plugin", "lpe", "metrics", "mix",
           "picture", "plugins", "read", "render", "sample_filter", "texture"]
