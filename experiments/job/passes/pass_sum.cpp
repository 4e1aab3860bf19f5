#include "experiments/job/passes/pass_sum.h"

namespace raylex::experiments {
namespace {

void add_values(std::vector<double>& sum, const std::vector<double>& values) {
    if (values.empty()) return;
    if (sum.empty()) sum.assign(values.size(), 0.0);
    for (std::size_t i = 0; i < values.size(); ++i) sum[i] += values[i];
}

std::size_t value_count(const display::ChannelDefinition& channel, const display::PixelRegion& region) {
    return static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()) *
           static_cast<std::size_t>(display::component_count(channel.type));
}

}  // namespace

std::vector<display::ChannelId> positions_in(std::span<const display::ChannelDefinition> channels,
                                             std::span<const display::ChannelDefinition> of_sum) {
    std::vector<display::ChannelId> positions;
    for (const display::ChannelDefinition& each : of_sum) {
        positions.push_back(display::invalid_channel);
        for (std::size_t i = 0; i < channels.size(); ++i)
            if (channels[i].name == each.name) positions.back() = static_cast<display::ChannelId>(i);
    }
    return positions;
}

bool is_summed(std::span<const display::ChannelDefinition> channels, display::ChannelId id) {
    const display::ChannelDefinition& channel = channels[static_cast<std::size_t>(id)];
    const display::ChannelDefinition& source =
        display::takes_samples(channel) ? channel : channels[static_cast<std::size_t>(channel.source)];
    return source.style == display::ChannelStyle::expression;
}

std::vector<double> PassImage::resolve(display::ChannelId id, std::span<const display::ChannelDefinition> channels,
                                       const display::PixelRegion& region) const {
    const auto index = static_cast<std::size_t>(id);
    if (position[index] >= 0) return buffer.resolve(position[index], region);
    const display::ChannelDefinition& channel = channels[index];
    if (!half || display::takes_samples(channel)) return {};
    const display::ChannelId source = position[static_cast<std::size_t>(channel.source)];
    if (source < 0) return {};
    const double share = static_cast<double>(half->light_path_count()) / static_cast<double>(buffer.light_path_count());
    if (!(share > 0 && share < 1)) return {};  // stopped before the second half
    std::vector<double> first = half->resolve(source, region);
    const std::vector<double> whole = buffer.resolve(source, region);
    for (std::size_t i = 0; i < first.size(); ++i) {
        const double second = (whole[i] - share * first[i]) / (1 - share), difference = first[i] - second;
        // Halves of n1 and n2 samples with the variance v / n1 and v / n2 differ by v / n1 + v / n2 in the mean square.
        if (channel.statistic == display::Statistic::mse) first[i] = share * (1 - share) * difference * difference;
        if (channel.statistic == display::Statistic::odd) first[i] = second;
    }
    return first;
}

std::vector<double> PassSum::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const auto index = static_cast<std::size_t>(id);
    if (!is_summed(channels_, id)) return images_[with_aovs_].buffer.resolve(id, region);
    std::vector<double> sum;
    for (const PassImage& image : images_) add_values(sum, image.resolve(id, channels_, region));
    sum.resize(value_count(channels_[index], region));
    return sum;
}

std::vector<double> LivePassSum::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const auto index = static_cast<std::size_t>(id);
    std::vector<double> sum;
    for (const PassImage* image : finished_) {
        add_values(sum, image->resolve(id, channels_, region));
        if (!is_summed(channels_, id)) return sum;
    }
    if (position_[index] >= 0) add_values(sum, running_.resolve(position_[index], region));
    sum.resize(value_count(channels_[index], region));
    return sum;
}

std::vector<double> LivePassSum::resolve_alpha(const display::PixelRegion& region) const {
    return finished_.empty() ? running_.resolve_alpha(region) : finished_.front()->buffer.resolve_alpha(region);
}

std::vector<double> LivePassSum::resolve_variance_of_mean(display::ChannelId id,
                                                          const display::PixelRegion& region) const {
    const auto index = static_cast<std::size_t>(id);
    std::vector<double> sum;
    for (const PassImage* image : finished_) {
        if (image->position[index] < 0) continue;
        const std::vector<double> values = image->buffer.resolve_variance_of_mean(image->position[index], region);
        if (values.empty()) return {};
        add_values(sum, values);
    }
    if (position_[index] < 0) return sum;
    const std::vector<double> values = running_.resolve_variance_of_mean(position_[index], region);
    if (values.empty()) return {};
    add_values(sum, values);
    return sum;
}

}  // namespace raylex::experiments
