"""Display in notebooks: images with tabs for layers and exposures, and results of split checks."""

import base64
import html
import itertools

from . import _raylex
from ._raylex import Check, Image, Verdict

_numbers = itertools.count()
EXPOSURES = (-2, 0, 2)
MOST_LAYERS = 24
LARGEST_SIDE = 480

_STYLE = """<style>
.raylex{font:13px sans-serif;color:#222;background:#fff;padding:6px;display:inline-block}
.raylex input{position:absolute;opacity:0}
.raylex label{display:inline-block;padding:2px 8px;margin:0 2px 4px 0;border:1px solid #bbb}
.raylex label{border-radius:3px;cursor:pointer}
.raylex input:checked+label{background:#235;color:#fff}
.raylex input:focus-visible+label{outline:2px solid #58f}
.raylex .panel{display:none}.raylex code{background:#eee;padding:0 3px}
.raylex .holds{color:#060}.raylex .fails{color:#a00;font-weight:bold}
</style>"""


def _tabs(name, labels, panels, chosen=0):
    """Returns radio buttons and their panels, without scripts, so that they work in untrusted notebooks and in
    print."""
    rules, buttons = [], []
    for i, label in enumerate(labels):
        rules.append(f"#{name}_{i}:checked~.{name}_{i}{{display:block}}")
        checked = " checked" if i == chosen else ""
        buttons.append(f'<input type="radio" name="{name}" id="{name}_{i}"{checked}>'
                       f'<label for="{name}_{i}">{html.escape(label)}</label>')
    shown = [f'<div class="panel {name}_{i}">{panel}</div>' for i, panel in enumerate(panels)]
    return f"<style>{''.join(rules)}</style><div>{''.join(buttons)}{''.join(shown)}</div>"


def _img(image, layer, exposure):
    png = base64.b64encode(_raylex._png(image, layer, float(exposure), LARGEST_SIDE)).decode()
    return f'<img alt="{html.escape(layer)}, {exposure:+d} stops" src="data:image/png;base64,{png}">'


def _layer(image, layer, name):
    caption = ""
    if layer in image.expressions:
        caption = f"<div><code>{html.escape(image.expressions[layer])}</code></div>"
    if not _raylex._is_light(image, layer):
        return caption + _img(image, layer, 0)
    stops = [f"{each:+d} stops" if each else "0 stops" for each in EXPOSURES]
    return caption + _tabs(name, stops, [_img(image, layer, each) for each in EXPOSURES], EXPOSURES.index(0))


def verdict_html(verdict):
    """Returns one line with the result, the largest error and the reason for the bound."""
    kind, word = ("holds", "sum to") if verdict.holds else ("fails", "DO NOT SUM to")
    if not verdict.judged:
        word = "cannot be checked (every pixel is clamped) against"
    return (f'<div class="{kind}">{html.escape(verdict.partition or "layers")}: {len(verdict.layers)} layers {word} '
            f"{html.escape(verdict.of)}; largest relative error {verdict.largest_relative:.3g}, "
            f"bound {verdict.bound:.3g}</div>")


def image_html(image):
    """Returns the image with a tab for each layer, exposures for light, and the results of its partitions."""
    number = next(_numbers)
    shown = [name for name in image.names if name != "alpha"][:MOST_LAYERS]
    panels = [_layer(image, name, f"raylex{number}x{i}") for i, name in enumerate(shown)]
    left = len(image.names) - len(shown) - ("alpha" in image)
    more = f"<div>and {left} more layers</div>" if left > 0 else ""
    verdicts = "".join(verdict_html(each) for each in image.verify()) if image.partitions else ""
    told = "" if image.complete else '<div class="fails">incomplete: the render was stopped</div>'
    return f'<div class="raylex">{_STYLE}{told}{_tabs(f"raylex{number}", shown, panels)}{more}{verdicts}</div>'


def check_html(check):
    """Returns a proof's result, with the counterexample if there is one."""
    kind = "holds" if check.holds else "fails"
    path = "" if check.counterexample is None else f"<div><code>{html.escape(check.counterexample.text)}</code></div>"
    return f'<div class="raylex">{_STYLE}<div class="{kind}">{html.escape(check.summary)}</div>{path}</div>'


Image._repr_html_ = image_html
Check._repr_html_ = check_html
Verdict._repr_html_ = lambda verdict: f'<div class="raylex">{_STYLE}{verdict_html(verdict)}</div>'
