#include "experiments/report/page.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include "display/output/exr_reader.h"
#include "display/output/split_check.h"
#include "experiments/report/html.h"
#include "experiments/report/preview.h"
#include "experiments/report/statistics_table.h"

namespace raylex::experiments {
namespace {

using display::ExrImage;
using display::ImageLayer;
using display::SplitVerdict;

std::string shown_name(const ImageLayer& layer) {
    return layer.name.empty() ? "beauty" : layer.name;
}

std::string attribute(const ExrImage& image, const std::string& name) {
    const auto found = image.attributes.find(name);
    return found != image.attributes.end() ? found->second : std::string();
}

std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

bool is_black(const ImageLayer& layer) {
    for (const display::ImagePlane* plane : layer.triple())
        if (!std::all_of(plane->values.begin(), plane->values.end(), [](float value) { return value == 0; }))
            return false;
    return true;
}

/// The layers of one heading: a partition, loose channels, or geometry.
struct Group {
    std::string title, note;
    std::vector<const ImageLayer*> layers;
};

std::vector<Group> grouped(const ExrImage& image) {
    std::vector<Group> groups;
    std::set<const ImageLayer*> placed;
    const ImageLayer* beauty = image.layer("beauty");
    if (beauty != nullptr && beauty->is_color()) {
        groups.push_back({"Beauty", "", {beauty}});
        placed.insert(beauty);
    }
    for (const display::PartitionDeclaration& partition : image.partitions) {
        Group group{"Partition " + partition.name, "sums to " + (partition.of.empty() ? "beauty" : partition.of), {}};
        for (const std::string& name : partition.layers)
            if (const ImageLayer* layer = image.layer(name)) {
                group.layers.push_back(layer);
                placed.insert(layer);
            }
        groups.push_back(std::move(group));
    }
    Group light{"Other light", "in no partition", {}}, geometry{"Geometry", "", {}};
    for (const ImageLayer& layer : image.layers) {
        if (placed.contains(&layer)) continue;
        (look_of(layer) == LayerLook::light && layer.name != "albedo" ? light : geometry).layers.push_back(&layer);
    }
    for (Group* group : {&light, &geometry})
        if (!group->layers.empty()) groups.push_back(std::move(*group));
    return groups;
}

class Page {
  public:
    Page(const display::ColorManager& color, const PageOptions& options) : color_(color), options_(options) {}

    Status add(const std::string& path) {
        auto image = display::read_exr(path);
        if (!image) return image.error();
        auto verdicts = display::check_declared_splits(*image);
        if (!verdicts) return verdicts.error();
        body_ += "<section class=\"image\">\n<h2>" + escape_html(std::filesystem::path(path).filename().string()) +
                 "</h2>\n";
        add_introduction(*image);
        add_verdicts(*verdicts);
        Status pictures = add_pictures(*image);
        if (!pictures) return pictures;
        add_statistics(path);
        add_header(*image);
        body_ += "</section>\n";
        for (const SplitVerdict& verdict : *verdicts) {
            ++judged_;
            if (!verdict.holds) ++failed_;
        }
        return success();
    }

    [[nodiscard]] std::string finish() const {
        std::string verdict;
        if (judged_ == 0) verdict = "No partition is declared, so there is nothing to judge.";
        else if (failed_ == 0)
            verdict = "<span class=\"holds\">Every split holds:</span> in " +
                      (judged_ == 1 ? std::string("the one partition")
                                    : "each of " + std::to_string(judged_) + " partitions") +
                      " the layers sum to their whole at every pixel, up to the rounding of the file.";
        else
            verdict = "<span class=\"fails\">" + std::to_string(failed_) + " of " + std::to_string(judged_) +
                      " partitions do not hold.</span>";
        return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
               "content=\"width=device-width, initial-scale=1\">\n"
               "<title>raylex report</title>\n<style>" +
               std::string(page_style()) + "</style>\n</head>\n<body>\n<h1>raylex report</h1>\n<p>" + verdict +
               "</p>\n"
               "<p class=\"faint\">Pictures through " +
               escape_html(shown_through()) +
               ". Click a layer to see it large; arrow keys flip through the layers, "
               "<b>b</b> goes back to beauty, <b>e</b> lifts the exposure by 3 stops.</p>\n" +
               body_ + "<script>" + std::string(page_script()) + "</script>\n</body>\n</html>\n";
    }

  private:
    [[nodiscard]] std::string shown_through() const {
        const std::string display = options_.display.empty() ? color_.default_display() : options_.display;
        const std::string view = options_.view.empty() ? color_.default_view(display) : options_.view;
        return "display " + display + ", view " + view + " of " + color_.description();
    }

