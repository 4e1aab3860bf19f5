#include "experiments/python/bindings/image.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "display/services/parameters.h"
#include "experiments/python/bindings/arrays.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace raylex::python {

using namespace pybind11::literals;

namespace {

/// Returns the name of a layer for Python. The file's layer without a name is the beauty.
std::string spoken(const std::string& name) {
    return name.empty() ? "beauty" : name;
}

/// Returns the name of a layer's coverage array. Colour and coverage are separate arrays.
std::string alpha_of(const std::string& name) {
    return name.empty() ? "alpha" : name + ".A";
}

}  // namespace

Image::Image(display::ExrImage image) : description_(std::move(image)) {
    for (std::size_t i = 0; i < description_.layers.size(); ++i) {
        const display::ImageLayer& layer = description_.layers[i];
        std::vector<std::size_t> planes;
        for (std::size_t p = 0; p < layer.planes.size(); ++p) planes.push_back(p);
        const bool coverage = layer.is_color() && layer.planes.size() == 4 && layer.planes[3].name == "A";
        if (coverage) planes.pop_back();
        add(i, spoken(layer.name), planes);
        if (coverage) add(i, alpha_of(layer.name), {3});
    }
    for (display::ImageLayer& layer : description_.layers)
        for (display::ImagePlane& plane : layer.planes) plane.values = std::vector<float>();
}

void Image::add(std::size_t layer, std::string name, std::vector<std::size_t> planes) {
    const display::ImageLayer& from = description_.layers[layer];
    LayerArray& array = arrays_.emplace_back();
    array.name = std::move(name);
    array.layer = layer;
    array.planes = std::move(planes);
    const std::size_t count = array.planes.size();
    for (const std::size_t plane : array.planes) array.components.push_back(from.planes[plane].name);
    if (count == 1) {
        array.values = std::move(description_.layers[layer].planes[array.planes.front()].values);
        return;
    }
    array.values.resize(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()) * count);
    for (std::size_t c = 0; c < count; ++c) {
        const std::vector<float>& values = from.planes[array.planes[c]].values;
        for (std::size_t i = 0; i < values.size(); ++i) array.values[i * count + c] = values[i];
    }
}

const LayerArray& Image::array(const std::string& name) const {
    const auto found =
        std::find_if(arrays_.begin(), arrays_.end(), [&](const LayerArray& each) { return each.name == name; });
    if (found != arrays_.end()) return *found;
    return array(*take(description_.require_layer(name == "beauty" ? "" : name)));
}

const LayerArray& Image::array(const display::ImageLayer& layer) const {
    const auto index = static_cast<std::size_t>(&layer - description_.layers.data());
    return *std::find_if(arrays_.begin(), arrays_.end(),  // coverage comes after its colour
                         [index](const LayerArray& each) { return each.layer == index; });
}

bool Image::contains(const std::string& name) const {
    return std::any_of(arrays_.begin(), arrays_.end(), [&](const LayerArray& each) { return each.name == name; }) ||
           description_.require_layer(name == "beauty" ? "" : name);
}

std::vector<std::string> Image::names() const {
    std::vector<std::string> names;
    for (const LayerArray& each : arrays_) names.push_back(each.name);
    return names;
}

display::ExrImage Image::as_exr() const {
    display::ExrImage image = description_;
    for (const LayerArray& array : arrays_) {
        const std::size_t count = array.planes.size();
        for (std::size_t c = 0; c < count; ++c) {
            std::vector<float>& values = image.layers[array.layer].planes[array.planes[c]].values;
            values.resize(array.values.size() / count);
            for (std::size_t i = 0; i < values.size(); ++i) values[i] = array.values[i * count + c];
        }
    }
    return image;
}

std::shared_ptr<Image> denoised(const Image& image, const display::DenoiseOptions& options) {
    display::ExrImage pixels = image.as_exr();
    take(display::denoise_image(pixels, options));
    auto result = std::make_shared<Image>(std::move(pixels));
    result->warnings = image.warnings;
    result->statistics = image.statistics;
    result->complete = image.complete;
    result->write = [options, from = image.path(), write = image.write](const std::string& path) -> Status {
        if (write)
            if (Status written = write(path); !written) return written;
        const auto rewritten = display::denoise_exr(write ? path : from, path, options);
        return rewritten ? success() : Status(rewritten.error());
    };
    return result;
}

