#include "experiments/atlas/requested_layers.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <optional>

#include "experiments/program/console.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/language/prefixes.h"
#include "lpe/program.h"

namespace raylex::experiments {
namespace {

using Parts = std::array<double, display::PathAtlas::parts>;

Status check_channel(const display::ChannelDefinition& channel, const display::AtlasFile& atlas) {
    const SourceLocation where = display::location_of(channel);
    if (channel.style != display::ChannelStyle::expression)
        return error_at(where,
                        "channel '" + channel.name + "' is not light; an atlas only answers light path expressions",
                        "render it: raylex render --aov " + channel.name);
    lpe::ChannelSource source;
    source.expression = channel.expression;
    source.dialect = channel.dialect;
    const auto prefixes = channel.rest_of.empty() ? lpe::expression_prefixes(source)
                                                  : Result<std::vector<std::string>>(std::vector<std::string>());
    if (!prefixes) return prefixes.error();
    const bool by_technique = prefixes->size() == 1 && lpe::technique_prefix(prefixes->front());
    if (by_technique && !atlas.table().rules.techniques)
        return error_at(where,
                        "channel '" + channel.name + "' needs the technique '" + prefixes->front() +
                            "', and the path strings of " + atlas.path() + " do not distinguish techniques",
                        "render the atlas with --atlas-by label,lobe,group,technique");
    if (!prefixes->empty() && !by_technique)
        return error_at(where,
                        "channel '" + channel.name + "' has the prefix '" + prefixes->front() +
                            "', which changes values, and an atlas stores unchanged light",
                        "render the channel with --lpe, or omit the prefix");
    if (channel.dialect == lpe::Dialect::osl && atlas.table().dropped_straight)
        return error_at(
            where,
            "channel '" + channel.name +
                "' is in the dialect osl, where passing straight through a cutout is an event, and the atlas " +
                atlas.path() + " does not store these events",
            "render the atlas with --atlas-by label,lobe,group,straight");
    return success();
}

}  // namespace

double standard_error(const Parts& luminance, const std::array<float, display::PathAtlas::parts>& counts) {
    double mean = 0, count = 0;
    int parts = 0;
    for (std::size_t k = 0; k < luminance.size(); ++k) {
        if (!(counts[k] > 0)) continue;
        mean += luminance[k];
        count += static_cast<double>(counts[k]);
        ++parts;
    }
    if (parts < 2) return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (std::size_t k = 0; k < luminance.size(); ++k) {
        const double share = static_cast<double>(counts[k]) / count;
        if (!(share > 0)) continue;
        const double off = luminance[k] / share - mean;
        sum += share * off * off;
    }
    return std::sqrt(sum / (parts - 1));
}

Result<lpe::Program> compile_plan(const ChannelPlan& plan, std::vector<std::int32_t>& program_channel) {
    program_channel.assign(plan.channels.size(), -1);
    std::vector<lpe::ChannelSource> sources;
    for (std::size_t i = 0; i < plan.channels.size(); ++i) {
        const display::ChannelDefinition& channel = plan.channels[i];
        if (channel.style != display::ChannelStyle::expression) continue;
        program_channel[i] = static_cast<std::int32_t>(sources.size());
        lpe::ChannelSource source;
        source.name = channel.name;
        source.expression = channel.expression;
        source.dialect = channel.dialect;
        source.origin = channel.origin;
        source.origin_line = channel.origin_line;
        source.origin_column = channel.origin_column;
        for (const std::size_t other : channel.rest_of)
            source.rest_of.push_back(static_cast<std::size_t>(program_channel[other]));
        sources.push_back(std::move(source));
    }
    return lpe::Program::compile(sources);
}

/// Computes the layers from the words, row by row.
class RequestedLayers::Builder {
  public:
    Builder(display::AtlasFile& atlas, const ChannelPlan& plan, const AskSettings& settings, const WhatIf& changed,
            RequestedLayers& to)
        : atlas_(atlas), plan_(plan), settings_(settings), changed_(changed), to_(to) {}

    Status run() {
        for (const display::ChannelDefinition& channel : plan_.channels)
            if (Status good = check_channel(channel, atlas_); !good) return good;
        std::vector<std::int32_t> program_channel;
        auto program = compile_plan(plan_, program_channel);
        if (!program) return program.error();
        const PathStringAnswers answers(atlas_.table(), *program, techniques());
        if (Status planned = plan_layers(answers, program_channel); !planned) return planned;
        atlas_.read_parts(settings_.errors);
        to_.alpha_.allocate(pixel_count());
        tbb::enumerable_thread_specific<display::AtlasRow> row_of_thread;
        std::mutex mutex;
        std::map<int, Error> errors;  // [row]; the first row's error is reported, for any number of threads
        tbb::parallel_for(0, atlas_.height(), [&](int y) {
            display::AtlasRow& row = row_of_thread.local();
            if (Status had = atlas_.row(y, row); !had) {
                const std::lock_guard lock(mutex);
                errors.emplace(y, std::move(had).error());
                return;
            }
            add_row(row, y, answers);
        });
        if (!errors.empty()) return errors.begin()->second;
        return success();
    }

