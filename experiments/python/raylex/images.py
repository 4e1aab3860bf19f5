"""Images: layers with names, dimensions and coordinates; metrics; checks; pictures."""

import os

import numpy as np

from . import _raylex
from ._raylex import Image


class Layer:
    """A layer of an image with the attributes of an xarray array: values, dims, coords, attrs. Values are not copied.

    :ivar values: float32 (height, width, components) or (height, width)
    :ivar dims: ('y', 'x', 'component') or ('y', 'x')
    :ivar coords: {'y': 0.5, 1.5, ... pixels from the top, 'x': from the left, 'component': names}
    """

    def __init__(self, image, name):
        self.name = name
        self.values = image[name]
        self.dims = ("y", "x", "component")[: self.values.ndim]
        self.coords = {"y": np.arange(image.height) + 0.5, "x": np.arange(image.width) + 0.5}
        if self.values.ndim == 3:
            self.coords["component"] = image.components(name)
        self.attrs = {"lpe": image.expressions[name]} if name in image.expressions else {}

    @property
    def shape(self):
        return self.values.shape

    def __array__(self, dtype=None):
        return np.asarray(self.values, dtype=dtype)

    def __dlpack__(self, **arguments):
        return self.values.__dlpack__(**arguments)

    def __dlpack_device__(self):
        return self.values.__dlpack_device__()

    def sel(self, component):
        """Returns the values of one component: sel('R')."""
        names = self.coords.get("component", [])
        if component not in names:
            raise KeyError(f"no component {component!r} in {self.name!r}; expected one of {names}")
        return self.values[..., names.index(component)]

    def to_xarray(self):
        """Converts the layer to an xarray.DataArray (Debian: python3-xarray)."""
        import xarray
        return xarray.DataArray(self.values, dims=self.dims, coords=self.coords, name=self.name, attrs=self.attrs)

    def __repr__(self):
        sizes = ", ".join(f"{dim}: {size}" for dim, size in zip(self.dims, self.shape))
        return f"Layer({self.name!r}: {sizes})"


def _view(self, name):
    """Returns the layer with dimensions, coordinates and its expression, as a :class:`Layer`."""
    return Layer(self, name)


def _to_xarray(self, names=None):
    """Returns the layers `names` (default: all) as an xarray.Dataset (Debian: python3-xarray)."""
    import xarray
    layers = [Layer(self, name) for name in (self.names if names is None else names)]
    return xarray.Dataset({layer.name: layer.to_xarray().drop_vars("component", errors="ignore").rename(
        {"component": f"component_{layer.shape[2]}"} if layer.values.ndim == 3 else {}) for layer in layers})


def _verify(self, of="", sums=(), preset="", tolerance=(0.0, 0.0)):
    """Checks in every pixel that layers sum to the layer that they split. Returns a list of :class:`Verdict`, true if
    the check holds.

    By default checks every partition that the image declares; with ``sums=['diffuse_*', 'emission']`` these layers
    against `of`; with ``preset='cycles'`` (renderman, arnold, vray) the layers of another renderer.

    :param tolerance: (absolute, relative), in addition to rounding
    """
    return _raylex._verify(self, of, list(sums), preset, tuple(tolerance))


class Rebuild:
    """What is missing when layers are added up. ``print`` shows the lines of ``raylex verify``.

    :ivar lines: these lines, a list of str
    :ivar unassigned, doubled: light that the sum lacks, and light that it has more than once, as fractions of all light
    :ivar lost: {colour: unassigned light where this factor of a product is 0, as a fraction}
    :ivar negative: {layer: (pixels with negative values, the lowest value)}
    :ivar difference: float32 (height, width, 3): whole minus sum beyond what is allowed, else 0
    """

    def __init__(self, verdict):
        self.__dict__.update(verdict._rebuild())
        self._verdict = str(verdict)

    def __str__(self):
        return "\n  ".join([self._verdict, *self.lines])


def _rebuild(self, of="", sums=(), preset=""):
    """Returns what is missing when layers are added up: a list of :class:`Rebuild`, one for each check of
    :meth:`verify` with these arguments."""
    return [Rebuild(verdict) for verdict in self.verify(of, sums, preset)]


def _factors(what_if, light, mix):
    """Texts NAME=FACTOR for colours and lights, and the name of a file with more of them."""
    def texts(factors):
        return [f"{name}={value if isinstance(value, str) else ','.join(repr(float(v)) for v in np.atleast_1d(value))}"
                for name, value in (factors or {}).items()]
    return texts(what_if), texts(light), os.fspath(mix) if mix else ""


def mix(path, output, light=None, *, mix=None):
    """Scales the light groups of an image file and recomputes its beauty, like ``raylex mix``.

    :param light: {layer or light group: factor}: a number, three numbers for red, green and blue, or '+1stop';
        'default' is the light without a group
    :param mix: TOML file with more factors, such as the page of an image saves
    :returns: the mixed :class:`Image`, written to `output`; its `warnings` name what is left out
    """
    return _raylex._mix(os.fspath(path), os.fspath(output), _factors(None, light, mix))


def read(*paths):
    """Reads an OpenEXR file, or several files with one layer each of the same image, as an :class:`Image`."""
    return _raylex._read_image([os.fspath(path) for path in paths])


def metrics():
    """Returns {name: formula} of all metrics."""
    return dict(_raylex._metrics())


def compare(image, reference, metric="relmse", *, layer="beauty", channel=""):
    """Returns the error of an image against a reference, by a metric of ``raylex compare``.

    :param image, reference: :class:`Image`, or arrays (height, width, 3), (height, width)
    :param metric: relmse, mse, mae, mape, rmse, smape, mean_ratio, relmse_mean, ssim, flip, ...; see :func:`metrics`
    :param channel: 'R', 'G', 'B', 'Y', or '' for the mean of all
    """
    return _raylex._compare(image, reference, metric, layer, channel)


def error_image(image, reference, metric="relmse", *, layer="beauty"):
    """Returns the metric of each pixel: float64 (height, width)."""
    return _raylex._error_image(image, reference, metric, layer)


def picture(image, layer="", *, exposure=0.0, largest_side=0):
    """Returns a picture of a layer: uint8 (height, width, 3), light through the display and view, geometry in false
    colours.

    :param image: an :class:`Image`, or an array of light (height, width, 3) or (height, width), such as a
        :class:`Layer` or ``results.mean(cell)``
    :param layer: layer of an :class:`Image`; by default the beauty under any name, else the first layer of light
    :param exposure: stops
    :param largest_side: pixels; 0: the size of the image
    """
    return _raylex._picture(image, layer, exposure, largest_side)


Image.view = _view
Image.to_xarray = _to_xarray
Image.verify = _verify
Image.rebuild = _rebuild
