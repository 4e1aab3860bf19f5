#include "experiments/report/words/page_path_strings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/atlas/requested_layers.h"
#include "experiments/job/text/json.h"
#include "experiments/report/html.h"
#include "experiments/report/pixel_data.h"
#include "lpe/language/names.h"
#include "lpe/match.h"

namespace raylex::experiments {
namespace {

using display::PathAlphabet;
using display::PathAtlas;
using display::PathStringTable;
using Parts = std::array<double, PathAtlas::parts>;

/// A path string in a block of pixels.
struct BlockPathString {
    std::array<double, 3> rgb{};
    Parts luminance{};
};

/// The path strings that the page keeps, pixel after pixel.
struct PagePathStrings {
    int block = 1, width = 0, height = 0;
    std::vector<float> counts;  ///< [pixel] how many path strings it has
    std::vector<float> words;   ///< numbers of path strings, ascending within a pixel
    std::array<std::vector<float>, 3> rgb;
    std::vector<float> errors;  ///< standard errors of their luminance
};

/// About the packed size of a pixel's path string: four halves of 1.75 bytes (page_layers.cpp), and a number.
constexpr std::size_t bytes_per_path_string = 8;

class Reducer {
  public:
    Reducer(display::AtlasFile& atlas, int block) : atlas_(atlas), block_(block) {
        page_.block = block;
        page_.width = (atlas.width() + block - 1) / block;
        page_.height = (atlas.height() + block - 1) / block;
    }
    /// False if there are more than `most` path strings.
    Result<bool> run(std::size_t most) {
        const auto columns = static_cast<std::size_t>(page_.width);
        for (int y = 0; y < atlas_.height(); ++y) {
            if (y % block_ == 0) {
                blocks_.assign(columns, {});
                samples_.assign(columns, {});
                pixels_.assign(columns, 0);
            }
            if (Status read = atlas_.row(y, row_); !read) return read.error();
            for (std::size_t x = 0; x < row_.rgba.size(); ++x) add_pixel(x);
            if ((y + 1) % block_ != 0 && y + 1 != atlas_.height()) continue;
            for (std::size_t x = 0; x < columns; ++x) finish_block(x);
            if (page_.words.size() > most) return false;
        }
        return true;
    }
    [[nodiscard]] const PagePathStrings& page() const { return page_; }

  private:
    void add_pixel(std::size_t x) {
        const std::size_t to = x / static_cast<std::size_t>(block_);
        ++pixels_[to];
        for (std::size_t k = 0; k < PathAtlas::parts; ++k) samples_[to][k] += row_.counts[x][k];
        for (std::size_t i = row_.begin[x]; i < row_.begin[x + 1]; ++i) {
            const display::PathStringSample& sample = row_.samples[i];
            BlockPathString& word = blocks_[to][sample.word];
            double luminance = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                word.rgb[c] += sample.rgb[c];
                luminance += sample.rgb[c] / 3;
            }
            for (std::size_t k = 0; k < PathAtlas::parts; ++k)
                word.luminance[k] += luminance * static_cast<double>(sample.parts[k]);
        }
    }
    void finish_block(std::size_t x) {
        page_.counts.push_back(static_cast<float>(blocks_[x].size()));
        for (auto& [number, word] : blocks_[x]) {
            page_.words.push_back(static_cast<float>(number));
            for (std::size_t c = 0; c < 3; ++c) page_.rgb[c].push_back(static_cast<float>(word.rgb[c] / pixels_[x]));
            for (double& luminance : word.luminance) luminance /= pixels_[x];
            page_.errors.push_back(static_cast<float>(standard_error(word.luminance, samples_[x])));
        }
    }