  private:
    /// The image layers of one channel of the program.
    struct Target {
        int least = 0, most = -1, error = -1;
    };
    struct Sum {
        std::array<double, 3> sure{}, possible{};
    };
    /// The light of all path strings of a pixel.
    struct Whole {
        Sum sum;
        Parts luminance{};
        bool changed = false;  ///< some factor is not 1
    };

    /// Returns the techniques in the prefixes of the channels, which have been parsed before.
    [[nodiscard]] PathStringAnswers::Techniques techniques() const {
        PathStringAnswers::Techniques wanted;
        for (const display::ChannelDefinition& channel : plan_.channels) {
            std::optional<lpe::TechniquePrefix>& of_channel = wanted.emplace_back();
            if (!channel.rest_of.empty()) continue;
            lpe::ChannelSource source;
            source.expression = channel.expression;
            source.dialect = channel.dialect;
            const auto prefixes = lpe::expression_prefixes(source);
            if (prefixes && !prefixes->empty()) of_channel = lpe::technique_prefix(prefixes->front());
        }
        return wanted;
    }

    int add_layer(const std::string& name, const display::ChannelDefinition& like, bool light) {
        display::ChannelDefinition channel = like;
        channel.name = name;
        channel.rest_of.clear();
        if (!light) {
            channel.style = display::ChannelStyle::name;
            channel.type = display::ChannelType::real;
            channel.space = "standard error of the mean (R + G + B) / 3 of " + like.name;
        }
        to_.channels_.push_back(std::move(channel));
        const std::size_t components = light ? 3 : 1;
        to_.layers_.emplace_back().components = components;
        to_.layers_.back().pixels.allocate(components * pixel_count());
        return static_cast<int>(to_.channels_.size()) - 1;
    }

    Status plan_layers(const PathStringAnswers& answers, const std::vector<std::int32_t>& program_channel) {
        to_.layout_.width = atlas_.width();
        to_.layout_.height = atlas_.height();
        display::ChannelDefinition whole;
        whole.style = display::ChannelStyle::expression;
        whole.expression = "C.*";
        whole.space = "rendering colour space";
        add_layer("beauty", whole, true);
        for (std::size_t i = 0; i < plan_.channels.size(); ++i) {
            const display::ChannelDefinition& channel = plan_.channels[i];
            const auto number = static_cast<std::uint16_t>(program_channel[i]);
            const std::int64_t word = answers.undecided_path_string(number);
            const bool is_exact = word < 0 && !has_open_factors(answers, number);
            if (word >= 0 && !settings_.intervals)
                return refuse(channel, static_cast<std::uint32_t>(word), answers, number);
            Target target;
            target.least = add_layer(is_exact ? channel.name : channel.name + "_least", channel, true);
            if (!is_exact) {
                target.most = add_layer(channel.name + "_most", channel, true);
                to_.undecided_.push_back(channel.name);
            } else if (settings_.errors) {
                target.error = add_layer(channel.name + "_error", channel, false);
            }
            targets_.push_back(target);
        }
        if (!changed_.most.empty()) {
            beauty_least_ = add_layer("beauty_least", to_.channels_[beauty], true);
            beauty_most_ = add_layer("beauty_most", to_.channels_[beauty], true);
            to_.undecided_.emplace_back("beauty");
        } else if (settings_.errors) beauty_error_ = add_layer("beauty_error", to_.channels_[beauty], false);
        const bool by_filter = atlas_.table().negative == display::SignedLight::weights;
        if (!to_.undecided_.empty() && atlas_.table().is_signed())
            return error_at(
                {atlas_.path(), 0, 0},
                std::string("single path strings can have negative light, because ") +
                    (by_filter ? "the pixel filter has negative lobes" : "the scene disperses light by wavelength") +
                    ", so there are no bounds for channel '" + to_.undecided_.front() + "'",
                by_filter ? "render the atlas with box, triangle, gaussian or blackman-harris"
                          : "render the atlas with a greater --atlas-length or --atlas-budget");
        return success();
    }
    /// Returns whether the channel gets light of which only bounds of the factor are known.
    [[nodiscard]] bool has_open_factors(const PathStringAnswers& answers, std::uint16_t program_channel) const {
        for (std::uint32_t word = 0; word < changed_.most.size(); ++word)
            for (const auto& channels : {answers.all(word), answers.some(word)})
                if (changed_.is_open(word) && std::binary_search(channels.begin(), channels.end(), program_channel))
                    return true;
        return false;
    }
    /// Returns bounds of the channel's light that the merged words leave open: "between 1.2 % and 1.3 % of the image's
    /// light".
    Result<std::string> at_stake(const PathStringAnswers& answers, std::uint16_t program_channel) {
        const auto has = [program_channel](std::span<const std::uint16_t> channels) {
            return std::binary_search(channels.begin(), channels.end(), program_channel);
        };
        double sure = 0, possible = 0, all = 0;
        atlas_.read_parts(false);
        display::AtlasRow row;
        for (int y = 0; y < atlas_.height(); ++y) {
            if (Status read = atlas_.row(y, row); !read) return read.error();
            for (const display::PathStringSample& sample : row.samples) {
                const double light = sample.rgb[0] + sample.rgb[1] + sample.rgb[2];
                all += light;
                sure += has(answers.all(sample.word)) ? light : 0;
                possible += has(answers.some(sample.word)) ? light : 0;
            }
        }
        const auto share = [all](double light) { return number_text(all != 0 ? 100 * light / all : 0) + " %"; };
        return "between " + share(sure) + " and " + share(sure + possible) + " of the image's light";
    }

