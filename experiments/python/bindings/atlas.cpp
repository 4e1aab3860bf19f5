// raylex.Atlas: makes layers from the atlas of a render, like `raylex ask`.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <memory>
#include <mutex>
#include <optional>

#include "display/output/splits/stored_precision.h"
#include "display/output/writer/memory_image.h"
#include "experiments/atlas/answer.h"
#include "experiments/atlas/merged_atlas.h"
#include "experiments/atlas/top_contributions.h"
#include "experiments/cli/checks.h"
#include "experiments/mix/image_mix.h"
#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/image.h"

namespace raylex::python {

using namespace pybind11::literals;

namespace {

/// A requested layer: (name, expression, dialect).
using Question = std::tuple<std::string, std::string, std::string>;

/// The values of all pixels and words as arrays.
struct Entries {
    std::vector<std::int64_t> begin;  ///< [pixel + 1]
    std::vector<std::int32_t> word;
    std::vector<float> rgb, parts, samples;
};

class Atlas {
  public:
    explicit Atlas(const std::filesystem::path& path)
        : file_(unlocked([&] { return take(display::AtlasFile::open(path.string())); })) {}

    [[nodiscard]] const display::AtlasFile& file() const { return *file_; }
    [[nodiscard]] const display::PathStringTable& table() const { return file_->table(); }

    /// Runs one request at a time, because the parts to be read are a setting of the file. A request may read rows with
    /// many threads.
    template <class Work>
    auto read(Work&& work) {
        return unlocked([&] {
            const std::lock_guard lock(reading_);
            file_->read_parts(true);
            return work(*file_);
        });
    }

