"""Path atlases: new layers after the render. ``render(atlas="scene.atlas.exr")`` writes an :class:`Atlas`."""

import html
import os

from . import _raylex
from ._raylex import Atlas
from .images import _factors
from .lpe import _channels

__all__ = ["Atlas", "WordsAt", "merge"]


def _ask(self, lpe=None, *, dialect="renderman", shipped=False, light_groups=False, intervals=False, errors=False,
         what_if=None, light=None, mix=None):
    """Makes layers from the words, without tracing rays. Returns an :class:`Image` like :func:`raylex.render`.

    :param lpe: {layer: light path expression}; if the channels share no path, a layer 'rest' is added and the sum is
        proved
    :param dialect: dialect of the expressions, 'renderman' or 'osl'
    :param shipped: True: adds the layers of the shipped partition
    :param light_groups: True: adds a layer for each light group
    :param intervals: True: a layer that is not exact is replaced by its bounds, NAME_least and NAME_most;
        by default it is an error
    :param errors: True: adds NAME_error for each layer, the standard error of its mean (R + G + B) / 3
    :param what_if: {'OBJECT.LOBE': factor of its colour}, a number or three for red, green and blue
    :param light: {light group: factor}, such as {'key': 2, 'default': '+1stop'}
    :param mix: TOML file with more factors of both kinds
    :raises RaylexError: an expression that does not parse, or that distinguishes paths merged in the atlas
    """
    return self._ask(_channels(lpe or {}, dialect), shipped, light_groups, intervals, errors,
                     _factors(what_if, light, mix))


def _at(self, x, y, top=20):
    """Returns the `top` brightest words of a pixel, with standard errors, as :class:`PixelWords`.

    :param x, y: the pixel, counted from the top left corner
    """
    pixel = self._at(x, y, top)
    return WordsAt(self, x, y, pixel)


def _suggest(self, count=4):
    """Suggests a partition that isolates noise: `count` layers and the rest, each with its fractions of noise and
    light.

    ``atlas.ask({each.name: each.expression for each in atlas.suggest() if each.expression})`` makes its layers.
    """
    return self._suggest(count)


def _entries(self):
    """Returns all values as NumPy arrays: {'begin': int64 (height * width + 1,), 'word': int32 (n,), 'rgb': float32 (n,
    3), 'parts': float32 (n, 8), 'samples': float32 (height, width, 8)}.

    The words of pixel p = y * width + x are entries begin[p] to begin[p + 1] - 1. 'parts' is the fraction of an entry's
    luminance from each eighth of the samples, 'samples' the number of samples in each eighth.
    """
    return self._entries()


def _verify(self):
    """Checks in every pixel that all words sum to the beauty. Returns an :class:`AtlasVerdict`."""
    return self._verify()


class WordsAt:
    """Words of a pixel with their texts, and the attributes of the C++ class PixelWords."""

    def __init__(self, atlas, x, y, pixel):
        texts = atlas.words
        self.x, self.y, self._pixel = x, y, pixel
        self.texts = [texts[word.number] for word in pixel.words]

    def __getattr__(self, name):
        return getattr(self._pixel, name)

    def __len__(self):
        return len(self._pixel.words)

    def __iter__(self):
        """Iterates over (text, AtlasWord), the brightest first."""
        return iter(zip(self.texts, self._pixel.words))

    def __repr__(self):
        head = f"pixel ({self.x}, {self.y}): mean {self.mean:.4g} +- {self.error:.2g}"
        rows = [f"  {word.mean:10.4g} +- {word.error:<8.2g} {text}" for text, word in self]
        return "\n".join([head, *rows, *([f"  and {self.more} more"] if self.more else [])])

    def _repr_html_(self):
        rows = "".join(f"<tr><td>{100 * word.mean / self.mean if self.mean else 0:.1f} %</td>"
                       f"<td>{word.mean:.3g} &plusmn; {word.error:.2g}</td>"
                       f"<td style='text-align:left'><code>{html.escape(text)}</code></td></tr>" for text, word in self)
        more = f"<div>and {self.more} more</div>" if self.more else ""
        return (f"<div>pixel ({self.x}, {self.y}): mean {self.mean:.4g} &plusmn; {self.error:.2g}, "
                f"{self.samples:.0f} samples</div><table><tr><th>share</th><th>mean</th><th>path</th></tr>{rows}"
                f"</table>{more}")


def merge(paths, output):
    """Merges several atlases, in any order: renders of a scene with different seeds, or the shards of a render.

    :returns: the merged :class:`Atlas`, written to `output`
    """
    _raylex._merge_atlases([os.fspath(path) for path in paths], os.fspath(output))
    return Atlas(output)


for _name, _method in {"ask": _ask, "at": _at, "suggest": _suggest, "entries": _entries, "verify": _verify}.items():
    _method.__name__ = _name
    setattr(Atlas, _name, _method)
