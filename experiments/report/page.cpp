#include "experiments/report/page.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "experiments/report/guide/guide_view.h"
#include "experiments/report/html.h"
#include "experiments/report/page_layers.h"
#include "experiments/report/statistics_table.h"
#include "experiments/report/words/page_path_strings.h"
#include "experiments/verify/presets.h"
#include "experiments/verify/rebuild_lines.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {
namespace {

using display::ExrImage;
using display::SplitResult;

std::string attribute(const ExrImage& image, const std::string& name) {
    const auto found = image.attributes.find(name);
    return found != image.attributes.end() ? found->second : std::string();
}

std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

// The end of an opening tag, from its class on, and the result of the check.
const char* answer_markup(const SplitResult& verdict) {
    if (verdict.answer == display::SplitAnswer::cannot_tell) return "fails\">cannot tell: every pixel is clamped";
    if (!verdict.holds) return "fails\">does not hold";
    return verdict.answer == display::SplitAnswer::holds_as_allowed ? "holds\">holds within what is allowed"
                                                                    : "holds\">holds";
}

/// Checks the partitions that the header declares; without any, the splits that the names of a renderer's layers imply.
Result<std::vector<SplitResult>> results_of(const ExrImage& image) {
    auto results = display::check_declared_splits(image);
    if (!results || !results->empty() || attribute(image, "software").starts_with("raylex")) return results;
    for (const Preset& preset : presets()) {
        if (!is_named_after(preset, image)) continue;
        const auto splits = find_splits(preset, image, {});
        for (std::size_t i = 0; splits && i < splits->size(); ++i) {
            auto result = check_found(image, (*splits)[i]);
            if (!result) continue;  // a layer with such a name is no light
            result->partition = std::string(preset.renderer) + " " + (*splits)[i].title;
            results->push_back(*std::move(result));
        }
    }
    return results;
}

class Page {
  public:
    Page(const display::ColorManager& color, const PageOptions& options, std::size_t images, std::size_t atlases)
        : color_(color),
          options_(options),
          layers_(color, options, page_bytes / std::max<std::size_t>(images, 1)),
          bytes_of_path_strings_(path_strings_bytes / std::max<std::size_t>(atlases, 1)) {}

    /// `atlas`: the atlas of the image, or null. If the image comes from an atlas, `path` is that file.
    Status add(const std::string& path, const ExrImage& image, display::AtlasFile* atlas) {
        auto verdicts = results_of(image);
        if (!verdicts) return verdicts.error();
        auto pictures = layers_.html(image, *verdicts);
        if (!pictures) return pictures.error();
        body_ += "<section class=\"image\">\n<header><h2>" +
                 escape_html(std::filesystem::path(path).filename().string()) + "</h2>";
        add_introduction(image, *verdicts);
        body_ += "</header>\n" + *pictures;
        if (atlas != nullptr) {
            auto words = path_strings_html(*atlas, atlases_++, bytes_of_path_strings_);
            if (!words) return words.error();
            body_ += *words;
        }
        const std::filesystem::path statistics = std::filesystem::path(path).replace_extension(".json");
        const Result<std::string> record = read_record(statistics.string(), "a statistics file");
        if (record) body_ += guide_view_html(*record, image.width, image.height);
        add_results(*verdicts);
        if (record) add_statistics(*record);
        add_header(image);
        body_ += "</section>\n";
        for (const SplitResult& verdict : *verdicts) {
            ++checked_;
            if (verdict.answer == display::SplitAnswer::does_not_hold) ++failed_;
            if (verdict.answer == display::SplitAnswer::cannot_tell) ++open_;
            undecided_ += verdict.undecided;
            pixels_ += verdict.pixels;
        }
        return success();
    }

    [[nodiscard]] std::string finish() const {
        std::string verdict;
        if (checked_ == 0)
            verdict =
                "The file declares no partition, and its layers have no names of a known renderer, so there is nothing "
                "to check.";
        else if (failed_ + open_ == 0)
            verdict = "<span class=\"holds\">Every split holds:</span> in " +
                      (checked_ == 1 ? std::string("the one partition")
                                     : "each of " + std::to_string(checked_) + " partitions") +
                      " the layers sum to their whole at " +
                      (undecided_ == 0 ? "every pixel"
                                       : std::to_string(pixels_ - undecided_) + " of " + std::to_string(pixels_) +
                                             " pixels; the others are clamped") +
                      ", up to the rounding and compression of the file.";
        else if (failed_ == 0)
            verdict = "<span class=\"fails\">Cannot tell for " + std::to_string(open_) + " of " +
                      std::to_string(checked_) + " partitions:</span> every pixel is clamped to the range of the file.";
        else
            verdict = "<span class=\"fails\">" + std::to_string(failed_) + " of " + std::to_string(checked_) +
                      " partitions do not hold.</span>";
        return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
               "content=\"width=device-width, initial-scale=1\">\n"
               "<title>raylex report</title>\n<style>" +
               std::string(page_style()) + "</style>\n</head>\n<body>\n<p>" + verdict + "</p>\n" + body_ +
               "<p class=\"faint\">Pictures through " + escape_html(shown_through()) + ". " +
               std::string(precision_note) + "</p>\n" + layers_.view_scripts() + "<script>" +
               std::string(pixels_script()) + "</script>\n<script>" + std::string(panes_script()) + "</script>\n" +
               (atlases_ > 0 ? words_scripts() : std::string()) + "<script>" + std::string(mix_script()) +
               "</script>\n<script>" + std::string(guide_script()) + "</script>\n<script>" +
               std::string(split_script()) + "</script>\n</body>\n</html>\n";
    }

