#include "experiments/job/passes/pass_sum.h"

namespace raylex::experiments {
namespace {

void add_values(std::vector<double>& sum, const std::vector<double>& values) {
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

std::vector<double> PassSum::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const auto index = static_cast<std::size_t>(id);
    if (!is_summed(channels_, id)) return images_[with_aovs_].buffer.resolve(id, region);
    std::vector<double> sum;
    for (const PassImage& image : images_)
        if (image.position[index] >= 0) add_values(sum, image.buffer.resolve(image.position[index], region));
    sum.resize(value_count(channels_[index], region));
    return sum;
}

std::vector<double> LivePassSum::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const auto index = static_cast<std::size_t>(id);
    std::vector<double> sum;
    for (const PassImage* image : finished_) {
        if (image->position[index] >= 0) add_values(sum, image->buffer.resolve(image->position[index], region));
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