    void add_introduction(const ExrImage& image) {
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

    void add_verdicts(const std::vector<SplitVerdict>& verdicts) {
        if (verdicts.empty()) {
            body_ += "<p class=\"faint\">The header declares no partition.</p>\n";
            return;
        }
        body_ +=
            "<div class=\"wide\"><table>\n<tr><th>Partition</th><th>Verdict</th><th>Layers</th><th>Largest relative "
            "error</th><th>at pixel</th><th>Bound</th>"
            "<th>Largest absolute error</th><th>at pixel</th></tr>\n";
        for (const SplitVerdict& v : verdicts) {
            const auto pixel = [](int x, int y) { return "(" + std::to_string(x) + ", " + std::to_string(y) + ")"; };
            body_ += "<tr><td>" + escape_html(v.partition) + "</td><td class=\"" +
                     (v.holds ? "holds\">holds" : "fails\">does not hold") + "</td><td class=\"number\">" +
                     std::to_string(v.layers.size()) + "</td><td class=\"number\">" + number(v.largest_relative) +
                     "</td><td>" + pixel(v.relative_x, v.relative_y) + "</td><td class=\"number\">" + number(v.bound) +
                     "</td><td class=\"number\">" + number(v.largest_absolute) + "</td><td>" +
                     pixel(v.absolute_x, v.absolute_y) + "</td></tr>\n";
        }
        body_ += "</table></div>\n";
    }

    Result<std::string> encoded(const ExrImage& image, const ImageLayer& layer, double exposure) const {
        auto picture =
            picture_of(image, layer, color_, {options_.largest_side, exposure, options_.display, options_.view});
        if (!picture) return picture.error();
        auto png = display::encode_png(picture->width, picture->height, picture->rgb);
        if (!png) return png.error();
        return data_uri(*png);
    }

    Status add_pictures(const ExrImage& image) {
        body_ += "<div class=\"scene\">\n<figure class=\"viewer\"><div class=\"well\"><img alt=\"\" src=\"" +
                 std::string(blank_picture) +
                 "\"></div><figcaption><span class=\"name\"></span>"
                 "<code class=\"expression\"></code><span class=\"controls\"><button type=\"button\" "
                 "data-exposure=\"0\" aria-pressed=\"true\">as is</button>"
                 "<button type=\"button\" data-exposure=\"3\" aria-pressed=\"false\">+3 "
                 "stops</button></span></figcaption></figure>\n<div>\n";
        for (const Group& group : grouped(image)) {
            body_ += "<h3>" + escape_html(group.title);
            if (!group.note.empty()) body_ += " <span class=\"faint\">" + escape_html(group.note) + "</span>";
            body_ += "</h3>\n<div class=\"layers\">\n";
            for (const ImageLayer* layer : group.layers) {
                Status added = add_layer(image, *layer);
                if (!added) return added;
            }
            body_ += "</div>\n";
        }
        body_ += "</div>\n</div>\n";
        return success();
    }

    Status add_layer(const ExrImage& image, const ImageLayer& layer) {
        const std::string name = shown_name(layer);
        if (layer.triple()[0] == nullptr) {
            body_ += "<p class=\"faint\">" + escape_html(name) + " has no form that can be shown.</p>\n";
            return success();
        }
        auto picture = encoded(image, layer, 0);
        if (!picture) return picture.error();
        const LayerLook look = look_of(layer);
        const std::string expression = attribute(image, "lpe/" + name);
        std::string extra;
        if (look == LayerLook::light && layer.name != "albedo") {
            auto bright = encoded(image, layer, 3);
            if (!bright) return bright.error();
            if (*bright != *picture) extra = " data-bright=\"" + *bright + "\"";
        }
        const bool dark = look == LayerLook::light && is_black(layer);
        body_ += "<button type=\"button\" class=\"layer" + std::string(dark ? " empty" : "") +
                 "\" aria-pressed=\"false\" data-name=\"" + escape_html(name) + "\" data-expression=\"" +
                 escape_html(expression) + "\" data-look=\"" + describe(look) + "\"><img alt=\"" + escape_html(name) +
                 "\" src=\"" + *picture + "\"" + extra + "><span>" + escape_html(name);
        if (!expression.empty()) body_ += "<code>" + escape_html(expression) + "</code>";
        else if (look != LayerLook::light) body_ += "<code>" + std::string(describe(look)) + "</code>";
        if (dark) body_ += "<code>no light in this image</code>";
        body_ += "</span></button>\n";
        return success();
    }

    void add_statistics(const std::string& path) {
        const std::filesystem::path file = std::filesystem::path(path).replace_extension(".json");
        std::ifstream stream(file, std::ios::binary);
        if (!stream) return;
        const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
        const std::string table = statistics_table(text);
        if (table.empty()) return;
        body_ += "<details open><summary>What it cost</summary>\n" + table + "</details>\n";
    }

    void add_header(const ExrImage& image) {
        body_ += "<details><summary>Where it came from: the image header</summary>\n<div class=\"wide\"><table>\n";
        for (const auto& [name, value] : image.attributes) {
            const bool long_text = value.find('\n') != std::string::npos;
            body_ += "<tr><td><code>" + escape_html(name) + "</code></td><td>" +
                     (long_text ? "<pre>" + escape_html(value) + "</pre>" : "<code>" + escape_html(value) + "</code>") +
                     "</td></tr>\n";
        }
        body_ += "</table></div></details>\n";
    }

    /// One transparent pixel, until the script shows a layer.
    static constexpr std::string_view blank_picture =
        "data:image/"
        "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNkYAAAAAYAAjCB0C8AAAAASUVORK5CYII=";

    const display::ColorManager& color_;
    const PageOptions& options_;
    std::string body_;
    int judged_ = 0, failed_ = 0;
};

}  // namespace

Result<std::string> make_page(const std::vector<std::string>& images, const display::ColorManager& color,
                              const PageOptions& options) {
    Page page(color, options);
    for (const std::string& path : images) {
        Status added = page.add(path);
        if (!added) return added.error();
    }
    return page.finish();
}

}  // namespace raylex::experiments
