// The atlas of a render, with its words in an order that depends only on their light.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "display/output/atlas/atlas_file.h"
#include "display/output/splits/stored_precision.h"
#include "display/output/writer/exr_pixels.h"

namespace raylex::display {
namespace {

class RenderAtlas final : public AtlasSource {
  public:
    RenderAtlas(const PathAtlas& atlas, const PathAlphabet& alphabet, const FrameBuffer& image, ChannelId beauty,
                SignedLight negative)
        : atlas_(atlas), image_(image), beauty_(beauty) {
        const std::vector<double> light = atlas.light_of_path_strings();
        std::vector<std::vector<PathStringTable::Letter>> letters(light.size());
        std::vector<std::uint32_t> order;
        for (std::uint32_t word = 0; word < light.size(); ++word) {
            if (light[word] <= 0) continue;  // prefixes of words, and merged words
            letters[word] = atlas.words().letters(word);
            order.push_back(word);
        }
        // Numbers of words depend on threads; their letters do not.
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return light[a] != light[b] ? light[a] > light[b] : letters[a] < letters[b];
        });
        number_.assign(light.size(), none);
        for (const std::uint32_t word : order) {
            number_[word] = static_cast<std::uint32_t>(table_.words.size());
            if (alphabet.rules().techniques) {
                table_.techniques.push_back(PathAlphabet::technique_of(letters[word].back()));
                letters[word].pop_back();
            }
            table_.words.push_back(std::move(letters[word]));
        }
        table_.rules = alphabet.rules();
        table_.dropped_straight = atlas.dropped_straight();
        table_.negative = negative;
        table_.merged = atlas.merged_path_strings();
        for (std::size_t column = 1; column < atlas.seen().size(); ++column) {
            if (atlas.seen()[column] == 0 || alphabet.event(column).type == lpe::EventType::user) continue;
            const bool unread = alphabet.kind(column) == PathAlphabet::Kind::straight && !table_.rules.straight;
            if (unread) continue;
            table_.events.push_back(alphabet.event(column));
            table_.letters.push_back(alphabet.letter(column));
        }
    }
    [[nodiscard]] int width() const override { return image_.layout().width; }
    [[nodiscard]] int height() const override { return image_.layout().height; }
    [[nodiscard]] const PathStringTable& table() const override { return table_; }

    Status row(int y, AtlasRow& row) override {
        const PixelRegion line{0, y, width(), y + 1};
        const std::vector<double> beauty = image_.resolve(beauty_, line), alpha = image_.resolve_alpha(line);
        const auto columns = static_cast<std::size_t>(width());
        row.begin.assign(1, 0);
        row.samples.clear();
        row.rgba.resize(columns);
        row.counts.resize(columns);
        for (std::size_t x = 0; x < columns; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y) * columns + x;
            Repairs repairs;  // check_atlas() counts them
            for (std::size_t c = 0; c < 3; ++c)
                row.rgba[x][c] = repairs.to_stored(beauty[3 * x + c], 0, StoredType::single_float);
            row.rgba[x][3] = static_cast<float>(alpha[x]);
            const auto counts = atlas_.samples(pixel);
            std::transform(counts.begin(), counts.end(), row.counts[x].begin(),
                           [](std::uint32_t count) { return static_cast<float>(count); });
            atlas_.resolve(pixel, image_.light_path_count(), light_);
            const auto first = static_cast<std::ptrdiff_t>(row.samples.size());
            for (const PathAtlas::Light& light : light_) add(light, row);
            std::sort(row.samples.begin() + first, row.samples.end(),
                      [](const PathStringSample& a, const PathStringSample& b) { return a.word < b.word; });
            row.begin.push_back(static_cast<std::uint32_t>(row.samples.size()));
        }
        return success();
    }

  private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    void add(const PathAtlas::Light& light, AtlasRow& row) {
        if (number_[light.word] == none) return;  // a word without light
        PathStringSample& sample = row.samples.emplace_back();
        sample.word = number_[light.word];
        double all = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            sample.rgb[c] = light.rgb[c];
            all += light.rgb[c];
        }
        for (std::size_t k = 0; k < PathAtlas::parts; ++k)
            sample.parts[k] = all == 0 ? 0 : static_cast<float>(light.eighths[k] / all);
    }

    const PathAtlas& atlas_;
    const FrameBuffer& image_;
    ChannelId beauty_;
    PathStringTable table_;
    std::vector<std::uint32_t> number_;  // [word of the atlas] number in the file
    std::vector<PathAtlas::Light> light_;
};

}  // namespace

std::unique_ptr<AtlasSource> atlas_of_render(const PathAtlas& atlas, const PathAlphabet& alphabet,
                                             const FrameBuffer& image, ChannelId beauty, SignedLight negative) {
    return std::make_unique<RenderAtlas>(atlas, alphabet, image, beauty, negative);
}

Result<AtlasCheck> check_atlas(AtlasSource& source, double magnitude) {
    AtlasCheck result;
    result.words = source.table().words.size();
    AtlasRow row;
    for (int y = 0; y < source.height(); ++y) {
        if (Status read = source.row(y, row); !read) return read.error();
        for (std::size_t x = 0; x < row.rgba.size(); ++x) {
            result.most_samples = std::max<std::uint64_t>(result.most_samples, row.begin[x + 1] - row.begin[x]);
            bool exceeds = false, clamped = false;
            for (std::size_t c = 0; c < 3; ++c) {
                double sum = 0, whole = std::abs(static_cast<double>(row.rgba[x][c]));
                bool sum_is_clamped = false;
                const bool whole_is_clamped = is_clamped(row.rgba[x][c], StoredType::single_float);
                for (std::size_t i = row.begin[x]; i < row.begin[x + 1]; ++i) {
                    const auto value = row.samples[i].rgb[c];
                    sum += value;
                    whole += std::abs(value);
                    sum_is_clamped |= std::abs(value) >= static_cast<double>(largest_of(StoredType::single_float));
                }
                clamped = clamped || sum_is_clamped || whole_is_clamped;
                const double error =
                    error_of_clamped(sum, static_cast<double>(row.rgba[x][c]), sum_is_clamped, whole_is_clamped);
                exceeds = exceeds || !(error <= 0x1p-23 * whole + cancelled_unit * magnitude);
                if (const double relative = whole > 0 ? error / whole : 0; relative > result.largest) {
                    result.largest = relative;
                    result.x = static_cast<int>(x);
                    result.y = y;
                }
            }
            result.exceeding += exceeds ? 1 : 0;
            result.clamped += clamped ? 1 : 0;
        }
        result.samples += row.samples.size();
    }
    result.holds = result.exceeding == 0;
    return result;
}

}  // namespace raylex::display