  private:
    std::unique_ptr<display::AtlasFile> file_;
    std::mutex reading_;
};

std::vector<std::string> path_string_texts(const Atlas& atlas) {
    std::vector<std::string> texts;
    for (std::uint32_t word = 0; word < atlas.table().words.size(); ++word)
        texts.push_back(experiments::path_string_text(atlas.table(), word));
    return texts;
}

experiments::Job job_of(const std::vector<Question>& channels, bool shipped, bool light_groups) {
    experiments::Job job;
    for (const auto& [name, expression, dialect] : channels) {
        experiments::ExpressionRequest& request = job.expressions.emplace_back();
        request.name = name;
        request.expression = expression;
        request.location = {"lpe '" + name + "'", 0, 0};
        request.dialect = take(experiments::parse_dialect(dialect, request.location));
    }
    job.shipped_partition = shipped;
    job.light_groups = light_groups;
    return job;
}

/// Texts NAME=FACTOR for colours and lights, and the name of a file with more of them.
using Factors = std::tuple<std::vector<std::string>, std::vector<std::string>, std::string>;

experiments::Mix mix_of(const Factors& factors) {
    const auto& [colors, lights, file] = factors;
    experiments::Mix mix;
    if (!file.empty()) take(experiments::read_mix(file, mix));
    take(experiments::add_factors(colors, "what_if", mix.colors));
    take(experiments::add_factors(lights, "light", mix.lights));
    return mix;
}

std::shared_ptr<Image> ask(Atlas& atlas, const std::vector<Question>& channels, bool shipped, bool light_groups,
                           bool intervals, bool errors, const Factors& factors) {
    const experiments::Job job = job_of(channels, shipped, light_groups);
    const experiments::Mix mix = mix_of(factors);
    if (channels.empty() && !shipped && !light_groups && mix.lights.empty() && mix.colors.empty())
        fail(
            "no layer is requested; expected lpe={name: expression}, shipped=True, light_groups=True, what_if= or "
            "light=");
    return atlas.read([&](display::AtlasFile& file) {
        const auto answer = std::make_shared<const experiments::AtlasAnswer>(
            take(experiments::answer_question(file, job, {intervals, errors, mix})));
        if (!answer->refuted.empty()) fail(answer->refuted);
        auto image = std::make_shared<Image>(
            display::image_in_memory(answer->layers, experiments::RequestedLayers::beauty, answer->description));
        image->warnings = answer->notes;
        image->complete = answer->description.complete;
        image->write = [answer](const std::string& path) {
            return display::write_exr(path, answer->layers, experiments::RequestedLayers::beauty, answer->description);
        };
        return image;
    });
}

experiments::PixelContributions path_strings_at(Atlas& atlas, int x, int y, int top) {
    if (top < 1) fail("top is " + std::to_string(top) + "; expected 1 or more");
    return atlas.read([&](display::AtlasFile& file) {
        return take(experiments::top_contributions(file, x, y, static_cast<std::size_t>(top)));
    });
}

std::vector<experiments::SuggestedLayer> suggest(Atlas& atlas, int count) {
    if (count < 1) fail("count is " + std::to_string(count) + "; expected 1 or more");
    return atlas.read([&](display::AtlasFile& file) {
        return take(experiments::suggest_partition(file, static_cast<std::size_t>(count)));
    });
}

Entries entries_of(Atlas& atlas) {
    return atlas.read([](display::AtlasFile& file) {
        Entries all;
        all.begin.push_back(0);
        display::AtlasRow row;
        for (int y = 0; y < file.height(); ++y) {
            take(file.row(y, row));
            const auto before = static_cast<std::int64_t>(all.word.size());
            for (std::size_t x = 1; x < row.begin.size(); ++x) all.begin.push_back(before + row.begin[x]);
            for (const auto& counts : row.counts) all.samples.insert(all.samples.end(), counts.begin(), counts.end());
            for (const display::PathStringSample& sample : row.samples) {
                all.word.push_back(static_cast<std::int32_t>(sample.word));
                for (const double value : sample.rgb) all.rgb.push_back(static_cast<float>(value));
                all.parts.insert(all.parts.end(), sample.parts.begin(), sample.parts.end());
            }
        }
        return all;
    });
}

py::dict entries(Atlas& atlas) {
    Entries all = entries_of(atlas);
    constexpr auto parts = static_cast<py::ssize_t>(display::PathAtlas::parts);
    const auto count = static_cast<py::ssize_t>(all.word.size());
    py::dict arrays;
    arrays["begin"] =
        owning_array(std::move(all.begin), {py::ssize_t{atlas.file().width()} * atlas.file().height() + 1});
    arrays["word"] = owning_array(std::move(all.word), {count});
    arrays["rgb"] = owning_array(std::move(all.rgb), {count, 3});
    arrays["parts"] = owning_array(std::move(all.parts), {count, parts});
    arrays["samples"] = owning_array(std::move(all.samples), {atlas.file().height(), atlas.file().width(), parts});
    return arrays;
}

void merge(const std::vector<std::string>& paths, const std::string& output) {
    if (paths.size() < 2) fail("one atlas cannot be merged; expected at least two");
    for (const std::string& path : paths) {
        std::error_code failed;
        if (std::filesystem::equivalent(path, output, failed))
            fail("'" + path + "' is an input and would be overwritten; expected a different file");
    }
    unlocked([&] {
        const auto merged = take(experiments::MergedAtlas::open(paths));
        take(display::write_atlas(output, *merged, merged->description()));
    });
}

std::shared_ptr<Image> mix_file(const std::string& from, const std::string& to, const Factors& factors) {
    const experiments::Mix mix = mix_of(factors);
    return unlocked([&] {
        const auto mixed = take(experiments::mix_image(from, to, mix, "raylex.mix()"));
        auto image = std::make_shared<Image>(take(display::read_exr(to)));
        image->warnings = experiments::mix_notes(mixed);
        return image;
    });
}

void add_answers(py::module_& module) {
    using experiments::PixelContributions;
    using experiments::SuggestedLayer;
    using experiments::TopContribution;
    py::class_<PixelContributions>(module, "PixelWords", "The brightest path strings of a pixel, in order.")
        .def_property_readonly(
            "rgba",
            [](const PixelContributions& p) { return py::make_tuple(p.rgba[0], p.rgba[1], p.rgba[2], p.rgba[3]); },
            "value in the render: scene-linear red, green, blue, and alpha")
        .def_readonly("mean", &PixelContributions::mean, "(R + G + B) / 3")
        .def_readonly("error", &PixelContributions::error, "standard error of the mean; inf if unknown")
        .def_readonly("samples", &PixelContributions::samples, "camera samples of the pixel")
        .def_readonly("more", &PixelContributions::more, "number of further path strings")
        .def_readonly("words", &PixelContributions::words, "list of AtlasWord");
    py::class_<TopContribution>(module, "AtlasWord", "The light of one word in one pixel.")
        .def_readonly("number", &TopContribution::word, "index in Atlas.words")
        .def_property_readonly(
            "rgb", [](const TopContribution& w) { return py::make_tuple(w.rgb[0], w.rgb[1], w.rgb[2]); },
            "scene-linear")
        .def_readonly("mean", &TopContribution::mean, "(R + G + B) / 3")
        .def_readonly("error", &TopContribution::error, "standard error of the mean; inf if unknown");
    py::class_<SuggestedLayer>(module, "SuggestedLayer", "A layer that isolates a kind of noise.")
        .def_readonly("name", &SuggestedLayer::name)
        .def_readonly("expression", &SuggestedLayer::expression, "expression in the dialect renderman; '' for the rest")
        .def_readonly("light", &SuggestedLayer::light, "fraction of the image's light, 0 to 1")
        .def_readonly("noise", &SuggestedLayer::noise, "fraction of the image's variance, 0 to 1")
        .def("__repr__", [](const SuggestedLayer& layer) {
            return "SuggestedLayer(" + layer.name + ": " + (layer.expression.empty() ? "rest" : layer.expression) +
                   ", noise " + std::to_string(layer.noise) + ", light " + std::to_string(layer.light) + ")";
        });
    py::class_<display::AtlasCheck>(module, "AtlasVerdict",
                                    "Whether all path strings sum to the beauty, pixel by pixel.")
        .def_readonly("holds", &display::AtlasCheck::holds)
        .def_readonly("largest_relative", &display::AtlasCheck::largest,
                      "largest |sum - beauty| / (sum of |path strings| + |beauty|) of any pixel; at most 2^-23 if the "
                      "check holds")
        .def_readonly("exceeding", &display::AtlasCheck::exceeding, "number of pixels beyond 2^-23")
        .def_readonly("entries", &display::AtlasCheck::samples, "number of path strings of all pixels together")
        .def("__bool__", [](const display::AtlasCheck& result) { return result.holds; });
}

}  // namespace

void add_atlas(py::module_& module) {
    add_answers(module);
    py::class_<Atlas>(
        module, "Atlas",
        "A path atlas from `raylex render --atlas` or render(atlas=): the light of each distinct word in every pixel.")
        .def(py::init<const std::filesystem::path&>(), "path"_a)
        .def_property_readonly("path", [](const Atlas& atlas) { return atlas.file().path(); })
        .def_property_readonly(
            "width", [](const Atlas& atlas) { return atlas.file().width(); }, "pixels")
        .def_property_readonly(
            "height", [](const Atlas& atlas) { return atlas.file().height(); }, "pixels")
        .def_property_readonly(
            "words", &path_string_texts,
            "the path strings by index: 'C <R.D.'floor'> ... L'; '...' means one or more scattering events")
        .def_property_readonly(
            "by", [](const Atlas& atlas) { return to_string(atlas.table().rules); },
            "properties that distinguish path strings")
        .def_property_readonly(
            "length", [](const Atlas& atlas) { return atlas.table().rules.length; },
            "number of scattering events of the longest complete path strings")
        .def_property_readonly(
            "merged", [](const Atlas& atlas) { return atlas.table().merged; },
            "number of path strings shortened to stay within the budget")
        .def_property_readonly(
            "attributes", [](const Atlas& atlas) { return atlas.file().description().attributes; },
            "attributes of the header: dict of str")
        .def_property_readonly(
            "complete", [](const Atlas& atlas) { return atlas.file().description().complete; },
            "False if the render was stopped early")
        .def("_at", &path_strings_at, "x"_a, "y"_a, "top"_a)
        .def("_suggest", &suggest, "count"_a)
        .def("_ask", &ask, "channels"_a, "shipped"_a, "light_groups"_a, "intervals"_a, "errors"_a, "factors"_a)
        .def("_entries", &entries)
        .def(
            "_verify",
            [](Atlas& atlas) {
                return atlas.read([](display::AtlasFile& file) {
                    return take(display::check_atlas(file, display::light_magnitude_of(file.description().attributes)));
                });
            })
        .def("__repr__", [](const Atlas& atlas) {
            return "Atlas('" + atlas.file().path() + "': " + std::to_string(atlas.file().width()) + "x" +
                   std::to_string(atlas.file().height()) + ", " + std::to_string(atlas.table().words.size()) +
                   " path strings)";
        });
    module.def("_merge_atlases", &merge, "paths"_a, "output"_a);
    module.def("_mix", &mix_file, "path"_a, "output"_a, "factors"_a);
}

}  // namespace raylex::python
