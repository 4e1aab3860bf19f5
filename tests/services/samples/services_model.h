// A model of the display services with maps and lists, and random programs of calls for it and for the services.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::services_model {

using namespace display;
using test::expression_channel;
using test::plain_channel;
using test::Random;
using RowState = SampleTable::RowState;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr int width = 3, height = 2, samples_per_pixel = 32, block = 16;
constexpr int pixels = width * height, rays = pixels * samples_per_pixel, channels_known = 10;

inline std::vector<ChannelDefinition> model_channels() {
    std::vector<ChannelDefinition> list{
        expression_channel("beauty", "C.*"),
        plain_channel("heat", ChannelType::real),
        plain_channel("paint", ChannelType::rgb),
        plain_channel("P", ChannelType::point),
        plain_channel("N", ChannelType::normal),
        plain_channel("nearest", ChannelType::real, FilterRule::zmin, infinity),
        plain_channel("index", ChannelType::integer, FilterRule::zmin),
        plain_channel("largest", ChannelType::vector, FilterRule::max),
        plain_channel("total", ChannelType::real, FilterRule::sum),
        plain_channel("mean", ChannelType::rgb, FilterRule::average),
    };
    ChannelDefinition layer = plain_channel("layer of heat", ChannelType::real);
    layer.source = 1;  // values cannot be sent to it
    list.push_back(layer);
    return list;
}

// ------------------------------------------------------------------------------------------------- calls and programs

enum class Kind {
    splat_float,
    splat_rgb,
    write_float,
    write_rgb,
    write_integer,
    add,
    distance,
    opacity,
    surface,
    raster
};
struct Call {
    Kind kind = Kind::splat_float;
    int channel = 0;
    int row = 0;  ///< row of the ray: 0 is its camera row, i its i-th extra row; far: outside the batch
    static constexpr int far = 1000;
    Rgb value;
    std::int32_t integer = 0;
    bool volume = false;
};
/// The calls of an integrator for one ray.
using Calls = std::vector<Call>;

struct Program {
    std::vector<Calls> calls;     ///< [ray] rays of a pixel are adjacent, in the order of samples
    std::vector<CameraRow> rows;  ///< [ray]
    std::array<bool, samples_per_pixel / block> discarded{};  ///< [iteration]: a block of samples of every pixel
    bool discard_first = false;                               ///< before all calls of the iteration, or between them
};

inline float some_value(Random& random) {
    return random.below(40) == 0 ? std::numeric_limits<float>::quiet_NaN() : random.uniform_float() * 4 - 1;
}

inline Program random_program(std::uint64_t seed) {
    Random random(seed);
    Program program;
    for (bool& each : program.discarded) each = random.below(5) == 0;
    program.discard_first = random.below(2) == 0;
    for (int ray = 0; ray < rays; ++ray) {
        CameraRow row;
        const int pixel = ray / samples_per_pixel;
        row.pixel_x = pixel % width;
        row.pixel_y = pixel / width;
        row.sample = static_cast<std::uint64_t>(ray % samples_per_pixel);
        row.filter_weight = random.below(2) == 0 ? 1.0f : 0.75f;
        program.rows.push_back(row);
        Calls calls;
        int extra = 0;
        for (int n = random.below(9); n > 0; --n) {
            Call call;
            call.kind = static_cast<Kind>(random.below(10));
            call.channel = random.below(12) == 0 ? invalid_channel : random.below(30) == 0 ? 99 : random.below(11);
            call.row = random.below(40) == 0 ? Call::far : random.below(extra + 1);
            call.value = Rgb(some_value(random), some_value(random), some_value(random));
            call.integer = random.below(1000) - 500;
            call.volume = random.below(2) == 0;
            if (call.kind == Kind::opacity || call.kind == Kind::add) {
                constexpr std::array<float, 5> choices{0, 0.25f, 0.5f, 0.875f, 1};
                call.value = Rgb(choices[static_cast<std::size_t>(random.below(5))],
                                 choices[static_cast<std::size_t>(random.below(5))],
                                 choices[static_cast<std::size_t>(random.below(5))]);
            }
            if (call.kind == Kind::surface) call.integer = random.below(6) - 1;
            if (call.kind == Kind::add && call.row != Call::far) ++extra;
            calls.push_back(call);
        }
        program.calls.push_back(std::move(calls));
    }
    return program;
}

