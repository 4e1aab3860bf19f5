#include "display/deep/deep_buffer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "display/buffer/fixed_point.h"
#include "display/buffer/ray_rows.h"
#include "display/services/elementary.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

constexpr int quantum = -80;  // like the frame buffer's: 1e-24 of a sample's unit
constexpr int mantissa_bits = 23;
constexpr std::uint32_t background_key = 0xffffffffu;

/// The sort key and bin of a depth: the bits of non-negative floats sort like integers.
std::uint32_t depth_key(float depth, int level) {
    return std::bit_cast<std::uint32_t>(depth) >> level;
}

/// A volume bin and a surface bin with the same key can interleave. The transmittances were computed in the order of
/// the bins. So the order stays, and depths are moved within the key to match it: by ImfDeepImageState.h, (Z, ZBack)
/// must increase strictly, and tidy spans must not overlap.
void put_in_order(DeepSample& front, DeepSample& back, bool tidy) {
    back.z = std::max(back.z, front.z);
    if (tidy) front.z_back = std::min(front.z_back, back.z);
    const bool clash =
        tidy ? back.z == front.z && front.z_back == front.z : back.z == front.z && back.z_back <= front.z_back;
    if (clash) back.z = std::nextafter(front.z, std::numeric_limits<float>::max());
    back.z_back = std::max(back.z_back, back.z);
}

}  // namespace

/// A bin without its sums. Surfaces and volumes of the same depth have separate bins; volume bins come first.
struct DeepBuffer::Bin {
    std::uint32_t key = 0;
    bool surface = false;
    float nearest = 0, farthest = 0;

    [[nodiscard]] bool before(const Bin& other) const {
        return key != other.key ? key < other.key : !surface && other.surface;
    }
    [[nodiscard]] bool same(const Bin& other) const { return key == other.key && surface == other.surface; }
};

struct DeepBuffer::Pixel {
    std::vector<Bin> bins;     // sorted
    std::vector<Int128> sums;  // [bin][stride()]
    Int128 weight = 0;
    std::uint32_t refused = 0;
    std::uint8_t level = 0;  // 0: not started; first_level_ is at least 1
};

struct DeepBuffer::Row {
    int index = 0;
    double weight = 0, drop = 0;  // weight of the sample; drop in transmittance, weight included
    bool background = false;
    bool sample_covers = false;  // the sample's alpha is not 0
};

struct DeepBuffer::Scratch {
    std::vector<Int128> terms;         // [stride()]
    std::vector<WrittenMean> written;  // [chosen channel] of one sample
};

DeepBuffer::DeepBuffer(int width, int height, std::span<const ChannelDefinition> channels,
                       std::vector<ChannelId> chosen, const DeepOptions& options)
    : width_(width),
      height_(height),
      channels_(channels.begin(), channels.end()),
      chosen_(std::move(chosen)),
      options_(options),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    quanta_.assign(2, quantum);
    for (const ChannelId id : chosen_) {
        const ChannelDefinition& channel = channels_[static_cast<std::size_t>(id)];
        components_ += static_cast<std::size_t>(raylex::display::component_count(channel.type));
        quanta_.resize(stride(), quantum + channel.scale_exponent);
    }
    first_level_ =
        std::clamp(mantissa_bits + static_cast<int>(std::floor(elementary::log2(options.tolerance))), 1, mantissa_bits);
}

DeepBuffer::~DeepBuffer() = default;
DeepBuffer::DeepBuffer(DeepBuffer&&) noexcept = default;
DeepBuffer& DeepBuffer::operator=(DeepBuffer&&) noexcept = default;

Status DeepBuffer::check(std::span<const ChannelDefinition> channels, std::span<const ChannelId> chosen,
                         const DeepOptions& options) {
    if (options.most_samples < 1 || options.most_samples > 4096)
        return error_at({}, std::to_string(options.most_samples) + " deep samples per pixel; expected 1 to 4096");
    if (!(options.tolerance >= 0x1p-23) || !(options.tolerance <= 1))
        return error_at({}, "deep tolerance " + std::to_string(options.tolerance) + "; expected 1.2e-7 to 1");
    for (const ChannelId id : chosen) {
        const ChannelDefinition& channel = channels[static_cast<std::size_t>(id)];
        if (!takes_samples(channel))
            return error_at({}, "channel '" + channel.name +
                                    "' cannot be deep: it uses another channel's samples; expected "
                                    "light or a filtered channel");
        if (channel.type == ChannelType::integer || channel.rule != FilterRule::filter)
            return error_at({}, "channel '" + channel.name + "' cannot be deep: it is " +
                                    (channel.type == ChannelType::integer ? "an integer" : "not a filtered mean") +
                                    "; expected light or a filtered channel (depth is in every deep image)");
    }
    return success();
}