    display::AtlasFile& atlas_;
    int block_;
    PagePathStrings page_;
    display::AtlasRow row_;
    std::vector<std::map<std::uint32_t, BlockPathString>> blocks_;  // [block of a row]
    std::vector<std::array<float, PathAtlas::parts>> samples_;
    std::vector<double> pixels_;
};

Result<PagePathStrings> reduced(display::AtlasFile& atlas, std::size_t most) {
    for (int block = 1;; block = block + std::max(1, block / 2)) {
        Reducer reducer(atlas, block);
        const auto fits = reducer.run(most);
        if (!fits) return fits.error();
        // A page of one block cannot be reduced further.
        if (*fits || block >= std::max(atlas.width(), atlas.height())) return reducer.page();
    }
}

Json letters_json(const std::vector<PathStringTable::Letter>& letters) {
    Json json = Json::array();
    for (const PathStringTable::Letter letter : letters)
        json.push_back(letter == PathAlphabet::open ? -1 : static_cast<int>(letter));
    return json;
}

Json table_json(const PathStringTable& table) {
    constexpr std::string_view types = "CRTVLBOU", scatters = "xDGSs";
    Json json{{"events", Json::array()}, {"letters", letters_json(table.letters)}, {"words", Json::array()}};
    for (const lpe::Event& event : table.events)
        json["events"].push_back(Json{{"type", std::string(1, types[static_cast<std::size_t>(event.type)])},
                                      {"scatter", std::string(1, scatters[static_cast<std::size_t>(event.scatter)])},
                                      {"number", event.lobe_number},
                                      {"labels", event.labels},
                                      {"text", lpe::to_text(event)}});
    for (const auto& word : table.words) json["words"].push_back(letters_json(word));
    for (const display::Technique& each : table.techniques) json["techniques"].push_back({each.s, each.t});
    return json;
}

/// The attributes of a header that identify the render.
constexpr std::array names_of_a_render{"raylex/scene",          "raylex/seed",       "raylex/samples_per_pixel",
                                       "raylex/camera_samples", "raylex/integrator", "raylex/filter"};

/// The power of two that scales the largest value to between 2^14 and 2^15, so that small values keep their precision
/// as half floats.
float scale_of(std::span<const float> values) {
    float most = 0;
    for (const float value : values)
        if (std::isfinite(value)) most = std::max(most, std::abs(value));
    return most > 0 ? std::exp2(std::floor(std::log2(most)) - 14) : 1;
}

std::string element(const std::string& id, const std::string& packed) {
    return "<script type=\"text/plain\" id=\"" + id + "\">" + packed + "</script>\n";
}

}  // namespace

bool is_atlas_of(const display::AtlasFile& atlas, const display::ExrImage& image) {
    if (atlas.width() != image.width || atlas.height() != image.height) return false;
    const auto& attributes = atlas.description().attributes;
    return std::all_of(names_of_a_render.begin(), names_of_a_render.end(), [&](const char* name) {
        const auto of_atlas = attributes.find(name), of_image = image.attributes.find(name);
        return of_atlas != attributes.end() && of_image != image.attributes.end() &&
               of_atlas->second == of_image->second;
    });
}

Result<display::ExrImage> image_of_atlas(const std::string& path) {
    auto image = display::read_exr(path);
    if (!image) return image.error();
    for (display::ImageLayer& layer : image->layers)
        std::erase_if(layer.planes, [](const display::ImagePlane& plane) {
            return plane.name.size() > 1;  // n0 ... n7 count samples
        });
    return image;
}

Result<std::string> path_strings_html(display::AtlasFile& atlas, std::size_t number, std::size_t bytes) {
    auto page = reduced(atlas, bytes / bytes_per_path_string);
    if (!page) return page.error();
    const std::string id = "words-" + std::to_string(number);
    std::vector<float> light;
    for (const std::vector<float>& plane : page->rgb) light.insert(light.end(), plane.begin(), plane.end());
    const float scale = scale_of(light), error_scale = scale_of(page->errors);
    for (float& value : light) value /= scale;
    for (float& value : page->errors) value /= error_scale;
    const PathStringTable& table = atlas.table();
    const std::string text = json_text(table_json(table));
    const Json data{{"name", std::filesystem::path(atlas.path()).filename().string()},
                    {"id", id},
                    {"block", page->block},
                    {"width", page->width},
                    {"height", page->height},
                    {"scale", scale},
                    {"errorScale", error_scale},
                    {"techniques", table.rules.techniques},
                    {"mostVertices", PathAlphabet::most_vertices},
                    {"signed", table.is_signed()}};
    return "<script type=\"application/json\" class=\"words\">" + script_json(json_text(data)) + "</script>\n" +
           element(id + "-table",
                   pack_bytes(std::span(reinterpret_cast<const unsigned char*>(text.data()), text.size()))) +
           element(id + "-counts", pack_integers(page->counts)) + element(id + "-numbers", pack_integers(page->words)) +
           element(id + "-light", pack_halves(light)) + element(id + "-errors", pack_halves(page->errors));
}

std::string expression_names() {
    Json json = Json::object();
    for (const lpe::NamedExpression& each : lpe::builtin_names())
        json[std::string(each.name)] = std::string(each.expression);
    return json_text(json);
}

}  // namespace raylex::experiments