inline float depth_of(const Call& call) {
    return static_cast<float>(1 + (call.integer + 500) % 7);
}

// -------------------------------------------------------------------------------------------------------------- model

struct ModelValue {
    RowState state = RowState::untouched;
    std::array<double, 3> v{};
};
struct ModelRow {
    float depth = infinity;
    RgbD opacity{0.0};
    bool volume = false;
    int surface = 0;
    std::map<int, ModelValue> values;  ///< by channel
};
struct ModelRay {
    std::vector<ModelRow> rows{1};
};
struct ModelSplat {
    float x, y;
    Rgb value;
    auto operator<=>(const ModelSplat& o) const {
        return std::tuple(x, y, value.r, value.g, value.b) <=> std::tuple(o.x, o.y, o.value.r, o.value.g, o.value.b);
    }
    bool operator==(const ModelSplat&) const = default;
};
struct Model {
    std::vector<ModelRay> rays;
    std::map<std::pair<int, Refusal>, std::uint64_t> refusals;  ///< by channel; -1: none
    std::uint64_t invalid = 0;
    std::vector<ModelSplat> splats;
};

inline bool is_number(const Rgb& value) {
    return is_finite(value);
}

/// Refuses the call as documented, or returns its row.
inline ModelRow* accepted(Model& model, ModelRay& ray, const Call& call, const ChannelDefinition* channel,
                          bool right_type, bool number) {
    const int name = channel == nullptr ? -1 : call.channel;
    const auto refuse = [&](Refusal reason) {
        ++model.refusals[{name, reason}];
        return nullptr;
    };
    if (channel == nullptr || !takes_samples(*channel)) return refuse(Refusal::unknown_channel);
    if (!right_type) return refuse(Refusal::wrong_type);
    if (call.row == Call::far) return refuse(Refusal::unknown_row);
    if (!number) {
        ++model.invalid;
        return refuse(Refusal::bad_value);
    }
    return &ray.rows[static_cast<std::size_t>(call.row)];
}

inline void call_model(Model& model, ModelRay& ray, const Call& call, const std::vector<ChannelDefinition>& list,
                       const CameraRow& camera) {
    const bool to_channel = call.kind <= Kind::write_integer;
    if (to_channel) {
        if (call.channel == invalid_channel) return;  // valid, without effect
        const bool known = call.channel >= 0 && call.channel < static_cast<int>(list.size());
        const ChannelDefinition* channel = known ? &list[static_cast<std::size_t>(call.channel)] : nullptr;
        const bool triple = call.kind == Kind::splat_rgb || call.kind == Kind::write_rgb;
        const bool integer = call.kind == Kind::write_integer;
        const bool right = known && (triple    ? component_count(channel->type) == 3
                                     : integer ? channel->type == ChannelType::integer
                                               : channel->type == ChannelType::real);
        const bool number = integer || (triple ? is_number(call.value) : std::isfinite(call.value.r));
        ModelRow* row = accepted(model, ray, call, channel, right, number);
        if (row == nullptr) return;
        ModelValue& value = row->values[call.channel];
        const bool splat = call.kind == Kind::splat_float || call.kind == Kind::splat_rgb;
        for (int c = 0; c < 3; ++c) {
            const double v = integer ? call.integer : static_cast<double>(triple ? call.value[c] : call.value.r);
            double& to = value.v[static_cast<std::size_t>(c)];
            to = splat ? to + v : v;
        }
        if (!splat) value.state = RowState::written;
        else if (value.state == RowState::untouched) value.state = RowState::splatted;
        return;
    }
    if (call.kind == Kind::raster) {
        if (is_number(call.value)) model.splats.push_back({camera.screen_x, camera.screen_y, call.value});
        else ++model.invalid;
        return;
    }
    const bool good = call.kind != Kind::surface || call.integer >= 0;
    if (!good || call.row == Call::far) {
        ++model.refusals[{-1, good ? Refusal::unknown_row : Refusal::bad_value}];
        return;
    }
    ModelRow& row = ray.rows[static_cast<std::size_t>(call.row)];
    if (call.kind == Kind::distance) row.depth = depth_of(call), row.volume = call.volume;
    if (call.kind == Kind::opacity) row.opacity = RgbD(call.value);
    if (call.kind == Kind::surface) row.surface = call.integer;
    if (call.kind == Kind::add) ray.rows.push_back({depth_of(call), RgbD(call.value), call.volume, 0, {}});
}

