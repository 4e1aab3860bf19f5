#include "display/buffer/adaptive/adaptive_sampler.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "display/buffer/record_bytes.h"

namespace raylex::display {
namespace {

/// The shortest text that parses back to the value.
std::string number_text(double value) {
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

Status check_ranges(const AdaptiveSettings& settings) {
    const auto refuse = [&](const std::string& found, const std::string& expected) {
        return error_at(settings.location, "adaptive sampling with " + found + "; expected " + expected);
    };
    if (!(settings.error > 0) || !std::isfinite(settings.error))
        return refuse("an error of " + number_text(settings.error), "a relative error above 0, such as 0.01 or 1%");
    if (settings.max_samples < 2)  // one sample has no error estimate
        return refuse("at most " + std::to_string(settings.max_samples) + " samples a pixel", "at least 2");
    if (settings.min_samples > settings.max_samples)
        return refuse("at least " + std::to_string(settings.min_samples) + " and at most " +
                          std::to_string(settings.max_samples) + " samples",
                      "min_samples up to max_samples");
    if (!(settings.floor >= 0) || !std::isfinite(settings.floor))
        return refuse("a floor of " + number_text(settings.floor),
                      "a share of the image's mean from 0 on, such as 0.1");
    if (settings.neighbourhood < 0 || settings.neighbourhood > 8)
        return refuse("a neighbourhood of " + std::to_string(settings.neighbourhood), "a radius of 0 to 8 pixels");
    return success();
}

/// The expected maximum of as many standard normal numbers as a neighbourhood of that radius has pixels.
double largest_normal(int radius) {
    constexpr std::array<double, 9> expected{0, 1.4850, 1.9653, 2.2412, 2.4313, 2.5750, 2.6897, 2.7849, 2.8658};
    return expected[static_cast<std::size_t>(radius)];
}

/// Returns the id of the channel with that name, or invalid_channel.
ChannelId channel_named(std::span<const ChannelDefinition> channels, const std::string& name) {
    for (std::size_t i = 0; i < channels.size(); ++i)
        if (channels[i].name == name) return static_cast<ChannelId>(i);
    return invalid_channel;
}

}  // namespace

Status AdaptiveSampler::check(const AdaptiveSettings& settings, std::span<const ChannelDefinition> channels,
                              ChannelId beauty) {
    if (Status ranges = check_ranges(settings); !ranges) return ranges;
    if (settings.channels.empty() && beauty < 0)
        return error_at(settings.location,
                        "adaptive sampling without a beauty and without channels; expected the channels of its metric");
    for (std::size_t i = 0; i < settings.channels.size(); ++i) {
        const AdaptiveChannel& each = settings.channels[i];
        const ChannelId id = channel_named(channels, each.name);
        if (id < 0) {
            std::vector<std::string> names;
            std::string list;
            for (const ChannelDefinition& channel : channels) {
                names.push_back(channel.name);
                list += (list.empty() ? "" : ", ") + channel.name;
            }
            return error_at(each.location,
                            "the metric of adaptive sampling names the channel '" + each.name +
                                "', which does not exist; expected one of: " + list,
                            near_miss(each.name, names));
        }
        const ChannelDefinition& channel = channels[static_cast<std::size_t>(id)];
        if (channel.rule != FilterRule::filter || channel.type == ChannelType::integer || !takes_samples(channel))
            return error_at(each.location, "the metric of adaptive sampling names the channel '" + each.name +
                                               "', whose samples are not averaged by the pixel filter; expected light, "
                                               "colours or filtered numbers");
        if (!(each.weight > 0) || !std::isfinite(each.weight))
            return error_at(each.location, "channel '" + each.name + "' has the weight " + number_text(each.weight) +
                                               " in the metric of adaptive sampling; expected a number above 0");
        for (std::size_t k = 0; k < i; ++k)
            if (settings.channels[k].name == each.name)
                return error_at(each.location, "the metric of adaptive sampling names the channel '" + each.name +
                                                   "' twice; expected every channel once");
    }
    return success();
}

AdaptiveSampler::AdaptiveSampler(const AdaptiveSettings& settings, std::span<const ChannelDefinition> channels,
                                 ChannelId beauty, const FrameBufferLayout& layout)
    : settings_(settings), layout_(layout) {
    if (settings_.channels.empty()) settings_.channels.push_back({channels[static_cast<std::size_t>(beauty)].name});
    for (const AdaptiveChannel& each : settings_.channels) ids_.push_back(channel_named(channels, each.name));
    const std::size_t pixels = static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height);
    open_.assign(pixels, 1);
    const auto block = static_cast<std::uint64_t>(layout.block_size);
    blocks_ = std::max<std::uint64_t>(1, (settings_.min_samples + block - 1) / block);
    progress_.target = settings_.error;
    progress_.open_pixels = pixels;
    progress_.predicted_samples = std::min(blocks_ * block, settings_.max_samples) * pixels;
}

PooledErrors AdaptiveSampler::add_errors(const FrameBuffer& buffer, ChannelId id, double weight, double& mean_square) {
    std::vector<PixelMoments> pixels;
    {  // free these before the pools are built: a large image has no room for both
        const std::vector<double> values = buffer.resolve(id), variances = buffer.resolve_variance_of_mean(id);
        pixels = pixel_moments(values, variances, values.size() / errors_.size());
    }
    const double dark = darkest(pixels, settings_.floor);
    mean_square = 0;
    for (int y = 0; y < layout_.height; ++y)
        for (int x = 0; x < layout_.width; ++x) {
            PixelMoments& pixel = pixels[index(x, y)];
            pixel.samples = static_cast<double>(buffer.sample_count(x, y));
            const double error = relative_error(pixel, dark, weight);
            mean_square += error * error;
            errors_[index(x, y)] = std::max(errors_[index(x, y)], error);
        }
    mean_square /= static_cast<double>(errors_.size());
    return {pixels, layout_.width, layout_.height, dark};
}

std::vector<double> AdaptiveSampler::spread(const std::vector<double>& values) const {
    if (settings_.neighbourhood == 0) return values;
    // The maximum over a square is the maximum of its rows' maxima.
    std::vector<double> rows(values.size()), result(values.size());
    for (int y = 0; y < layout_.height; ++y)
        for (int x = 0; x < layout_.width; ++x) {
            const int last = std::min(x + settings_.neighbourhood, layout_.width - 1);
            double largest = 0;
            for (int at = std::max(x - settings_.neighbourhood, 0); at <= last; ++at)
                largest = std::max(largest, values[index(at, y)]);
            rows[index(x, y)] = largest;
        }
    for (int y = 0; y < layout_.height; ++y)
        for (int x = 0; x < layout_.width; ++x) {
            const int last = std::min(y + settings_.neighbourhood, layout_.height - 1);
            double largest = 0;
            for (int at = std::max(y - settings_.neighbourhood, 0); at <= last; ++at)
                largest = std::max(largest, rows[index(x, at)]);
            result[index(x, y)] = largest;
        }
    return result;
}

void AdaptiveSampler::decide(const FrameBuffer& buffer) {
    errors_.assign(open_.size(), 0);
    progress_.error = -1;
    std::vector<PooledErrors> pools;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
        double mean_square = 0;
        pools.push_back(add_errors(buffer, ids_[i], settings_.channels[i].weight, mean_square));
        if (const double error = std::sqrt(mean_square); error > progress_.error) {
            progress_.error = error;
            progress_.channel = settings_.channels[i].name;
            worst = i;
        }
    }
    const std::vector<double> largest = spread(errors_);
    taken_ += blocks_;
    blocks_ = std::max<std::uint64_t>(1, taken_ / 8);
    progress_.open_pixels = 0;
    for (int y = 0; y < layout_.height; ++y)
        for (int x = 0; x < layout_.width; ++x) {
            const std::size_t pixel = index(x, y);
            const std::uint64_t samples = buffer.sample_count(x, y);
            const bool open = samples < settings_.max_samples &&
                              (samples < settings_.min_samples || largest[pixel] > settings_.error);
            open_[pixel] = open ? 1 : 0;
            progress_.open_pixels += open ? 1 : 0;
        }
    predict(buffer, largest, pools, worst);
}

