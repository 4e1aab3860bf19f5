#include "experiments/atlas/top_contributions.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/atlas/requested_layers.h"

namespace raylex::experiments {
namespace {

using display::PathAlphabet;
using display::PathAtlas;
using display::PathStringTable;
using Parts = std::array<double, PathAtlas::parts>;

double mean_of(const std::array<double, 3>& rgb) {
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

void add_parts(const display::PathStringSample& sample, Parts& sum) {
    const double whole = mean_of(sample.rgb);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += whole * static_cast<double>(sample.parts[k]);
}

/// An event as part of an expression and as part of a layer name. It ignores object labels and does not distinguish
/// glossy from singular scattering.
struct Notation {
    std::string expression, name;
};

Notation notation_of(const lpe::Event& event, bool groups) {
    switch (event.type) {
        case lpe::EventType::volume:
            return {"V", "V"};
        case lpe::EventType::emission:
            return {"O", "O"};
        case lpe::EventType::light:
        case lpe::EventType::background: {
            // In renderman, L also matches the background.
            const std::string group = event.labels.empty() ? "" : event.labels.front();
            if (!groups) return {"L", "L"};
            std::string quoted, plain;
            for (const char c : group) {
                if (c == '\'' || c == '\\' || c == '*' || c == '?') quoted += '\\';
                quoted += c;
                plain += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
            }
            return {group.empty() ? "<L.''>" : "<L.'" + quoted + "'>", group.empty() ? "L" : "L_" + plain};
        }
        default: {
            const char type = event.type == lpe::EventType::reflection ? 'R' : 'T';
            const char scatter = event.scatter == lpe::Scatter::diffuse ? 'D' : 'S';
            return {std::string("<") + type + scatter + ">", std::string(1, type) + scatter};
        }
    }
}

/// Returns the notation of a word; words with equal notation form one layer. Empty if the word is a class whose
/// scattering events are not all known.
Notation notation_of(const PathStringTable& table, const std::vector<PathStringTable::Letter>& word) {
    Notation all{"C", "C"};
    for (const PathStringTable::Letter letter : word) {
        if (letter == PathAlphabet::open) return {};
        for (std::size_t i = 0; i < table.events.size(); ++i) {
            if (table.letters[i] != letter) continue;
            if (table.events[i].scatter == lpe::Scatter::straight) break;  // renderman has no such event
            const Notation one = notation_of(table.events[i], table.rules.groups);
            all.expression += one.expression;
            all.name += "_" + one.name;
            break;
        }
    }
    return all;
}

/// Sums for one kind of word, in one pixel and over the image.
struct Kind {
    Notation notation;
    Parts here{};
    bool touched = false;
    double light = 0, variance = 0;
};

}  // namespace

Result<PixelContributions> top_contributions(display::AtlasFile& atlas, int x, int y, std::size_t most) {
    if (x < 0 || y < 0 || x >= atlas.width() || y >= atlas.height())
        return error_at({"--at", 0, 0}, "pixel (" + std::to_string(x) + ", " + std::to_string(y) +
                                            ") is outside the image of " + std::to_string(atlas.width()) + " x " +
                                            std::to_string(atlas.height()) + " pixels");
    display::AtlasRow row;
    if (Status read = atlas.row(y, row); !read) return read.error();
    const auto at = static_cast<std::size_t>(x);
    PixelContributions pixel;
    pixel.rgba = row.rgba[at];
    Parts whole{};
    for (const float count : row.counts[at]) pixel.samples += static_cast<double>(count);
    for (std::size_t i = row.begin[at]; i < row.begin[at + 1]; ++i) {
        const display::PathStringSample& sample = row.samples[i];
        Parts parts{};
        add_parts(sample, parts);
        add_parts(sample, whole);
        pixel.words.push_back({sample.word, sample.rgb, mean_of(sample.rgb), standard_error(parts, row.counts[at])});
    }
    const std::array<float, 4>& rgba = pixel.rgba;
    pixel.mean = mean_of({static_cast<double>(rgba[0]), static_cast<double>(rgba[1]), static_cast<double>(rgba[2])});
    pixel.error = standard_error(whole, row.counts[at]);
    std::stable_sort(pixel.words.begin(), pixel.words.end(), [](const TopContribution& a, const TopContribution& b) {
        return std::abs(a.mean) > std::abs(b.mean);
    });
    pixel.more = pixel.words.size() - std::min(pixel.words.size(), most);
    pixel.words.resize(std::min(pixel.words.size(), most));
    return pixel;
}

Result<std::vector<std::array<int, 2>>> brightest_outliers(display::AtlasFile& atlas, std::size_t most) {
    const int width = atlas.width(), height = atlas.height();
    std::vector<float> means;
    display::AtlasRow row;
    for (int y = 0; y < height; ++y) {
        if (Status read = atlas.row(y, row); !read) return read.error();
        for (const std::array<float, 4>& rgba : row.rgba) means.push_back((rgba[0] + rgba[1] + rgba[2]) / 3);
    }
    const auto mean_at = [&](int x, int y) {
        return means[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    };
    std::vector<std::pair<float, std::array<int, 2>>> found;
    std::vector<float> around;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            around.clear();
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
                    if (u != x || v != y) around.push_back(mean_at(u, v));
            const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
            std::nth_element(around.begin(), middle, around.end());
            const float above = mean_at(x, y) - (around.empty() ? 0.0f : *middle);
            if (above > 0) found.push_back({above, {x, y}});
        }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::array<int, 2>> pixels;
    for (std::size_t k = 0; k < std::min(found.size(), most); ++k) pixels.push_back(found[k].second);
    return pixels;
}

Result<std::vector<SuggestedLayer>> suggest_partition(display::AtlasFile& atlas, std::size_t most) {
    const PathStringTable& table = atlas.table();
    std::vector<Kind> kinds;
    std::vector<std::size_t> kind_of;
    std::map<std::string, std::size_t> known;
    for (const auto& word : table.words) {
        Notation notation = notation_of(table, word);
        const auto [place, fresh] = known.try_emplace(notation.expression, kinds.size());
        if (fresh) kinds.emplace_back().notation = std::move(notation);
        kind_of.push_back(place->second);
    }
    double light = 0, variance = 0;
    display::AtlasRow row;
    std::vector<std::size_t> here;
    for (int y = 0; y < atlas.height(); ++y) {
        if (Status read = atlas.row(y, row); !read) return read.error();
        for (std::size_t x = 0; x < row.rgba.size(); ++x) {
            here.clear();
            for (std::size_t i = row.begin[x]; i < row.begin[x + 1]; ++i) {
                Kind& kind = kinds[kind_of[row.samples[i].word]];
                if (!std::exchange(kind.touched, true)) here.push_back(kind_of[row.samples[i].word]);
                add_parts(row.samples[i], kind.here);
                kind.light += mean_of(row.samples[i].rgb);
            }
            for (const std::size_t k : here) {
                const double error = standard_error(kinds[k].here, row.counts[x]);
                if (std::isfinite(error)) kinds[k].variance += error * error;
                kinds[k].here = {};
                kinds[k].touched = false;
            }
        }
    }
    for (const Kind& kind : kinds) {
        light += kind.light;
        variance += kind.variance;
    }
    if (!(variance > 0)) return std::vector<SuggestedLayer>();
    std::stable_sort(kinds.begin(), kinds.end(), [](const Kind& a, const Kind& b) { return a.variance > b.variance; });
    std::vector<SuggestedLayer> layers;
    SuggestedLayer rest{"rest", {}, 0, 0};
    for (const Kind& kind : kinds) {
        const double brings = light != 0 ? kind.light / light : 0, noise = kind.variance / variance;
        if (layers.size() < most && !kind.notation.expression.empty()) {
            layers.push_back({kind.notation.name, kind.notation.expression, brings, noise});
        } else {
            rest.light += brings;
            rest.noise += noise;
        }
    }
    layers.push_back(rest);
    return layers;
}

}  // namespace raylex::experiments