namespace {

py::array_t<float> array_of_layer(const py::object& self, const std::string& name) {
    const auto& image = self.cast<const Image&>();
    const LayerArray& array = image.array(name);
    std::vector<py::ssize_t> shape{image.height(), image.width()};
    if (array.components.size() != 1) shape.push_back(static_cast<py::ssize_t>(array.components.size()));
    return py::array_t<float>(std::move(shape), array.values.data(), self);  // keeps the values alive
}

py::dict partitions_of(const Image& image) {
    py::dict partitions;
    for (const display::PartitionDeclaration& each : image.description().partitions)
        partitions[py::str(each.name)] =
            py::make_tuple(each.of.empty() ? std::string("beauty") : each.of, py::cast(each.layers));
    return partitions;
}

/// Returns the header's attributes of layers under "lpe/".
std::map<std::string, std::string> expressions_of(const Image& image) {
    std::map<std::string, std::string> expressions;
    for (const auto& [name, text] : image.description().attributes)
        if (name.starts_with("lpe/")) expressions[name.substr(4)] = text;
    return expressions;
}

void write_image(const Image& image, const std::filesystem::path& path) {
    if (!image.write) fail("the image was read from '" + image.path() + "'; only rendered images can be written");
    if (path.extension() != ".exr") fail("'" + path.string() + "' does not end in .exr; expected an OpenEXR file name");
    unlocked([&] { take(image.write(path.string())); });
}

std::string describe(const Image& image) {
    std::string list;
    for (const std::string& each : image.names()) list += (list.empty() ? "" : ", ") + each;
    return "Image(" + std::to_string(image.width()) + "x" + std::to_string(image.height()) + ": " + list +
           (image.complete ? "" : "; incomplete") + ")";
}

}  // namespace

void add_image(py::module_& module) {
    py::class_<Image, std::shared_ptr<Image>>(module, "Image",
                                              "The layers of an image, rendered or read. image['beauty'] is a float32 "
                                              "array of shape (height, width, 3), with rows from the top.")
        .def_property_readonly("width", &Image::width, "pixels")
        .def_property_readonly("height", &Image::height, "pixels")
        .def_property_readonly("path", &Image::path, "path of the file; '' if rendered")
        .def_property_readonly("names", &Image::names, "names of the layers, the beauty first")
        .def_property_readonly(
            "attributes", [](const Image& image) { return image.description().attributes; },
            "attributes of the header: dict of str")
        .def_property_readonly("expressions", &expressions_of, "{layer: light path expression}")
        .def_property_readonly("partitions", &partitions_of, "{name: (split layer, [layers])}; proved if rendered")
        .def_readonly("warnings", &Image::warnings, "warnings of the render")
        .def_readonly("statistics", &Image::statistics,
                      "statistics of a render: samples_per_pixel, seconds (wall), cpu_seconds, camera_rays, ...")
        .def_readonly("complete", &Image::complete, "False if the render was stopped early")
        .def(
            "components", [](const Image& image, const std::string& name) { return image.array(name).components; },
            "name"_a, "names along the last axis: R G B, X Y Z, or the single name of a layer without this axis")
        .def("__getitem__", &array_of_layer, "name"_a,
             "A layer by its name, with or without a prefix that all names share, as float32 (height, "
             "width, components), (height, width) for one component. No copy: the image's "
             "own "
             "memory.")
        .def("__contains__", &Image::contains)
        .def("__len__", [](const Image& image) { return image.arrays().size(); })
        .def("__iter__", [](const Image& image) { return py::iter(py::cast(image.names())); })
        .def("write", &write_image, "path"_a, "Writes a rendered image like `raylex render`, as multi-part OpenEXR.")
        .def(
            "denoise",
            [](const Image& image, bool keep_noisy, const std::optional<std::filesystem::path>& second, int threads) {
                return unlocked([&] {
                    return denoised(image, {threads, keep_noisy, second ? second->string() : std::string()});
                });
            },
            py::kw_only(), "keep_noisy"_a = false, "second"_a = py::none(), "threads"_a = 0,
            "Returns the image with denoised layers that still sum, like `raylex denoise`. NAME_error is the estimated "
            "standard error of a pixel. The image needs statistics: render(denoise=True) makes them and denoises, "
            "statistics={'beauty': ['mse'], ...} only makes them; `second` is the file of a second render of the same "
            "image.")
        .def("__repr__", &describe);
    module.def(
        "_read_image",
        [](const std::vector<std::string>& paths) {
            return unlocked([&] {
                auto image = std::make_shared<Image>(take(display::read_exr_set(paths)));
                if (paths.size() > 1)
                    image->write = [paths](const std::string& path) {
                        return error_at({path, 0, 0},
                                        "the image comes from " + std::to_string(paths.size()) +
                                            " files; expected an image that was rendered, or read from one file");
                    };
                return image;
            });
        },
        "paths"_a);
}

}  // namespace raylex::python