std::size_t DeepBuffer::expected_bytes() const {
    return pixels_.size() * (sizeof(Pixel) + 4 * (sizeof(Bin) + stride() * sizeof(Int128)));
}

void DeepBuffer::accumulate(const SampleTable& table) {
    if (table.discarded()) return;
    thread_local RayRows rays;
    thread_local Scratch scratch;
    rays.gather(table);
    scratch.terms.resize(stride());
    scratch.written.resize(chosen_.size());
    for (int row = 0; row < table.camera_row_count(); ++row) {
        const CameraRow& camera = table.camera_row(row);
        if (camera.pixel_x < 0 || camera.pixel_y < 0 || camera.pixel_x >= width_ || camera.pixel_y >= height_) continue;
        Pixel& pixel = pixels_[static_cast<std::size_t>(camera.pixel_y) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(camera.pixel_x)];
        add_sample(pixel, table, rays, row, scratch);
    }
}

/// Adds the rows of a sample from front to back, each with its drop in transmittance.
void DeepBuffer::add_sample(Pixel& pixel, const SampleTable& table, const RayRows& rays, int camera_row,
                            Scratch& scratch) {
    if (pixel.level == 0) pixel.level = static_cast<std::uint8_t>(first_level_);
    const auto weight = static_cast<double>(table.camera_row(camera_row).filter_weight);
    Int128 fixed = 0;
    if (!to_fixed(weight, quantum, fixed) || !add_fixed(pixel.weight, fixed)) {
        ++pixel.refused;
        return;
    }
    const std::span<const int> rows = rays.of(camera_row);
    const std::span<const double> coverage = rays.coverage(camera_row);
    for (std::size_t k = 0; k < chosen_.size(); ++k)
        scratch.written[k] = table.channel(chosen_[k]).style == ChannelStyle::name
                                 ? written_mean(table, chosen_[k], rows, coverage)
                                 : WrittenMean{.set = true};
    const bool covers = rays.alpha()[static_cast<std::size_t>(camera_row)] > 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        Row row;
        row.index = rows[i];
        row.weight = weight;
        row.drop = weight * coverage[i];
        row.background = !(table.depth[static_cast<std::size_t>(rows[i])] < deep_background);
        row.sample_covers = covers;
        add_row(pixel, table, row, scratch);
    }
}

void DeepBuffer::add_row(Pixel& pixel, const SampleTable& table, const Row& row, Scratch& scratch) {
    std::vector<Int128>& terms = scratch.terms;
    const auto index = static_cast<std::size_t>(row.index);
    const float depth = row.background ? deep_background : table.depth[index] + 0.0f;
    bool fits = depth >= 0, leaves_a_trace = false;
    const auto put = [&](std::size_t at, double value) {
        fits = fits && to_fixed(value, quanta_[at], terms[at]);
        leaves_a_trace = leaves_a_trace || terms[at] != 0;
    };
    put(0, row.drop);
    // Depths reach 1e30, so the mean of their logarithm is stored, relative to 1, to keep the sums in range.
    put(1, row.background ? 0 : row.drop * elementary::log2(std::max(depth, std::numeric_limits<float>::min())));
    std::size_t at = 2;
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
        const ChannelId id = chosen_[k];
        const auto components = static_cast<std::size_t>(raylex::display::component_count(table.channel(id).type));
        const double* const values = table.values(id) + index * components;
        const WrittenMean& written = scratch.written[k];
        const auto state = table.channel(id).style == ChannelStyle::name ? table.row_state(id, row.index)
                                                                         : SampleTable::RowState::splatted;
        const bool own = state == SampleTable::RowState::written && written.covers;
        const bool adds = state == SampleTable::RowState::splatted ||
                          (state == SampleTable::RowState::untouched && table.fill_value(id) == 0);
        const bool miss = !written.set && row.index == table.original(row.index) && std::isfinite(table.fill_value(id));
        // A sample without coverage has its written value in the first row that has one.
        const double share = row.sample_covers ? row.drop : row.index == written.first ? row.weight : 0.0;
        for (std::size_t c = 0; c < components; ++c) {
            double value = 0;
            if (adds) value = row.weight * values[c];
            else if (miss) value = row.weight * table.fill_value(id);
            if (written.any) value += share * (own ? values[c] : written.value[c]);
            put(at++, value);
        }
    }
    if (!fits) {
        ++pixel.refused;
        return;
    }
    if (!leaves_a_trace) return;
    Bin bin;
    bin.key = row.background ? background_key : depth_key(depth, pixel.level);
    bin.surface = row.background || table.is_volume[index] == 0;
    bin.nearest = bin.farthest = depth;
    const auto place = std::lower_bound(pixel.bins.begin(), pixel.bins.end(), bin,
                                        [](const Bin& a, const Bin& b) { return a.before(b); });
    const auto slot = static_cast<std::size_t>(place - pixel.bins.begin()) * stride();
    if (place != pixel.bins.end() && place->same(bin)) {
        place->nearest = std::min(place->nearest, depth);
        place->farthest = std::max(place->farthest, depth);
        for (std::size_t i = 0; i < terms.size(); ++i) pixel.sums[slot + i] += terms[i];
        return;
    }
    pixel.bins.insert(place, bin);
    pixel.sums.insert(pixel.sums.begin() + static_cast<std::ptrdiff_t>(slot), terms.begin(), terms.end());
    coarsen(pixel);
}