void AdaptiveSampler::predict(const FrameBuffer& buffer, const std::vector<double>& largest,
                              std::vector<PooledErrors>& pools, std::size_t worst) {
    forecast_ = ErrorForecast(settings_.channels[worst].weight);
    forecast_.add_level(pools[worst]);
    const double tolerance = settings_.error * settings_.error, deviations = largest_normal(settings_.neighbourhood);
    std::vector<ErrorPoint> points(open_.size());
    std::vector<double> needed(open_.size());  // 0: more samples than any pool so far reaches
    for (int y = 0; y < layout_.height; ++y)
        for (int x = 0; x < layout_.width; ++x) {
            const std::size_t pixel = index(x, y);
            points[pixel] = {static_cast<double>(buffer.sample_count(x, y)), largest[pixel] * largest[pixel]};
            if (open_[pixel] == 0 || points[pixel].square <= tolerance) needed[pixel] = points[pixel].samples;
        }
    while (std::all_of(pools.begin(), pools.end(), [](PooledErrors& each) { return each.grow(); })) {
        forecast_.add_level(pools[worst]);
        std::vector<double> squares(open_.size()), likely(open_.size());
        for (std::size_t i = 0; i < pools.size(); ++i) {
            const double weight = settings_.channels[i].weight * settings_.channels[i].weight;
            for (std::size_t pixel = 0; pixel < squares.size(); ++pixel) {
                const double square = weight * pools[i].squares()[pixel];
                squares[pixel] = std::max(squares[pixel], square);
                likely[pixel] = std::max(likely[pixel], square * (1 + deviations * pools[i].scatter()[pixel]));
            }
        }
        squares = spread(squares);
        for (int y = 0; y < layout_.height; ++y)
            for (int x = 0; x < layout_.width; ++x) {
                const std::size_t pixel = index(x, y);
                const double samples = pools.front().samples(x, y);
                if (needed[pixel] > 0 || samples <= points[pixel].samples) continue;
                const ErrorPoint next{samples, std::max(squares[pixel], likely[pixel]) / samples};
                needed[pixel] = crossing(points[pixel], next, tolerance).value_or(0);
                points[pixel] = next;
            }
    }
    const auto block = static_cast<double>(layout_.block_size), most = static_cast<double>(settings_.max_samples);
    double next_round = 0;  // number of samples when every open pixel has one more block
    for (int y = 0; y < layout_.height; ++y)
        for (int x = 0; x < layout_.width; ++x) {
            const std::size_t pixel = index(x, y);
            const double next = static_cast<double>(buffer.sample_count(x, y)) + (open_[pixel] != 0 ? block : 0);
            next_round += next;
            if (open_[pixel] == 0) continue;
            const ErrorPoint& last = points[pixel];
            if (needed[pixel] == 0)
                needed[pixel] = samples_to_error(last.samples, std::sqrt(last.square), settings_.error);
            needed[pixel] = std::clamp(needed[pixel], next, std::max(most, next));
        }
    PartsOfSum parts;
    add_parts(needed, layout_.width, layout_.height, parts);
    progress_.predicted_samples = static_cast<std::uint64_t>(parts.sum());
    progress_.least_samples = 0;
    if (parts.few_decide() || forecast_.few_samples_decide())
        progress_.least_samples = static_cast<std::uint64_t>(std::max(next_round, parts.lower()));
}