  private:
    [[nodiscard]] static std::string words_scripts() {
        return "<script>" + std::string(lpe_script()) +
               "</script>\n<script>const raylexNames = " + script_json(expression_names()) + ";\n" +
               std::string(words_script()) + "</script>\n";
    }
    [[nodiscard]] std::string shown_through() const {
        const std::string display = options_.display.empty() ? color_.default_display() : options_.display;
        const std::string view = options_.view.empty() ? color_.default_view(display) : options_.view;
        return "display " + display + ", view " + view + " of " + color_.description();
    }

    void add_introduction(const ExrImage& image, const std::vector<SplitResult>& verdicts) {
        for (const SplitResult& v : verdicts)
            body_ += "<p>" + escape_html(v.partition) + " <span class=\"" + answer_markup(v) + "</span></p>";
        for (const SplitResult& v : verdicts)
            for (const std::string& line : rebuild_lines(v))
                body_ += "<p class=\"rebuild\">" + escape_html(v.partition + ": " + line) + "</p>";
        std::string text = std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels";
        const auto append = [&](const char* name, const std::string& before, const std::string& after) {
            if (const std::string value = attribute(image, name); !value.empty())
                text += ", " + before + escape_html(value) + after;
        };
        append("raylex/samples_per_pixel", "", " samples per pixel");
        append("raylex/integrator", "integrator ", "");
        append("raylex/seed", "seed ", "");
        body_ += "<p class=\"faint\">" + text + "</p>\n";
        if (image.attributes.contains("raylex/incomplete"))
            body_ += "<p class=\"fails\">This render was interrupted: the image is incomplete.</p>\n";
    }

    void add_results(const std::vector<SplitResult>& verdicts) {
        if (verdicts.empty()) return;
        body_ +=
            "<details><summary>Split checks in numbers</summary>\n<div "
            "class=\"wide\"><table>\n<tr><th>Partition</th><th>Result</th><th>Layers</th><th>Largest relative "
            "error</th><th>at pixel</th><th>Bound</th><th>Pixels checked</th>"
            "<th>Largest absolute error</th><th>at pixel</th></tr>\n";
        for (const SplitResult& v : verdicts) {
            const auto pixel = [](int x, int y) { return "(" + std::to_string(x) + ", " + std::to_string(y) + ")"; };
            body_ += "<tr><td>" + escape_html(v.partition) + "</td><td class=\"" + answer_markup(v) +
                     "</td><td class=\"number\">" + std::to_string(v.layers.size()) + "</td><td class=\"number\">" +
                     number(v.largest_relative) + "</td><td>" + pixel(v.relative_x, v.relative_y) +
                     "</td><td class=\"number\">" + number(v.bound) + "</td><td class=\"number\">" +
                     std::to_string(v.checked()) + " of " + std::to_string(v.pixels) + "</td><td class=\"number\">" +
                     number(v.largest_absolute) + "</td><td>" + pixel(v.absolute_x, v.absolute_y) + "</td></tr>\n";
        }
        body_ += "</table></div></details>\n";
    }

    void add_statistics(const std::string& record) {
        const std::string table = statistics_table(record);
        if (table.empty()) return;
        body_ += "<details><summary>Cost</summary>\n" + table + "</details>\n";
    }

    void add_header(const ExrImage& image) {
        body_ += "<details><summary>Origin: the image header</summary>\n<div class=\"wide\"><table>\n";
        for (const auto& [name, value] : image.attributes) {
            if (name == "atlas/words" || name == "atlas/letters" || name == "atlas/scene")
                continue;  // long tables for programs
            const bool long_text = value.find('\n') != std::string::npos;
            body_ += "<tr><td><code>" + escape_html(name) + "</code></td><td>" +
                     (long_text ? "<pre>" + escape_html(value) + "</pre>" : "<code>" + escape_html(value) + "</code>") +
                     "</td></tr>\n";
        }
        body_ += "</table></div></details>\n";
    }

    static constexpr std::string_view precision_note =
        "Values are half floats: 11 significant bits, and steps of at least 2^-24. Layers with values beyond 65504 are "
        "scaled by a power of two. Ids are exact up to 2^24. Views come from a table with 35 nodes for each component, "
        "half a stop apart.";

    const display::ColorManager& color_;
    const PageOptions& options_;
    PageLayers layers_;
    const std::size_t bytes_of_path_strings_;
    std::string body_;
    std::size_t atlases_ = 0;
    int checked_ = 0, failed_ = 0, open_ = 0;
    std::size_t undecided_ = 0, pixels_ = 0;  ///< over all partitions
};

}  // namespace

Result<std::string> make_page(const std::vector<std::string>& images, const display::ColorManager& color,
                              const PageOptions& options) {
    const auto atlases = static_cast<std::size_t>(std::count_if(images.begin(), images.end(), display::is_atlas));
    Page page(color, options, images.size() - atlases, atlases);
    for (std::size_t i = 0; i < images.size(); ++i) {
        const bool alone = display::is_atlas(images[i]);
        auto image = alone ? image_of_atlas(images[i]) : display::read_exr(images[i]);
        if (!image) return image.error();
        std::unique_ptr<display::AtlasFile> atlas;
        const bool follows = !alone && i + 1 < images.size() && display::is_atlas(images[i + 1]);
        if (alone || follows) {
            auto opened = display::AtlasFile::open(images[alone ? i : i + 1]);
            if (!opened) return opened.error();
            atlas = *std::move(opened);
            if (follows && !is_atlas_of(*atlas, *image))
                atlas.reset();  // of another render: it gets a section of its own
        }
        if (Status added = page.add(images[i], *image, atlas.get()); !added) return added.error();
        if (follows && atlas) ++i;
    }
    return page.finish();
}

}  // namespace raylex::experiments