/// Raises the level until the number of bins, without the background, is at most the limit, or until level 31.
void DeepBuffer::coarsen(Pixel& pixel) const {
    const auto limit = static_cast<std::size_t>(options_.most_samples);
    const std::size_t width = stride();
    while (pixel.bins.size() > limit + (pixel.bins.back().key == background_key ? 1 : 0) && pixel.level < 31) {
        ++pixel.level;
        for (Bin& bin : pixel.bins)
            if (bin.key != background_key) bin.key >>= 1;
        // Halving keys can put a surface bin before a volume bin of the same new key, so bins and sums are sorted
        // again.
        std::vector<std::size_t> order(pixel.bins.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return pixel.bins[a].before(pixel.bins[b]); });
        std::vector<Bin> bins;
        std::vector<Int128> sums;
        for (const std::size_t i : order) {
            const Bin& bin = pixel.bins[i];
            const Int128* from = &pixel.sums[i * width];
            if (!bins.empty() && bins.back().same(bin)) {
                bins.back().nearest = std::min(bins.back().nearest, bin.nearest);
                bins.back().farthest = std::max(bins.back().farthest, bin.farthest);
                Int128* to = &sums[(bins.size() - 1) * width];
                for (std::size_t k = 0; k < width; ++k) to[k] += from[k];
            } else {
                bins.push_back(bin);
                sums.insert(sums.end(), from, from + width);
            }
        }
        pixel.bins = std::move(bins);
        pixel.sums = std::move(sums);
    }
}

std::vector<DeepSample> DeepBuffer::resolve(int x, int y) const {
    const Pixel& pixel =
        pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
    std::vector<DeepSample> samples;
    if (pixel.weight <= 0) return samples;
    const long double weight = to_long_double(pixel.weight, quantum);
    long double through = 1;
    for (std::size_t b = 0; b < pixel.bins.size(); ++b) {
        const Bin& bin = pixel.bins[b];
        const Int128* sums = &pixel.sums[b * stride()];
        const long double drop = to_long_double(sums[0], quantum) / weight;
        // Nothing behind an opaque surface is visible; rounding of the last drop leaves at most a few 1e-19.
        const bool open = through > 1e-15L;
        DeepSample sample;
        sample.alpha = open ? static_cast<float>(std::clamp(drop / through, 0.0L, 1.0L)) : 1.0f;
        const bool points = bin.surface || sample.alpha == 1;  // an opaque span would hide its inside
        sample.z = bin.nearest;
        sample.z_back = bin.farthest;
        if (points && bin.key != background_key && sums[0] > 0) {
            const auto exponent =
                static_cast<double>(to_long_double(sums[1], quantum) / to_long_double(sums[0], quantum));
            const auto mean = static_cast<float>(elementary::exp2(exponent));
            sample.z = sample.z_back = std::clamp(mean, bin.nearest, bin.farthest);
        } else if (points) {
            sample.z_back = sample.z;
        }
        for (std::size_t i = 2; i < stride(); ++i) {
            const long double light = to_long_double(sums[i], quanta_[i]) / weight;
            sample.values.push_back(open ? static_cast<float>(light / through) : 0.0f);
        }
        through = std::max(0.0L, through - drop);
        samples.push_back(std::move(sample));
        if (!open) samples.pop_back();
    }
    for (std::size_t i = 1; i < samples.size(); ++i) put_in_order(samples[i - 1], samples[i], options_.tidy);
    return samples;
}

DeepCounts DeepBuffer::counts() const {
    DeepCounts counts;
    int coarsest = 0;
    for (const Pixel& pixel : pixels_) {
        counts.samples += pixel.bins.size();
        counts.refused_rows += pixel.refused;
        if (pixel.level <= first_level_) continue;
        ++counts.merged_pixels;
        coarsest = std::max(coarsest, static_cast<int>(pixel.level));
    }
    if (coarsest > 0) counts.coarsest = std::ldexp(1.0, coarsest - mantissa_bits);
    return counts;
}

}  // namespace raylex::display
