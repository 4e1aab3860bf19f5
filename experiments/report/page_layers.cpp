#include "experiments/report/page_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <list>
#include <optional>
#include <set>
#include <utility>

#include "experiments/job/text/json.h"
#include "experiments/report/html.h"
#include "experiments/report/pixel_data.h"
#include "experiments/report/preview.h"

namespace raylex::experiments {
namespace {

using display::ExrImage;
using display::ImageLayer;
std::string shown_name(const ImageLayer& layer) {
    return layer.name.empty() ? "beauty" : layer.name;
}

bool is_light(const ImageLayer& layer) {
    return look_of(layer) == LayerLook::light && layer.name != "albedo";
}

bool is_black(const ImageLayer& layer) {
    for (const display::ImagePlane* plane : layer.triple())
        if (plane == nullptr ||
            !std::all_of(plane->values.begin(), plane->values.end(), [](float value) { return value == 0; }))
            return false;
    return true;
}

/// The layers below one heading: a partition, channels in no partition, or geometry.
struct Group {
    std::string title, note;
    const ImageLayer* whole = nullptr;  ///< the layer of which the others show their share
    std::vector<const ImageLayer*> layers;
};

std::vector<Group> grouped(const ExrImage& image) {
    std::vector<Group> groups;
    std::set<const ImageLayer*> placed;
    const ImageLayer* beauty = image.layer("beauty");
    if (beauty != nullptr && !beauty->is_color()) beauty = nullptr;
    if (beauty != nullptr) {
        groups.push_back({"Beauty", "", beauty, {beauty}});
        placed.insert(beauty);
    }
    for (const display::PartitionDeclaration& partition : image.partitions) {
        const ImageLayer* whole = partition.of.empty() ? beauty : image.layer(partition.of);
        Group group{partition.name, "sums to " + (partition.of.empty() ? "beauty" : partition.of), whole, {}};
        for (const std::string& name : partition.layers)
            if (const ImageLayer* layer = image.layer(name); layer != nullptr && placed.insert(layer).second)
                group.layers.push_back(layer);
        if (!group.layers.empty()) groups.push_back(std::move(group));
    }
    Group light{"Other light", "in no partition", beauty, {}}, geometry{"Geometry", "", nullptr, {}};
    for (const ImageLayer& layer : image.layers) {
        if (placed.contains(&layer)) continue;
        (is_light(layer) ? light : geometry).layers.push_back(&layer);
    }
    for (Group* group : {&light, &geometry})
        if (!group->layers.empty()) groups.push_back(std::move(*group));
    return groups;
}

/// A layer with the light of the sign of `sign` by which a rebuilt layer differs.
ImageLayer layer_of_difference(const std::string& name, const std::vector<float>& light, float sign) {
    ImageLayer layer;
    layer.name = name;
    for (std::size_t c = 0; c < 3; ++c) {
        display::ImagePlane& plane = layer.planes.emplace_back();
        plane.name = std::string(1, "RGB"[c]);
        for (std::size_t i = c; i < light.size(); i += 3) plane.values.push_back(std::max(0.0F, sign * light[i]));
    }
    return layer;
}

/// The layers of unassigned light and of light that is counted twice, of all results.
std::list<ImageLayer> add_differences(const ExrImage& image, const std::vector<display::SplitResult>& results,
                                      std::vector<Group>& groups) {
    std::list<ImageLayer> layers;
    for (const display::SplitResult& result : results) {
        const display::Rebuild& rebuild = result.rebuild;
        if (rebuild.light.empty()) continue;
        Group group{
            "Rebuilt " + result.of, "the sum of " + result.partition + " compared with it", image.layer(result.of), {}};
        const auto add = [&](const char* what, const display::LightDifference& difference, float sign) {
            if (difference.pixels == 0) return;
            layers.push_back(layer_of_difference(what + (" (" + result.partition + ")"), rebuild.light, sign));
            group.layers.push_back(&layers.back());
        };
        add("unassigned", rebuild.unassigned, 1);
        add("counted twice", rebuild.doubled, -1);
        groups.push_back(std::move(group));
    }
    return layers;
}

/// The planes one after the other, with one value per block: the mean if `mean`, else the pixel in the middle. A mean
/// would invent ids, normals and depths. picture_of() reduces in the same way.
std::vector<float> reduced_planes(const ExrImage& image, const std::vector<const display::ImagePlane*>& planes,
                                  int block, bool mean) {
    std::vector<float> values;
    for (const display::ImagePlane* plane : planes) {
        if (block == 1) {
            values.insert(values.end(), plane->values.begin(), plane->values.end());
            continue;
        }
        const auto at = [&](int x, int y) {
            return plane->values[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                 static_cast<std::size_t>(x)];
        };
        for (int y = 0; y < image.height; y += block)
            for (int x = 0; x < image.width; x += block) {
                if (!mean) {
                    values.push_back(
                        at(std::min(x + block / 2, image.width - 1), std::min(y + block / 2, image.height - 1)));
                    continue;
                }
                double sum = 0, count = 0;
                for (int v = y; v < std::min(y + block, image.height); ++v)
                    for (int u = x; u < std::min(x + block, image.width); ++u, ++count) sum += at(u, v);
                values.push_back(static_cast<float>(sum / count));
            }
    }
    return values;
}

/// The smallest power of two, at least 1, that brings all finite values into the range of half floats.
float half_scale(const std::vector<float>& values) {
    float most = 0, scale = 1;
    for (const float value : values)
        if (std::isfinite(value)) most = std::max(most, std::abs(value));
    while (most / scale > 65504.0F) scale *= 2;
    return scale;
}

double sum_of(const ImageLayer& layer) {
    double sum = 0;
    for (const display::ImagePlane* plane : layer.triple())
        if (plane != nullptr)
            for (const float value : plane->values) sum += value;
    return sum;
}

}  // namespace

/// A layer in the page: the data for the script, and the HTML of its row.
struct PageLayers::Row {
    Json json;
    std::string html, script;
    bool empty = false;
};

int PageLayers::block_of(const ExrImage& image, std::size_t more_planes) const {
    const int side = std::max(image.width, image.height);
    if (options_.largest_side > 0)
        return side > options_.largest_side ? (side + options_.largest_side - 1) / options_.largest_side : 1;
    auto planes = static_cast<double>(more_planes);
    for (const ImageLayer& layer : image.layers)
        if (layer.triple()[0] != nullptr && !(is_light(layer) && is_black(layer)))
            planes += static_cast<double>(std::min<std::size_t>(layer.planes.size(), 3));
    // Compression shrinks the 2 bytes of a noisy half to about 1.3, and base64 multiplies them by 4 / 3.
    const double bytes = planes * image.width * image.height * 1.75;
    return std::max(1, static_cast<int>(std::ceil(std::sqrt(bytes / static_cast<double>(image_bytes_)))));
}

Result<std::vector<PageLayers::View>> PageLayers::views_of(const ExrImage& image) {
    constexpr std::size_t most_views = 6;
    const std::string display = options_.display.empty() ? color_.default_display() : options_.display;
    const std::string chosen = options_.view.empty() ? color_.default_view(display) : options_.view;
    std::vector<std::string> names{chosen};
    for (const std::string& each : color_.views(display))
        if (each != chosen && names.size() < most_views) names.push_back(each);
    std::vector<View> views;
    for (const std::string& name : names) {
        auto table = pack_view(color_, image.chromaticities.value_or(display::Chromaticities{}), display, name);
        if (!table && name == chosen) return table.error();
        if (!table) continue;  // the config has a view that does not work
        const auto known = std::find(tables_.begin(), tables_.end(), *table);
        views.push_back({name, static_cast<std::size_t>(known - tables_.begin())});
        if (known == tables_.end()) tables_.push_back(std::move(*table));
    }
    return views;
}

Result<PageLayers::Row> PageLayers::row_of(const ExrImage& image, const ImageLayer& layer, int block, bool may_fold) {
    const std::string name = shown_name(layer);
    const LayerLook look = look_of(layer);
    const auto attribute = image.attributes.find("lpe/" + name);
    const std::string expression = attribute != image.attributes.end() ? attribute->second : std::string();
    const std::string under = !expression.empty() ? expression : describe(look);
    Row row;
    row.empty = may_fold && is_light(layer) && is_black(layer);
    const bool plain =
        layer.triple()[0] != nullptr;  // false for luminance with chroma, and for planes of unknown names
    const bool painted = look != LayerLook::light || !plain;  // here, at the size of the data; the page paints light
    const int side = std::max(image.width, image.height), size = painted ? (side + block - 1) / block : 96;
    auto picture = picture_of(image, layer, color_, {size, 0, options_.display, options_.view});
    if (!picture) return picture.error();
    auto png = display::encode_png(picture->width, picture->height, picture->rgb);
    if (!png) return png.error();

    row.json = Json{{"name", name},       {"expression", expression}, {"look", describe(look)}, {"light", !painted},
                    {"empty", row.empty}, {"planes", Json::array()},  {"data", nullptr}};
    if (look != LayerLook::mattes && plain && !row.empty) {
        std::vector<const display::ImagePlane*> planes;
        for (const display::ImagePlane* plane : layer.triple())
            if (std::find(planes.begin(), planes.end(), plane) == planes.end()) planes.push_back(plane);
        for (const display::ImagePlane* plane : planes) row.json["planes"].push_back(plane->name);
        if (look == LayerLook::light && planes.size() == 1) planes = {planes[0], planes[0], planes[0]};
        std::vector<float> values = reduced_planes(image, planes, block, look == LayerLook::light);
        const std::string id = "pixels-" + std::to_string(next_data_++);
        row.json["data"] = id;
        std::string packed;
        if (look == LayerLook::identity) {
            row.json["integers"] = true;
            packed = pack_integers(values);
        } else {
            const float scale = half_scale(values);
            for (float& value : values) value /= scale;
            row.json["scale"] = scale;
            packed = pack_halves(values);
        }
        row.script = "<script type=\"text/plain\" id=\"" + id + "\">" + packed + "</script>\n";
    }
    row.html = "<button type=\"button\" class=\"layer" + std::string(is_light(layer) ? " light" : "") +
               "\" aria-pressed=\"false\" data-name=\"" + escape_html(name) + "\" title=\"" +
               escape_html(name + (under.empty() ? "" : ": " + under)) + "\"><span class=\"thumb\"><img alt=\"" +
               escape_html(name) + "\" src=\"" + data_uri(*png) +
               "\"></span><span class=\"text\"><span class=\"title\">" + escape_html(name) +
               "</span><code class=\"value\"></code><code class=\"formula\">" + escape_html(under) +
               "</code></span><span class=\"part\"><span class=\"share\"></span><span class=\"track\"><span "
               "class=\"bar\"></span></span></span></button>\n";
    return row;
}

namespace {

/// The controls around the picture: one layer or all, exposure, view, zoom.
std::string tools(const std::vector<std::string>& views) {
    std::string options;
    for (std::size_t i = 0; i < views.size(); ++i)
        options += "<option value=\"" + std::to_string(i) + "\">" + escape_html(views[i]) + "</option>";
    return "<div class=\"stage\"><div class=\"tools\"><span class=\"group\"><button type=\"button\" "
           "data-show=\"one\">one "
           "layer</button><button type=\"button\" data-show=\"all\">all layers</button></span><label>exposure <input "
           "class=\"exposure\" type=\"range\" min=\"-10\" max=\"10\" step=\"0.1\" value=\"0\" aria-label=\"exposure\">"
           "</label><span class=\"stops\" title=\"back to 0\"></span><label>view <select class=\"view\">" +
           options +
           "</select></label><span class=\"group\"><button type=\"button\" data-fit>fit</button><button "
           "type=\"button\" "
           "data-actual>1:1</button></span><b class=\"name\"></b> <code class=\"expression\"></code></div>\n<div "
           "class=\"panes\" tabindex=\"0\"></div>\n<p class=\"status\" data-hint=\"wheel zooms, drag moves, arrow keys "
           "flip "
           "layers, a all, b beauty, e/E exposure\"></p></div>\n";
}

/// A heading. The first one above shares also names the pixel that the shares belong to.
std::string heading_of(const Group& group, bool first) {
    return "<h3>" + escape_html(group.title) +
           (group.note.empty() ? "" : " <span class=\"faint\">" + escape_html(group.note) + "</span>") +
           (first && group.whole != nullptr ? "<span class=\"head\">share <span class=\"where\"></span></span>" : "") +
           "</h3>\n";
}

/// The data of the image for the page's script; the caller adds views and layers.
Json image_json(const ExrImage& image, int block) {
    return {{"width", (image.width + block - 1) / block},
            {"height", (image.height + block - 1) / block},
            {"block", block},
            {"views", Json::array()},
            {"layers", Json::array()}};
}

/// The layers of light groups, for mix.js: those of a partition, or those that another renderer names so, or none; null
/// without a beauty. `rest`: whether the beauty can have light that is in none of them.
Json mix_json(const ExrImage& image) {
    const auto beauty = image.require_layer("");
    if (!beauty || !(*beauty)->is_color()) return nullptr;
    for (const display::PartitionDeclaration& partition : image.partitions)
        if (image.layer(partition.of) == *beauty && !partition.layers.empty() &&
            std::all_of(partition.layers.begin(), partition.layers.end(),
                        [](const std::string& name) { return name.starts_with("light_"); }))
            return {{"whole", shown_name(**beauty)}, {"layers", partition.layers}, {"rest", false}};
    std::vector<std::string> names;
    for (const ImageLayer& layer : image.layers)
        for (const char* prefix : {"Combined_", "RGBA_", "light_"})
            if (layer.is_color() && image.attributes.count("statistics/" + layer.name) == 0 &&
                !layer.name.ends_with("_noisy") &&
                std::string_view(layer.name).substr(layer.name.rfind('.') + 1).starts_with(prefix))
                names.push_back(layer.name);
    return {{"whole", shown_name(**beauty)}, {"layers", names}, {"rest", true}};
}

/// A layer, and the layer of which it shows its share.
using LayerOfWhole = std::pair<const ImageLayer*, const ImageLayer*>;

void link_wholes(const std::vector<LayerOfWhole>& layers, Json& rows) {
    for (std::size_t i = 0; i < layers.size(); ++i)
        for (std::size_t k = 0; k < layers.size(); ++k)
            if (layers[i].second != nullptr && layers[k].first == layers[i].second) rows[i]["whole"] = k;
}

}  // namespace

Result<std::string> PageLayers::html(const ExrImage& image, const std::vector<display::SplitResult>& results) {
    std::vector<Group> groups = grouped(image);
    const std::list<ImageLayer> differences = add_differences(image, results, groups);
    const int block = block_of(image, 3 * differences.size());
    auto views = views_of(image);
    if (!views) return views.error();
    Json data = image_json(image, block);
    std::vector<std::string> names;
    for (const View& view : *views) {
        data["views"].push_back(Json{{"data", "view-" + std::to_string(view.table)}});
        names.push_back(view.name);
    }
    std::vector<LayerOfWhole> wholes;
    std::string list, folded, scripts;
    std::size_t empty = 0;
    // The script expects the order of the rows in the page. Layers without light come last and are folded away.
    Json dark = Json::array();
    for (const Group& group : groups) {
        std::string rows;
        for (const ImageLayer* layer : group.layers) {
            if (layer->triple()[0] == nullptr) {
                rows += "<p class=\"faint\">" + escape_html(shown_name(*layer)) +
                        " cannot be shown: its planes are of an unknown kind.</p>\n";
                continue;
            }
            auto row = row_of(image, *layer, block, layer != group.whole);
            if (!row) return row.error();
            row->json["share"] = nullptr;
            row->json["whole"] = nullptr;
            scripts += row->script;
            if (row->empty) {
                ++empty;
                folded += row->html;
                dark.push_back(std::move(row->json));
                continue;
            }
            rows += row->html;
            if (is_light(*layer) && group.whole != nullptr) {
                const double share = sum_of(*layer) / sum_of(*group.whole);
                if (std::isfinite(share)) row->json["share"] = share;
            }
            wholes.emplace_back(layer, is_light(*layer) ? group.whole : nullptr);
            data["layers"].push_back(std::move(row->json));
        }
        if (rows.empty()) continue;
        list += heading_of(group, list.empty()) + rows;
    }
    if (data["layers"].empty())
        return std::string(
            "<p class=\"faint\">No layer of this file can be shown: all are black or of an unknown kind.</p>\n");
    link_wholes(wholes, data["layers"]);
    data["mix"] = mix_json(image);
    for (Json& each : dark) data["layers"].push_back(std::move(each));
    if (list.find("class=\"where\"") == std::string::npos) list = "<span class=\"where\" hidden></span>" + list;
    if (empty > 0)
        list += "<details><summary>" + std::to_string(empty) + (empty == 1 ? " layer" : " layers") +
                " without light in this image</summary>\n" + folded + "</details>\n";
    return "<div class=\"screen\">\n" + tools(names) + "<aside class=\"list\">\n" + list + "</aside>\n</div>\n" +
           "<script type=\"application/json\" class=\"data\">" + script_json(json_text(data)) + "</script>\n" + scripts;
}

std::string PageLayers::view_scripts() const {
    std::string html;
    for (std::size_t i = 0; i < tables_.size(); ++i)
        html += "<script type=\"text/plain\" id=\"view-" + std::to_string(i) + "\">" + tables_[i] + "</script>\n";
    return html;
}

}  // namespace raylex::experiments
