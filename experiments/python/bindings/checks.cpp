// Checks of splits, and metrics: the functions of `raylex verify` and `raylex compare`.
#include <pybind11/stl.h>

#include <cmath>

#include "display/output/color/color_manager.h"
#include "display/output/comparison/comparison.h"
#include "display/output/reader/exr_layers.h"
#include "display/output/splits/split_check.h"
#include "experiments/cli/checks.h"
#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/image.h"
#include "experiments/report/preview.h"
#include "experiments/verify/presets.h"
#include "experiments/verify/rebuild_lines.h"

namespace raylex::python {

using namespace pybind11::literals;
using display::SplitResult;

namespace {

/// The result of a check, and the shape of its map.
struct CheckResult {
    SplitResult split;
    int width = 0, height = 0;
    std::string note;  ///< of a preset: the omitted layers, and its formula
};

std::vector<CheckResult> results_of(const display::ExrImage& image, std::vector<SplitResult> splits) {
    std::vector<CheckResult> results;
    for (SplitResult& each : splits) results.push_back({std::move(each), image.width, image.height, {}});
    return results;
}

display::Allowance allowance_of(double absolute, double relative) {
    if (!std::isfinite(absolute) || !std::isfinite(relative) || absolute < 0 || relative < 0)
        fail("a tolerance is negative or NaN; expected two numbers from 0 on");
    display::Allowance allowance;
    if (absolute == 0 && relative == 0) return allowance;
    allowance.absolute = absolute;
    allowance.relative = relative;
    allowance.reason = "tolerance";
    allowance.instead_of_compression = true;
    return allowance;
}

std::vector<CheckResult> verify_preset(const display::ExrImage& image, const std::string& preset, const std::string& of,
                                       const display::Allowance& tolerance, bool given) {
    std::vector<CheckResult> results;
    for (const experiments::FoundSplit& split :
         take(experiments::find_splits(*take(experiments::find_preset(preset)), image, of))) {
        SplitResult result =
            take(display::check_split(image, split.of, {split.sum}, given ? tolerance : split.allowance));
        result.partition = split.title;
        results.push_back({std::move(result), image.width, image.height, split.formula});
    }
    return results;
}

std::vector<CheckResult> verify(const Image& image, const std::string& of, const std::vector<std::string>& sums,
                                const std::string& preset, std::pair<double, double> tolerance) {
    const display::Allowance allowance = allowance_of(tolerance.first, tolerance.second);
    return unlocked([&] {
        const display::ExrImage exr = image.as_exr();
        const bool given = tolerance != std::pair(0.0, 0.0);
        if (!preset.empty()) return verify_preset(exr, preset, of, allowance, given);
        if (!sums.empty()) return results_of(exr, {take(display::check_split(exr, of, sums, allowance))});
        if (exr.partitions.empty())
            fail(
                "the image declares no partition; expected sums=['diffuse_*', ...] or preset='cycles'. Its layers "
                "are: " +
                display::list_names(exr.layer_names()));
        return results_of(exr, take(display::check_declared_splits(exr, allowance)));
    });
}

/// The attributes of raylex.Rebuild.
py::dict rebuild_of(const CheckResult& result) {
    const display::Rebuild& rebuild = result.split.rebuild;
    const double whole = rebuild.whole > 0 ? rebuild.whole : 1;
    std::map<std::string, double> lost;
    for (const auto& [factor, light] : rebuild.lost) lost[factor] = light / whole;
    std::map<std::string, std::pair<std::size_t, float>> negative;
    for (const auto& [layer, values] : rebuild.negative) negative[layer] = {values.pixels, values.lowest};
    std::vector<float> light = rebuild.light;
    light.resize(3 * static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height));
    return py::dict("lines"_a = experiments::rebuild_lines(result.split),
                    "unassigned"_a = rebuild.unassigned.light / whole, "doubled"_a = rebuild.doubled.light / whole,
                    "lost"_a = lost, "negative"_a = negative,
                    "difference"_a = owning_array(std::move(light), {result.height, result.width, 3}));
}

void add_results(py::module_& module) {
    py::class_<CheckResult>(module, "Verdict",
                            "The result of a check whether layers sum to the layer that they split, in every pixel.")
        .def_property_readonly(
            "holds", [](const CheckResult& v) { return v.split.holds; },
            "whether the sum holds, to rounding or within the tolerance")
        .def_property_readonly("partition", [](const CheckResult& v) { return v.split.partition; })
        .def_property_readonly("of", [](const CheckResult& v) { return v.split.of.empty() ? "beauty" : v.split.of; })
        .def_property_readonly("layers", [](const CheckResult& v) { return v.split.layers; })
        .def_property_readonly(
            "largest_relative", [](const CheckResult& v) { return v.split.largest_relative; },
            "largest |sum - of| / (sum of |layers| + |of|) of any pixel")
        .def_property_readonly(
            "bound", [](const CheckResult& v) { return v.split.bound; },
            "bound on rounding, relative like largest_relative")
        .def_property_readonly(
            "exceeding", [](const CheckResult& v) { return v.split.exceeding; },
            "number of pixels beyond the tolerance")
        .def_property_readonly(
            "judged", [](const CheckResult& v) { return v.split.checked(); },
            "number of pixels without clamped values; 0: the split cannot be checked")
        .def_property_readonly(
            "residual",
            [](const CheckResult& v) {
                return owning_array(std::vector<float>(v.split.residual), {v.height, v.width});
            },
            "float32 (height, width): |sum - of| relative to sum of |layers| + |of|, largest component")
        .def("_rebuild", &rebuild_of)
        .def_readonly("formula", &CheckResult::note, "of a preset: the formula of the sum")
        .def("__bool__", [](const CheckResult& v) { return v.split.holds; })
        .def("__str__", [](const CheckResult& v) { return experiments::result_text(v.split); })
        .def("__repr__", [](const CheckResult& v) { return "Verdict(" + experiments::result_line(v.split) + ")"; });
    module.def("_verify", &verify, "image"_a, "of"_a, "sums"_a, "preset"_a, "tolerance"_a);
}

/// Returns an array as an image with one layer, "beauty", in Rec. 709, for metrics.
display::ExrImage image_of(const Array<float>& array, const std::string& what) {
    const bool color = array.ndim() == 3 && array.shape(2) == 3;
    if (!color && array.ndim() != 2)
        fail(what + " has shape " + shape_text(array) + "; expected (height, width, 3) or (height, width)");
    display::ExrImage image;
    image.path = what;
    image.height = static_cast<int>(array.shape(0));
    image.width = static_cast<int>(array.shape(1));
    display::ImageLayer& layer = image.layers.emplace_back();
    const std::size_t count = color ? 3 : 1, pixels = static_cast<std::size_t>(array.size()) / count;
    for (std::size_t c = 0; c < count; ++c) {
        display::ImagePlane& plane = layer.planes.emplace_back();
        plane.name = color ? std::string(1, "RGB"[c]) : "Y";
        for (std::size_t i = 0; i < pixels; ++i) plane.values.push_back(array.data()[i * count + c]);
    }
    return image;
}

display::ExrImage comparable(const py::handle& object, const std::string& what) {
    if (py::isinstance<Image>(object)) return object.cast<const Image&>().as_exr();
    return image_of(array_of<float>(object, what), what);
}

double compare(const py::object& image, const py::object& reference, const std::string& metric,
               const std::string& layer, const std::string& channel) {
    const display::AnyMetric chosen = take(display::require_metric(metric, {"metric", 0, 0}));
    const display::ExrImage a = comparable(image, "image"), b = comparable(reference, "reference");
    if (channel.size() > 1) fail("channel is '" + channel + "'; expected 'R', 'G', 'B', 'Y' or ''");
    return unlocked([&] {
        return take(take(display::LayerPair::make(a, b, layer)).value(chosen, channel.empty() ? 'A' : channel[0]));
    });
}

py::array_t<double> error_image(const py::object& image, const py::object& reference, const std::string& metric,
                                const std::string& layer) {
    const display::AnyMetric chosen = take(display::require_metric(metric, {"metric", 0, 0}));
    const display::ExrImage a = comparable(image, "image"), b = comparable(reference, "reference");
    std::vector<double> map =
        unlocked([&] { return take(take(display::LayerPair::make(a, b, layer)).errors(chosen, 'A')).map; });
    return owning_array(std::move(map), {b.height, b.width});
}

/// Returns an image with only one array, as a layer whose name selects the display; without a name, the array that
/// people look at first.
display::ExrImage only(const Image& image, const std::string& name) {
    const LayerArray& array =
        name.empty() ? image.array(*take(experiments::shown_layer(image.description(), name))) : image.array(name);
    display::ExrImage exr = image.description();
    display::ImageLayer layer = exr.layers[array.layer];
    std::vector<display::ImagePlane> planes;
    const std::size_t count = array.planes.size();
    for (std::size_t c = 0; c < count; ++c) {
        display::ImagePlane& plane = planes.emplace_back(layer.planes[array.planes[c]]);
        for (std::size_t i = c; i < array.values.size(); i += count) plane.values.push_back(array.values[i]);
    }
    layer.planes = std::move(planes);
    exr.layers = {std::move(layer)};
    return exr;
}

/// Returns the picture of one layer for display: 8-bit RGB through display and view, or false colour for data.
experiments::Picture picture(const display::ExrImage& exr, double exposure, int largest_side) {
    const auto color = take(display::ColorManager::open());
    experiments::PictureOptions options;
    options.largest_side = largest_side;
    options.exposure = exposure;
    return take(experiments::picture_of(exr, exr.layers.front(), color, options));
}

void add_pictures(py::module_& module) {
    module.def(
        "_picture",
        [](const py::object& image, const std::string& layer, double exposure, int largest_side) {
            const display::ExrImage exr = py::isinstance<Image>(image)
                                              ? only(image.cast<const Image&>(), layer)
                                              : image_of(array_of<float>(image, "image"), "image");
            experiments::Picture made = unlocked([&] { return picture(exr, exposure, largest_side); });
            return owning_array(std::move(made.rgb), {made.height, made.width, 3});
        },
        "image"_a, "layer"_a, "exposure"_a, "largest_side"_a);
    module.def(
        "_png",
        [](const Image& image, const std::string& layer, double exposure, int largest_side) {
            const std::vector<unsigned char> png = unlocked([&] {
                const experiments::Picture made = picture(only(image, layer), exposure, largest_side);
                return take(display::encode_png(made.width, made.height, made.rgb));
            });
            return py::bytes(reinterpret_cast<const char*>(png.data()), png.size());
        },
        "image"_a, "layer"_a, "exposure"_a, "largest_side"_a);
    module.def(
        "_is_light",
        [](const Image& image, const std::string& layer) {
            const display::ExrImage exr = only(image, layer);
            return experiments::look_of(exr.layers.front()) == experiments::LayerLook::light;
        },
        "image"_a, "layer"_a);
}

}  // namespace

void add_checks(py::module_& module) {
    add_results(module);
    module.def("_metrics", [] {
        std::vector<std::pair<std::string, std::string>> all;
        for (const display::AnyMetric& each : display::all_metrics()) all.emplace_back(each.name, each.formula);
        return all;
    });
    module.def("_compare", &compare, "image"_a, "reference"_a, "metric"_a, "layer"_a, "channel"_a);
    module.def("_error_image", &error_image, "image"_a, "reference"_a, "metric"_a, "layer"_a);
    add_pictures(module);
}

}  // namespace raylex::python