inline Model model_of(const Program& program, const std::vector<ChannelDefinition>& list) {
    Model model;
    model.rays.resize(rays);
    for (std::size_t ray = 0; ray < rays; ++ray) {
        if (program.discarded[program.rows[ray].sample / block]) continue;
        for (const Call& call : program.calls[ray]) call_model(model, model.rays[ray], call, list, program.rows[ray]);
    }
    std::sort(model.splats.begin(), model.splats.end());
    return model;
}

/// The rows from front to back with their coverages, and the sample's alpha.
inline std::vector<std::pair<const ModelRow*, double>> front_to_back(const ModelRay& ray, double& alpha) {
    std::vector<std::pair<const ModelRow*, double>> sorted;
    for (const ModelRow& row : ray.rows) sorted.emplace_back(&row, 0);
    std::stable_sort(sorted.begin(), sorted.end(), [](auto& a, auto& b) { return a.first->depth < b.first->depth; });
    RgbD through{1.0};
    for (auto& [row, coverage] : sorted) {
        const double before = through.average();
        through *= RgbD(1.0) - row->opacity;
        coverage = before - through.average();
    }
    alpha = 1 - through.average();
    return sorted;
}

/// The filtered value of one sample in a channel.
inline double sample_value(const ModelRay& ray, int channel, std::size_t component) {
    double alpha = 0, splatted = 0, covered = 0, weighted = 0, first = 0;
    bool any = false;
    for (const auto& [row, coverage] : front_to_back(ray, alpha)) {
        const auto found = row->values.find(channel);
        if (found == row->values.end()) continue;
        const double v = found->second.v[component];
        if (found->second.state != RowState::written || channel == 0) {  // light adds up, in either way
            splatted += v;
            continue;
        }
        if (!any) first = v;
        any = true;
        covered += coverage;
        weighted += coverage * v;
    }
    if (!any) return splatted;
    return splatted + (alpha > 0 ? alpha : 1) * (covered > 0 ? weighted / covered : first);
}

/// The value of a pixel in a channel, by its rule.
inline double pixel_value(const Model& model, const Program& program, const ChannelDefinition& definition, int channel,
                          int pixel, std::size_t component) {
    double sum = 0, weights = 0, picked = 0, nearest = infinity;
    int seen = 0;
    for (int s = 0; s < samples_per_pixel; ++s) {
        const auto at = static_cast<std::size_t>(pixel * samples_per_pixel + s);
        if (program.discarded[program.rows[at].sample / block]) continue;
        const ModelRay& ray = model.rays[at];
        const auto weight = static_cast<double>(program.rows[at].filter_weight);
        weights += weight;
        if (definition.rule == FilterRule::filter) {
            sum += weight * sample_value(ray, channel, component);
            continue;
        }
        double alpha = 0;
        for (const auto& [row, coverage] : front_to_back(ray, alpha)) {
            const auto found = row->values.find(channel);
            if (found == row->values.end()) continue;
            const double v = found->second.v[component];
            if (definition.rule == FilterRule::max && (seen == 0 || v > picked)) picked = v;
            if (definition.rule == FilterRule::zmin && (seen == 0 || row->depth < static_cast<float>(nearest)))
                picked = v, nearest = row->depth;
            ++seen;
            sum += v;
        }
    }
    if (definition.rule == FilterRule::filter) return weights > 0 ? sum / weights : 0;
    if (seen == 0) return static_cast<double>(definition.miss_value);
    if (definition.rule == FilterRule::average) return sum / seen;
    return definition.rule == FilterRule::sum ? sum : picked;
}

}  // namespace raylex::services_model
