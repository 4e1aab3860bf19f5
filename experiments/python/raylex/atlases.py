"""Path atlases: render once, ask later. :class:`Atlas` is what ``render(atlas="scene.atlas.exr")`` left."""

import html
import os

from . import _raylex
from ._raylex import Atlas
from .lpe import _channels

__all__ = ["Atlas", "WordsAt", "merge"]


def _ask(self, lpe=None, *, dialect="renderman", shipped=False, light_groups=False, intervals=False, errors=False):
    """Layers from the words, without a ray: an :class:`Image` as :func:`raylex.render` with these arguments gives it.

    :param lpe: {layer: light path expression}; channels that share no path get a layer 'rest', proved to sum
    :param dialect: of the expressions, 'renderman' or 'osl'
    :param shipped: the layers of the shipped partition
    :param light_groups: a layer for each light group
    :param intervals: True: a layer that the atlas cannot tell exactly becomes two, NAME_least and NAME_most, between
        which it lies; by default it is refused
    :param errors: True: NAME_error beside each layer, the standard error of its mean (R + G + B) / 3
    :raises RaylexError: an expression that does not parse, or would tell apart what the atlas keeps together
    """
    return self._ask(_channels(lpe or {}, dialect), shipped, light_groups, intervals, errors)


def _at(self, x, y, top=20):
    """Why is this pixel bright: the `top` words that make it so, with standard errors, as :class:`PixelWords`.

    :param x, y: the pixel, from the top left corner
    """
    pixel = self._at(x, y, top)
    return WordsAt(self, x, y, pixel)


def _suggest(self, count=4):
    """A partition that isolates what is noisy: `count` layers and the rest, each with its shares of noise and light.

    ``atlas.ask({each.name: each.expression for each in atlas.suggest() if each.expression})`` makes it.
    """
    return self._suggest(count)


def _entries(self):
    """Everything, as NumPy arrays: {'begin': int64 (height * width + 1,), 'word': int32 (n,), 'rgb': float32 (n, 3),
    'parts': float32 (n, 8), 'samples': float32 (height, width, 8)}.

    The words of pixel p = y * width + x are entries begin[p] to begin[p + 1]; 'parts' is which share of an entry's
    luminance each eighth of the samples brought, 'samples' how many of them the pixel had.
    """
    return self._entries()


def _verify(self):
    """Whether all words sum to the beauty beside them, pixel by pixel: an :class:`AtlasVerdict`."""
    return self._verify()


class WordsAt:
    """Words of a pixel, with their texts; what it has beside that is of :class:`PixelWords`."""

    def __init__(self, atlas, x, y, pixel):
        texts = atlas.words
        self.x, self.y, self._pixel = x, y, pixel
        self.texts = [texts[word.number] for word in pixel.words]

    def __getattr__(self, name):
        return getattr(self._pixel, name)

    def __len__(self):
        return len(self._pixel.words)

    def __iter__(self):
        """(text, AtlasWord), the brightest first."""
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
    """One atlas of several: renders of one scene with different seeds, in any order.

    :returns: the merged :class:`Atlas`, written to `output`
    """
    _raylex._merge_atlases([os.fspath(path) for path in paths], os.fspath(output))
    return Atlas(output)


for _name, _method in {"ask": _ask, "at": _at, "suggest": _suggest, "entries": _entries, "verify": _verify}.items():
    _method.__name__ = _name
    setattr(Atlas, _name, _method)