    /// Returns the option with which a render would distinguish the paths merged in this word.
    [[nodiscard]] std::string remedy(std::uint32_t word) const {
        const display::PathStringTable& table = atlas_.table();
        const auto& letters = table.words[word];
        if (std::find(letters.begin(), letters.end(), display::PathAlphabet::open) == letters.end())
            return "--atlas-by with more than '" + to_string(table.rules) + "'";
        return table.merged > 0 ? "a greater --atlas-budget"
                                : "an --atlas-length above " + std::to_string(table.rules.length);
    }

    Error refuse(const display::ChannelDefinition& channel, std::uint32_t word, const PathStringAnswers& answers,
                 std::uint16_t program_channel) {
        const auto open = at_stake(answers, program_channel);
        if (!open) return open.error();
        return error_at(display::location_of(channel),
                        "channel '" + channel.name +
                            "' cannot be computed exactly: it accepts only some of the paths that " + atlas_.path() +
                            " merges as '" + path_string_text(atlas_.table(), word) + "', which leaves it " + *open,
                        "--intervals makes layers of both bounds; a render with " + remedy(word) + " is exact");
    }

    [[nodiscard]] std::size_t pixel_count() const {
        return static_cast<std::size_t>(atlas_.width()) * static_cast<std::size_t>(atlas_.height());
    }