std::uint64_t AdaptiveSampler::unconverged() const {
    std::uint64_t count = 0;
    for (std::size_t pixel = 0; pixel < errors_.size(); ++pixel)
        count += open_[pixel] == 0 && errors_[pixel] > settings_.error ? 1 : 0;
    return count;
}

void AdaptiveSampler::append_record(std::string& bytes) const {
    RecordWriter writer(bytes);
    writer.number(blocks_);
    writer.number(taken_);
    writer.text(progress_.channel);
    writer.number(progress_.error);
    writer.number(progress_.predicted_samples);
    writer.plane({reinterpret_cast<const char*>(open_.data()), open_.size()});
    writer.number(static_cast<std::uint8_t>(errors_.empty() ? 0 : 1));
    writer.plane({reinterpret_cast<const char*>(errors_.data()), errors_.size() * sizeof(double)});
}

Status AdaptiveSampler::restore_record(std::string_view bytes) {
    RecordReader reader(bytes);
    blocks_ = reader.number<std::uint64_t>();
    taken_ = reader.number<std::uint64_t>();
    progress_.channel = reader.text();
    progress_.error = reader.number<double>();
    progress_.predicted_samples = reader.number<std::uint64_t>();
    progress_.least_samples = 0;
    std::fill(open_.begin(), open_.end(), std::uint8_t{0});
    reader.plane({reinterpret_cast<char*>(open_.data()), open_.size()});
    errors_.assign(reader.number<std::uint8_t>() != 0 ? open_.size() : 0, 0.0);
    reader.plane({reinterpret_cast<char*>(errors_.data()), errors_.size() * sizeof(double)});
    if (!reader.at_end()) return error_at({}, "the record of adaptive sampling does not match this image");
    progress_.open_pixels = static_cast<std::uint64_t>(
        std::count_if(open_.begin(), open_.end(), [](std::uint8_t each) { return each != 0; }));
    return success();
}

std::string describe(const AdaptiveSettings& settings) {
    std::string text = "error " + number_text(settings.error) + " of";
    if (settings.channels.empty()) text += " beauty or all light";
    for (const AdaptiveChannel& each : settings.channels) text += " " + each.name + "*" + number_text(each.weight);
    return text + ", " + std::to_string(settings.min_samples) + " to " + std::to_string(settings.max_samples) +
           " samples, floor " + number_text(settings.floor) + ", neighbourhood " +
           std::to_string(settings.neighbourhood);
}

}  // namespace raylex::display