    void add_row(const display::AtlasRow& row, int y, const PathStringAnswers& answers) {
        std::vector<Sum> sums(targets_.size());
        std::vector<Parts> luminance(settings_.errors ? targets_.size() : 0);
        for (std::size_t x = 0; x < row.rgba.size(); ++x) {
            std::fill(sums.begin(), sums.end(), Sum());
            std::fill(luminance.begin(), luminance.end(), Parts());
            const std::size_t pixel = static_cast<std::size_t>(y) * row.rgba.size() + x;
            const Whole whole = add_words(row, x, answers, sums, luminance);
            put_pixel(row, x, pixel, sums, luminance);
            put_beauty(row, x, pixel, whole);
        }
    }
    Whole add_words(const display::AtlasRow& row, std::size_t x, const PathStringAnswers& answers,
                    std::vector<Sum>& sums, std::vector<Parts>& luminance) const {
        Whole whole;
        for (std::size_t i = row.begin[x]; i < row.begin[x + 1]; ++i) {
            const display::PathStringSample& sample = row.samples[i];
            std::array<double, 3> rgb = sample.rgb, more{};
            if (!changed_.factors.empty()) {
                const std::array<double, 3>& factor = changed_.factors[sample.word];
                for (std::size_t c = 0; c < 3; ++c) rgb[c] *= factor[c];
                whole.changed = whole.changed || factor != std::array<double, 3>{1, 1, 1};
                if (changed_.is_open(sample.word))
                    for (std::size_t c = 0; c < 3; ++c)
                        more[c] = sample.rgb[c] * (changed_.most[sample.word][c] - factor[c]);
                add(rgb, whole.sum.sure);
                add(more, whole.sum.possible);
            }
            if (settings_.errors) add_parts(sample, rgb, whole.luminance);
            for (const std::uint16_t channel : answers.all(sample.word)) {
                add(rgb, sums[channel].sure);
                add(more, sums[channel].possible);
                if (settings_.errors) add_parts(sample, rgb, luminance[channel]);
            }
            for (const std::uint16_t channel : answers.some(sample.word)) {
                add(rgb, sums[channel].possible);
                add(more, sums[channel].possible);
            }
        }
        return whole;
    }
    void put_beauty(const display::AtlasRow& row, std::size_t x, std::size_t pixel, const Whole& whole) {
        const std::array<float, 4>& rgba = row.rgba[x];
        const Sum& sum = whole.sum;
        const bool changed = whole.changed || sum.possible != std::array<double, 3>{};
        const auto bound = [&](double part) -> std::array<double, 3> {
            if (!changed) return {rgba[0], rgba[1], rgba[2]};
            return {sum.sure[0] + part * sum.possible[0], sum.sure[1] + part * sum.possible[1],
                    sum.sure[2] + part * sum.possible[2]};
        };
        put(beauty, pixel, bound(0.5));
        if (beauty_least_ >= 0) {
            put(beauty_least_, pixel, bound(0));
            put(beauty_most_, pixel, bound(1));
        }
        to_.alpha_[pixel] = rgba[3];
        if (beauty_error_ >= 0)
            to_.layers_[static_cast<std::size_t>(beauty_error_)].pixels[pixel] =
                static_cast<float>(standard_error(whole.luminance, row.counts[x]));
    }
    void put_pixel(const display::AtlasRow& row, std::size_t x, std::size_t pixel, const std::vector<Sum>& sums,
                   const std::vector<Parts>& luminance) {
        for (std::size_t channel = 0; channel < sums.size(); ++channel) {
            const Sum& sum = sums[channel];
            put(targets_[channel].least, pixel, sum.sure);
            if (targets_[channel].most >= 0)
                put(targets_[channel].most, pixel,
                    {sum.sure[0] + sum.possible[0], sum.sure[1] + sum.possible[1], sum.sure[2] + sum.possible[2]});
            if (targets_[channel].error >= 0)
                to_.layers_[static_cast<std::size_t>(targets_[channel].error)].pixels[pixel] =
                    static_cast<float>(standard_error(luminance[channel], row.counts[x]));
        }
    }
    static void add(const std::array<double, 3>& rgb, std::array<double, 3>& sum) {
        for (std::size_t c = 0; c < 3; ++c) sum[c] += rgb[c];
    }
    static void add_parts(const display::PathStringSample& sample, const std::array<double, 3>& rgb, Parts& luminance) {
        const double whole = (rgb[0] + rgb[1] + rgb[2]) / 3;
        for (std::size_t k = 0; k < luminance.size(); ++k) luminance[k] += whole * static_cast<double>(sample.parts[k]);
    }
    void put(int layer, std::size_t pixel, const std::array<double, 3>& rgb) {
        float* const to = to_.layers_[static_cast<std::size_t>(layer)].pixels.values().data() + 3 * pixel;
        for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(rgb[c]);
    }

    display::AtlasFile& atlas_;
    const ChannelPlan& plan_;
    const AskSettings& settings_;
    const WhatIf& changed_;
    RequestedLayers& to_;
    std::vector<Target> targets_;  // [program channel]
    int beauty_error_ = -1, beauty_least_ = -1, beauty_most_ = -1;
};

Result<RequestedLayers> RequestedLayers::make(display::AtlasFile& atlas, const ChannelPlan& plan,
                                              const AskSettings& settings, const WhatIf& changed) {
    RequestedLayers layers;
    if (Status built = Builder(atlas, plan, settings, changed, layers).run(); !built) return built.error();
    return layers;
}

std::vector<double> RequestedLayers::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const Layer& layer = layers_[static_cast<std::size_t>(id)];
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.y1 - region.y0) *
                   layer.components);
    for (int y = region.y0; y < region.y1; ++y) {
        const std::size_t first = (static_cast<std::size_t>(y) * static_cast<std::size_t>(layout_.width) +
                                   static_cast<std::size_t>(region.x0)) *
                                  layer.components;
        const float* const row = layer.pixels.values().data() + first;
        values.insert(values.end(), row, row + region.width() * static_cast<std::ptrdiff_t>(layer.components));
    }
    return values;
}

std::vector<double> RequestedLayers::resolve_alpha(const display::PixelRegion& region) const {
    std::vector<double> values;
    for (int y = region.y0; y < region.y1; ++y)
        for (int x = region.x0; x < region.x1; ++x)
            values.push_back(
                static_cast<double>(alpha_[static_cast<std::size_t>(y) * static_cast<std::size_t>(layout_.width) +
                                           static_cast<std::size_t>(x)]));
    return values;
}

}  // namespace raylex::experiments
